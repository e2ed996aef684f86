//! Levels of detail as commands use them: from the file or from the baker, measured, and counted
//! for reports.

mod baked;
mod cache;
mod ladder;
mod record;

use cullet::Scene;

pub use baked::{Wanted, file, load, load_with};
pub(crate) use ladder::Ladder;
pub(crate) use record::{DeviationRecord, LadderRecord, LevelsRecord, LevelsSummary};

/// Counted up whenever the same mesh and options give other levels: neither the baker, which keeps
/// what is finished, nor who keeps whole baked files, takes those of before for them.
pub const LEVELS_VERSION: u32 = 4;

/// One a mesh: it holds levels of another, and no instance shows it.
#[must_use]
pub fn holders(scene: &Scene) -> Vec<bool> {
    let mut holds = vec![false; scene.meshes().len()];
    for mesh in 0..scene.meshes().len() as u32 {
        scene.levels(mesh).iter().for_each(|levels| holds[levels.mesh as usize] = true);
    }
    scene.slots().for_each(|slot| holds[scene.mesh_id(slot) as usize] = false);
    holds
}
