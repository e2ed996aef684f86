//! Triangle planes quantised to 16 bits: twice the memory of the engine's, and no quicker at any
//! level.

use fearless_simd::{Simd, dispatch, i16x16, i32x8, prelude::*};

use crate::methods::bulk::Bulk;
use crate::methods::planes::Frame;

/// The largest number of a quantised eye: 14 bits and a sign, so that four products with a plane
/// fit into 32 bits.
const EYE_LIMIT: f64 = 8191.0;
/// The largest number of a quantised plane.
const PLANE_LIMIT: i32 = 32767;

/// Planes of a mesh's triangles in eight bytes each, as
/// [`Planes8`](cullet::cull::backface::Planes8) in four.
#[derive(Clone, Debug)]
pub struct Planes16 {
    frame: Frame,
    /// (nx, ny) and (nz, −d), so that a multiply-add of pairs yields a triangle a lane.
    xy: Vec<[i16; 2]>,
    zd: Vec<[i16; 2]>,
    len: usize,
}

/// How far the product of a quantised plane and eye may be from the true one.
fn error_bound(eye: [i32; 4]) -> i32 {
    let eye_sum: i32 = eye.iter().map(|v| v.abs()).sum();
    // Half of each factor's partner, and the product of the halves; and what a plane lost before it
    // was quantised: a thin triangle's normal is off by less than 4.5e-7, times 4 products.
    (eye_sum + 4 * PLANE_LIMIT) / 2 + 4 + PLANE_LIMIT / 64
}

impl Planes16 {
    /// The planes of a triangle list, counter-clockwise fronts.
    ///
    /// # Panics
    /// If an index is not below the number of positions.
    #[must_use]
    pub fn new(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        let len = indices.len() / 3;
        let zeros = vec![[0; 2]; len.next_multiple_of(64)];
        let frame = Frame::around(positions);
        let mut planes = Self { frame, xy: zeros.clone(), zd: zeros, len };
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
        let p = self.frame.plane(corners) * f64::from(PLANE_LIMIT);
        // To the nearest: a cast rounds down, and the bias keeps what is cast positive.
        let [x, y, z, d] = p.to_array().map(|v| ((v + 32768.5) as i32 - 32768) as i16);
        self.xy[index] = [x, y];
        self.zd[index] = [z, d];
    }

    /// The oracle of [`Bulk::cull`]: one triangle after the other.
    #[must_use]
    pub fn cull_ref(&self, eye: [f64; 4]) -> Vec<u64> {
        let mut culled = vec![0; self.len.div_ceil(64)];
        if let Some(eye) = self.eye(eye) {
            for i in 0..self.len {
                let p = [self.xy[i][0], self.xy[i][1], self.zd[i][0], self.zd[i][1]];
                let value: i32 = (0..4).map(|k| i32::from(p[k]) * eye[k]).sum();
                culled[i / 64] |= u64::from(value + error_bound(eye) < 0) << (i % 64);
            }
        }
        culled
    }

    fn eye(&self, eye: [f64; 4]) -> Option<[i32; 4]> {
        Some((self.frame.eye(eye)? * EYE_LIMIT).to_array().map(|v| v.round() as i32))
    }
}

impl Bulk<[f64; 4]> for Planes16 {
    fn count_all(&self) -> usize {
        self.len
    }

    fn cull_words(&self, simd: cullet::Simd, eye: [f64; 4], first: usize, culled: &mut [u64]) {
        let Some(eye) = self.eye(eye) else { return culled.fill(0) };
        let range = first * 64..(first + culled.len()) * 64;
        let (xy, zd) = (&self.xy[range.clone()], &self.zd[range]);
        dispatch!(simd.level(), simd => cull16(simd, xy, zd, eye, error_bound(eye), culled));
    }
}

#[inline(always)]
fn cull16<S: Simd>(
    simd: S,
    xy: &[[i16; 2]],
    zd: &[[i16; 2]],
    eye: [i32; 4],
    bound: i32,
    culled: &mut [u64],
) {
    let [x, y, z, w] = eye.map(|v| v as i16);
    let pair =
        |a: i16, b: i16| i16x16::simd_from(simd, [a, b, a, b, a, b, a, b, a, b, a, b, a, b, a, b]);
    let (eye_xy, eye_zd) = (pair(x, y), pair(z, w));
    let bound = i32x8::splat(simd, bound);
    let words = xy.as_chunks::<64>().0.iter().zip(zd.as_chunks::<64>().0);
    for ((xy, zd), culled) in words.zip(culled) {
        let (xy, zd) = (xy.as_flattened(), zd.as_flattened());
        *culled = 0;
        for group in 0..8 {
            let load = |s: &[i16]| i16x16::from_slice(simd, &s[group * 16..][..16]);
            let value = load(xy).pairwise_dot_product(eye_xy)
                + load(zd).pairwise_dot_product(eye_zd)
                + bound;
            *culled |= value.simd_lt(i32x8::splat(simd, 0)).to_bitmask() << (group * 8);
        }
    }
}
