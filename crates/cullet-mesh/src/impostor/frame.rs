//! Frames of impostors: directions on the octahedral square, and what of a mesh a parallel view
//! along one shows.

use cullet::bounds::Aabb;
use glam::DVec3;

/// The least side of what is looked at, as a share of the radius: a flat mesh has a texel's size
/// too.
pub(super) const LEAST_SIDE: f64 = 1e-3;

/// A direction from which the mesh was looked at, by parallel lines of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpostorFrame {
    /// Unit vectors to the right, up and towards the viewer, in the space of the mesh.
    pub axes: [[f64; 3]; 3],
    /// Half of the size along each of them of what the frame shows: the mesh's box, or the sphere
    /// around the mesh if that is smaller.
    pub half: [f64; 3],
}

impl ImpostorFrame {
    /// The parallel view of what is in a box, and no farther than `radius` from its centre, from a
    /// direction, which need not be of unit length.
    #[must_use]
    pub fn towards(direction: [f64; 3], bounds: &Aabb, radius: f32) -> Self {
        let box_half = bounds.half_extent();
        let least = length(box_half) * LEAST_SIDE;
        let size = length(direction);
        let axes = axes(direction.map(|v| v / size));
        let reach = |a: [f64; 3]| -> f64 { (0..3).map(|k| a[k].abs() * box_half[k]).sum() };
        Self { axes, half: axes.map(|a| reach(a).min(radius.into()).max(least)) }
    }
}

/// The unit vector of a place on the square from −1 to 1: Y is up in its middle and down at its
/// corners (Q. Meyer et al., *On Floating-Point Normal Vectors*, 2010).
pub(super) fn octahedral([u, v]: [f64; 2]) -> [f64; 3] {
    let y = 1.0 - u.abs() - v.abs();
    let [x, z] = match y < 0.0 {
        true => [(1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v)],
        false => [u, v],
    };
    let size = length([x, y, z]);
    [x / size, y / size, z / size]
}

/// The place of a direction on the square; its middle for none.
pub(super) fn square([x, y, z]: [f64; 3]) -> [f64; 2] {
    let sum = x.abs() + y.abs() + z.abs();
    if !(sum > 0.0 && sum.is_finite()) {
        return [0.0; 2];
    }
    let [u, v] = [x / sum, z / sum];
    match y < 0.0 {
        true => [(1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v)],
        false => [u, v],
    }
}

/// Right, up and towards the viewer.
fn axes(towards: [f64; 3]) -> [[f64; 3]; 3] {
    let towards = DVec3::from(towards);
    let pole = if towards.y.abs() > 0.99 { DVec3::NEG_Z } else { DVec3::Y };
    let right = pole.cross(towards);
    let right = right / right.length();
    [right, towards.cross(right), towards].map(DVec3::into)
}

pub(super) fn length(a: [f64; 3]) -> f64 {
    // Squares of coordinates beyond 1e150 are none of f32.
    DVec3::from(a).length()
}

/// The triangles of a box around `bounds` that has some thickness everywhere: what the level of an
/// impostor is a mesh of.
pub(super) fn box_triangles(bounds: &Aabb) -> (Vec<[f32; 3]>, Vec<u32>) {
    let (centre, half) = (bounds.center(), bounds.half_extent());
    let grow = length(half) * LEAST_SIDE;
    let [low, high] = [-1.0, 1.0]
        .map(|s: f64| -> [f64; 3] { std::array::from_fn(|a| centre[a] + s * (half[a] + grow)) });
    let grown = Aabb::rounded_out(low, high);
    // Each face counter-clockwise from outside.
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = faces.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    (grown.corners().to_vec(), indices)
}

#[cfg(test)]
mod tests {
    use cullet::{Mesh, MeshData};

    use super::*;

    #[test]
    fn boxes_are_solid_also_where_the_mesh_is_flat() {
        for bounds in [
            Aabb::new([-1.0, 0.0, -2.0], [1.0, 0.0, 5.0]),
            Aabb::new([0.0; 3], [1.0, 0.0, 0.0]),
            Aabb::new([-1e-20; 3], [1e-20; 3]),
            Aabb::new([1e6; 3], [1e6 + 1.0; 3]),
        ] {
            let (positions, indices) = box_triangles(&bounds);
            assert!(positions.iter().all(|p| p.iter().all(|v| v.is_finite())));
            let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() });
            let mesh = mesh.expect("valid");
            assert_eq!((mesh.triangle_count(), mesh.degenerate_count()), (12, 0));
            assert_eq!(mesh.clusters().len(), 1);
            assert!(bounds.corners().iter().all(|&c| mesh.bounds().contains(c)));
        }
    }
}
