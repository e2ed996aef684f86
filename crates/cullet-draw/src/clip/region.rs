//! Half-spaces and the convex regions that they bound, in any number of dimensions.
//!
//! One form serves every place of the pipeline: a window in the plane (two coordinates), a frustum
//! in object or world space (three), and the clip volume before the divide (four, where all planes
//! pass through the origin). What cuts lines and polygons is written once, over this.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use cullet::bounds::Plane;
use cullet::view::Frustum;
use cullet::view::FrustumPlane;
use thiserror::Error;

/// A number to clip with: `f32` or `f64`.
pub trait Scalar:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// The nearest number of this type.
    fn from_f64(v: f64) -> Self;
    /// The same number, or the nearest, as f64.
    fn to_f64(self) -> f64;
    /// Without its sign.
    #[must_use]
    fn abs(self) -> Self;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

macro_rules! scalar {
    ($($t:ty),*) => {$(
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            #[inline]
            fn from_f64(v: f64) -> Self {
                v as Self
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn abs(self) -> Self {
                self.abs()
            }
        }
    )*};
}
scalar!(f32, f64);

/// Why there is nothing to clip with.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ClipError {
    /// A plane without a direction, or with a number that is not finite.
    #[error(
        "{normal:?}·x = {d} is no plane: its normal must be finite and not zero, its d finite; \
         check where the plane comes from"
    )]
    NoPlane {
        /// The normal as it was given.
        normal: Vec<f64>,
        /// The offset as it was given.
        d: f64,
    },
    /// All bits of an outcode are taken.
    #[error("a region has room for {limit} planes; clip against the rest in a second pass")]
    Full {
        /// The most planes there may be.
        limit: usize,
    },
    /// A window whose sides are out of order, or NaN.
    #[error("the window's axis {axis} runs from {low} to {high}: low must not exceed high")]
    NoWindow {
        /// Number of the coordinate, from 0.
        axis: usize,
        /// Its low side.
        low: f64,
        /// Its high side.
        high: f64,
    },
    /// A guard band narrower than the view itself, or NaN.
    #[error("a guard band of {0} times the view: it must be finite and at least 1")]
    NoGuardBand(f64),
}

/// The half-space n·x ≤ d. The normal points out and need not have unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace<T, const D: usize> {
    normal: [T; D],
    d: T,
}

impl<T: Scalar, const D: usize> HalfSpace<T, D> {
    /// The half-space n·x ≤ d.
    ///
    /// # Errors
    /// [`ClipError::NoPlane`] if the normal is zero or a number is not finite.
    pub fn new(normal: [T; D], d: T) -> Result<Self, ClipError> {
        let finite = normal.iter().chain([&d]).all(|v| v.to_f64().is_finite());
        if finite && normal.iter().any(|v| *v != T::ZERO) {
            return Ok(Self { normal, d });
        }
        Err(ClipError::NoPlane {
            normal: normal.iter().map(|v| v.to_f64()).collect(),
            d: d.to_f64(),
        })
    }

    /// n.
    #[must_use]
    pub fn normal(&self) -> [T; D] {
        self.normal
    }

    /// d.
    #[must_use]
    pub fn d(&self) -> T {
        self.d
    }

    /// n·x − d as plain arithmetic rounds it: above zero outside. The same numbers give the same
    /// height, whichever primitive it belongs to, so neighbours agree about the vertices that they
    /// share.
    #[inline]
    #[must_use]
    pub fn height(&self, p: &[T; D]) -> T {
        // From the first product on, and not from 0: −0 + 0 would cost an addition.
        let mut sum = self.normal[0] * p[0];
        for i in 1..D {
            sum = sum + self.normal[i] * p[i];
        }
        sum - self.d
    }

    /// Where the edge from `inside` to `outside` crosses the plane, as its parameter in 0..=1;
    /// `None` where `inside` is itself on the plane, or a height is NaN.
    ///
    /// Reckoned from the end that is inside, whichever way the edge runs: the two polygons that
    /// share an edge run it in opposite ways, and must get the same crossing bit for bit.
    #[inline]
    pub(super) fn crossing(&self, inside: &[T; D], outside: &[T; D]) -> Option<T> {
        let p = self.height(inside);
        (p < T::ZERO).then(|| {
            let q = self.height(outside);
            // A cut vertex that inherited its side may round to the other one.
            if q > T::ZERO { p / (p - q) } else { T::ONE }
        })
    }
}

impl TryFrom<Plane> for HalfSpace<f64, 3> {
    type Error = ClipError;

    fn try_from(plane: Plane) -> Result<Self, ClipError> {
        Self::new(plane.normal, plane.d)
    }
}

/// A convex region: up to 32 half-spaces, each with a number that outcodes name it by.
///
/// Inside is n·x ≤ d for every plane: a point *on* a plane is inside. A NaN is outside of nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Region<T, const D: usize> {
    sides: [HalfSpace<T, D>; Frustum::MAX_PLANES],
    present: u32,
    /// Planes that cut before the others.
    first: u32,
}

impl<T: Scalar, const D: usize> Default for Region<T, D> {
    fn default() -> Self {
        Self::everything()
    }
}

