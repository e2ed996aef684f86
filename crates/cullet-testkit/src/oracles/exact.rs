//! Numbers without rounding, as sums of f64: readable, and slow.
//!
//! Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, 1997.

/// Returns a + b as a rounded sum and its rounding error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let t = s - a;
    (s, (a - (s - t)) + (b - t))
}

/// An exact number as a sum of f64, its parts of rising magnitude without zeros.
#[derive(Clone, Debug)]
pub struct Exact(Vec<f64>);

impl Exact {
    /// Returns the sum.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        other.0.iter().for_each(|&t| sum.grow(t));
        sum
    }

    /// Returns the product.
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self(Vec::new());
        for &a in &self.0 {
            for &b in &other.0 {
                let p = a * b;
                let tail = a.mul_add(b, -p);
                product.grow(tail);
                product.grow(p);
            }
        }
        product
    }

    /// Returns the difference.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        self.plus(&Self(other.0.iter().map(|t| -t).collect()))
    }

    /// Returns the scalar product of `a` and `b`.
    #[must_use]
    pub fn dot(a: &[Self], b: &[Self]) -> Self {
        a.iter().zip(b).fold(Self(Vec::new()), |sum, (a, b)| sum.plus(&a.times(b)))
    }

    /// Returns the number, rounded.
    #[must_use]
    pub fn value(&self) -> f64 {
        // From the smallest part on, so that nothing is lost to the larger ones.
        self.0.iter().sum()
    }

    /// Returns −1, 0 or 1.
    #[must_use]
    pub fn sign(&self) -> i32 {
        self.0.last().map_or(0, |&t| i32::from(t > 0.0) - i32::from(t < 0.0))
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

#[cfg(test)]
mod tests {
    use super::Exact;

    #[test]
    fn a_tenth_is_a_little_more_than_it_is_called() {
        let a = Exact::from(0.1).times(&Exact::from(10.0));
        assert_eq!(a.minus(&Exact::from(1.0)).sign(), 1);
    }
}
