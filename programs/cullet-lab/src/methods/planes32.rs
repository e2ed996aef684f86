//! Triangle planes in f32: 16 bytes each, the reference of the quantised forms in size and speed.

use fearless_simd::{Simd, dispatch, prelude::*};

use crate::methods::bulk::Bulk;
use crate::methods::planes::Frame;

/// Planes of a mesh's triangles in sixteen bytes each.
#[derive(Clone, Debug)]
pub struct Planes32 {
    frame: Frame,
    /// nx, ny, nz and −d of sixteen triangles, the largest number of each triangle ±1.
    blocks: Vec<Block>,
    len: usize,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Block([[f32; 16]; 4]);

/// How far the product of a plane and an eye, both with numbers up to 1, may be from the true one:
/// the four numbers of each are rounded (2⁻²⁴ of each product twice), so are products and sums
/// (2⁻²⁴ of at most 4, seven times), and a thin triangle's normal is off by up to 4.5e-7 in each of
/// four products.
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
        let mut planes = Self { frame: Frame::around(positions), blocks, len };
        for (i, t) in indices.as_chunks::<3>().0.iter().enumerate() {
            planes.set(i, t.map(|v| positions[v as usize]));
        }
        planes
    }

    /// Replaces the plane of triangle `index`; see
    /// [`Planes8::set`](cullet::cull::backface::Planes8::set).
    ///
    /// # Panics
    /// If `index` is not below the number of triangles.
    pub fn set(&mut self, index: usize, corners: [[f32; 3]; 3]) {
        assert!(index < self.len, "triangle {index} of {}", self.len);
        let plane = self.frame.plane(corners);
        for (row, v) in self.blocks[index / 16].0.iter_mut().zip(plane.to_array()) {
            row[index % 16] = v as f32;
        }
    }

    /// The oracle of [`Bulk::cull`]: one triangle after the other.
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

    fn relative(&self, eye: [f64; 4]) -> Option<[f32; 4]> {
        Some(self.frame.eye(eye)?.to_array().map(|v| v as f32))
    }
}

impl Bulk<[f64; 4]> for Planes32 {
    fn count_all(&self) -> usize {
        self.len
    }

    fn cull_words(&self, simd: cullet::Simd, eye: [f64; 4], first: usize, culled: &mut [u64]) {
        let Some(eye) = self.relative(eye) else { return culled.fill(0) };
        let blocks = &self.blocks[first * 4..(first + culled.len()) * 4];
        dispatch!(simd.level(), simd => words(simd, blocks, eye, culled));
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
