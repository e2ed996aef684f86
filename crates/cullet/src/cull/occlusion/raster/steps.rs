//! Nearness in sixteen bits: steps, rounded down.
//!
//! In perspective 1 / w, five bits of the exponent and eleven of the fraction: 32 octaves from the
//! near plane on, each value to 1/2048 of itself. In parallel views the share of the depth range,
//! in 65,536 equal steps. Step 0 is nothing: neither what is farther than all steps nor what is
//! open is told from it.

use crate::math;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, u16x8, u32x8};

/// The scale from nearness to steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// Bits of an f32 that are dropped, and those of the value that is step 0.
    shift: u32,
    first: u32,
    /// Added to a nearness, so that its fraction has all the bits: 0 or 1.
    offset: f32,
    /// More than what that addition is off by.
    rounding: f32,
}

impl Scale {
    /// Returns the scale of a view whose lines of sight meet. Its near plane is at about `w`.
    pub(super) fn perspective(w: f64) -> Self {
        let w = if w > 1e-6 && w < 1e12 { w } else { 1e-3 };
        let top = math::exponent(1.0 / w) + 1;
        Self { shift: 12, first: ((top - 32 + 127) as u32) << 11, offset: 0.0, rounding: 0.0 }
    }

    /// Returns the scale of a view whose lines of sight are parallel. Its nearness is from 0 to 1.
    pub(super) fn parallel() -> Self {
        Self { shift: 7, first: 127 << 16, offset: 1.0, rounding: 2.0_f32.powi(-22) }
    }

    /// The steps up to which something does not hide what is no nearer than this; all of them for
    /// NaN.
    #[inline(always)]
    pub(crate) fn of_tested(&self, nearness: f32) -> u16 {
        if nearness.is_nan() {
            return 0xffff;
        }
        self.whole(nearness + self.offset + self.rounding)
    }

    /// Whole steps of what is at least as near.
    #[inline(always)]
    pub(crate) fn of_drawn(&self, nearness: f32) -> u16 {
        self.whole(nearness + self.offset - self.rounding)
    }

    #[inline(always)]
    fn whole(&self, value: f32) -> u16 {
        (value.max(0.0).to_bits() >> self.shift).saturating_sub(self.first).min(0xffff) as u16
    }

    /// The least nearness of some steps; 0 for none.
    #[inline(always)]
    pub(crate) fn nearness(&self, steps: u16) -> f32 {
        match steps {
            0 => 0.0,
            _ => f32::from_bits((self.first + u32::from(steps)) << self.shift) - self.offset,
        }
    }

    /// Returns the steps of eight values, each as [`of_drawn`](Self::of_drawn) does. None of them
    /// may be NaN.
    #[inline(always)]
    pub(super) fn of_eight_drawn<S: Simd>(&self, simd: S, nearness: f32x8<S>) -> u16x8<S> {
        let zero = f32x8::splat(simd, 0.0);
        let bits: u32x8<S> = (nearness + self.offset - self.rounding).max(zero).bitcast();
        let first = u32x8::splat(simd, self.first);
        let steps = (bits >> self.shift).max(first) - first;
        let (low, high) = steps.min(u32x8::splat(simd, 0xffff)).split();
        low.narrow(high)
    }
}

#[cfg(test)]
mod tests {
    use crate::simd::dispatch;

    use super::*;

    #[test]
    fn steps_are_rounded_down_and_ascend() {
        for scale in [Scale::perspective(0.1), Scale::perspective(37.0), Scale::parallel()] {
            let mut last = 0;
            for i in 0..4000 {
                let nearness = if scale.offset == 0.0 {
                    2.0_f32.powf(i as f32 * 0.01 - 33.0)
                } else {
                    i as f32 / 3999.0
                };
                let (drawn, tested) = (scale.of_drawn(nearness), scale.of_tested(nearness));
                assert!(drawn >= last && scale.nearness(drawn) <= nearness);
                assert!(tested == drawn || tested == drawn.saturating_add(1));
                let is_inside = tested > 0 && tested < 0xffff;
                assert!(!is_inside || scale.nearness(tested + 1) > nearness, "{nearness}");
                last = drawn;
            }
            assert!(last > 0xf000);
            for nothing in [f32::NAN, -1.0, -0.0, 0.0, f32::NEG_INFINITY] {
                assert_eq!(scale.of_drawn(nothing), 0);
            }
            for everything in [f32::NAN, f32::INFINITY] {
                assert_eq!(scale.of_tested(everything), 0xffff);
            }
        }
    }

    #[test]
    fn eight_at_once_are_as_one_by_one() {
        let values = [0.0, -3.0, 1e-12, 0.013, 0.7, 0.999_999, 4.0, f32::INFINITY];
        for scale in [Scale::perspective(0.1), Scale::parallel()] {
            for level in crate::Simd::all() {
                let found: [u16; 8] = dispatch!(level, simd => {
                    scale.of_eight_drawn(simd, f32x8::from_slice(simd, &values)).into()
                });
                assert_eq!(found, values.map(|v| scale.of_drawn(v)));
            }
        }
    }
}
