//! Intervals of f64, rounded outward: whatever the true value, it is within.

use std::ops::{Add, Mul, Neg, Sub};

/// All numbers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Interval {
    pub(crate) const ZERO: Self = Self { low: 0.0, high: 0.0 };
    pub(crate) const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// Just this number.
    pub(crate) fn exactly(value: f64) -> Self {
        if value.is_finite() { Self { low: value, high: value } } else { Self::ALL }
    }

    /// One step outward on each side: the result of one operation, rounded to nearest, is within
    /// half a step of the truth. What overflowed or is NaN may be anything.
    fn rounded(low: f64, high: f64) -> Self {
        if low.is_finite() && high.is_finite() {
            Self { low: low.next_down(), high: high.next_up() }
        } else {
            Self::ALL
        }
    }

    /// Whether all of it is above zero.
    pub(crate) fn is_positive(self) -> bool {
        self.low > 0.0
    }

    /// Whether zero may be meant.
    pub(crate) fn has_zero(self) -> bool {
        self.low <= 0.0 && self.high >= 0.0
    }

    /// The quotient; anything where the divisor may be zero.
    pub(crate) fn over(self, divisor: Self) -> Self {
        if divisor.has_zero() {
            return Self::ALL;
        }
        let q = [
            self.low / divisor.low,
            self.low / divisor.high,
            self.high / divisor.low,
            self.high / divisor.high,
        ];
        Self::hull(q)
    }

    fn hull(v: [f64; 4]) -> Self {
        if v.iter().any(|v| v.is_nan()) {
            return Self::ALL;
        }
        Self::rounded(v[0].min(v[1]).min(v[2].min(v[3])), v[0].max(v[1]).max(v[2].max(v[3])))
    }
}

impl Add for Interval {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::rounded(self.low + other.low, self.high + other.high)
    }
}

impl Neg for Interval {
    type Output = Self;

    fn neg(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }
}

impl Sub for Interval {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        // A zero is exact, and most matrices are full of them: their intervals stay narrow.
        if self == Self::ZERO || other == Self::ZERO {
            return if self == Self::ALL || other == Self::ALL { Self::ALL } else { Self::ZERO };
        }
        Self::hull([
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_is_within() {
        let third = Interval::exactly(1.0).over(Interval::exactly(3.0));
        assert!(third.low < third.high && third.high - third.low < 1e-15);
        let one = third * Interval::exactly(3.0);
        assert!(one.low < 1.0 && one.high > 1.0);
        let zero = one - Interval::exactly(1.0);
        assert!(zero.has_zero() && !zero.is_positive());
        assert_eq!(Interval::exactly(2.0) * Interval::ZERO, Interval::ZERO);
        let negative = Interval { low: -3.0, high: -2.0 };
        let product = negative * Interval { low: -5.0, high: 7.0 };
        assert!(product.low <= -21.0 && product.high >= 15.0);
        assert!(product.low > -21.1 && product.high < 15.1);
    }

    #[test]
    fn what_is_not_finite_may_be_anything() {
        assert_eq!(Interval::exactly(f64::NAN), Interval::ALL);
        assert_eq!(Interval::exactly(1.0).over(zeroish()), Interval::ALL);
        assert_eq!(Interval::exactly(1e300) * Interval::exactly(1e300), Interval::ALL);
        assert_eq!(Interval::ALL * Interval::ZERO, Interval::ALL);
        assert_eq!(Interval::ALL + Interval::exactly(1.0), Interval::ALL);
    }

    fn zeroish() -> Interval {
        Interval { low: -1e-300, high: 1e-300 }
    }
}
