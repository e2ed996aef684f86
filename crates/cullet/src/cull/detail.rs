//! Detail culling: dropping what is small on the screen. Lossy.

use crate::view::ScreenRect;

/// How the size of a screen rectangle is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Measure {
    /// Width and height both below the threshold.
    #[default]
    WidthAndHeight,
    /// Area below the threshold, in square pixels.
    Area,
    /// Diagonal below the threshold.
    Diameter,
}

/// What counts as too small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// How size is measured.
    pub measure: Measure,
    /// The threshold, in pixels (square pixels for [`Measure::Area`]).
    pub threshold_px: f64,
}

impl Detail {
    /// Whether a projected box is too small. One that crosses the near plane has no rectangle and is
    /// never small.
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
