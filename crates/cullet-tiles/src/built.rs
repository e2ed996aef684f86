//! A scene of a cut.

use std::collections::BTreeMap;

use cullet::{Mesh, Prepared, Scene};

use crate::source::{TileContent, TileId};

/// The scene of some tiles: their instances, tile by tile in ascending order, so that it is the same whenever each came. Cost: that of
/// adding and sorting all instances.
#[must_use]
pub fn scene_of(
    meshes: &[(Mesh, Prepared)],
    contents: &BTreeMap<TileId, TileContent>,
    tiles: &[TileId],
) -> Scene {
    let mut scene = Scene::new();
    for (mesh, prepared) in meshes {
        scene.add_prepared_mesh(mesh.clone(), prepared.clone());
    }
    for content in tiles.iter().filter_map(|tile| contents.get(tile)) {
        for instance in &content.instances {
            // A source that names a mesh which it does not have loses that instance, as does a world of more than 2^32.
            let _ = scene.add(*instance);
        }
    }
    scene.commit();
    scene
}
