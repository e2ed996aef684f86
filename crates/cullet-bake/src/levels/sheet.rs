//! The last levels of a chain: of each part a triangle, or two that share an edge, seen from both
//! sides.
//!
//! Collapsing edges ends at a handful of triangles, or at none at all. What is a few pixels large
//! needs no more than a sheet through its middle: for a box that lies in the plane of two opposite
//! edges.

use glam::DVec3;

use super::original::Original;
use super::peaks::Peaks;
use super::within::Found;
use cullet_draw::surface::SurfacePoint;
use cullet_draw::surface::{SurfaceTree, closest_point};

/// Directions to whose ends corners of a sheet are looked for. Of so few all triangles between them
/// can be tried.
const DIRECTIONS: [[f32; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
];

/// Number of points of a part by which its sheets are compared.
const COMPARED: usize = 96;

impl Original {
    /// Returns a sheet of one triangle, or of up to two, for each part, and the measured error of
    /// the whole sheet; nothing for a part without triangles. A one-sided part has the sheet twice,
    /// once for each side.
    ///
    /// The sheet is the best of those between some 14 corners of the part, by the farthest of a
    /// hundred points; its error is the largest distance of all points, including those that
    /// confirm other levels.
    pub(super) fn sheets(&self, triangles: usize) -> Option<Found> {
        let mut indices = Vec::new();
        for (number, part) in (0..).zip(&self.parts) {
            let own: Vec<u32> = (0..self.positions.len() as u32)
                .filter(|&v| self.part[v as usize] == number)
                .collect();
            for corners in self.sheet(&own, triangles) {
                indices.extend(corners);
                if !part.two_sided {
                    indices.extend([corners[0], corners[2], corners[1]]);
                }
            }
        }
        (!indices.is_empty()).then(|| Found { error: self.largest_distance(&indices), indices })
    }

    fn place(&self, v: u32) -> DVec3 {
        DVec3::from_array(self.positions[v as usize].map(f64::from))
    }

    /// The sheet of some vertices.
    fn sheet(&self, own: &[u32], triangles: usize) -> Vec<[u32; 3]> {
        let corners = self.ends(own);
        let step = own.len().div_ceil(COMPARED).max(1);
        let mut compared: Vec<DVec3> = own.iter().step_by(step).map(|&v| self.place(v)).collect();
        compared.extend(corners.iter().map(|&v| self.place(v)));
        let mut best = Best { original: self, compared, far: f64::INFINITY, sheet: Vec::new() };
        for (at, &a) in corners.iter().enumerate() {
            for (next, &b) in corners.iter().enumerate().skip(at + 1) {
                corners[next + 1..].iter().for_each(|&c| best.compare(&[[a, b, c]]));
            }
        }
        if triangles > 1
            && let Some(&[a, b, c]) = best.sheet.first()
        {
            for &d in corners.iter().filter(|d| ![a, b, c].contains(d)) {
                for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                    best.compare(&[[a, b, c], [a, c, d]]);
                }
            }
        }
        best.sheet
    }

    /// The vertices farthest along each direction, either way, each once.
    fn ends(&self, own: &[u32]) -> Vec<u32> {
        let mut ends = Vec::with_capacity(2 * DIRECTIONS.len());
        for direction in DIRECTIONS {
            let along = |v: &u32| -> f32 {
                let p = self.positions[*v as usize];
                (0..3).map(|a| p[a] * direction[a]).sum()
            };
            let low = own.iter().min_by(|a, b| along(a).total_cmp(&along(b)));
            let high = own.iter().max_by(|a, b| along(a).total_cmp(&along(b)));
            ends.extend(low.into_iter().chain(high));
        }
        ends.sort_unstable();
        ends.dedup();
        ends
    }

    /// The largest distance that is found between the original and a list of triangles, either way,
    /// by all points there are and the tops that are reached from them.
    fn largest_distance(&self, indices: &[u32]) -> f32 {
        let tree = SurfaceTree::new(&self.positions, indices);
        let (mut error, mut last) = (0.0_f32, 0);
        for &point in &self.positions {
            error = tree.farther(point, error, &mut last).unwrap_or(error);
        }
        let there = self.points.iter().copied().chain(self.confirming_points(&self.indices));
        let error = self.highest(&tree, &self.indices, there, error);
        let back = self.points_back(indices).into_iter().chain(self.confirming_points(indices));
        self.highest(&self.tree, indices, back, error)
    }

    /// The largest distance of points of a surface from another, and of the tops that are reached
    /// from them, at least `error`.
    fn highest(
        &self,
        from: &SurfaceTree,
        indices: &[u32],
        points: impl Iterator<Item = SurfacePoint>,
        mut error: f32,
    ) -> f32 {
        let mut peaks = Peaks::default();
        for point in points {
            error = peaks.add(from, point, error).map_or(error, |distance| error.max(distance));
        }
        let far = |top: SurfacePoint| from.nearest(top.point, f32::INFINITY);
        let tops = peaks.climb(from, |t| self.corners(indices, t)).into_iter();
        tops.map(|top| far(top).map_or(f32::INFINITY, |n| n.0)).fold(error, f32::max)
    }
}

/// The best sheet so far: the one of whose compared points the farthest is nearest.
struct Best<'a> {
    original: &'a Original,
    compared: Vec<DVec3>,
    /// Squared.
    far: f64,
    sheet: Vec<[u32; 3]>,
}

impl Best<'_> {
    fn compare(&mut self, sheet: &[[u32; 3]]) {
        let corners = sheet.iter().map(|t| t.map(|v| self.original.place(v)));
        let corners: Vec<[DVec3; 3]> = corners.collect();
        if corners.iter().any(|[a, b, c]| (*b - *a).cross(*c - *a) == DVec3::ZERO) {
            return;
        }
        let to = |p: DVec3| {
            let of = |t: &[DVec3; 3]| (closest_point(p, *t) - p).length_squared();
            corners.iter().map(of).fold(f64::INFINITY, f64::min)
        };
        let mut far = 0.0_f64;
        for &p in &self.compared {
            far = far.max(to(p));
            if far >= self.far {
                return;
            }
        }
        self.far = far;
        self.sheet = sheet.to_vec();
    }
}
