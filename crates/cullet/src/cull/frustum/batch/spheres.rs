//! The sphere tests, in SIMD of any width.

use crate::simd::dispatch;
use fearless_simd::prelude::*;

use super::planes::{Planes, SharedSides, SidePair, SpherePlane};
use super::words::{BLOCKS, bits, load, padded, parts, valid};
use crate::bounds::SphereBlock;

/// The visible spheres of words `first..` of a batch of `len`.
pub(super) fn visible(
    level: crate::Simd,
    planes: &Planes,
    (blocks, len): (&[SphereBlock], usize),
    first: usize,
    visible: &mut [u64],
) {
    match &planes.shared {
        Some(sides) => dispatch!(level, simd => {
            run(simd, &Shared::new(simd, sides), (blocks, len), first, visible);
        }),
        None => dispatch!(level, simd => {
            let test = Each { planes: planes.sphere_planes(), inside: false };
            run(simd, &test, (blocks, len), first, visible);
        }),
    }
}

/// Sets the bits in `inside` of the spheres that are proved inside every plane, and clears all
/// others. Only spheres whose bits are set in `visible` count.
pub(super) fn inside(
    level: crate::Simd,
    planes: &Planes,
    (blocks, len): (&[SphereBlock], usize),
    first: usize,
    visible: &[u64],
    inside: &mut [u64],
) {
    dispatch!(level, simd => {
        let test = Each { planes: planes.sphere_planes(), inside: true };
        run(simd, &test, (blocks, len), first, inside);
    });
    inside.iter_mut().zip(visible).for_each(|(i, v)| *i &= v);
}

/// A test of sixty-four spheres: bits of those that pass.
trait Test<S: Simd> {
    fn word(&self, simd: S, blocks: &[SphereBlock; BLOCKS]) -> u64;
}

#[inline(always)]
fn run<S: Simd>(
    simd: S,
    test: &impl Test<S>,
    (blocks, len): (&[SphereBlock], usize),
    first: usize,
    words: &mut [u64],
) {
    let (full, rest) = parts(blocks, len, first, words);
    for (chunk, word) in full {
        *word = test.word(simd, chunk);
    }
    for (index, word) in rest {
        *word = test.word(simd, &padded(blocks, index)) & valid(len, index);
    }
}

/// Any planes, one after the other.
struct Each<'a> {
    planes: &'a [SpherePlane],
    inside: bool,
}

impl<S: Simd> Test<S> for Each<'_> {
    #[inline(always)]
    fn word(&self, simd: S, blocks: &[SphereBlock; BLOCKS]) -> u64 {
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
                let t = dot::<S>(&splat(simd, &plane.n), x, y, z);
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
fn splat<S: Simd>(simd: S, n: &[f32; 3]) -> [S::f32s; 3] {
    [S::f32s::splat(simd, n[0]), S::f32s::splat(simd, n[1]), S::f32s::splat(simd, n[2])]
}

#[inline(always)]
fn dot<S: Simd>(n: &[S::f32s; 3], x: S::f32s, y: S::f32s, z: S::f32s) -> S::f32s {
    x * n[0] + (y * n[1] + z * n[2])
}

/// The sides of a view that opposite planes share: eleven products where each plane alone takes
/// eighteen.
struct Shared<S: Simd> {
    f: [S::f32s; 3],
    far: S::f32s,
    near: S::f32s,
    pairs: [Pair<S>; 2],
}

struct Pair<S: Simd> {
    h: [S::f32s; 3],
    m: S::f32s,
    k: S::f32s,
    o: S::f32s,
}

impl<S: Simd> Shared<S> {
    // Made before the loop: a store of the answer might change `sides` for all the compiler knows, and
    // it would be read again for every vector.
    #[inline(always)]
    fn new(simd: S, sides: &SharedSides) -> Self {
        let [a, b] = &sides.pairs;
        Self {
            f: splat(simd, &sides.f),
            far: S::f32s::splat(simd, sides.far),
            near: S::f32s::splat(simd, sides.near),
            pairs: [Pair::new(simd, a), Pair::new(simd, b)],
        }
    }
}

impl<S: Simd> Pair<S> {
    #[inline(always)]
    fn new(simd: S, pair: &SidePair) -> Self {
        let [m, k, o] = splat(simd, &[pair.m, pair.k, pair.o]);
        Self { h: splat(simd, &pair.h), m, k, o }
    }

    /// How far outside the farther of two opposite sides.
    #[inline(always)]
    fn distance(&self, x: S::f32s, y: S::f32s, z: S::f32s, p: S::f32s) -> S::f32s {
        let across = (dot::<S>(&self.h, x, y, z) - self.m).abs();
        across - p * self.k - self.o
    }
}

impl<S: Simd> Test<S> for Shared<S> {
    #[inline(always)]
    fn word(&self, simd: S, blocks: &[SphereBlock; BLOCKS]) -> u64 {
        let lanes = S::f32s::LEN;
        let [a, b] = &self.pairs;
        let mut word = 0;
        let mut start = 0;
        while start < 64 {
            let [x, y, z, r] = &blocks[start / 16].0;
            let x = load::<S>(simd, x, start % 16);
            let y = load::<S>(simd, y, start % 16);
            let z = load::<S>(simd, z, start % 16);
            let r = load::<S>(simd, r, start % 16);
            let p = dot::<S>(&self.f, x, y, z);
            let side = a.distance(x, y, z, p).max(b.distance(x, y, z, p));
            // No NaN can be here, so any order of the four is the same.
            let end = (p - self.far).max(self.near - p);
            word |= side.max(end).simd_le(r).to_bitmask() << start;
            start += lanes;
        }
        word
    }
}
