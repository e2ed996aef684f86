//! Lines clipped by planes, windows and convex regions, as parameters.
//!
//! A line from a to b is a + t·(b − a), t in 0..=1, and what is left of it is `[t0, t1]`:
//! positions, colours and texture coordinates all follow by [`at`]. On a side is inside, as
//! everywhere in this room, so a line that only touches a region gives t0 = t1.
//!
//! Three ways, the first two for windows with sides along the axes: by outcodes (Cohen &
//! Sutherland, in Newman & Sproull, *Principles of Interactive Computer Graphics*, 1973), which
//! decides most lines with comparisons alone; by parameters (Liang & Barsky, *A New Concept and
//! Method for Line Clipping*, 1984); and by parameters against any planes (Cyrus & Beck,
//! *Generalized Two- and Three-Dimensional Clipping*, 1978).

use std::cmp::Ordering;

use super::ClipError;
use super::region::{HalfSpace, Region, Scalar};

/// The point, or any attribute, at a parameter of a line: exactly `a` at 0.
#[inline]
#[must_use]
pub fn at<T: Scalar, const N: usize>(a: &[T; N], b: &[T; N], t: T) -> [T; N] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

/// Narrows `[t0, t1]` to where a height that is `a` at 0 and `b` at 1 is not above zero. `false`
/// where nothing is left. A NaN narrows nothing.
#[inline]
fn narrow<T: Scalar>(t: &mut [T; 2], a: T, b: T) -> bool {
    if a > T::ZERO {
        if b > T::ZERO {
            return false;
        }
        let enters = a / (a - b);
        if enters > t[0] {
            t[0] = enters;
        }
    } else if b > T::ZERO {
        let leaves = a / (a - b);
        if leaves < t[1] {
            t[1] = leaves;
        }
    }
    let empty = t[0] > t[1];
    !empty
}

impl<T: Scalar, const D: usize> HalfSpace<T, D> {
    /// The part of a line within the half-space; `None` where there is none.
    #[inline]
    #[must_use]
    pub fn clip_line(&self, a: &[T; D], b: &[T; D]) -> Option<[T; 2]> {
        let mut t = [T::ZERO, T::ONE];
        narrow(&mut t, self.height(a), self.height(b)).then_some(t)
    }
}

impl<T: Scalar, const D: usize> Region<T, D> {
    /// The part of a line within the region, by Cyrus & Beck; `None` where there is none.
    ///
    /// In four dimensions, before the divide, this is right for points with w ≤ 0 as well: the part
    /// within a clip volume has w ≥ 0. A line with a NaN is kept whole by the planes that it hides
    /// from.
    #[must_use]
    pub fn clip_line(&self, a: &[T; D], b: &[T; D]) -> Option<[T; 2]> {
        let mut t = [T::ZERO, T::ONE];
        self.sides().all(|(_, s)| narrow(&mut t, s.height(a), s.height(b))).then_some(t)
    }
}

/// A window: low ≤ x ≤ high on each axis. Sides may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window<T, const D: usize> {
    low: [T; D],
    high: [T; D],
}

impl<T: Scalar, const D: usize> Window<T, D> {
    /// The window between two corners. A low that equals its high is a window without width, and
    /// right.
    ///
    /// # Errors
    /// [`ClipError::NoWindow`] where a low exceeds its high, or is NaN.
    pub fn new(low: [T; D], high: [T; D]) -> Result<Self, ClipError> {
        match (0..D).find(|&i| low[i].partial_cmp(&high[i]).is_none_or(Ordering::is_gt)) {
            None => Ok(Self { low, high }),
            Some(axis) => Err(ClipError::NoWindow {
                axis,
                low: low[axis].to_f64(),
                high: high[axis].to_f64(),
            }),
        }
    }

    /// The low corner.
    #[must_use]
    pub fn low(&self) -> [T; D] {
        self.low
    }

    /// The high corner.
    #[must_use]
    pub fn high(&self) -> [T; D] {
        self.high
    }

    /// The window as a region: plane 2i is the low side of axis i, plane 2i + 1 the high one.
    /// Infinite sides, and axes beyond the sixteenth, are absent.
    #[must_use]
    pub fn region(&self) -> Region<T, D> {
        let mut region = Region::everything();
        for i in 0..D.min(16) {
            for (k, sign, d) in [(0, -T::ONE, -self.low[i]), (1, T::ONE, self.high[i])] {
                let mut normal = [T::ZERO; D];
                normal[i] = sign;
                if let Ok(side) = HalfSpace::new(normal, d) {
                    region.set(i * 2 + k, side);
                }
            }
        }
        region
    }

    /// Bit 2i: below the low side of axis i; bit 2i + 1: above the high one. In the plane that is
    /// left, right, bottom, top, nine codes in all. No bit for a NaN.
    #[inline]
    #[must_use]
    pub fn outcode(&self, p: &[T; D]) -> u32 {
        let mut code = 0;
        for i in 0..D.min(16) {
            code |= u32::from(p[i] < self.low[i]) << (2 * i);
            code |= u32::from(p[i] > self.high[i]) << (2 * i + 1);
        }
        code
    }

