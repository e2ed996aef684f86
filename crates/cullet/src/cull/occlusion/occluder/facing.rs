//! Area that a patch shows to an eye.
//!
//! A box on the screen says little about what is hidden: a wall seen along its surface and a patch
//! that faces away have large boxes. With the area vector aᵢ of each triangle, half the cross
//! product of its edges, and v from the shape to the eye, Σ max(0, aᵢ·v) is what faces the eye; it
//! is half of Σ |aᵢ·v| + Σ aᵢ·v. The second sum is a product with one vector. The first is at most
//! Σ |vₐ| Σ |aᵢₐ| over the axes a, exact for boxes, and at most √(Σ |aᵢ| · vᵀ (Σ aᵢ aᵢᵀ / |aᵢ|) v) by
//! the inequality of Cauchy and Schwarz, exact for what is flat.

use alloc::vec::Vec;

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
    let mut normals = Vec::new();
    mesh.for_facets(|number, is_own, corners| {
        let [u, v] = [1, 2].map(|k: usize| [0, 1, 2].map(|a: usize| corners[k][a] - corners[0][a]));
        let n = cross(u, v);
        let length = dot(n, n).sqrt();
        let number = usize::from(number);
        normals.resize(normals.len().max(number + 1), None);
        normals[number] = Some((is_own, n.map(|v| v / length)));
    });
    let mut sum = 0.0;
    for edges in &mesh.edges {
        for lane in 0..FACETS {
            let normal = |side: usize| normals.get(usize::from(edges[side][lane]))?.as_ref();
            let [left, right] = [0, 1].map(normal);
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::{Occluder, Patch, Shape};
    use super::*;
    use crate::cull::occlusion::{BoxTests, OcclusionBuffer};
    use crate::{Camera, Depth, Projection, Simd, Transform, View};

    fn facing(positions: &[[f32; 3]], indices: &[u32], two_sided: bool) -> Facing {
        let patch = Patch::cut(positions, indices, Patch::FACETS, two_sided).unwrap().remove(0);
        Facing::of(&patch.mesh)
    }

    proptest! {
        #[test]
        fn what_faces_an_eye_is_never_more_than_estimated(
            corners in prop::collection::vec([-1.0..1.0_f32, -1.0..1.0, -1.0..1.0], 4..9),
            v in [-1.0..1.0_f32, -1.0..1.0, -1.0..1.0],
        ) {
            // A fan: no edge has three triangles.
            let indices: Vec<u32> = (2..corners.len() as u32).flat_map(|i| [0, i - 1, i]).collect();
            let all = facing(&corners, &indices, false);
            let exact: f32 = indices
                .chunks(3)
                .map(|t| {
                    let [p, q, r] = [t[0], t[1], t[2]].map(|i| corners[i as usize]);
                    let [u, w] = [q, r].map(|c| [0, 1, 2].map(|a: usize| c[a] - p[a]));
                    (dot(cross(u, w), v) * 0.5).max(0.0)
                })
                .sum();
            prop_assert!(all.towards(v) >= exact - 1e-4, "{} of {exact}", all.towards(v));
            prop_assert!(all.pixels(v) <= all.towards(v));
        }
    }

    #[test]
    fn a_flat_patch_shows_its_front_alone_and_thin_pieces_next_to_nothing() {
        let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let of = |two_sided, v| facing(&square, &[0, 1, 2, 0, 2, 3], two_sided).towards(v);
        assert!((of(false, [0.6, 0.0, 0.8]) - 0.8).abs() < 1e-5);
        assert!(of(false, [0.6, 0.0, -0.8]) < 1e-5);
        assert!((of(true, [0.6, 0.0, -0.8]) - 0.8).abs() < 1e-5);
        let thin = square.map(|[x, y, z]| [x, y * 0.001, z]);
        // At 100 pixels a unit the square has 10,000, less half of its outline; the strip is a
        // tenth of a pixel wide.
        let of = |positions: &[[f32; 3]]| {
            facing(positions, &[0, 1, 2, 0, 2, 3], false).pixels([0.0, 0.0, 1e4])
        };
        assert!((of(&square) - 9800.0).abs() < 1.0, "{}", of(&square));
        assert_eq!(of(&thin), 0.0);
    }

    #[test]
    fn pixels_of_a_patch_are_about_those_that_it_is_drawn_over() {
        let square = [[-1.0, -1.0, 0.3], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.3]];
        let patch = Patch::cut(&square, &[0, 1, 2, 0, 2, 3], Patch::FACETS, false).unwrap();
        let occluder = Occluder::new(patch.into_iter().map(Shape::Patch).collect());
        let (near, far) = (0.1, 100.0);
        let projections = [
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near, far },
            Projection::Orthographic { left: -4.0, right: 4.0, bottom: -2.5, top: 2.5, near, far },
        ];
        for projection in projections {
            for (eye, is_seen) in [([1.0, 0.5, 5.0], true), ([1.0, 0.5, -5.0], false)] {
                for mirror in [1.0, -1.0] {
                    let camera = Camera::look_at(eye, [0.0; 3], projection);
                    let view = View::new(&camera, Depth::Reversed, [640, 400]).unwrap();
                    let mut buffer = OcclusionBuffer::new([640, 400]).unwrap();
                    buffer.begin(&view, [0.0; 3]);
                    let linear = [[mirror, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 1.0]];
                    let at = Transform { linear, translation: [0.1, 0.0, 0.0] };
                    occluder.shapes()[0].draw(Simd::best(), &mut buffer, &at);
                    let places = (0..400).flat_map(|y| (0..640).map(move |x| [x, y]));
                    let drawn = places.filter(|&[x, y]| buffer.nearness(x, y) > 0.0).count() as f32;
                    let tests = BoxTests::new(&buffer, Simd::best()).for_object(&at);
                    let v = tests.pixels_of_area([0.0, 0.0, 0.15]).unwrap();
                    let pixels = occluder.facing()[0].as_ref().unwrap().pixels(v);
                    assert_eq!(drawn > 0.0, is_seen, "{projection:?} from {eye:?}");
                    let is_near = (pixels - drawn).abs() <= drawn * 0.1;
                    assert!(is_near, "{pixels} of {drawn}, {projection:?} from {eye:?}, {mirror}");
                }
            }
        }
    }
}
