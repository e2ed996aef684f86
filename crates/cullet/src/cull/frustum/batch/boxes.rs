//! The box tests, in SIMD of any width.

use crate::simd::dispatch;
use fearless_simd::prelude::*;

use super::planes::{BoxPlane, Planes};
use super::words::{BLOCKS, bits, load, padded, parts, valid};
use crate::bounds::{BoxBlock, Boxes};

/// The visible boxes of words `first..` of a batch of `len`.
pub(super) fn visible(
    simd: crate::Simd,
    planes: &Planes,
    boxes: &Boxes,
    first: usize,
    visible: &mut [u64],
) {
    dispatch!(simd, simd => {
        let mut test = Outside { planes: planes.box_planes() };
        run(simd, &mut test, boxes, first, visible);
    });
}

/// Sets the bits in `inside` of the visible boxes that are proved inside every plane, and clears
/// all others. `inside` and `visible` are words `first..` of a batch. Words without a visible box
/// are not tested.
pub(super) fn inside(
    simd: crate::Simd,
    planes: &Planes,
    boxes: &Boxes,
    first: usize,
    visible: &[u64],
    inside: &mut [u64],
) {
    dispatch!(simd, simd => {
        let mut test = Inside { planes: planes.box_planes(), visible, first };
        run(simd, &mut test, boxes, first, inside);
    });
}

/// A test of sixty-four boxes.
trait Test {
    fn word<S: Simd>(&mut self, simd: S, index: usize, blocks: &[BoxBlock; BLOCKS]) -> u64;
}

struct Outside<'a> {
    planes: &'a [BoxPlane],
}

struct Inside<'a> {
    planes: &'a [BoxPlane],
    visible: &'a [u64],
    first: usize,
}

impl Test for Outside<'_> {
    #[inline(always)]
    fn word<S: Simd>(&mut self, simd: S, _: usize, blocks: &[BoxBlock; BLOCKS]) -> u64 {
        if S::f32s::LEN == 16 {
            !signs::<S, false, 4>(simd, self.planes, blocks)
        } else {
            !signs::<S, false, 8>(simd, self.planes, blocks)
        }
    }
}

impl Test for Inside<'_> {
    #[inline(always)]
    fn word<S: Simd>(&mut self, simd: S, index: usize, blocks: &[BoxBlock; BLOCKS]) -> u64 {
        let visible = self.visible[index - self.first];
        if visible == 0 {
            return 0;
        }
        if S::f32s::LEN == 16 {
            visible & !signs::<S, true, 4>(simd, self.planes, blocks)
        } else {
            visible & !signs::<S, true, 8>(simd, self.planes, blocks)
        }
    }
}

#[inline(always)]
fn run<S: Simd>(simd: S, test: &mut impl Test, boxes: &Boxes, first: usize, words: &mut [u64]) {
    let (blocks, len) = (boxes.blocks(), boxes.len());
    let (full, rest) = parts(blocks, len, first, words);
    for (i, (chunk, word)) in full.enumerate() {
        *word = test.word(simd, first + i, chunk);
    }
    for (index, word) in rest {
        *word = test.word(simd, index, &padded(blocks, index)) & valid(len, index);
    }
}

/// For each box whether some plane's test is negative: that it is outside, or, `INSIDE`, that it is
/// not proved inside. `V` vectors are tested at a time.
///
/// Planes outermost: their numbers are loaded once for V vectors, and rows straight from memory as
/// operands. One vector at a time with all planes, which reads each row once where registers allow,
/// was slower on AVX2 (sixteen registers hold no six planes); so was a jump by the signs of each
/// plane (three times: compilers merge the arms again). Sums end in a sign bit, and signs are
/// joined as integers, for comparisons and products share two of the four pipes of Zen 4.
#[inline(always)]
fn signs<S: Simd, const INSIDE: bool, const V: usize>(
    simd: S,
    planes: &[BoxPlane],
    blocks: &[BoxBlock; BLOCKS],
) -> u64 {
    let lanes = S::f32s::LEN;
    let mut word = 0;
    let mut start = 0;
    while start < 64 {
        let mut negative = [S::i32s::splat(simd, 0); V];
        for plane in planes {
            let [p, q, r] = if INSIDE { plane.far_rows() } else { plane.near_rows() };
            let b = S::f32s::splat(simd, plane.b);
            let c = S::f32s::splat(simd, plane.c);
            let d = S::f32s::splat(simd, if INSIDE { plane.inside } else { plane.d });
            for v in 0..V {
                let at = start + v * lanes;
                let rows = &blocks[at / 16].0;
                let sum = load::<S>(simd, &rows[p], at % 16)
                    + (load::<S>(simd, &rows[q], at % 16) * b
                        + load::<S>(simd, &rows[r], at % 16) * c);
                let signed = if INSIDE { d - sum } else { sum + d };
                negative[v] |= bits::<S>(signed);
            }
        }
        for v in 0..V {
            let found = negative[v].simd_lt(S::i32s::splat(simd, 0)).to_bitmask();
            word |= found << (start + v * lanes);
        }
        start += V * lanes;
    }
    word
}
