//! Exact signs: on which side of a line or a plane a point lies, without rounding.
//!
//! ```
//! use cullet::exact::{area_sign, plane_sign};
//!
//! // 0.1, 0.2 and 0.3 are not quite what they are called, and rounding hides by how much.
//! assert_eq!(plane_sign([0.1, 0.2, 0.0], 0.3, [1.0, 1.0, 0.0]), 1);
//! assert_eq!(area_sign(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 2), 1);
//! ```
//!
//! Error-free sums and products of f64: Shewchuk, *Adaptive Precision Floating-Point Arithmetic and
//! Fast Robust Geometric Predicates*, 1997. Coordinates are f32, so the product of two is exact in
//! f64 and only longer ones need a tail. Signs are right as long as nothing overflows and no tail
//! falls below the smallest f64, which products of up to six f32 numbers cannot do.

use crate::array::Each;
use crate::math::{two_product, two_sum};

/// An exact sum of at most `N` numbers.
pub(crate) struct Sum<const N: usize> {
    // Non-overlapping, of rising magnitude, without zeros.
    parts: [f64; N],
    len: usize,
}

impl<const N: usize> Sum<N> {
    pub(crate) fn new() -> Self {
        Self { parts: [0.0; N], len: 0 }
    }

    /// Adds one number (Shewchuk's Grow-Expansion, dropping zeros).
    pub(crate) fn add(&mut self, term: f64) {
        let (mut carry, mut kept) = (term, 0);
        for i in 0..self.len {
            let (sum, error) = two_sum(carry, self.parts[i]);
            carry = sum;
            if error != 0.0 {
                self.parts[kept] = error;
                kept += 1;
            }
        }
        if carry != 0.0 {
            self.parts[kept] = carry;
            kept += 1;
        }
        self.len = kept;
    }

    pub(crate) fn add_product(&mut self, a: f64, b: f64) {
        let (p, tail) = two_product(a, b);
        self.add(p);
        self.add(tail);
    }

    /// -1, 0 or 1.
    pub(crate) fn sign(&self) -> i32 {
        // The largest part exceeds the rest together.
        if self.len == 0 { 0 } else { sign_of(self.parts[self.len - 1]) }
    }
}

fn sign_of(v: f64) -> i32 {
    i32::from(v > 0.0) - i32::from(v < 0.0)
}

fn wide(p: [f32; 3]) -> [f64; 3] {
    p.each(f64::from)
}

/// Twice the signed area of (a, b, c) seen along `axis`, that is component `axis` of
/// (b − a) × (c − a), as six exact terms.
fn area_terms(corners: &[[f32; 3]; 3], axis: usize) -> [f64; 6] {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let [a, b, c] = corners.each(wide);
    [a[u] * b[v], -a[v] * b[u], b[u] * c[v], -b[v] * c[u], c[u] * a[v], -c[v] * a[u]]
}

/// The sign of component `axis` of (b − a) × (c − a) of three finite points: 1 where they turn
/// counter-clockwise seen from the positive end of that axis, −1 where clockwise, 0 where they lie
/// in one line as seen from there. Exact; some 40 additions. Points that are not finite have no
/// sign that means anything.
///
/// # Panics
/// If `axis` is above 2.
#[must_use]
pub fn area_sign(corners: &[[f32; 3]; 3], axis: usize) -> i32 {
    let mut sum = Sum::<6>::new();
    area_terms(corners, axis).into_iter().for_each(|t| sum.add(t));
    sum.sign()
}

/// The sign of n·p − d for a plane n·x = d: 1 on the side to which its normal points, −1 on the
/// other, 0 on the plane.
///
/// Exact as long as no product overflows or is so small that its rounding error is below the
/// smallest f64, which coordinates that come from f32 and coefficients between 1e−200 and 1e200
/// cannot do. What is not finite has no sign that means anything.
#[must_use]
pub fn plane_sign(normal: [f64; 3], d: f64, point: [f64; 3]) -> i32 {
    let mut sum = Sum::<8>::new();
    (0..3).for_each(|axis| sum.add_product(normal[axis], point[axis]));
    sum.add(-d);
    sum.sign()
}

