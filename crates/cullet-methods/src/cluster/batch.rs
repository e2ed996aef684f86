//! Many clusters against one eye, with SIMD.
//!
//! Bounds are kept in blocks of sixteen, a row for each number, and tested as many at a time as a vector
//! is wide. The arithmetic is that of [`Bound::is_behind`], product by product, so the answers are the
//! same at every level.

use cullet::Level;
use cullet::cull::backface::ClusterEye;
use fearless_simd::{Simd, dispatch, prelude::*};

use super::{
    Batch, Bound, EllipticConeQuantised, NormalBox, NormalBoxAtOrigin, NormalBoxTurned, NormalCone,
    NormalConeCentre, Pyramid,
};
use crate::bulk::Bulk;

/// One number of sixteen clusters.
type Row = [f32; 16];
/// The same in signed bytes.
type ByteRow = [i8; 16];

/// The bounds of many clusters: answers as a mask, a count or a list.
#[derive(Clone, Debug)]
pub struct ClusterBounds<B: Bound> {
    batch: B::Batch,
}

impl<B: Bound> Default for ClusterBounds<B> {
    fn default() -> Self {
        Self { batch: B::Batch::default() }
    }
}

impl<B: Bound> FromIterator<Option<B>> for ClusterBounds<B> {
    /// Clusters without a bound are never culled.
    fn from_iter<I: IntoIterator<Item = Option<B>>>(bounds: I) -> Self {
        let mut all = Self::default();
        bounds.into_iter().for_each(|b| all.push(b));
        all
    }
}

impl<B: Bound> ClusterBounds<B> {
    /// Adds a cluster; `None` is one that is never culled.
    pub fn push(&mut self, bound: Option<B>) {
        self.batch.push(bound);
    }

    /// How many clusters there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.batch.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.batch.is_empty()
    }

    /// Bits of 64 clusters.
    pub(super) fn word(&self, level: Level, word: usize, eye: &ClusterEye) -> u64 {
        let mut out = [0];
        self.batch.cull_words(level, eye, word, &mut out);
        out[0]
    }
}

/// An eye that is none (see [`ClusterEye::new`]) culls nothing.
impl<B: Bound> Bulk<[f64; 4]> for ClusterBounds<B> {
    fn count_all(&self) -> usize {
        self.len()
    }

    fn cull_words(&self, level: Level, eye: [f64; 4], first: usize, culled: &mut [u64]) {
        match ClusterEye::new(eye) {
            Some(eye) => self.batch.cull_words(level, &eye, first, culled),
            None => culled.fill(0),
        }
    }
}

/// A bound of which sixteen are kept in a block.
pub trait Lanes: Bound {
    /// Sixteen bounds.
    type Block: Copy + std::fmt::Debug + Send + Sync;
    /// Sixteen bounds that no eye is behind: zeros, for every bound here.
    const NOTHING: Self::Block;
    /// Sets one of the sixteen.
    fn set_lane(&self, block: &mut Self::Block, lane: usize);
    /// Bits of as many bounds, from `start` on, as a vector has lanes: those that the eye is behind.
    fn test_lanes<S: Simd>(simd: S, block: &Self::Block, start: usize, eye: &ClusterEye) -> u64;
}

/// Blocks of sixteen bounds each: the batch of every bound that has no better.
#[derive(Clone, Debug)]
pub struct Blocks<B: Lanes> {
    blocks: Vec<B::Block>,
    len: usize,
}

/// Blocks a word of 64 bits.
const BLOCKS: usize = 4;

impl<B: Lanes> Default for Blocks<B> {
    fn default() -> Self {
        Self { blocks: Vec::new(), len: 0 }
    }
}

impl<B: Lanes> Batch<B> for Blocks<B> {
    fn push(&mut self, bound: Option<B>) {
        if self.len.is_multiple_of(16 * BLOCKS) {
            self.blocks.extend([B::NOTHING; BLOCKS]);
        }
        if let Some(bound) = bound {
            bound.set_lane(&mut self.blocks[self.len / 16], self.len % 16);
        }
        self.len += 1;
    }

    fn len(&self) -> usize {
        self.len
    }

    fn cull_words(&self, level: Level, eye: &ClusterEye, first: usize, culled: &mut [u64]) {
        let blocks = &self.blocks[first * BLOCKS..(first + culled.len()) * BLOCKS];
        dispatch!(level, simd => words::<_, B>(simd, blocks, eye, culled));
    }
}

