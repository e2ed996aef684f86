//! The back-facing regions of a surface.

use cullet::cull::backface::{Facing, ObjectEye};
use cullet::mesh::{Regions, connected_regions};

/// The connected regions of the triangles that an eye sees from behind.
///
/// A convex solid has exactly one from any eye outside of it. Each further region is a fold that
/// turns away, and the more there are, the smaller are the clusters that can be culled. Triangles
/// that are edge-on, or too thin to tell, are in none and may part a region; so may triangles of no
/// area. Cost: O(n), as [`connected_regions`].
///
/// # Panics
/// If an index is not below the number of positions.
#[must_use]
pub fn back_regions(eye: &ObjectEye, positions: &[[f32; 3]], indices: &[u32]) -> Regions {
    let triangles = indices.as_chunks::<3>().0;
    connected_regions(positions, indices, |t| {
        eye.facing(&triangles[t].map(|v| positions[v as usize])) == Facing::Back
    })
}

#[cfg(test)]
mod tests {
    use cullet::{
        Transform,
        view::{CullFace, FrontFace},
    };
    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;

    /// A box whose sides are grids, each with corners of its own: convex, with seams. The corners
    /// of a side share a coordinate to the last bit, so it is flat.
    fn cuboid(rows: u32, axes: DVec3) -> (Vec<[f32; 3]>, Vec<u32>) {
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        for face in 0..6u32 {
            let (major, sign) = (face as usize / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
            let first = positions.len() as u32;
            for i in 0..=rows {
                for j in 0..=rows {
                    let along = |k: u32| 2.0 * f64::from(k) / f64::from(rows) - 1.0;
                    let mut p = DVec3::ZERO;
                    p[major] = sign;
                    p[(major + 1) % 3] = along(i) * sign;
                    p[(major + 2) % 3] = along(j);
                    positions.push((p * axes).as_vec3().to_array());
                }
            }
            grid(first, rows, rows, &positions, &mut indices);
        }
        (positions, indices)
    }

    /// An ellipsoid of `rows` rings of `2 rows` facets, with a seam. The corners of a facet are on
    /// two circles of latitude, so it is a flat trapezium of the convex hull of all corners.
    /// Rounded to f32 its corners are flat no more, and then its diagonal is the one that bulges;
    /// between facets the surface bends by degrees, which no rounding turns. So it is convex as
    /// built.
    fn ellipsoid(rows: u32, axes: DVec3) -> (Vec<[f32; 3]>, Vec<u32>) {
        let sides = 2 * rows;
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        for side in 0..=sides {
            for ring in 0..=rows {
                let around = f64::from(side % sides) / f64::from(sides) * std::f64::consts::TAU;
                let down = f64::from(ring) / f64::from(rows) * std::f64::consts::PI;
                // The poles are one place each, to the last bit.
                let r = if ring % rows == 0 { 0.0 } else { down.sin() };
                let p = DVec3::new(r * around.cos(), down.cos(), r * around.sin());
                positions.push((p * axes).as_vec3().to_array().map(|v| v + 0.0));
            }
        }
        grid(0, sides, rows, &positions, &mut indices);
        (positions, indices)
    }

    /// The triangles of a grid of vertices from number `first`, `long` × `wide` quads.
    fn grid(first: u32, long: u32, wide: u32, positions: &[[f32; 3]], indices: &mut Vec<u32>) {
        for (i, j) in (0..long).flat_map(|i| (0..wide).map(move |j| (i, j))) {
            let at = |i: u32, j: u32| first + i * (wide + 1) + j;
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            indices.extend(hull_pair(quad, positions));
        }
    }

    /// The two triangles of a quad that are on its convex hull.
    fn hull_pair([a, b, c, d]: [u32; 4], positions: &[[f32; 3]]) -> [u32; 6] {
        let at = |v: u32| DVec3::from(positions[v as usize].map(f64::from));
        let n = (at(b) - at(a)).cross(at(c) - at(a));
        if n.dot(at(d) - at(a)) <= 0.0 { [a, b, c, a, c, d] } else { [a, b, d, b, c, d] }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1024))]

        #[test]
        fn a_convex_solid_has_one_back_region_from_outside(
            rows in 1u32..9,
            axes in prop::array::uniform3(0.2..3.0f64),
            boxy in any::<bool>(),
            direction in prop::array::uniform3(-1.0..1.0f64),
            distance in 1.01..20.0f64,
        ) {
            prop_assume!(DVec3::from(direction).length() > 0.1);
            let axes = DVec3::from(axes);
            let make = if boxy { cuboid } else { ellipsoid };
            let (positions, indices) = make(if boxy { rows } else { rows + 2 }, axes);
            // Outside the sphere around it.
            let radius = axes.length();
            let e = DVec3::from(direction).normalize() * radius * distance;
            let eye = ObjectEye::new(
                [e.x, e.y, e.z, 1.0],
                &Transform::IDENTITY,
                FrontFace::default(),
                CullFace::Back,
            );
            // Facets of a box side, or mirror images, may be edge-on.
            let triangles = indices.as_chunks::<3>().0;
            let edge_on = |t: &[u32; 3]| eye.facing(&t.map(|v| positions[v as usize])) == Facing::Edge;
            let has_area = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                a != b && b != c && c != a
            };
            prop_assume!(!triangles.iter().any(|t| has_area(t) && edge_on(t)));
            let regions = back_regions(&eye, &positions, &indices);
            prop_assert_eq!(regions.count(), 1);
            let solid = triangles.iter().filter(|t| has_area(t)).count();
            // Opposite to a facet that is seen is one that is not; diagonals may lie otherwise.
            prop_assert!(regions.triangles[0] as usize * 5 >= solid * 2);
        }
    }
}