impl<T: Scalar, const D: usize> Region<T, D> {
    /// The region without planes, which is all of space.
    #[must_use]
    pub fn everything() -> Self {
        let nothing = HalfSpace { normal: [T::ZERO; D], d: T::ZERO };
        Self { sides: [nothing; Frustum::MAX_PLANES], present: 0, first: 0 }
    }

    /// The region within some half-spaces, numbered in their order.
    ///
    /// # Errors
    /// [`ClipError::Full`] beyond 32.
    pub fn new(sides: impl IntoIterator<Item = HalfSpace<T, D>>) -> Result<Self, ClipError> {
        let mut region = Self::everything();
        for side in sides {
            region.push(side)?;
        }
        Ok(region)
    }

    /// Adds a half-space and returns its number, the lowest that is free.
    ///
    /// # Errors
    /// [`ClipError::Full`] if all 32 are taken.
    pub fn push(&mut self, side: HalfSpace<T, D>) -> Result<usize, ClipError> {
        let number = (!self.present).trailing_zeros() as usize;
        if number >= Frustum::MAX_PLANES {
            return Err(ClipError::Full { limit: Frustum::MAX_PLANES });
        }
        self.set(number, side);
        Ok(number)
    }

    pub(super) fn set(&mut self, number: usize, side: HalfSpace<T, D>) {
        self.sides[number] = side;
        self.present |= 1 << number;
    }

    /// Lets a plane cut before the others, because it makes cuts by them unnecessary.
    pub(super) fn cut_first(&mut self, number: usize) {
        self.first |= 1 << number;
    }

    #[inline]
    pub(super) fn first(&self) -> u32 {
        self.first
    }

    /// The same region without the planes that are not in `mask`; the rest keep their numbers.
    #[must_use]
    pub fn only(mut self, mask: u32) -> Self {
        self.present &= mask;
        self
    }

    /// Bit i is set where plane i exists.
    #[must_use]
    pub fn present(&self) -> u32 {
        self.present
    }

    /// The planes and their numbers, ascending.
    pub fn sides(&self) -> impl Iterator<Item = (usize, &HalfSpace<T, D>)> {
        bits(self.present).map(|i| (i, &self.sides[i]))
    }

    /// Returns n and d of each plane, ascending by their numbers.
    #[must_use]
    pub fn planes(&self) -> Vec<([T; D], T)> {
        self.sides().map(|(_, side)| (side.normal, side.d)).collect()
    }

    #[inline]
    pub(super) fn side(&self, number: usize) -> &HalfSpace<T, D> {
        &self.sides[number]
    }

    /// Bit i: the point's height over plane i is above zero. No bit for a NaN.
    #[inline]
    #[must_use]
    pub fn outcode(&self, p: &[T; D]) -> u32 {
        self.outcode_of(p, u32::MAX)
    }

    #[inline]
    pub(super) fn outcode_of(&self, p: &[T; D], mask: u32) -> u32 {
        let mut code = 0;
        let mut left = self.present & mask;
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            code |= u32::from(self.sides[i].height(p) > T::ZERO) << i;
            left &= left - 1;
        }
        code
    }
}

/// The planes of a frustum, with their numbers. In f32 each is rounded to the nearest; clip in f64
/// where the region must not lose a sliver.
impl<T: Scalar> From<&Frustum> for Region<T, 3> {
    fn from(frustum: &Frustum) -> Self {
        let mut region = Self::everything();
        for (i, plane) in frustum.planes() {
            let normal = plane.normal.map(T::from_f64);
            region.set(i, HalfSpace { normal, d: T::from_f64(plane.d) });
        }
        region.cut_first(FrustumPlane::Near as usize);
        region
    }
}

/// The numbers of the bits that are set, ascending.
pub(super) fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < 32).then_some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_plane_is_refused_with_its_numbers() {
        let refused = HalfSpace::<f64, 3>::try_from(Plane::new([0.0; 3], 1.0)).unwrap_err();
        assert!(refused.to_string().contains("[0.0, 0.0, 0.0]"), "{refused}");
        for (normal, d) in [([f32::NAN, 1.0], 0.0), ([1.0, 0.0], f32::INFINITY), ([0.0; 2], 0.0)] {
            assert!(HalfSpace::new(normal, d).is_err(), "{normal:?} {d}");
        }
    }

    #[test]
    fn a_region_holds_32_planes() {
        let side = HalfSpace::new([1.0_f32, 0.0], 1.0).unwrap();
        let mut region = Region::new([side; 32]).unwrap();
        assert_eq!(region.push(side), Err(ClipError::Full { limit: 32 }));
        assert_eq!(region.outcode(&[2.0, 0.0]), u32::MAX);
        assert_eq!(region.outcode(&[1.0, 0.0]), 0, "on a plane is inside");
        assert_eq!(region.outcode(&[f32::NAN, 0.0]), 0);
        let mut few = region.only(0b101);
        assert_eq!(few.outcode(&[2.0, 0.0]), 0b101);
        assert_eq!(few.push(side), Ok(1));
    }
}
