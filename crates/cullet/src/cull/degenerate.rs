//! Triangles without area, and transforms that make them so.
//!
//! A mesh that cannot deform has none left in its clusters: [`crate::Mesh`] puts them aside when it
//! is made. What is left for run time is a deformed mesh, and an instance whose transform flattens
//! space: where the linear part has rank 2, triangles along the direction that is lost collapse to
//! a line; where it has rank 1 or 0, all do. Every answer here is exact: no tolerance, so no thin
//! triangle is ever called degenerate.

use alloc::vec::Vec;
use core::ops::Range;

use crate::array::Each;
use crate::exact::{dot_area_sign, is_collinear};
use crate::math::two_sum;
use crate::transform::Transform;

/// Whether a triangle has no area: its corners lie on one line. NaN coordinates count as area.
#[must_use]
pub fn is_zero_area(corners: &[[f32; 3]; 3]) -> bool {
    is_collinear(corners)
}

/// Effect of an instance's transform on areas, prepared for the triangles of its mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flattening {
    rank: u8,
    /// The direction that is lost where the rank is 2, each coordinate an exact sum of two.
    lost: [[f64; 2]; 3],
}

impl Flattening {
    /// Effect of `transform`.
    #[must_use]
    pub fn of(transform: &Transform) -> Self {
        let full = Self { rank: 3, lost: [[0.0; 2]; 3] };
        let columns = &transform.linear;
        if !transform.is_finite() || crate::exact::determinant_sign(columns) != 0 {
            return full;
        }
        // Each row of the cofactor matrix that is not zero is the lost direction: it is orthogonal
        // to every row of the linear part, and they span a plane.
        let row = |i: usize| [0, 1, 2].each(|j| f64::from(columns[j][i]));
        for (a, b) in [(row(0), row(1)), (row(1), row(2)), (row(2), row(0))] {
            let lost = [0, 1, 2].each(|i| {
                let (u, v) = ((i + 1) % 3, (i + 2) % 3);
                // Both products are exact, of f32 as they are.
                let (sum, tail) = two_sum(a[u] * b[v], -(a[v] * b[u]));
                [sum, tail]
            });
            if lost.iter().any(|c| c[0] != 0.0) {
                return Self { rank: 2, lost };
            }
        }
        Self { rank: u8::from(columns.iter().flatten().any(|&v| v != 0.0)), ..full }
    }

    /// The rank of the linear part, as [`Transform::rank`].
    #[must_use]
    pub fn rank(&self) -> u8 {
        self.rank
    }

    /// Whether a triangle has no area once it is transformed: its plane holds the lost direction,
    /// or it has none to begin with. NaN coordinates count as area.
    #[must_use]
    pub fn flattens(&self, corners: &[[f32; 3]; 3]) -> bool {
        match self.rank {
            3 => is_collinear(corners),
            2 => self.loses_area(corners),
            _ => corners.iter().flatten().all(|v| v.is_finite()),
        }
    }

    fn loses_area(&self, corners: &[[f32; 3]; 3]) -> bool {
        let [a, b, c] = corners.each(|p| glam::DVec3::from(p.each(f64::from)));
        let (ab, ac) = (b - a, c - a);
        let lost = glam::DVec3::from(self.lost.each(|c| c[0]));
        let value = ab.cross(ac).dot(lost);
        let size = ab.abs().element_sum() * ac.abs().element_sum() * lost.abs().element_sum();
        // Below a dozen roundings, each of at most half an epsilon of the size.
        if value.abs() > size * (8.0 * f64::EPSILON) || value.is_nan() {
            return false;
        }
        dot_area_sign(&self.lost, corners) == 0
    }

    /// Appends the numbers of those triangles of `range` that keep some area, ascending. Returns
    /// how many. `indices` is the whole index list; a triangle beyond it is left out, and one whose
    /// vertices are out of range is kept. At most `range.len()` are appended.
    pub fn keep_into(
        &self,
        positions: &[[f32; 3]],
        indices: &[u32],
        range: Range<u32>,
        kept: &mut Vec<u32>,
    ) -> usize {
        let before = kept.len();
        let end = (range.end as usize).min(indices.len() / 3);
        let start = (range.start as usize).min(end);
        for (triangle, t) in indices[start * 3..end * 3].chunks_exact(3).zip(range.start..) {
            let at = |i: usize| positions.get(triangle[i] as usize).copied();
            let gone = match (at(0), at(1), at(2)) {
                (Some(a), Some(b), Some(c)) => self.flattens(&[a, b, c]),
                _ => false,
            };
            if !gone {
                kept.push(t);
            }
        }
        kept.len() - before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(rows: [[f32; 3]; 3]) -> Transform {
        let columns = [0, 1, 2].each(|j| [0, 1, 2].each(|i| rows[i][j]));
        Transform { linear: columns, ..Transform::IDENTITY }
    }

    /// Returns the rank of `transform`. Asserts that `Transform` and `Flattening` agree on it.
    fn rank(transform: Transform) -> u8 {
        assert_eq!(transform.rank(), Flattening::of(&transform).rank());
        transform.rank()
    }

    #[test]
    fn ranks_are_exact() {
        assert_eq!(rank(Transform::IDENTITY), 3);
        // Nearly singular, yet not: the determinant is 2^-46.
        let e = f32::EPSILON;
        assert_eq!(rank(linear([[1.0 + e, 1.0, 0.0], [1.0, 1.0 - e, 0.0], [0.0, 0.0, 1.0]])), 3);
        assert_eq!(rank(linear([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0]])), 2);
        assert_eq!(rank(linear([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]])), 2);
        assert_eq!(rank(linear([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [3.0, 6.0, 9.0]])), 1);
        assert_eq!(rank(linear([[0.0; 3]; 3])), 0);
        assert_eq!(rank(linear([[f32::NAN; 3]; 3])), 3);
    }

    #[test]
    fn a_flat_instance_loses_the_triangles_along_its_lost_direction() {
        let flat = Flattening::of(&Transform::from_scale_translation([1.0, 0.0, 1.0], [5.0; 3]));
        let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let wall = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(!flat.flattens(&floor) && flat.flattens(&wall));
        let indices = [0, 1, 2, 3, 4, 5, 0, 1, 9];
        let positions: Vec<_> = floor.into_iter().chain(wall).collect();
        let mut kept = Vec::new();
        assert_eq!(flat.keep_into(&positions, &indices, 0..5, &mut kept), 2);
        assert_eq!(kept, [0, 2], "the last has a vertex out of range, and is kept");
    }

    #[test]
    fn nothing_is_left_of_a_line() {
        let line = Flattening::of(&linear([[1.0, 1.0, 1.0], [0.0; 3], [0.0; 3]]));
        assert!(line.rank() < 2);
        assert!(line.flattens(&[[0.0, 0.0, 0.0], [1.0, 5.0, 0.0], [0.0, 3.0, 1.0]]));
        assert!(!line.flattens(&[[f32::NAN, 0.0, 0.0], [1.0, 5.0, 0.0], [0.0, 3.0, 1.0]]));
    }
}