    /// The part of a line within the window, by Cohen & Sutherland: accepted or rejected by
    /// outcodes where they decide; else the end that is outside moves to the side that its lowest
    /// bit names, and the codes are tested again. `None` where nothing is left.
    ///
    /// The moved end lies on that side exactly, whatever rounding says, so there are at most 4·D
    /// rounds. A line of finite ends gives finite parameters; an infinite end that must be moved
    /// gives a NaN.
    #[must_use]
    pub fn cohen_sutherland(&self, a: &[T; D], b: &[T; D]) -> Option<[T; 2]> {
        let mut t = [T::ZERO, T::ONE];
        let mut ends = [*a, *b];
        let mut codes = [self.outcode(a), self.outcode(b)];
        while codes[0] | codes[1] != 0 {
            if codes[0] & codes[1] != 0 {
                return None;
            }
            let end = usize::from(codes[0] == 0);
            let bit = codes[end].trailing_zeros() as usize;
            let (axis, high) = (bit / 2, bit % 2 == 1);
            let side = if high { self.high[axis] } else { self.low[axis] };
            // From the whole line and not from what is left of it, so that errors do not add up.
            t[end] = (side - a[axis]) / (b[axis] - a[axis]);
            if t[0] > t[1] {
                return None;
            }
            ends[end] = at(a, b, t[end]);
            ends[end][axis] = side;
            // Sides that an earlier round has settled stay settled.
            let settled = (1_u32 << (bit + 1)) - 1;
            codes[end] = self.outcode(&ends[end]) & !settled;
        }
        Some(t)
    }

    /// The part of a line within the window, by Liang & Barsky: for each axis, where the line
    /// enters and leaves the slab between its two sides. `None` where nothing is left. A line with
    /// a NaN is kept whole by the sides that it hides from.
    #[must_use]
    pub fn liang_barsky(&self, a: &[T; D], b: &[T; D]) -> Option<[T; 2]> {
        let mut t = [T::ZERO, T::ONE];
        for i in 0..D {
            if !narrow(&mut t, self.low[i] - a[i], self.low[i] - b[i])
                || !narrow(&mut t, a[i] - self.high[i], b[i] - self.high[i])
            {
                return None;
            }
        }
        Some(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::oracles::clip::clip_line_ref;

    #[test]
    fn three_ways_agree_on_plain_lines() {
        let window = Window::new([0.0, 0.0], [4.0, 2.0]).unwrap();
        for (a, b, expected) in [
            ([1.0, 1.0], [3.0, 1.0], Some([0.0, 1.0])),
            ([-2.0, 1.0], [6.0, 1.0], Some([0.25, 0.75])),
            ([-1.0, -1.0], [3.0, 3.0], Some([0.25, 0.75])),
            // Candidates that miss, around a corner; and one that touches it.
            ([-2.0, 1.0], [1.0, 4.0], None),
            ([-1.0, 1.0], [1.0, 3.0], Some([0.5, 0.5])),
            ([5.0, 0.0], [6.0, 1.0], None),
            // Along a side, and without length.
            ([0.0, -1.0], [0.0, 3.0], Some([0.25, 0.75])),
            ([4.0, 2.0], [4.0, 2.0], Some([0.0, 1.0])),
        ] {
            assert_eq!(window.cohen_sutherland(&a, &b), expected, "{a:?} {b:?}");
            assert_eq!(window.liang_barsky(&a, &b), expected, "{a:?} {b:?}");
            assert_eq!(window.region().clip_line(&a, &b), expected, "{a:?} {b:?}");
            assert_eq!(clip_line_ref(&window.region().planes(), &a, &b), expected, "{a:?} {b:?}");
        }
    }

    #[test]
    fn half_open_and_inverted_windows() {
        let right = Window::new([0.0, f64::NEG_INFINITY], [f64::INFINITY; 2]).unwrap();
        assert_eq!(right.region().present(), 1);
        assert_eq!(right.cohen_sutherland(&[-1.0, 5.0], &[1.0, 5.0]), Some([0.5, 1.0]));
        assert_eq!(right.liang_barsky(&[-1.0, 5.0], &[1.0, 5.0]), Some([0.5, 1.0]));
        let refused = Window::new([0.0, 2.0], [1.0, 1.0]).unwrap_err();
        assert_eq!(refused, ClipError::NoWindow { axis: 1, low: 2.0, high: 1.0 });
        assert!(Window::new([f32::NAN], [1.0]).is_err());
    }

    #[test]
    fn a_line_behind_the_eye_is_cut_before_it_is_divided() {
        // w runs from 1 to −1; the near plane z ≥ 0 leaves the first quarter.
        let near = HalfSpace::new([0.0, 0.0, -1.0, 0.0], 0.0).unwrap();
        let [a, b] = [[0.0, 0.0, 0.5, 1.0], [4.0, 0.0, -1.5, -1.0]];
        let t = near.clip_line(&a, &b).unwrap();
        assert_eq!(t, [0.0, 0.25]);
        assert_eq!(at(&a, &b, t[1]), [1.0, 0.0, 0.0, 0.5]);
    }
}
