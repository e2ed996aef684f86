//! Functions whose last bit is the same on every machine: those that the standard library takes
//! from the system, here in Rust (`libm`, after musl); and sums and products with their errors.
//!
//! The systems' own differ: glibc's from musl's and from Windows', and glibc's on a processor with
//! fused multiply-add from glibc's on one without. `sqrt`, `floor`, `ceil`, `round` and `trunc` are
//! exact by their definition, and stay the standard library's.

/// sin v, v in radians.
pub fn sin(v: f64) -> f64 {
    libm::sin(v)
}

/// cos v, v in radians.
pub fn cos(v: f64) -> f64 {
    libm::cos(v)
}

/// (sin v, cos v), v in radians.
pub fn sin_cos(v: f64) -> (f64, f64) {
    libm::sincos(v)
}

/// tan v, v in radians.
pub fn tan(v: f64) -> f64 {
    libm::tan(v)
}

/// The angle from 0 to π whose cosine is v; NaN beyond −1 to 1.
pub fn acos(v: f64) -> f64 {
    libm::acos(v)
}

/// The angle from −π to π of the vector (x, y).
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// eᵛ.
pub fn exp(v: f64) -> f64 {
    libm::exp(v)
}

/// 2ᵛ.
pub fn exp2(v: f64) -> f64 {
    libm::exp2(v)
}

/// The natural logarithm.
pub fn ln(v: f64) -> f64 {
    libm::log(v)
}

/// The logarithm to base 2.
pub fn log2(v: f64) -> f64 {
    libm::log2(v)
}

/// The cube root.
pub fn cbrt(v: f64) -> f64 {
    libm::cbrt(v)
}

/// vᵖ.
pub fn pow(v: f64, p: f64) -> f64 {
    libm::pow(v, p)
}

/// √(x² + y²), without overflow on the way.
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// ⌊log₂ v⌋ of a positive normal number, from its bits.
pub fn exponent(v: f64) -> i32 {
    debug_assert!(v.is_normal() && v > 0.0, "{v}");
    (v.to_bits() >> 52) as i32 - 1023
}

/// a + b as a rounded sum and its rounding error (Knuth, *The Art of Computer Programming* 2,
/// 4.2.2).
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let t = s - a;
    (s, (a - (s - t)) + (b - t))
}

/// a · b as a rounded product and its rounding error, which is exact while the product is between
/// 1e−290 and 1e290 and each factor below 1e300.
///
/// (Dekker, *A Floating-Point Technique for Extending the Available Precision*, 1971. A fused
/// multiply-add would do, were it right: mingw-w64 10 rounds one in twenty wrongly; and it is a call
/// into software where the processor has none.)
pub fn two_product(a: f64, b: f64) -> (f64, f64) {
    let split = |v: f64| {
        let t = v * 134_217_729.0; // 2²⁷ + 1
        let high = t - (t - v);
        (high, v - high)
    };
    let p = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

/// The methods of numbers that `core` has not.
#[cfg(not(feature = "std"))]
pub trait Float {
    fn sqrt(self) -> Self;
    fn floor(self) -> Self;
    fn ceil(self) -> Self;
    fn round(self) -> Self;
    fn trunc(self) -> Self;
    fn powi(self, n: i32) -> Self;
}

/// The web's own instructions, of which `libm` makes none: its square root takes some hundred others.
#[cfg(all(not(feature = "std"), target_arch = "wasm32", target_feature = "simd128"))]
mod one {
    use core::arch::wasm32::*;

    macro_rules! one {
        ($($name:ident, $number:ty: $splat:ident, $all:ident, $lane:ident;)*) => {
            $(pub(super) fn $name(v: $number) -> $number {
                $lane::<0>($all($splat(v)))
            })*
        };
    }

    one! {
        sqrt, f64: f64x2_splat, f64x2_sqrt, f64x2_extract_lane;
        floor, f64: f64x2_splat, f64x2_floor, f64x2_extract_lane;
        ceil, f64: f64x2_splat, f64x2_ceil, f64x2_extract_lane;
        trunc, f64: f64x2_splat, f64x2_trunc, f64x2_extract_lane;
        sqrtf, f32: f32x4_splat, f32x4_sqrt, f32x4_extract_lane;
        floorf, f32: f32x4_splat, f32x4_floor, f32x4_extract_lane;
        ceilf, f32: f32x4_splat, f32x4_ceil, f32x4_extract_lane;
        truncf, f32: f32x4_splat, f32x4_trunc, f32x4_extract_lane;
    }
}
#[cfg(all(
    not(feature = "std"),
    not(all(target_arch = "wasm32", target_feature = "simd128"))
))]
use libm as one;