/// Whether three points lie on one line, two or all of them perhaps in one place.
pub(crate) fn is_collinear(corners: &[[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.each(wide);
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let p = (b[u] - a[u]) * (c[v] - a[v]);
        let q = (b[v] - a[v]) * (c[u] - a[u]);
        // Three roundings a product, one of the difference: what exceeds them is not zero.
        if (p - q).abs() > (p.abs() + q.abs()) * (4.0 * f64::EPSILON) {
            return false;
        }
    }
    (0..3).all(|axis| area_sign(corners, axis) == 0)
}

/// The sign of k · ((b − a) × (c − a)), each kᵢ given as an exact sum of two numbers.
pub(crate) fn dot_area_sign(k: &[[f64; 2]; 3], corners: &[[f32; 3]; 3]) -> i32 {
    let mut sum = Sum::<72>::new();
    for axis in 0..3 {
        for term in area_terms(corners, axis) {
            for part in k[axis] {
                sum.add_product(term, part);
            }
        }
    }
    sum.sign()
}

/// Returns the sign of the determinant of three columns. Exact arithmetic only where f64 cannot
/// tell.
#[must_use]
pub fn determinant_sign(columns: &[[f32; 3]; 3]) -> i32 {
    let [x, y, z] = columns.each(wide);
    let (mut value, mut size) = (0.0, 0.0);
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        // Products of two are exact; those of three and their sum are off by less than 7 · 2⁻⁵³ of
        // the size.
        let (plus, minus) = (y[u] * z[v] * x[axis], y[v] * z[u] * x[axis]);
        value += plus - minus;
        size += plus.abs() + minus.abs();
    }
    // Written so that what is not finite goes on.
    if value.abs() > size * 1e-15 {
        return if value > 0.0 { 1 } else { -1 };
    }
    exact_determinant_sign(columns)
}

fn exact_determinant_sign(columns: &[[f32; 3]; 3]) -> i32 {
    let [x, y, z] = columns.each(wide);
    let mut sum = Sum::<12>::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        sum.add_product(y[u] * z[v], x[axis]);
        sum.add_product(-y[v] * z[u], x[axis]);
    }
    sum.sign()
}

/// Returns the side of the plane of `corners` = (a, b, c) that `point` is on: 1 where the normal
/// (b − a) × (c − a) points, −1 on the other side, 0 on the plane. Exact for finite points.
#[must_use]
pub fn side_sign(corners: &[[f32; 3]; 3], point: [f32; 3]) -> i32 {
    let [a, b, c] = *corners;
    // The determinant of the points with a column of ones, by that column.
    let mut sum = Sum::<48>::new();
    let faces =
        [([a, b, c], -1.0), ([a, b, point], 1.0), ([a, c, point], -1.0), ([b, c, point], 1.0)];
    for ([x, y, z], sign) in faces.each(|(f, s)| (f.each(wide), s)) {
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            sum.add_product(sign * y[u] * z[v], x[axis]);
            sum.add_product(-sign * y[v] * z[u], x[axis]);
        }
    }
    sum.sign()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_see_what_rounding_hides() {
        let mut sum = Sum::<4>::new();
        [1e30, 1.0, -1e30].into_iter().for_each(|t| sum.add(t));
        assert_eq!(sum.sign(), 1);
        sum.add(-1.0);
        assert_eq!(sum.sign(), 0);
    }

    #[test]
    fn collinear_points_are_found_at_any_scale() {
        // 0.1 and its multiples are not exact, so these three only look collinear.
        let almost = [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2], [0.3, 0.3, 0.300_000_04]];
        assert!(!is_collinear(&almost));
        let tiny = f32::from_bits(1);
        assert!(!is_collinear(&[[0.0; 3], [tiny, 0.0, 0.0], [0.0, tiny, 0.0]]));
        assert!(is_collinear(&[[0.0; 3], [1e38, 1e38, 0.0], [-3e38, -3e38, 0.0]]));
        // Coordinates of very different size, where even the f64 differences round.
        assert!(!is_collinear(&[[1e20, 0.0, 0.0], [0.0, 1e-20, 0.0], [-1e20, 0.0, 0.0]]));
    }

    /// Columns of any size, of which many are a sum of the others but for the last bit.
    #[test]
    fn the_quick_sign_of_a_determinant_is_the_exact_one() {
        let mut state = 1_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / 8_388_608.0 - 1.0
        };
        let mut signs = [0; 3];
        for round in 0..20_000 {
            let scale = 10.0_f32.powi(round % 61 - 30);
            let [x, y] = [(); 2].map(|()| [(); 3].map(|()| next() * scale));
            let (a, b) = (next(), next());
            let mut z =
                [0, 1, 2].map(|k| if round % 3 == 0 { next() } else { a * x[k] + b * y[k] });
            if round % 5 == 0 {
                z = x;
            }
            let sign = determinant_sign(&[x, y, z]);
            assert_eq!(sign, exact_determinant_sign(&[x, y, z]), "{x:?} {y:?} {z:?}");
            signs[(sign + 1) as usize] += 1;
        }
        assert!(signs.iter().all(|&n| n > 1000), "{signs:?}");
    }

    #[test]
    fn sides_and_determinants_have_the_right_sign() {
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(determinant_sign(&unit), 1);
        let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(side_sign(&floor, [5.0, 5.0, 1e-30]), 1);
        assert_eq!(side_sign(&floor, [5.0, 5.0, -1e-30]), -1);
        assert_eq!(side_sign(&floor, [1e30, 5.0, 0.0]), 0);
        assert_eq!(area_sign(&floor, 2), 1);
    }
}
