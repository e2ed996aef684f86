//! Parts of nodes that Godot draws as one: instances of a MultiMesh, cells of a GridMap. They hide
//! what is behind them; whether they are drawn is their node's to say.

use cullet::{Handle, Instance, MeshId, Scene, Transform};
use godot::classes::{GridMap, Mesh, MultiMesh, multi_mesh};
use godot::obj::InstanceId;
use godot::prelude::*;

use crate::convert;

/// More parts than this hide nothing: following them would take too long.
pub(crate) const MOST_PARTS: usize = 16_384;

/// A part.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) handle: Handle,
    /// Its number in its node, from 1 on.
    pub(crate) number: usize,
    /// Its place in the space of its node.
    local: Transform3D,
    /// Cell and item of a GridMap.
    cell: Option<(Vector3i, i32)>,
}

/// The place of a part before it is in the engine's scene.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) local: Transform3D,
    pub(crate) mesh: Gd<Mesh>,
    cell: Option<(Vector3i, i32)>,
}

/// Returns the places of the drawn instances of a MultiMesh; none where there are too many.
pub(crate) fn of_multi(multi: &Gd<MultiMesh>) -> Vec<Place> {
    let Some(mesh) = multi.get_mesh() else { return Vec::new() };
    let count = drawn(multi);
    let is_flat = multi.get_transform_format() != multi_mesh::TransformFormat::TRANSFORM_3D;
    if is_flat || count > MOST_PARTS {
        return Vec::new();
    }
    let place =
        |i| Place { local: multi.get_instance_transform(i as i32), mesh: mesh.clone(), cell: None };
    (0..count).map(place).collect()
}

fn drawn(multi: &Gd<MultiMesh>) -> usize {
    let (all, some) = (multi.get_instance_count(), multi.get_visible_instance_count());
    usize::try_from(if some < 0 { all } else { all.min(some) }).unwrap_or(0)
}

/// Returns the places of the cells of a GridMap; none where there are too many.
pub(crate) fn of_grid(grid: &Gd<GridMap>) -> Vec<Place> {
    // Baked meshes stand in for the cells then. Godot's function for them would bake them.
    let baked = grid.get("baked_meshes").try_to::<VarArray>();
    let is_baked = baked.is_ok_and(|baked| !baked.is_empty());
    let Some(library) = grid.get_mesh_library().filter(|_| !is_baked) else { return Vec::new() };
    let cells = grid.get_used_cells();
    if cells.len() > MOST_PARTS {
        return Vec::new();
    }
    let mut places = Vec::new();
    for cell in cells.iter_shared() {
        let item = grid.get_cell_item(cell);
        let Some(mesh) = library.get_item_mesh(item) else { continue };
        let local = of_cell(grid, cell) * library.get_item_mesh_transform(item);
        places.push(Place { local, mesh, cell: Some((cell, item)) });
    }
    places
}

/// Returns the place of a cell as `GridMap` computes it.
fn of_cell(grid: &Gd<GridMap>, cell: Vector3i) -> Transform3D {
    let scale = grid.get_cell_scale();
    let basis = grid.get_cell_item_basis(cell).scaled(Vector3::new(scale, scale, scale));
    Transform3D::new(basis, grid.map_to_local(cell))
}

impl Place {
    /// Adds the part to the scene, drawn by `mesh` of the engine; `None` for one that is mirrored,
    /// which shows its other side, or whose place is not finite.
    pub(crate) fn add(
        &self,
        scene: &mut Scene,
        mesh: MeshId,
        node: &Transform3D,
        layers: u32,
        (index, number): (usize, usize),
    ) -> Option<Part> {
        let at = *node * self.local;
        if !convert::is_finite(&at) || at.basis.determinant() <= 0.0 {
            return None;
        }
        let instance = Instance::new(mesh, convert::transform(&at));
        let user_data = index as u64 | (number as u64) << 32;
        let handle = scene.add(Instance { layers, user_data, ..instance }).ok()?;
        Some(Part { handle, number, local: self.local, cell: self.cell })
    }
}

impl Part {
    /// Returns its place in world space.
    pub(crate) fn place(&self, node: &Transform3D) -> Transform {
        convert::transform(&(*node * self.local))
    }

    /// Whether it is drawn as it was when it was added: an instance of `multi`.
    pub(crate) fn is_in_multi(&self, multi: &Gd<MultiMesh>, mesh: InstanceId) -> bool {
        self.number <= drawn(multi)
            && multi.get_mesh().is_some_and(|m| m.instance_id() == mesh)
            && multi.get_instance_transform(self.number as i32 - 1) == self.local
    }

    /// Whether it is drawn as it was when it was added: a cell of `grid`.
    pub(crate) fn is_in_grid(&self, grid: &Gd<GridMap>) -> bool {
        let Some((cell, item)) = self.cell else { return false };
        let Some(library) = grid.get_mesh_library() else { return false };
        grid.get_cell_item(cell) == item
            && of_cell(grid, cell) * library.get_item_mesh_transform(item) == self.local
    }
}
