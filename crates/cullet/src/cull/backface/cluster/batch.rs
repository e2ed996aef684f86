//! Many elliptic cones against one eye, with SIMD.
//!
//! Cones are kept in blocks of sixteen, a row for each number, and tested as many at a time as a
//! vector is wide. The arithmetic is that of [`EllipticCone::is_behind_eye`], product by product,
//! so the answers are the same at every level.

use alloc::vec::Vec;

use crate::array::Each;
use crate::simd::dispatch_256;
use fearless_simd::{Simd, prelude::*};

use super::{ClusterEye, EllipticCone};

/// One number of sixteen clusters.
type Row = [f32; 16];

/// Apex, axis, s and t of sixteen cones. Zeros are a cone that no eye is behind.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Block([[Row; 3]; 4]);

/// Blocks a word of 64 bits.
const BLOCKS: usize = 4;

/// The cones of many clusters, structure of arrays: 48 bytes each.
#[derive(Clone, Debug, Default)]
pub struct EllipticCones {
    blocks: Vec<Block>,
    len: usize,
}

impl FromIterator<Option<EllipticCone>> for EllipticCones {
    /// Clusters without a cone are never culled.
    fn from_iter<I: IntoIterator<Item = Option<EllipticCone>>>(cones: I) -> Self {
        let mut all = Self::default();
        cones.into_iter().for_each(|cone| all.push(cone));
        all
    }
}

impl EllipticCones {
    /// Adds a cluster; `None` is one that is never culled.
    pub fn push(&mut self, cone: Option<EllipticCone>) {
        if self.len.is_multiple_of(16 * BLOCKS) {
            self.blocks.extend([Block([[[0.0; 16]; 3]; 4]); BLOCKS]);
        }
        if let Some(EllipticCone { apex, axis, s, t }) = cone {
            let block = &mut self.blocks[self.len / 16].0;
            for (rows, vector) in block.iter_mut().zip([apex, axis, s, t]) {
                (0..3).for_each(|k| rows[k][self.len % 16] = vector[k]);
            }
        }
        self.len += 1;
    }

    /// How many clusters there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The cone of a cluster; `None` for one that is never culled.
    ///
    /// # Panics
    /// If there is no such cluster.
    #[must_use]
    pub fn get(&self, cluster: usize) -> Option<EllipticCone> {
        assert!(cluster < self.len, "cluster {cluster} of {}", self.len);
        let block = &self.blocks[cluster / 16].0;
        let [apex, axis, s, t] = block.each(|rows| rows.each(|row| row[cluster % 16]));
        (axis != [0.0; 3]).then_some(EllipticCone { apex, axis, s, t })
    }

    /// Words `first..` of the mask of the clusters that the eye is proved behind, as many as
    /// `culled` has; the bits beyond the last cluster are 0. The same at every level.
    ///
    /// # Panics
    /// If the words reach beyond the last cluster's.
    pub fn cull_words(
        &self,
        simd: crate::Simd,
        eye: &ClusterEye,
        first: usize,
        culled: &mut [u64],
    ) {
        let blocks = &self.blocks[first * BLOCKS..(first + culled.len()) * BLOCKS];
        dispatch_256!(simd, simd => words(simd, blocks, eye, culled));
    }
}

#[inline(always)]
fn words<S: Simd>(simd: S, blocks: &[Block], eye: &ClusterEye, out: &mut [u64]) {
    for (blocks, out) in blocks.as_chunks::<BLOCKS>().0.iter().zip(out) {
        *out = 0;
        for (i, block) in blocks.iter().enumerate() {
            for start in (0..16).step_by(S::f32s::LEN) {
                *out |= test_lanes(simd, block, start, eye) << (i * 16 + start);
            }
        }
    }
}

// Written out where closures would do: one that is not inlined is compiled without the level's
// instructions, and costs ten times as much.
#[inline(always)]
fn test_lanes<S: Simd>(simd: S, block: &Block, start: usize, eye: &ClusterEye) -> u64 {
    let [apex, axis, s, t] = &block.0;
    let weight = S::f32s::splat(simd, eye.weight());
    let [x, y, z] = rows::<S>(simd, apex, start);
    let [ex, ey, ez] = eye.xyz();
    let w = [
        S::f32s::splat(simd, ex) - x * weight,
        S::f32s::splat(simd, ey) - y * weight,
        S::f32s::splat(simd, ez) - z * weight,
    ];
    let z = dot::<S>(rows(simd, axis, start), w);
    let s = dot::<S>(rows(simd, s, start), w);
    let t = dot::<S>(rows(simd, t, start), w);
    let negative = z.simd_lt(S::f32s::splat(simd, 0.0));
    let above = (z * z - (s * s + t * t)).simd_gt(S::f32s::splat(simd, ClusterEye::LEAST_SQUARE));
    (negative & above).to_bitmask()
}

#[inline(always)]
fn dot<S: Simd>(a: [S::f32s; 3], b: [S::f32s; 3]) -> S::f32s {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn rows<S: Simd>(simd: S, [x, y, z]: &[Row; 3], start: usize) -> [S::f32s; 3] {
    let at = start..start + S::f32s::LEN;
    [
        S::f32s::from_slice(simd, &x[at.clone()]),
        S::f32s::from_slice(simd, &y[at.clone()]),
        S::f32s::from_slice(simd, &z[at]),
    ]
}
