//! Boxes as the caller has them: at any stride, in f32 or f64, by corners or by centre and half
//! size.

use std::ffi::c_void;

use engine::bounds::{Aabb, Boxes as Batch};

use crate::memory::{Plain, Rows, rows};
use crate::status::{Error, Result};

/// Types of numbers in arrays of the caller's.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum Number {
    /// `float`.
    F32 = 0,
    /// `double`.
    F64 = 1,
}

/// Contents of the two arrays of boxes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum BoxForm {
    /// The lowest and the highest corner.
    MinMax = 0,
    /// The centre and half the size.
    CenterHalf = 1,
}

/// Boxes in arrays of the caller's, of any layout. Set it to zero before its fields.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BoxArrays {
    /// The three numbers of the first box's lowest corner, or of its centre.
    pub first: *const c_void,
    /// The three numbers of the first box's highest corner, or of half its size.
    pub second: *const c_void,
    /// Bytes from one box to the next in `first`: a multiple of the size of a number, at least three
    /// of them.
    pub stride: usize,
    /// The same for `second`; 0 for that of `first`.
    pub second_stride: usize,
    /// How many boxes.
    pub count: usize,
    /// A `cullet_number`: the type of all numbers.
    pub number: u32,
    /// A `cullet_box_form`: what `first` and `second` are.
    pub form: u32,
    /// The point of the world that the numbers are relative to; finite. Zero for none.
    pub origin: [f64; 3],
}

impl Plain for BoxArrays {}

/// Boxes in the caller's memory, checked as far as they can be.
pub(super) struct BoxRows {
    both: Both,
    has_centers: bool,
    origin: [f64; 3],
}

enum Both {
    F32(Rows<f32>, Rows<f32>),
    F64(Rows<f64>, Rows<f64>),
}

impl BoxArrays {
    /// Checks the arrays.
    ///
    /// # Safety
    /// There must be as many boxes as `count` says, at those strides, for as long as the result is
    /// used.
    pub(super) unsafe fn rows(&self) -> Result<BoxRows> {
        let Self { stride, second_stride, count, number, form, origin, .. } = *self;
        let has_centers = match form {
            0 => false,
            1 => true,
            _ => {
                let message =
                    format!("arrays->form is {form}: it must be 0 or 1, a cullet_box_form");
                return Err(Error::value(message));
            }
        };
        if origin.iter().any(|v| !v.is_finite()) {
            return Err(Error::value(format!("arrays->origin is {origin:?}: it must be finite")));
        }
        let other = if second_stride == 0 { stride } else { second_stride };
        let (first, second) = ("arrays->first", "arrays->second");
        // SAFETY: the caller's promise.
        let both = unsafe {
            match number {
                0 => Both::F32(
                    rows(first, self.first.cast(), stride, count)?,
                    rows(second, self.second.cast(), other, count)?,
                ),
                1 => Both::F64(
                    rows(first, self.first.cast(), stride, count)?,
                    rows(second, self.second.cast(), other, count)?,
                ),
                _ => {
                    let message =
                        format!("arrays->number is {number}: it must be 0 or 1, a cullet_number");
                    return Err(Error::value(message));
                }
            }
        };
        Ok(BoxRows { both, has_centers, origin })
    }
}

impl BoxRows {
    /// The point to store the boxes relative to: the origin of f32, which loses nothing by it, and
    /// the middle of f64, since far from it f32 would round boxes by much.
    pub(super) fn middle(&self) -> [f64; 3] {
        let Both::F64(rows, _) = &self.both else { return self.origin };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for row in rows.iter() {
            for a in 0..3 {
                // Infinite numbers have no middle; a NaN fails both comparisons.
                if row[a].is_finite() {
                    low[a] = low[a].min(row[a]);
                    high[a] = high[a].max(row[a]);
                }
            }
        }
        let middle = |a: usize| self.origin[a] + (low[a] * 0.5 + high[a] * 0.5);
        [0, 1, 2].map(|a| Some(middle(a)).filter(|v| v.is_finite()).unwrap_or(self.origin[a]))
    }

    /// Stores the boxes relative to `origin`, from box `at` of a batch on.
    pub(super) fn write(&self, origin: [f64; 3], batch: &mut Batch, at: usize) {
        let is_same = origin == self.origin;
        match (&self.both, self.has_centers) {
            (Both::F32(min, max), false) if is_same => {
                put(batch, at, min, max, |min, max| Aabb { min, max });
            }
            (Both::F32(center, half), true) if is_same => {
                put(batch, at, center, half, |c, h| Aabb {
                    min: [0, 1, 2].map(|a| (c[a] - h[a]).next_down()),
                    max: [0, 1, 2].map(|a| (c[a] + h[a]).next_up()),
                });
            }
            (Both::F32(first, second), _) => {
                let wide = |row: [f32; 3]| row.map(f64::from);
                put(batch, at, first, second, |f, s| self.moved(origin, wide(f), wide(s)));
            }
            (Both::F64(first, second), _) => {
                put(batch, at, first, second, |f, s| self.moved(origin, f, s));
            }
        }
    }

    /// A box relative to another origin: each rounding of each step goes outward.
    fn moved(&self, origin: [f64; 3], first: [f64; 3], second: [f64; 3]) -> Aabb {
        let corner = |sign: f64, start: [f64; 3], outward: fn(f64) -> f64| {
            [0, 1, 2].map(|a| {
                let mut v = start[a];
                if self.has_centers {
                    v = outward(v + sign * second[a]);
                }
                // Adding zero is exact, and here by far the most frequent.
                if self.origin[a] != 0.0 {
                    v = outward(v + self.origin[a]);
                }
                if origin[a] != 0.0 {
                    v = outward(v - origin[a]);
                }
                v
            })
        };
        let high = if self.has_centers { first } else { second };
        Aabb::rounded_out(corner(-1.0, first, f64::next_down), corner(1.0, high, f64::next_up))
    }
}

/// Stores boxes that `make` makes of rows, sixteen at a time: a box that is read back as soon as it
/// is made, in other widths than it was written in, waits for memory and takes four times as long.
fn put<T: Plain>(
    batch: &mut Batch,
    at: usize,
    first: &Rows<T>,
    second: &Rows<T>,
    make: impl Fn([T; 3], [T; 3]) -> Aabb,
) {
    let mut some = [Aabb::EMPTY; 16];
    for start in (0..first.count()).step_by(some.len()) {
        let count = some.len().min(first.count() - start);
        for (number, to) in some[..count].iter_mut().enumerate() {
            *to = make(first.get(start + number), second.get(start + number));
        }
        for (number, b) in some[..count].iter().enumerate() {
            batch.set(at + start + number, b);
        }
    }
}
