//! Triangle planes in f32: 16 bytes each, the reference of the quantised forms in size and speed.

use cullet::Level;
use cullet::bounds::Aabb;
use cullet::cull::Indices;
use cullet::cull::backface::ClusterPlanes;
use fearless_simd::{Simd, dispatch, prelude::*};
use glam::{DVec3, DVec4};

use crate::answers;

/// Planes of a mesh's triangles in sixteen bytes each.
#[derive(Clone, Debug)]
pub struct Planes32 {
    /// What offsets are relative to, and divided by, so that they are comparable to normals.
    centre: DVec3,
    scale: f64,
    /// nx, ny, nz and −d of sixteen triangles, the largest number of each triangle ±1.
    blocks: Vec<Block>,
    len: usize,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Block([[f32; 16]; 4]);

/// How far the product of a plane and an eye, both with numbers up to 1, may be from the true one: the
/// four numbers of each are rounded (2⁻²⁴ of each product twice), so are products and sums (2⁻²⁴ of at
/// most 4, seven times), and a thin triangle's normal is off by up to 4.5e-7 in each of four products.
const ERROR: f32 = 4e-6;

impl Planes32 {
    /// The planes of a triangle list, counter-clockwise fronts.
    ///
    /// # Panics
    /// If an index is not below the number of positions.
    #[must_use]
    pub fn new(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        let len = indices.len() / 3;
        let blocks = vec![Block([[0.0; 16]; 4]); len.next_multiple_of(64) / 16];
        let bounds = Aabb::from_points(positions);
        let centre = if bounds.is_empty() { DVec3::ZERO } else { bounds.center().into() };
        let scale = DVec3::from(bounds.half_extent()).length();
        let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
        let mut planes = Self { centre, scale, blocks, len };
        for (i, t) in indices.as_chunks::<3>().0.iter().enumerate() {
            planes.set(i, t.map(|v| positions[v as usize]));
        }
        planes
    }

    /// Replaces the plane of triangle `index`; see [`Planes8::set`](cullet::cull::backface::Planes8::set).
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    pub fn set(&mut self, index: usize, corners: [[f32; 3]; 3]) {
        assert!(index < self.len, "triangle {index} of {}", self.len);
        // A sliver has no plane: zeros, which no eye is behind.
        let triangle = ClusterPlanes::new([corners]);
        let plane = triangle.half_spaces().next().map_or(DVec4::ZERO, |(n, d)| {
            let n = DVec3::from(n);
            let plane = n.extend((n.dot(self.centre) - d) / self.scale);
            plane / plane.abs().max_element()
        });
        for (row, v) in self.blocks[index / 16].0.iter_mut().zip(plane.to_array()) {
            row[index % 16] = v as f32;
        }
    }

    /// How many triangles there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no triangle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// As [`Planes8::cull`](cullet::cull::backface::Planes8::cull).
    pub fn cull(&self, level: Level, eye: [f64; 4], culled: &mut Vec<u64>) {
        let eye = self.relative(eye);
        answers::cull(self.len, culled, |first, out| self.words(level, eye, first, out));
    }

    /// How many triangles [`cull`](Self::cull) culls.
    #[must_use]
    pub fn count(&self, level: Level, eye: [f64; 4]) -> u64 {
        let eye = self.relative(eye);
        answers::count(self.len, |first, out| self.words(level, eye, first, out))
    }

    /// Lists the triangles that are *not* culled, ascending.
    pub fn keep(&self, level: Level, eye: [f64; 4], kept: &mut Indices) {
        let eye = self.relative(eye);
        answers::keep(self.len, level, kept, |first, out| self.words(level, eye, first, out));
    }

    /// The oracle of [`cull`](Self::cull): one triangle after the other.
    #[must_use]
    pub fn cull_ref(&self, eye: [f64; 4]) -> Vec<u64> {
        let mut culled = vec![0; self.len.div_ceil(64)];
        if let Some(e) = self.relative(eye) {
            for i in 0..self.len {
                let [x, y, z, d] = self.blocks[i / 16].0.map(|row| row[i % 16]);
                let value = (x * e[0] + y * e[1]) + (z * e[2] + d * e[3]);
                culled[i / 64] |= u64::from(value < -ERROR) << (i % 64);
            }
        }
        culled
    }

    /// The eye in units of the planes, its largest number ±1; `None` where it is not finite, zero, or of
    /// negative weight.
    fn relative(&self, eye: [f64; 4]) -> Option<[f32; 4]> {
        let eye = DVec4::from(eye);
        let e = (eye.truncate() - self.centre * eye.w).extend(eye.w * self.scale);
        let largest = e.abs().max_element();
        // The largest of some NaN and a number may be the number.
        let right = eye.w >= 0.0 && largest > 0.0 && e.is_finite();
        right.then(|| (e / largest).to_array().map(|v| v as f32))
    }

    fn words(&self, level: Level, eye: Option<[f32; 4]>, first: usize, out: &mut [u64]) {
        let Some(eye) = eye else { return out.fill(0) };
        let blocks = &self.blocks[first * 4..(first + out.len()) * 4];
        dispatch!(level, simd => words(simd, blocks, eye, out));
    }
}

#[inline(always)]
fn words<S: Simd>(simd: S, blocks: &[Block], eye: [f32; 4], out: &mut [u64]) {
    let eye = eye.map(|v| S::f32s::splat(simd, v));
    let limit = S::f32s::splat(simd, -ERROR);
    for (blocks, out) in blocks.as_chunks::<4>().0.iter().zip(out) {
        *out = 0;
        for start in (0..64).step_by(S::f32s::LEN) {
            let rows = &blocks[start / 16].0;
            let product = |k: usize| {
                S::f32s::from_slice(simd, &rows[k][start % 16..start % 16 + S::f32s::LEN]) * eye[k]
            };
            let value = (product(0) + product(1)) + (product(2) + product(3));
            *out |= value.simd_lt(limit).to_bitmask() << start;
        }
    }
}
