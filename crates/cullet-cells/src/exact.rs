//! Numbers without rounding, as sums of f64: for the signs that rounding hides. Readable, and slow.
//!
//! Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*,
//! 1997.

use alloc::vec;
use alloc::vec::Vec;

use cullet::math::{two_product, two_sum};

/// An exact number as a sum of f64, its parts of rising magnitude without zeros.
#[derive(Clone, Debug)]
pub(crate) struct Exact(Vec<f64>);

impl Exact {
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        other.0.iter().for_each(|&t| sum.grow(t));
        sum
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut product = Self(Vec::new());
        for &a in &self.0 {
            for &b in &other.0 {
                let (p, tail) = two_product(a, b);
                product.grow(tail);
                product.grow(p);
            }
        }
        product
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        self.plus(&Self(other.0.iter().map(|t| -t).collect()))
    }

    /// The number, rounded.
    pub(crate) fn value(&self) -> f64 {
        // From the smallest part on, so that nothing is lost to the larger ones.
        self.0.iter().sum()
    }

    pub(crate) fn sign(&self) -> i32 {
        self.0.last().map_or(0, |&t| sign_of(t))
    }

    fn grow(&mut self, term: f64) {
        let mut carry = term;
        for part in &mut self.0 {
            (carry, *part) = two_sum(carry, *part);
        }
        self.0.push(carry);
        self.0.retain(|&t| t != 0.0);
    }
}

impl From<f64> for Exact {
    fn from(v: f64) -> Self {
        Self(if v == 0.0 { Vec::new() } else { vec![v] })
    }
}

/// Returns the sign of a number.
fn sign_of(v: f64) -> i32 {
    i32::from(v > 0.0) - i32::from(v < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_ten_times_is_more_than_one() {
        let a = Exact::from(0.1).times(&Exact::from(10.0));
        assert_eq!(a.minus(&Exact::from(1.0)).sign(), 1, "0.1 is a little more than a tenth");
    }
}
