//! A scene of a cut.

use std::collections::BTreeMap;

use cullet::lod::Levels;
use cullet::{
    Instance, Mesh, Scene,
    prepared::{Preparation, Prepared},
};
use cullet_io::baked::pays;

use crate::source::{TileContent, TileId};

/// A tile in memory, ready for scenes.
#[derive(Clone, Debug)]
pub struct Loaded {
    pub(crate) instances: Vec<Instance>,
    pub(crate) meshes: Vec<(Mesh, Prepared)>,
    pub(crate) levels: Vec<([u32; 2], Levels)>,
}

impl Loaded {
    /// Prepares a tile's content together with its own meshes. Cost: that of preparing the meshes.
    #[must_use]
    pub fn of(content: TileContent, preparation: Preparation) -> Self {
        let mut meshes: Vec<(Mesh, Prepared)> = content
            .meshes
            .into_iter()
            .map(|mesh| {
                let prepared = Prepared::of(&mesh, preparation);
                (mesh, prepared)
            })
            .collect();
        for (mesh, occluder) in content.occluders {
            let Some((_, prepared)) = meshes.get_mut(mesh as usize) else { continue };
            if prepared.occluder().is_some_and(|own| pays(&occluder, own)) {
                *prepared = std::mem::take(prepared).with_occluder(occluder);
            }
        }
        Self { instances: content.instances, meshes, levels: content.levels }
    }
}

/// The scene of some tiles: their instances, tile by tile in ascending order, so that it is the
/// same whenever each came. Cost: that of adding and sorting all instances, and of copying meshes
/// that are a tile's own.
#[must_use]
pub fn scene_of(
    meshes: &[(Mesh, Prepared)],
    loaded: &BTreeMap<TileId, Loaded>,
    tiles: &[TileId],
) -> Scene {
    let mut scene = Scene::new();
    let shared = meshes.len() as u32;
    for (mesh, prepared) in meshes {
        scene.add_prepared_mesh(mesh.clone(), prepared.clone());
    }
    for tile in tiles.iter().filter_map(|tile| loaded.get(tile)) {
        let first = scene.meshes().len() as u32;
        for (mesh, prepared) in &tile.meshes {
            scene.add_prepared_mesh(mesh.clone(), prepared.clone());
        }
        for ([mesh, held_by], levels) in &tile.levels {
            // Levels that do not fit are none: all is drawn in full.
            let of = |own: u32| first.saturating_add(own);
            let _ = scene.add_levels(of(*mesh), of(*held_by), levels.clone());
        }
        for &instance in &tile.instances {
            let own = instance.mesh.checked_sub(shared).map(|own| first.saturating_add(own));
            // A source that names a mesh which it does not have loses that instance, as does a
            // world of more than 2^32.
            let _ = scene.add(Instance { mesh: own.unwrap_or(instance.mesh), ..instance });
        }
    }
    scene.commit(&cullet::Culler::default());
    scene
}
