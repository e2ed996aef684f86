//! The sphere tests, in SIMD of any width.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

use super::boxes::{BLOCKS, bits, load, padded, valid};
use super::output::{Mask, Sink};
use super::planes::{Planes, SharedSides, SidePair, SpherePlane};
use crate::bounds::SphereBlock;

/// Tests words `first..last` of a batch of `len` spheres.
pub(super) fn visible(
    level: Level,
    planes: &Planes,
    (blocks, len): (&[SphereBlock], usize),
    (first, last): (usize, usize),
    sink: &mut impl Sink,
) {
    match &planes.shared {
        Some(sides) => dispatch!(level, simd => {
            run(simd, &Shared { sides }, (blocks, len), (first, last), sink);
        }),
        None => dispatch!(level, simd => {
            let test = Each { planes: planes.sphere_planes(), inside: false };
            run(simd, &test, (blocks, len), (first, last), sink);
        }),
    }
}

/// Which spheres are proved inside every plane, of those whose bits are set in `visible`.
pub(super) fn inside(
    level: Level,
    planes: &Planes,
    (blocks, len): (&[SphereBlock], usize),
    first: usize,
    visible: &[u64],
    inside: &mut [u64],
) {
    let last = first + visible.len();
    dispatch!(level, simd => {
        let test = Each { planes: planes.sphere_planes(), inside: true };
        run(simd, &test, (blocks, len), (first, last), &mut Mask { first, words: inside });
    });
    inside.iter_mut().zip(visible).for_each(|(i, v)| *i &= v);
}

/// A test of sixty-four spheres: bits of those that pass.
trait Test {
    fn word<S: Simd>(&self, simd: S, blocks: &[SphereBlock; BLOCKS]) -> u64;
}

#[inline(always)]
fn run<S: Simd>(
    simd: S,
    test: &impl Test,
    (blocks, len): (&[SphereBlock], usize),
    (first, last): (usize, usize),
    sink: &mut impl Sink,
) {
    let whole = (len / 64).clamp(first, last);
    let (full, _) = blocks.as_chunks::<BLOCKS>();
    for (i, chunk) in full[first.min(full.len())..whole.min(full.len())].iter().enumerate() {
        let word = test.word(simd, chunk);
        sink.word(simd, first + i, word);
    }
    for index in whole..last {
        let word = test.word(simd, &padded(blocks, index)) & valid(len, index);
        sink.word(simd, index, word);
    }
}

/// Any planes, one after the other.
struct Each<'a> {
    planes: &'a [SpherePlane],
    inside: bool,
}

impl Test for Each<'_> {
    #[inline(always)]
    fn word<S: Simd>(&self, simd: S, blocks: &[SphereBlock; BLOCKS]) -> u64 {
        let lanes = S::f32s::LEN;
        let mut word = 0;
        for start in (0..64).step_by(lanes) {
            let rows = &blocks[start / 16].0;
            let [x, y, z, r] = rows;
            let x = load::<S>(simd, x, start % 16);
            let y = load::<S>(simd, y, start % 16);
            let z = load::<S>(simd, z, start % 16);
            let r = load::<S>(simd, r, start % 16);
            let mut negative = S::i32s::splat(simd, 0);
            for plane in self.planes {
                let t = dot::<S>(simd, &plane.n, x, y, z);
                let signed = if self.inside {
                    S::f32s::splat(simd, plane.inside) - (t + r)
                } else {
                    S::f32s::splat(simd, plane.d) - (t - r)
                };
                negative |= bits::<S>(signed);
            }
            word |= negative.simd_ge(S::i32s::splat(simd, 0)).to_bitmask() << start;
        }
        word
    }
}

#[inline(always)]
fn dot<S: Simd>(simd: S, n: &[f32; 3], x: S::f32s, y: S::f32s, z: S::f32s) -> S::f32s {
    x * S::f32s::splat(simd, n[0])
        + (y * S::f32s::splat(simd, n[1]) + z * S::f32s::splat(simd, n[2]))
}

/// The sides of a view that opposite planes share: eleven products where each plane alone takes
/// eighteen.
struct Shared<'a> {
    sides: &'a SharedSides,
}

impl Test for Shared<'_> {
    #[inline(always)]
    fn word<S: Simd>(&self, simd: S, blocks: &[SphereBlock; BLOCKS]) -> u64 {
        let lanes = S::f32s::LEN;
        let SharedSides { f, far, near, pairs: [a, b] } = self.sides;
        let mut word = 0;
        for start in (0..64).step_by(lanes) {
            let [x, y, z, r] = &blocks[start / 16].0;
            let x = load::<S>(simd, x, start % 16);
            let y = load::<S>(simd, y, start % 16);
            let z = load::<S>(simd, z, start % 16);
            let r = load::<S>(simd, r, start % 16);
            let p = dot::<S>(simd, f, x, y, z);
            let a = side::<S>(simd, a, dot::<S>(simd, &a.h, x, y, z), p);
            let b = side::<S>(simd, b, dot::<S>(simd, &b.h, x, y, z), p);
            let far = p - S::f32s::splat(simd, *far);
            let near = S::f32s::splat(simd, *near) - p;
            // No NaN can be here, so any order of the four is the same.
            let farthest = a.max(b).max(far.max(near));
            word |= farthest.simd_le(r).to_bitmask() << start;
        }
        word
    }
}

/// How far outside the farther of two opposite sides.
#[inline(always)]
fn side<S: Simd>(simd: S, pair: &SidePair, h: S::f32s, p: S::f32s) -> S::f32s {
    let across = (h - S::f32s::splat(simd, pair.m)).abs();
    across - p * S::f32s::splat(simd, pair.k) - S::f32s::splat(simd, pair.o)
}
