//! Detail culling: dropping what is small on the screen. Lossy, so off by default: what is dropped
//! is smaller than the threshold, in pixels, and no more than that is promised.

mod batch;
mod nodes;

pub(crate) use batch::SizeTest;
pub(crate) use nodes::NodeSizes;

use crate::math;
use crate::view::ScreenRect;

/// How the size of a screen rectangle is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Measure {
    /// Width and height both below the threshold: what is long and thin, such as a cable, is kept
    /// by its long side.
    #[default]
    #[cfg_attr(feature = "serde", serde(rename = "box"))]
    WidthAndHeight,
    /// Area below the threshold, in square pixels.
    Area,
    /// Diagonal below the threshold.
    Diameter,
}

/// Measure and threshold of detail culling.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct Detail {
    /// How size is measured.
    pub measure: Measure,
    /// The threshold, in pixels (square pixels for [`Measure::Area`]).
    pub threshold_px: f64,
    /// Whether clusters of rigid instances are dropped by themselves, too. Default off: it tears
    /// holes into whatever is made of clusters that are smaller than the threshold but is itself
    /// larger; [levels](crate::lod) are for that. An instance that
    /// [hides](crate::Culler::occlusion) others keeps its clusters.
    pub clusters: bool,
    /// How much above the threshold what is left begins to [fade](Self::weight), as a share of it,
    /// from 0. Default 0. What fades hides nothing.
    pub fade: f64,
}

impl Default for Detail {
    /// Culls bounds narrower and lower than a pixel.
    fn default() -> Self {
        Self { measure: Measure::default(), threshold_px: 1.0, clusters: false, fade: 0.0 }
    }
}

impl Detail {
    /// These settings with another [measure](Self::measure) of size.
    #[must_use]
    pub fn with_measure(self, measure: Measure) -> Self {
        Self { measure, ..self }
    }

    /// These settings with another [threshold](Self::threshold_px), in pixels.
    #[must_use]
    pub fn with_threshold_px(self, threshold_px: f64) -> Self {
        Self { threshold_px, ..self }
    }

    /// These settings with [clusters](Self::clusters) dropped by themselves or not.
    #[must_use]
    pub fn with_clusters(self, clusters: bool) -> Self {
        Self { clusters, ..self }
    }

    /// These settings with another width of the [fade](Self::fade), as a share of the threshold.
    #[must_use]
    pub fn with_fade(self, fade: f64) -> Self {
        Self { fade, ..self }
    }

    /// Whether a projected box is too small. One that crosses the near plane has no rectangle and
    /// is never small; nor is one whose size or threshold is NaN.
    #[must_use]
    pub fn is_small(&self, rect: Option<&ScreenRect>) -> bool {
        rect.is_some_and(|rect| self.is_small_size([rect.width(), rect.height()], 1.0))
    }

    /// Returns whether a width and height in pixels, multiplied by `weight`, are below the
    /// threshold. Returns false if [`weight`](crate::Instance::size_weight) is infinite, NaN or
    /// below 0.
    #[must_use]
    pub fn is_small_size(&self, size: [f64; 2], weight: f64) -> bool {
        weight >= 0.0 && self.measured(size, weight) < self.threshold_px
    }

    /// Returns the number that is compared with the threshold, in pixels (square pixels for
    /// [`Measure::Area`]). It is NaN where `weight` is infinite and both lengths are zero.
    fn measured(&self, [w, h]: [f64; 2], weight: f64) -> f64 {
        let (w, h) = (w * weight, h * weight);
        match self.measure {
            // Not `max`, which would not see a NaN.
            Measure::WidthAndHeight if w > h || w.is_nan() => w,
            Measure::WidthAndHeight => h,
            Measure::Area => w * h,
            Measure::Diameter => math::hypot(w, h),
        }
    }

    /// How much of something is to be drawn, 0 to 1, by the width and height of its picture in
    /// pixels: 0 at the threshold, where it goes, 1 from `1 + fade` times that. A renderer that
    /// draws it by that share, blended or as a pattern of pixels, has nothing pop out of sight. 1
    /// where there is no size.
    #[must_use]
    pub fn weight(&self, size: Option<[f64; 2]>, weight: f64) -> f64 {
        let Some(size) = size else { return 1.0 };
        let above = self.measured(size, weight) / self.threshold_px - 1.0;
        match self.fade {
            fade if fade > 0.0 && above < fade => (above / fade).clamp(0.0, 1.0),
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small(measure: Measure, threshold_px: f64, size: [f64; 2]) -> bool {
        let rect = ScreenRect { min: [10.0, 20.0], max: [10.0 + size[0], 20.0 + size[1]] };
        Detail { measure, threshold_px, ..Detail::default() }.is_small(Some(&rect))
    }

    #[test]
    fn each_measure_has_its_own_threshold() {
        assert!(small(Measure::WidthAndHeight, 4.0, [3.0, 3.9]));
        assert!(!small(Measure::WidthAndHeight, 4.0, [0.1, 4.0]), "both must be below");
        assert!(small(Measure::Area, 12.0, [0.1, 100.0]));
        assert!(!small(Measure::Area, 12.0, [3.0, 4.0]));
        assert!(small(Measure::Diameter, 5.1, [3.0, 4.0]));
        assert!(!small(Measure::Diameter, 5.0, [3.0, 4.0]));
    }

    #[test]
    fn what_has_no_size_is_never_small() {
        let detail = Detail { measure: Measure::Area, threshold_px: 1e9, ..Detail::default() };
        assert!(!detail.is_small(None));
        assert!(!small(Measure::WidthAndHeight, 4.0, [f64::NAN, 1.0]));
        assert!(!small(Measure::Diameter, f64::NAN, [1.0, 1.0]));
    }

    #[test]
    fn sizes_count_by_their_weight() {
        let detail = Detail { threshold_px: 4.0, ..Detail::default() };
        assert!(detail.is_small_size([3.0, 1.0], 1.0) && !detail.is_small_size([3.0, 1.0], 2.0));
        for weight in [f64::INFINITY, f64::NAN, -1.0] {
            assert!(!detail.is_small_size([3.0, 1.0], weight), "{weight}");
            assert!(!detail.is_small_size([0.0, 0.0], weight), "{weight}");
        }
        assert!(detail.is_small_size([3.0, 1.0], 0.0));
    }

    #[test]
    fn what_comes_near_the_threshold_fades() {
        let detail = Detail { threshold_px: 4.0, fade: 0.5, ..Detail::default() };
        assert_eq!(detail.weight(Some([4.0, 1.0]), 1.0), 0.0);
        assert_eq!(detail.weight(Some([1.0, 5.0]), 1.0), 0.5);
        assert_eq!(detail.weight(Some([3.0, 2.0]), 2.0), 1.0);
        assert_eq!(detail.weight(None, 1.0), 1.0);
        assert_eq!(Detail { fade: 0.0, ..detail }.weight(Some([4.1, 1.0]), 1.0), 1.0);
    }
}