#[cfg(not(feature = "std"))]
impl Float for f64 {
    fn sqrt(self) -> Self {
        one::sqrt(self)
    }
    fn floor(self) -> Self {
        one::floor(self)
    }
    fn ceil(self) -> Self {
        one::ceil(self)
    }
    // Half of the way is less than a half where adding that would round up, as in `libm`.
    fn round(self) -> Self {
        one::trunc(self + (0.5 - 0.25 * Self::EPSILON).copysign(self))
    }
    fn trunc(self) -> Self {
        one::trunc(self)
    }
    fn powi(self, n: i32) -> Self {
        let (mut power, mut base, mut left) = (1.0, self, n.unsigned_abs());
        while left > 0 {
            power *= if left & 1 == 1 { base } else { 1.0 };
            base *= base;
            left >>= 1;
        }
        if n < 0 { 1.0 / power } else { power }
    }
}

#[cfg(not(feature = "std"))]
impl Float for f32 {
    fn sqrt(self) -> Self {
        one::sqrtf(self)
    }
    fn floor(self) -> Self {
        one::floorf(self)
    }
    fn ceil(self) -> Self {
        one::ceilf(self)
    }
    fn round(self) -> Self {
        one::truncf(self + (0.5 - 0.25 * Self::EPSILON).copysign(self))
    }
    fn trunc(self) -> Self {
        one::truncf(self)
    }
    fn powi(self, n: i32) -> Self {
        f64::from(self).powi(n) as Self
    }
}

/// A number that no call in this process had before: of 2³² calls on a target without atomics of 64
/// bits, and of all elsewhere.
pub fn unique() -> u64 {
    #[cfg(target_has_atomic = "64")]
    static NEXT: core::sync::atomic::AtomicU64 = core::sync::atomic::AtomicU64::new(1);
    #[cfg(not(target_has_atomic = "64"))]
    static NEXT: core::sync::atomic::AtomicU32 = core::sync::atomic::AtomicU32::new(1);
    #[allow(clippy::useless_conversion, reason = "it is of 64 bits on most targets")]
    NEXT.fetch_add(1, core::sync::atomic::Ordering::Relaxed).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn next(state: &mut u64) -> u64 {
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *state ^ (*state >> 29)
    }

    /// Integers of 53 bits, against arithmetic on integers.
    #[test]
    fn errors_of_sums_and_products_are_those_of_integers() {
        let mut state = 5;
        for _ in 0..1_000_000 {
            let [a, b] = [(); 2].map(|()| (next(&mut state) >> 11) as i64 | 1);
            let (p, tail) = two_product(a as f64, b as f64);
            assert_eq!(p as i128 + tail as i128, i128::from(a) * i128::from(b), "{a} {b}");
            let (a, b) = ((a as f64) * 1024.0, b as f64);
            let (s, tail) = two_sum(a, b);
            assert_eq!(s as i128 + tail as i128, a as i128 + b as i128, "{a} {b}");
        }
    }

    #[test]
    fn an_exponent_is_the_whole_part_of_a_logarithm() {
        for k in -1022..1024 {
            let power = f64::from_bits(((k + 1023) as u64) << 52);
            assert_eq!(exponent(power), k);
            assert_eq!(exponent(power * 1.999_999_999), k);
        }
        assert_eq!([1.0, 0.75, 3.0, 4.0].map(exponent), [0, -1, 1, 2]);
    }
}
