//! Candidates: shapes that may be drawn into the buffer.

use super::super::raster::ScreenBounds;
use crate::sort::{of_f32, pair};

/// Candidate shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    /// How near it comes; infinite where it crosses the near plane.
    pub(crate) nearness: f32,
    pub(crate) slot: u32,
    pub(crate) shape: u32,
    /// Cost of drawing it, in microseconds of the model.
    pub(crate) cost: f32,
    /// The pixels that it may touch; `None` where it crosses the near plane.
    pub(crate) bounds: Option<ScreenBounds>,
}

impl Candidate {
    /// Key to sort by: the nearer one first; ties go by slot and shape.
    pub(crate) fn by_nearness(&self) -> u128 {
        u128::from(!of_f32(self.nearness)) << 64 | pair(self.slot, self.shape)
    }
}
