//! Spots: where the vertices of a patch lie on the screen.
//!
//! A vertex has its three numbers side by side: eight vertices are eight loads and some shuffles,
//! where an array for each number takes 24 loads.

use fearless_simd::prelude::*;
use fearless_simd::{f32x4, f32x8};

use super::super::connected::{LANES, NUMBERS};
use super::{Numbers, numbers};

/// Column, row and nearness of each vertex of a patch, and of those that cutting adds.
#[derive(Clone, Debug)]
pub(super) struct Spots(Numbers<[f32; 4]>);

impl Spots {
    pub(super) fn new() -> Self {
        Self(numbers([0.0; 4]))
    }

    /// Sets eight vertices from `first` on.
    #[inline(always)]
    pub(super) fn set<S: Simd>(&mut self, simd: S, first: usize, [x, y, n]: [f32x8<S>; 3]) {
        let to = &mut self.0.as_flattened_mut()[first * 4..][..LANES * 4];
        let zero = f32x4::splat(simd, 0.0);
        let ((x0, x1), (y0, y1), (n0, n1)) = (x.split(), y.split(), n.split());
        for (half, [x, y, n]) in [[x0, y0, n0], [x1, y1, n1]].into_iter().enumerate() {
            let (xn, y) = ([x.zip_low(n), x.zip_high(n)], [y.zip_low(zero), y.zip_high(zero)]);
            for k in 0..2 {
                let to = &mut to[half * 16 + k * 8..][..8];
                xn[k].zip_low(y[k]).store_slice(&mut to[..4]);
                xn[k].zip_high(y[k]).store_slice(&mut to[4..]);
            }
        }
    }

    /// Sets a vertex.
    pub(super) fn put(&mut self, vertex: usize, x: f32, y: f32, nearness: f32) {
        self.0[vertex] = [x, y, nearness, 0.0];
    }

    /// Returns the column and the row of a vertex.
    pub(super) fn place(&self, vertex: u16) -> [f32; 2] {
        let [x, y, ..] = self.0[usize::from(vertex) % NUMBERS];
        [x, y]
    }

    /// Returns columns, rows and nearness of eight vertices.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(&self, simd: S, at: &[u16; LANES]) -> [f32x8<S>; 3] {
        let [x0, y0, n0] = self.gather_four(simd, [at[0], at[1], at[2], at[3]]);
        let [x1, y1, n1] = self.gather_four(simd, [at[4], at[5], at[6], at[7]]);
        [x0.combine(x1), y0.combine(y1), n0.combine(n1)]
    }

    #[inline(always)]
    fn gather_four<S: Simd>(&self, simd: S, [a, b, c, d]: [u16; 4]) -> [f32x4<S>; 3] {
        let a = f32x4::simd_from(simd, self.0[usize::from(a) % NUMBERS]);
        let b = f32x4::simd_from(simd, self.0[usize::from(b) % NUMBERS]);
        let c = f32x4::simd_from(simd, self.0[usize::from(c) % NUMBERS]);
        let d = f32x4::simd_from(simd, self.0[usize::from(d) % NUMBERS]);
        let (ac, bd) = (a.zip_low(c), b.zip_low(d));
        let n = a.zip_high(c).zip_low(b.zip_high(d));
        [ac.zip_low(bd), ac.zip_high(bd), n]
    }
}

#[cfg(test)]
mod tests {
    use crate::Simd;
    use crate::simd::dispatch;

    use super::*;

    #[test]
    fn what_is_set_in_eights_is_gathered_at_any_place_at_every_level() {
        let of = |number: f32| core::array::from_fn::<f32, 16, _>(|v| v as f32 + number * 100.0);
        let (x, y, n) = (of(1.0), of(2.0), of(3.0));
        for level in Simd::all() {
            let mut spots = Spots::new();
            let at = [3, 15, 0, 7, 7, 8, 12, 4000];
            spots.put(4000, -1.0, -2.0, -3.0);
            let found: [[f32; 8]; 3] = dispatch!(level, simd => {
                for first in [0, 8] {
                    let eight = |of: &[f32; 16]| f32x8::from_slice(simd, &of[first..first + 8]);
                    spots.set(simd, first, [eight(&x), eight(&y), eight(&n)]);
                }
                let [x, y, n] = spots.gather(simd, &at);
                [x.into(), y.into(), n.into()]
            });
            for lane in 0..7 {
                let v = usize::from(at[lane]);
                assert_eq!([found[0][lane], found[1][lane]], spots.place(at[lane]));
                assert_eq!([0, 1, 2].map(|k| found[k][lane]), [x[v], y[v], n[v]]);
            }
            assert_eq!([0, 1, 2].map(|k| found[k][7]), [-1.0, -2.0, -3.0]);
        }
    }
}