#[inline(always)]
fn words<S: Simd, B: Lanes>(simd: S, blocks: &[B::Block], eye: &ClusterEye, out: &mut [u64]) {
    for (blocks, out) in blocks.as_chunks::<BLOCKS>().0.iter().zip(out) {
        *out = 0;
        for (i, block) in blocks.iter().enumerate() {
            for start in (0..16).step_by(S::f32s::LEN) {
                *out |= B::test_lanes(simd, block, start, eye) << (i * 16 + start);
            }
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, row: &Row, start: usize) -> S::f32s {
    S::f32s::from_slice(simd, &row[start..start + S::f32s::LEN])
}

#[inline(always)]
fn load_bytes<S: Simd>(simd: S, row: &ByteRow, start: usize) -> S::f32s {
    let mut floats = [0.0; 16];
    for i in 0..S::f32s::LEN {
        floats[i] = f32::from(row[start + i]);
    }
    S::f32s::from_slice(simd, &floats[..S::f32s::LEN])
}

// Written out where a closure would do: one that is not inlined is compiled without the level's
// instructions, and costs ten times as much.
#[inline(always)]
fn to_eye<S: Simd>(simd: S, apex: &[Row; 3], start: usize, eye: &ClusterEye) -> [S::f32s; 3] {
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
fn dot<S: Simd>(a: [S::f32s; 3], b: [S::f32s; 3]) -> S::f32s {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn rows<S: Simd>(simd: S, rows: &[Row; 3], start: usize) -> [S::f32s; 3] {
    let [x, y, z] = rows;
    [load::<S>(simd, x, start), load::<S>(simd, y, start), load::<S>(simd, z, start)]
}

#[inline(always)]
fn byte_rows<S: Simd>(simd: S, rows: &[ByteRow; 3], start: usize) -> [S::f32s; 3] {
    let [x, y, z] = rows;
    let load = load_bytes::<S>;
    [load(simd, x, start), load(simd, y, start), load(simd, z, start)]
}

/// z < 0 and z² − q > TINY.
#[inline(always)]
fn in_cone<S: Simd>(simd: S, z: S::f32s, q: S::f32s) -> u64 {
    let negative = z.simd_lt(S::f32s::splat(simd, 0.0));
    let above = (z * z - q).simd_gt(S::f32s::splat(simd, ClusterEye::LEAST_SQUARE));
    (negative & above).to_bitmask()
}

/// Rows of a bound that is nothing but f32 numbers.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Rows<const R: usize>([Row; R]);

impl<const R: usize> Rows<R> {
    fn set(&mut self, lane: usize, numbers: [f32; R]) {
        self.0.iter_mut().zip(numbers).for_each(|(row, v)| row[lane] = v);
    }

    /// Three rows from row `at` on.
    #[inline(always)]
    fn three(&self, at: usize) -> &[Row; 3] {
        self.0[at..].first_chunk().unwrap_or(&ZEROS)
    }
}

const ZEROS: [Row; 3] = [[0.0; 16]; 3];

macro_rules! plain {
    ($bound:ty, $rows:literal, |$simd:ident, $block:ident, $start:ident, $eye:ident| $test:expr) => {
        impl Lanes for $bound {
            type Block = Rows<$rows>;
            const NOTHING: Rows<$rows> = Rows([[0.0; 16]; $rows]);

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

plain!(NormalCone, 7, |simd, block, start, eye| {
    let w = to_eye(simd, block.three(0), start, eye);
    let z = dot::<S>(rows(simd, block.three(3), start), w);
    let cutoff = load::<S>(simd, &block.0[6], start);
    in_cone(simd, z, cutoff * cutoff * dot::<S>(w, w))
});

plain!(NormalConeCentre, 8, |simd, block, start, eye| {
    let w = to_eye(simd, block.three(0), start, eye);
    let room = load::<S>(simd, &block.0[3], start) * S::f32s::splat(simd, eye.weight());
    let z = S::f32s::splat(simd, 0.0) - dot::<S>(rows(simd, block.three(4), start), w) - room;
    let cutoff = load::<S>(simd, &block.0[7], start);
    let least = S::f32s::splat(simd, NormalConeCentre::LEAST);
    let above = z * z - cutoff * cutoff * dot::<S>(w, w);
    (z.simd_gt(least) & above.simd_gt(S::f32s::splat(simd, ClusterEye::LEAST_SQUARE))).to_bitmask()
});

plain!(NormalBox, 10, |simd, block, start, eye| {
    let v = to_eye(simd, block.three(7), start, eye);
    behind_box(simd, [block.three(0), block.three(3)], &block.0[6], v, start, eye)
});

plain!(NormalBoxAtOrigin, 7, |simd, block, start, eye| {
    let v = eye.xyz().map(|v| S::f32s::splat(simd, v));
    behind_box(simd, [block.three(0), block.three(3)], &block.0[6], v, start, eye)
});

plain!(NormalBoxTurned, 19, |simd, block, start, eye| {
    let v = to_eye(simd, block.three(16), start, eye);
    let v = [
        dot::<S>(rows(simd, block.three(0), start), v),
        dot::<S>(rows(simd, block.three(3), start), v),
        dot::<S>(rows(simd, block.three(6), start), v),
    ];
    behind_box(simd, [block.three(9), block.three(12)], &block.0[15], v, start, eye)
});

/// Σ max(mₖvₖ, m′ₖvₖ) < d.
#[inline(always)]
fn behind_box<S: Simd>(
    simd: S,
    [largest, smallest]: [&[Row; 3]; 2],
    d: &Row,
    v: [S::f32s; 3],
    start: usize,
    eye: &ClusterEye,
) -> u64 {
    let part = |k: usize| {
        let a = load::<S>(simd, &largest[k], start) * v[k];
        let b = load::<S>(simd, &smallest[k], start) * v[k];
        a.max(b)
    };
    let sum = part(0) + part(1) + part(2);
    let d = load::<S>(simd, d, start) * S::f32s::splat(simd, eye.weight());
    sum.simd_lt(d).to_bitmask()
}

/// Sixteen elliptic cones in bytes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct ByteRows {
    apex: [Row; 3],
    /// axis, s and t.
    vectors: [[ByteRow; 3]; 3],
}

impl Lanes for EllipticConeQuantised {
    type Block = ByteRows;
    const NOTHING: ByteRows = ByteRows { apex: ZEROS, vectors: [[[0; 16]; 3]; 3] };

    fn set_lane(&self, block: &mut ByteRows, lane: usize) {
        for k in 0..3 {
            block.apex[k][lane] = self.apex[k];
            for (rows, vector) in block.vectors.iter_mut().zip([self.axis, self.s, self.t]) {
                rows[k][lane] = vector[k];
            }
        }
    }

    #[inline(always)]
    fn test_lanes<S: Simd>(simd: S, block: &ByteRows, start: usize, eye: &ClusterEye) -> u64 {
        let w = to_eye(simd, &block.apex, start, eye);
        let [axis, s, t] = &block.vectors;
        let z = dot::<S>(byte_rows(simd, axis, start), w);
        let s = dot::<S>(byte_rows(simd, s, start), w);
        let t = dot::<S>(byte_rows(simd, t, start), w);
        in_cone(simd, z, s * s + t * t)
    }
}

/// Sixteen pyramids.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct PyramidRows<const K: usize> {
    apex: [Row; 3],
    generators: [[Row; 3]; K],
}

impl<const K: usize> Lanes for Pyramid<K> {
    type Block = PyramidRows<K>;
    const NOTHING: PyramidRows<K> = PyramidRows { apex: ZEROS, generators: [ZEROS; K] };

    fn set_lane(&self, block: &mut PyramidRows<K>, lane: usize) {
        for k in 0..3 {
            block.apex[k][lane] = self.apex[k];
            for (rows, g) in block.generators.iter_mut().zip(self.generators) {
                rows[k][lane] = g[k];
            }
        }
    }

    #[inline(always)]
    fn test_lanes<S: Simd>(simd: S, block: &PyramidRows<K>, start: usize, eye: &ClusterEye) -> u64 {
        let w = to_eye(simd, &block.apex, start, eye);
        let zero = S::f32s::splat(simd, 0.0);
        let behind = |g: &[Row; 3]| dot::<S>(rows(simd, g, start), w).simd_lt(zero);
        let mut all = zero.simd_eq(zero);
        for g in &block.generators {
            all &= behind(g);
        }
        all.to_bitmask()
    }
}
