//! Screen bounds: the pixels that something may touch, and how near it comes.

use crate::bounds::LANES;

/// Pixels that something may touch, and how near it comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenBounds {
    /// First column and row, inclusive.
    pub min: [u32; 2],
    /// Last column and row, inclusive.
    pub max: [u32; 2],
    /// No point of it is nearer; see
    /// [`OcclusionBuffer::nearness`](super::OcclusionBuffer::nearness).
    pub nearness: f32,
}

impl ScreenBounds {
    /// How many pixels it has.
    #[inline(always)]
    pub(crate) fn pixels(&self) -> f32 {
        (0..2).map(|a| (self.max[a] - self.min[a] + 1) as f32).product()
    }
}

/// Screen bounds of sixteen boxes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Rectangles {
    /// First and last columns and rows, inclusive.
    pub(crate) min: [[i32; LANES]; 2],
    pub(crate) max: [[i32; LANES]; 2],
    pub(crate) nearness: [f32; LANES],
    /// No point of the box is farther.
    pub(crate) farthest: [f32; LANES],
    /// One bit a box: it reaches some pixel, and the rest stands for it. Not so where it is
    /// outside, crosses the near plane or is not finite.
    pub(crate) bounded: u32,
    /// One bit a box: it is empty, behind the near plane, or beyond an edge of the screen.
    pub(crate) outside: u32,
}

impl Rectangles {
    pub(crate) const NONE: Self = Self {
        min: [[0; LANES]; 2],
        max: [[0; LANES]; 2],
        nearness: [0.0; LANES],
        farthest: [0.0; LANES],
        bounded: 0,
        outside: 0,
    };

    /// Returns the screen bounds of the box in `lane`. They have no meaning where it is not
    /// `bounded`.
    #[inline(always)]
    pub(crate) fn bounds(&self, lane: usize) -> ScreenBounds {
        ScreenBounds {
            min: [self.min[0][lane] as u32, self.min[1][lane] as u32],
            max: [self.max[0][lane] as u32, self.max[1][lane] as u32],
            nearness: self.nearness[lane],
        }
    }
}
