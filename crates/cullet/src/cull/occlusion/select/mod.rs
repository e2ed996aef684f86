//! Choosing: the occluders that are drawn, within a budget, or from a list.

mod candidate;
mod dynamic;
mod list;

pub(crate) use candidate::Candidate;
pub use dynamic::DynamicSurface;

use super::raster::OcclusionBuffer;
use crate::array::Each;

/// Settings of occlusion culling.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct Occlusion {
    /// Pixels across the buffer; its height follows from the viewport. Never more than the viewport
    /// has. Half of the screen finds nearly as much as all of it, at a quarter of the cost; the
    /// answer is never wrong. Default 640.
    pub width: u32,
    /// Cost that drawing occluders may come to, in microseconds of a cost model, not of a clock: so
    /// the same scene, view and budget give the same answer on every machine. 0 draws none. Half a
    /// millisecond finds most of what is hidden, even in a forest of a million instances. Default
    /// 200.
    pub budget: f32,
    /// Share of the cost of drawing what is left, by [`Culler::costs`](crate::Culler::costs), that
    /// may be spent before anything is known to be hidden, searching and testing included. With
    /// 0.015 no frame gets more than some 3 % slower: the first occluders cost up to twice what the
    /// model says, which assumes warm memory. If so little is left to draw that searching would
    /// cost more, occlusion is left out. After that, as long as something is found to be hidden, a
    /// fifth of the saving may be spent. `None`, the default, spends the budget in any scene. The
    /// value affects how much is found, never whether it is right.
    pub risk: Option<f32>,
}

impl Default for Occlusion {
    fn default() -> Self {
        Self { width: 640, budget: 200.0, risk: None }
    }
}

impl Occlusion {
    /// These settings with another [width](Self::width) of the buffer, in pixels.
    #[must_use]
    pub fn with_width(self, width: u32) -> Self {
        Self { width, ..self }
    }

    /// These settings with another [budget](Self::budget), in microseconds of the cost model.
    #[must_use]
    pub fn with_budget(self, budget: f32) -> Self {
        Self { budget, ..self }
    }

    /// These settings with another [risk](Self::risk), or with none.
    #[must_use]
    pub fn with_risk(self, risk: impl Into<Option<f32>>) -> Self {
        Self { risk: risk.into(), ..self }
    }

    /// The size of the buffer for a viewport.
    pub(crate) fn size(&self, viewport: [u32; 2]) -> [u32; 2] {
        let [width, height] = viewport.each(|v| v.clamp(1, OcclusionBuffer::LIMIT));
        let columns = self.width.clamp(1, width);
        let rows = (u64::from(height) * u64::from(columns)).div_ceil(u64::from(width));
        [columns, (rows as u32).clamp(1, OcclusionBuffer::LIMIT)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_follow_the_viewport() {
        let of = |width| Occlusion { width, ..Occlusion::default() };
        assert_eq!(of(640).size([1280, 720]), [640, 360]);
        assert_eq!(of(640).size([320, 33]), [320, 33]);
        assert_eq!(of(0).size([1280, 720]), [1, 1]);
        assert_eq!(of(7).size([65536, 65536]), [7, 7]);
    }
}
