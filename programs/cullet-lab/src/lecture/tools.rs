//! What checks of several subjects share: meshes of a few triangles, sets of triangles, numbers in words.

use std::collections::BTreeSet;

use cullet::mesh::Part;
use cullet::{
    Culler, Instance, Mesh, MeshData, Output, Scene, Transform, View, ViewState, Visible,
};
use cullet_draw::{Frame, RenderOptions, Selection, render};

use crate::lecture::lab::LabError;

/// The size of the pictures that checks draw.
pub(crate) const SIZE: [u32; 2] = [320, 200];

/// Which instance, by its slot, and which of its mesh's original triangles.
pub(crate) type TriangleId = (u32, u32);

/// Culls one view from a cold state.
pub(crate) fn cull(culler: &Culler, scene: &Scene, view: &View) -> Visible {
    let mut visible = Visible::default();
    culler.cull_one(scene, view, &mut ViewState::default(), &mut visible);
    visible
}

/// As [`cull`], down to triangles.
pub(crate) fn cull_triangles(culler: &Culler, scene: &Scene, view: &View) -> Visible {
    cull(&Culler { output: Output::Triangles, ..culler.clone() }, scene, view)
}

/// The triangles of a result that has them.
pub(crate) fn left(scene: &Scene, visible: &Visible) -> BTreeSet<TriangleId> {
    let of_range = |r: &cullet::TriangleRange| {
        let original = scene.mesh_at(r.slot, r.level).original_triangle();
        let (slot, first) = (r.slot, r.first as usize);
        let triangles = &visible.triangles[first..first + r.count as usize];
        triangles.iter().map(move |&t| (slot, original[t as usize]))
    };
    visible.triangle_ranges.iter().flat_map(of_range).collect()
}

/// All triangles that have an area.
pub(crate) fn all_triangles(scene: &Scene) -> BTreeSet<TriangleId> {
    let of_slot = |slot: u32| {
        let mesh = scene.mesh(slot);
        let drawn = (mesh.triangle_count() - mesh.degenerate_count()) as usize;
        mesh.original_triangle()[..drawn].iter().map(move |&t| (slot, t))
    };
    scene.slots().flat_map(of_slot).collect()
}

/// The triangles that a picture without culling shows.
pub(crate) fn seen(frame: &Frame) -> BTreeSet<TriangleId> {
    frame.visible().into_iter().map(|id| (id.slot, id.triangle)).collect()
}

/// A picture of all triangles, with the layers of each pixel counted.
pub(crate) fn draw(scene: &Scene, view: &View) -> Frame {
    draw_of(scene, view, Selection::All)
}

/// A picture of some triangles, with the layers of each pixel counted.
pub(crate) fn draw_of(scene: &Scene, view: &View, selection: Selection<'_>) -> Frame {
    let options = RenderOptions { count_layers: true, ..RenderOptions::default() };
    render(scene, view, selection, &options)
}

/// A mesh of one part.
pub(crate) fn mesh(
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    two_sided: bool,
) -> Result<Mesh, LabError> {
    let triangle_count = (indices.len() / 3) as u32;
    let parts = vec![Part { triangle_count, two_sided, ..Part::default() }];
    Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).map_err(other)
}

/// A scene of one mesh, where it is.
pub(crate) fn scene_of(mesh: Mesh) -> Result<Scene, LabError> {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh);
    scene.add(Instance::new(mesh, Transform::IDENTITY)).map_err(other)?;
    scene.commit();
    Ok(scene)
}

/// The cube from −1 to 1, wound outward: two triangles a side, the upper side last.
pub(crate) fn cube() -> (Vec<[f32; 3]>, Vec<u32>) {
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 });
    let sides =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3]];
    let triangles = sides.into_iter().flat_map(|[a, b, c, d]| [a, b, c, a, c, d]);
    ((0..8).map(corner).collect(), triangles.collect())
}

/// Sheets across a picture that is 3.2 wide and 2 high, each of so many columns and rows.
pub(crate) fn sheets(layers: u32, [columns, rows]: [u32; 2]) -> Result<Scene, LabError> {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for layer in 0..layers {
        let first = positions.len() as u32;
        for (row, column) in (0..=rows).flat_map(|r| (0..=columns).map(move |c| (r, c))) {
            let along = |i: u32, of: u32| 2.0 * i as f32 / of as f32 - 1.0;
            positions.push([1.6 * along(column, columns), along(row, rows), -1.0 - layer as f32]);
        }
        for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            let at = |r: u32, c: u32| first + (row + r) * (columns + 1) + column + c;
            indices.extend([at(0, 0), at(0, 1), at(1, 1), at(0, 0), at(1, 1), at(1, 0)]);
        }
    }
    scene_of(mesh(positions, indices, true)?)
}

/// A point of an instance in the world, in f64.
pub(crate) fn placed(transform: &Transform, p: [f32; 3]) -> [f64; 3] {
    let [x, y, z] = p.map(f64::from);
    let [x, y, z, _] = times(&transform.to_matrix(), [x, y, z, 1.0]);
    [x, y, z]
}

/// A matrix, column by column, times a point.
pub(crate) fn times(m: &[f64; 16], p: [f64; 4]) -> [f64; 4] {
    [0, 1, 2, 3].map(|row| (0..4).map(|column| m[4 * column + row] * p[column]).sum())
}

/// An invalid value that has no error of its own here.
pub(crate) fn other(error: impl std::fmt::Display) -> LabError {
    LabError::Other(error.to_string())
}

/// A number with its thousands set apart.
pub(crate) fn grouped(n: impl TryInto<u64>) -> String {
    let digits = n.try_into().unwrap_or(u64::MAX).to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A share in percent, with a digit more where it is small.
pub(crate) fn percent(part: impl TryInto<u64>, of: impl TryInto<u64>) -> String {
    let [part, of] = [part.try_into().unwrap_or(0), of.try_into().unwrap_or(0)].map(|n| n as f64);
    let percent = if of > 0.0 { 100.0 * part / of } else { 0.0 };
    if percent > 0.0 && percent < 9.95 {
        format!("{percent:.1} %")
    } else {
        format!("{percent:.0} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cube_is_a_solid_of_eight_units() {
        let (positions, indices) = cube();
        let mesh = mesh(positions, indices, false).expect("valid");
        assert_eq!(mesh.solid(), Ok(()));
        assert_eq!(mesh.topology().volume, 8.0);
    }

    #[test]
    fn numbers_read_as_in_the_book() {
        assert_eq!(grouped(1_234_567u32), "1,234,567");
        assert_eq!(grouped(12usize), "12");
        assert_eq!(percent(1u32, 200u32), "0.5 %");
        assert_eq!(percent(2u32, 3u32), "67 %");
        assert_eq!(percent(0u32, 0u32), "0 %");
    }
}
