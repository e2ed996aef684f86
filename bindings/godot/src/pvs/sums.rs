//! Checksums of nodes, by which one that moved or changed since the bake is told.

use std::collections::HashMap;

use cullet::scene::BoundsOverride;
use cullet::{MeshId, Transform};
use cullet_io::baked::{geometry_hash, hash};

use crate::item::Item;
use crate::look::Bounds;
use crate::mirror::{Mirror, world_box};

/// Sums of meshes, so that none is read twice.
#[derive(Debug, Default)]
pub(crate) struct MeshSums(HashMap<MeshId, u64>);

impl MeshSums {
    /// Returns the sum of a mesh; 0 for one that Godot may draw by coarser levels, which hides
    /// nothing in a bake.
    fn of(&mut self, mirror: &Mirror, mesh: MeshId) -> u64 {
        *self.0.entry(mesh).or_insert_with(|| {
            if mirror.meshes.has_levels(mesh) {
                return 0;
            }
            let mesh = &mirror.scene.meshes()[mesh as usize];
            let mut bytes = geometry_hash(mesh).to_le_bytes().to_vec();
            bytes.extend(mesh.parts().iter().map(|part| u8::from(part.two_sided)));
            hash(&bytes).max(1)
        })
    }

    /// Returns the sum of what an item hides others by now; 0 where it hides nothing.
    pub(crate) fn hides(&mut self, mirror: &Mirror, item: &Item) -> u64 {
        if !item.is_visible {
            return 0;
        }
        let mut bytes = Vec::new();
        for (mesh, at) in hiding(mirror, item) {
            let sum = self.of(mirror, mesh);
            if sum != 0 {
                bytes.extend(sum.to_le_bytes());
                at.linear.as_flattened().iter().for_each(|v| bytes.extend(v.to_le_bytes()));
                at.translation.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
            }
        }
        if bytes.is_empty() {
            return 0;
        }
        bytes.extend(item.look.layers.to_le_bytes());
        hash(&bytes).max(1)
    }

    /// Returns the meshes that an item hides by in a bake, with their places.
    pub(crate) fn hiding(&mut self, mirror: &Mirror, item: &Item) -> Vec<(MeshId, Transform)> {
        let mut all: Vec<_> = if item.is_visible { hiding(mirror, item).collect() } else { vec![] };
        all.retain(|(mesh, _)| self.of(mirror, *mesh) != 0);
        all
    }
}

/// Returns the meshes that an item hides by, with their places.
fn hiding<'a>(mirror: &'a Mirror, item: &'a Item) -> impl Iterator<Item = (MeshId, Transform)> {
    let own = item.handle.filter(|_| item.mesh.is_some());
    let handles = own.into_iter().chain(item.parts.iter().map(|part| part.handle));
    handles.filter_map(|handle| {
        let slot = mirror.scene.slot(handle).ok()?;
        Some((mirror.scene.mesh_id(slot), *mirror.scene.transform(slot)))
    })
}

/// Returns the sum of where an item may be drawn; 0 for one whose bounds are not known, and for a
/// `GridMap`, whose cells cannot be hidden.
pub(crate) fn seen(item: &Item) -> u64 {
    let Bounds::Box(..) = item.look.bounds else { return 0 };
    let BoundsOverride::World(bounds) = world_box(item) else { return 0 };
    let ends = bounds.min.iter().chain(&bounds.max);
    hash(&ends.flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()).max(1)
}
