//! The six planes of a view with AVX-512: thirty-two registers hold all planes, and each row is loaded
//! once.
//!
//! Which of its two rows on an axis a plane reads depends on a sign, so loads by computed address would
//! be eighteen a block, more than the arithmetic. Far and near plane are opposite, so that they read all
//! six rows between them; left and right take theirs from the registers of those, the choice compiled
//! in: 8 × 8 ways, 36 as the two may be swapped. Bottom and top load theirs.

use fearless_simd::prelude::*;
use fearless_simd::x86::Avx512;

use super::planes::{BoxPlane, Six};
use super::words::{BLOCKS, bits, load, padded, parts, valid};
use crate::bounds::BoxBlock;

pub(super) fn visible(
    simd: Avx512,
    six: &Six,
    batch: (&[BoxBlock], usize),
    first: usize,
    words: &mut [u64],
) {
    macro_rules! arms {
        ($($left:literal: $($right:literal)*;)*) => {
            match six.pattern {
                $($(p if p == $left | $right << 3 => {
                    compiled::<{ $left | $right << 3 }>(simd, six, batch, first, words);
                })*)*
                p => unreachable!("sides are sorted by pattern, yet this is {p}"),
            }
        };
    }
    arms!(
        0: 0 1 2 3 4 5 6 7;
        1: 1 2 3 4 5 6 7;
        2: 2 3 4 5 6 7;
        3: 3 4 5 6 7;
        4: 4 5 6 7;
        5: 5 6 7;
        6: 6 7;
        7: 7;
    );
}

fn compiled<const PATTERN: usize>(
    simd: Avx512,
    six: &Six,
    batch: (&[BoxBlock], usize),
    first: usize,
    words: &mut [u64],
) {
    simd.vectorize(
        #[inline(always)]
        || run::<_, PATTERN>(simd, six, batch, first, words),
    );
}

type Constants<S> = [<S as Simd>::f32s; 3];

#[inline(always)]
fn constants<S: Simd>(simd: S, p: &BoxPlane) -> Constants<S> {
    [S::f32s::splat(simd, p.b), S::f32s::splat(simd, p.c), S::f32s::splat(simd, p.d)]
}

#[inline(always)]
fn run<S: Simd, const PATTERN: usize>(
    simd: S,
    six: &Six,
    (blocks, len): (&[BoxBlock], usize),
    first: usize,
    words: &mut [u64],
) {
    let [far, near, left, right, bottom, top] = &six.planes;
    // One after the other: a closure over them would not be compiled for this level.
    let constants = [
        constants(simd, far),
        constants(simd, near),
        constants(simd, left),
        constants(simd, right),
        constants(simd, bottom),
        constants(simd, top),
    ];
    let rows = [far.rows, near.rows, bottom.rows, top.rows];
    let (full, rest) = parts(blocks, len, first, words);
    for (chunk, out) in full {
        *out = word::<S, PATTERN>(simd, &constants, &rows, chunk);
    }
    for (index, out) in rest {
        let chunk = padded(blocks, index);
        *out = word::<S, PATTERN>(simd, &constants, &rows, &chunk) & valid(len, index);
    }
}

#[inline(always)]
fn word<S: Simd, const PATTERN: usize>(
    simd: S,
    [far, near, left, right, bottom, top]: &[Constants<S>; 6],
    [f, n, b, t]: &[[usize; 3]; 4],
    blocks: &[BoxBlock; BLOCKS],
) -> u64 {
    let all = |r: &[usize; 3]| r[0] < 6 && r[1] < 6 && r[2] < 6;
    assert!(all(f) && all(n) && all(b) && all(t));
    let zero = S::i32s::splat(simd, 0);
    let mut word = 0;
    for g in 0..BLOCKS {
        let row = &blocks[g].0;
        let x = [load::<S>(simd, &row[f[0]], 0), load::<S>(simd, &row[n[0]], 0)];
        let y = [load::<S>(simd, &row[f[1]], 0), load::<S>(simd, &row[n[1]], 0)];
        let z = [load::<S>(simd, &row[f[2]], 0), load::<S>(simd, &row[n[2]], 0)];
        let bx = load::<S>(simd, &row[b[0]], 0);
        let by = load::<S>(simd, &row[b[1]], 0);
        let bz = load::<S>(simd, &row[b[2]], 0);
        let tx = load::<S>(simd, &row[t[0]], 0);
        let ty = load::<S>(simd, &row[t[1]], 0);
        let tz = load::<S>(simd, &row[t[2]], 0);
        let bit = |i: usize| PATTERN >> i & 1;
        let far_sum = sum::<S>(far, x[0], y[0], z[0]);
        let near_sum = sum::<S>(near, x[1], y[1], z[1]);
        let left_sum = sum::<S>(left, x[bit(0)], y[bit(1)], z[bit(2)]);
        let right_sum = sum::<S>(right, x[bit(3)], y[bit(4)], z[bit(5)]);
        let bottom_sum = sum::<S>(bottom, bx, by, bz);
        let top_sum = sum::<S>(top, tx, ty, tz);
        // sum + d < 0 and sum < −d are the same; half of each keeps adders and multipliers level.
        let negative = bits::<S>(bottom_sum + bottom[2])
            | bits::<S>(top_sum + top[2])
            | bits::<S>(right_sum + right[2]);
        let kept = far_sum.simd_ge(-far[2])
            & near_sum.simd_ge(-near[2])
            & left_sum.simd_ge(-left[2])
            & negative.simd_ge(zero);
        word |= kept.to_bitmask() << (16 * g);
    }
    word
}

#[inline(always)]
fn sum<S: Simd>(plane: &Constants<S>, x: S::f32s, y: S::f32s, z: S::f32s) -> S::f32s {
    x + (y * plane[0] + z * plane[1])
}
