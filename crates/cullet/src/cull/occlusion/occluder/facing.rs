//! Area that a patch shows to an eye.
//!
//! A box on the screen says little about what is hidden: a wall seen along its surface and a patch
//! that faces away have large boxes. With the area vector aᵢ of each triangle, half the cross
//! product of its edges, and v from the shape to the eye, Σ max(0, aᵢ·v) is what faces the eye; it
//! is half of Σ |aᵢ·v| + Σ aᵢ·v. The second sum is a product with one vector. The first is at most
//! Σ |vₐ| Σ |aᵢₐ| over the axes a, exact for boxes, and at most √(Σ |aᵢ| · vᵀ (Σ aᵢ aᵢᵀ / |aᵢ|) v) by
//! the inequality of Cauchy and Schwarz, exact for what is flat.

use alloc::collections::BTreeMap;

use super::super::raster::{Connected, FACETS};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// Pixels that are lost for each pixel of the outline.
const LOST_OF_OUTLINE: f32 = 0.5;

/// Sums over the triangles of a patch that bound the area which faces an eye.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Facing {
    /// Σ a, Σ |a| along each axis, and Σ of the lengths.
    net: [f32; 3],
    along: [f32; 3],
    total: f32,
    /// Σ a aᵀ / |a|: xx, yy, zz, xy, yz, zx.
    spread: [f32; 6],
    /// Backs hide too, and are not the backs of fronts.
    two_sided: bool,
    /// Mean length of the outline over all directions: an edge is part of it as often as its facets
    /// bend, one without a second facet always.
    outline: f32,
}

impl Facing {
    pub(super) fn of(mesh: &Connected) -> Self {
        let outline = mean_outline(mesh);
        let mut all = Self { two_sided: mesh.two_sided, outline, ..Self::default() };
        mesh.for_facets(|_, is_own, corners| {
            for pair in corners[1..].windows(2).filter(|_| is_own) {
                all.add([corners[0], pair[0], pair[1]]);
            }
        });
        all
    }

    fn add(&mut self, [p, q, r]: [[f32; 3]; 3]) {
        let (u, v) = ([0, 1, 2].map(|a| q[a] - p[a]), [0, 1, 2].map(|a| r[a] - p[a]));
        let a = cross(u, v).map(|v| v * 0.5);
        let length = dot(a, a).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        for i in 0..3 {
            self.net[i] += a[i];
            self.along[i] += a[i].abs();
            self.spread[i] += a[i] * a[i] / length;
            self.spread[i + 3] += a[i] * a[(i + 1) % 3] / length;
        }
        self.total += length;
    }

    /// Returns about the number of pixels that the shape covers whole, where a triangle of area
    /// vector a that faces the eye has a·v pixels. Along the outline pixels are covered in part, of
    /// which a shape in many thin pieces loses most.
    pub(crate) fn pixels(&self, v: [f32; 3]) -> f32 {
        let pixels_of_length = dot(v, v).sqrt().sqrt();
        (self.towards(v) - LOST_OF_OUTLINE * pixels_of_length * self.outline).max(0.0)
    }

    /// Returns about the area that faces an eye in the direction `v`, times the length of `v`, and
    /// no less than that.
    fn towards(&self, v: [f32; 3]) -> f32 {
        let along = dot(v.map(f32::abs), self.along);
        let [xx, yy, zz, xy, yz, zx] = self.spread;
        let squares = dot([v[0] * v[0], v[1] * v[1], v[2] * v[2]], [xx, yy, zz]);
        let products = dot([v[0] * v[1], v[1] * v[2], v[2] * v[0]], [xy, yz, zx]);
        let both = along.min(((squares + 2.0 * products).max(0.0) * self.total).sqrt());
        if self.two_sided { both } else { (both + dot(v, self.net)).max(0.0) * 0.5 }
    }
}

/// Mean length of the outline of the own facets of a patch.
fn mean_outline(mesh: &Connected) -> f32 {
    let mut normals = BTreeMap::new();
    mesh.for_facets(|number, is_own, corners| {
        let [u, v] = [1, 2].map(|k: usize| [0, 1, 2].map(|a: usize| corners[k][a] - corners[0][a]));
        let n = cross(u, v);
        let length = dot(n, n).sqrt();
        normals.insert(number, (is_own, n.map(|v| v / length)));
    });
    let mut sum = 0.0;
    for edges in &mesh.edges {
        for lane in 0..FACETS {
            let [left, right] = [0, 1].map(|side: usize| normals.get(&edges[side][lane]));
            let share = match (left, right) {
                // Normals at an angle have the eye between them as often as that is of half a turn.
                (Some((a, n)), Some((b, m))) if *a || *b => (1.0 - dot(*n, *m)) * 0.5,
                (Some((true, _)), None) | (None, Some((true, _))) => 1.0,
                _ => 0.0,
            };
            let [p, q] = [2, 3].map(|end: usize| mesh.place_of(edges[end][lane]));
            let along = [0, 1, 2].map(|a: usize| q[a] - p[a]);
            // A facet without area has no normal.
            sum += if share > 0.0 { share * dot(along, along).sqrt() } else { 0.0 };
        }
    }
    sum
}

pub(crate) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
