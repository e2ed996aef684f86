//! Groups of instances, merged.

use std::sync::Mutex;

use cullet_bake::merged::{MEASURED, MergeOptions, MergedGroup, add_to_scene, merge};
use cullet_command::args::BakeArgs;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure};
use cullet_io::Model;
use cullet_io::baked::Measured;

/// What came of it.
pub(super) struct Merged {
    pub(super) groups: u64,
    /// Of all their levels.
    pub(super) triangles: u64,
}

/// Merges groups of a model's instances, and gives them to its scene.
pub(super) fn run(
    model: &mut Model,
    args: &BakeArgs,
    console: &Console,
) -> Result<Merged, Failure> {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let mut options = MergeOptions::default();
    options.threads = args.threads.map_or(cores, |n| n as usize);
    const STEPS: u64 = 1000;
    let progress = Mutex::new((console.progress("merging instances", STEPS), 0));
    let go_on = |share: f64| {
        if let Ok(mut progress) = progress.lock() {
            let now = (share * STEPS as f64) as u64;
            if now > progress.1 {
                let more = now - progress.1;
                progress.0.steps(more);
                progress.1 = now;
            }
        }
        !interrupted()
    };
    let found = merge(&model.scene, &options, go_on);
    if let Ok((mut progress, _)) = progress.into_inner() {
        progress.finish();
    }
    let fail = |e: &dyn std::fmt::Display| Failure::input(format!("{}: --merge: {e}", model.name));
    let Some(groups) = found.map_err(|e| fail(&e))? else {
        let message =
            "interrupted; nothing was written, and of merged groups nothing is kept".to_owned();
        return Err(Failure { exit: Exit::Interrupted, message });
    };
    let triangles = |g: &MergedGroup| (g.levels.mesh.indices.len() / 3) as u64;
    let merged =
        Merged { groups: groups.len() as u64, triangles: groups.iter().map(triangles).sum() };
    let first = model.scene.meshes().len();
    add_to_scene(&mut model.scene, &groups).map_err(|e| fail(&e))?;
    model.mesh_names.resize(first, String::new());
    model.mesh_names.extend(groups.iter().map(|g| {
        format!(
            "{} merged",
            cullet_command::console::count(g.members.len() as u64, "instance", "instances")
        )
    }));
    if let Some(baked) = model.baked.as_mut().filter(|_| merged.groups > 0) {
        baked.stand_ins = Some(Measured {
            points: MEASURED.points,
            reverse_points: MEASURED.reverse_points,
            quantile: 1.0,
            most_over: 1.0,
            seed: MEASURED.seed,
        });
    }
    Ok(merged)
}
