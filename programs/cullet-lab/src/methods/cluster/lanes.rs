//! Sixteen bounds in a block, a row for each number, and the arithmetic that their tests share.
//!
//! The products are added up as those of [`Bound::is_behind_eye`] are, so that the answers are the
//! same.

use cullet::cull::backface::ClusterEye;
use fearless_simd::{Simd, prelude::*};

use super::Bound;

/// One number of sixteen clusters.
pub(super) type Row = [f32; 16];
/// The same in signed bytes.
pub(super) type ByteRow = [i8; 16];

/// A bound of which sixteen are kept in a block.
pub trait Lanes: Bound {
    /// Sixteen bounds.
    type Block: Copy + std::fmt::Debug + Send + Sync;
    /// Sixteen bounds that no eye is behind: zeros, for every bound here.
    const NOTHING: Self::Block;
    /// Sets one of the sixteen.
    fn set_lane(&self, block: &mut Self::Block, lane: usize);
    /// Bits of as many bounds, from `start` on, as a vector has lanes: those that the eye is
    /// behind.
    fn test_lanes<S: Simd>(simd: S, block: &Self::Block, start: usize, eye: &ClusterEye) -> u64;
}

/// Rows of a bound that is nothing but f32 numbers.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Rows<const R: usize>([Row; R]);

impl<const R: usize> Rows<R> {
    pub(super) const ZERO: Self = Self([[0.0; 16]; R]);

    pub(super) fn set(&mut self, lane: usize, numbers: [f32; R]) {
        self.0.iter_mut().zip(numbers).for_each(|(row, v)| row[lane] = v);
    }

    /// Three rows from row `at` on.
    #[inline(always)]
    pub(super) fn three(&self, at: usize) -> &[Row; 3] {
        self.0[at..].first_chunk().unwrap_or(&ZEROS)
    }

    /// Row `at`.
    #[inline(always)]
    pub(super) fn one(&self, at: usize) -> &Row {
        &self.0[at]
    }
}

pub(super) const ZEROS: [Row; 3] = [[0.0; 16]; 3];

/// [`Lanes`] of a bound that is nothing but f32 numbers, by the expression of its test.
macro_rules! plain {
    ($bound:ty, $rows:literal, |$simd:ident, $block:ident, $start:ident, $eye:ident| $test:expr) => {
        impl $crate::methods::cluster::Lanes for $bound {
            type Block = $crate::methods::cluster::Rows<$rows>;
            const NOTHING: $crate::methods::cluster::Rows<$rows> =
                $crate::methods::cluster::Rows::ZERO;

            fn set_lane(&self, block: &mut Self::Block, lane: usize) {
                block.set(lane, bytemuck::cast(*self));
            }

            #[inline(always)]
            fn test_lanes<S: Simd>(
                $simd: S,
                $block: &Self::Block,
                $start: usize,
                $eye: &ClusterEye,
            ) -> u64 {
                $test
            }
        }
    };
}
pub(super) use plain;

#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, row: &Row, start: usize) -> S::f32s {
    S::f32s::from_slice(simd, &row[start..start + S::f32s::LEN])
}

#[inline(always)]
pub(super) fn load_bytes<S: Simd>(simd: S, row: &ByteRow, start: usize) -> S::f32s {
    let mut floats = [0.0; 16];
    for i in 0..S::f32s::LEN {
        floats[i] = f32::from(row[start + i]);
    }
    S::f32s::from_slice(simd, &floats[..S::f32s::LEN])
}

// Written out where a closure would do: one that is not inlined is compiled without the level's
// instructions, and costs ten times as much.
#[inline(always)]
pub(super) fn to_eye<S: Simd>(
    simd: S,
    apex: &[Row; 3],
    start: usize,
    eye: &ClusterEye,
) -> [S::f32s; 3] {
    let w = S::f32s::splat(simd, eye.weight());
    let [x, y, z] = rows::<S>(simd, apex, start);
    let [ex, ey, ez] = eye.xyz();
    [
        S::f32s::splat(simd, ex) - x * w,
        S::f32s::splat(simd, ey) - y * w,
        S::f32s::splat(simd, ez) - z * w,
    ]
}

#[inline(always)]
pub(super) fn dot<S: Simd>(a: [S::f32s; 3], b: [S::f32s; 3]) -> S::f32s {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn rows<S: Simd>(simd: S, rows: &[Row; 3], start: usize) -> [S::f32s; 3] {
    let [x, y, z] = rows;
    [load::<S>(simd, x, start), load::<S>(simd, y, start), load::<S>(simd, z, start)]
}

#[inline(always)]
pub(super) fn byte_rows<S: Simd>(simd: S, rows: &[ByteRow; 3], start: usize) -> [S::f32s; 3] {
    let [x, y, z] = rows;
    let load = load_bytes::<S>;
    [load(simd, x, start), load(simd, y, start), load(simd, z, start)]
}

/// z < 0 and z² − q > TINY.
#[inline(always)]
pub(super) fn in_cone<S: Simd>(simd: S, z: S::f32s, q: S::f32s) -> u64 {
    let negative = z.simd_lt(S::f32s::splat(simd, 0.0));
    let above = (z * z - q).simd_gt(S::f32s::splat(simd, ClusterEye::LEAST_SQUARE));
    (negative & above).to_bitmask()
}
