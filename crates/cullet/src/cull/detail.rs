//! Detail culling: dropping what is small on the screen. Lossy, so off by default: what is dropped
//! is smaller than the threshold, in pixels, and no more than that is promised.

use crate::view::ScreenRect;

/// How the size of a screen rectangle is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Measure {
    /// Width and height both below the threshold.
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
pub struct Detail {
    /// How size is measured.
    pub measure: Measure,
    /// The threshold, in pixels (square pixels for [`Measure::Area`]).
    pub threshold_px: f64,
}

impl Default for Detail {
    /// Culls bounds narrower and lower than a pixel.
    fn default() -> Self {
        Self { measure: Measure::default(), threshold_px: 1.0 }
    }
}

impl Detail {
    /// Whether a projected box is too small. One that crosses the near plane has no rectangle and is
    /// never small; nor is one whose size or threshold is NaN.
    #[must_use]
    pub fn is_small(&self, rect: Option<&ScreenRect>) -> bool {
        let Some(rect) = rect else { return false };
        let (w, h) = (rect.width(), rect.height());
        let n = self.threshold_px;
        match self.measure {
            Measure::WidthAndHeight => w < n && h < n,
            Measure::Area => w * h < n,
            Measure::Diameter => w.hypot(h) < n,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small(measure: Measure, threshold_px: f64, size: [f64; 2]) -> bool {
        let rect = ScreenRect { min: [10.0, 20.0], max: [10.0 + size[0], 20.0 + size[1]] };
        Detail { measure, threshold_px }.is_small(Some(&rect))
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
        let detail = Detail { measure: Measure::Area, threshold_px: 1e9 };
        assert!(!detail.is_small(None));
        assert!(!small(Measure::WidthAndHeight, 4.0, [f64::NAN, 1.0]));
        assert!(!small(Measure::Diameter, f64::NAN, [1.0, 1.0]));
    }
}
