//! Bands: rows of tiles of a buffer, each drawn by itself.
//!
//! Coverage of a pixel depends on no other pixel, so a buffer can be drawn band by band, on as many threads,
//! with the same result to the last bit; and what is hidden in its band need not be drawn there, which threads
//! with a buffer each would not know of one another.

use fearless_simd::dispatch;
use fearless_simd::prelude::*;

use super::connected::Connected;
use super::outline::Outline;
use super::screen::{Clip, ObjectScreen, Screen};
use super::shared_edges::SharedCoverage;
use super::surface::Surface;
use super::tiles::TilesMut;
use crate::transform::Transform;

/// Rows of tiles of an [`OcclusionBuffer`](super::OcclusionBuffer), all or some of them, into which occluders are drawn:
/// of each only the part that lies in these rows.
#[derive(Debug)]
pub struct Band<'a> {
    pub(crate) target: TilesMut<'a>,
    pub(super) screen: Option<&'a Screen>,
    pub(super) origin: [f64; 3],
    pub(crate) pen: &'a mut Pen,
}

/// Memory of drawing, and what is known of the shape before.
#[derive(Clone, Debug)]
pub(crate) struct Pen {
    pub(crate) outline: Outline,
    /// Corners of a convex body before the divide, and where eight at a time are on the screen.
    pub(crate) clips: Vec<Clip>,
    pub(crate) places: Vec<[[f64; 8]; 3]>,
    surface: Surface,
    /// One for each side that triangles show.
    coverage: [SharedCoverage; 2],
    /// The screen of the object that was drawn last: many shapes may stand as one object.
    pub(super) object: Option<(Transform, ObjectScreen)>,
}

impl Pen {
    /// One for a buffer of so many columns and rows of tiles.
    pub(super) fn new(columns: usize, rows: usize) -> Self {
        Self {
            outline: Outline::default(),
            clips: Vec::new(),
            places: Vec::new(),
            surface: Surface::default(),
            coverage: [SharedCoverage::new(columns, rows), SharedCoverage::new(columns, rows)],
            object: None,
        }
    }
}

impl Band<'_> {
    /// The screen of an object; `None` where the buffer has none yet.
    pub(crate) fn object_screen(&mut self, transform: &Transform) -> Option<ObjectScreen> {
        if let Some((last, screen)) = &self.pen.object
            && last == transform
        {
            return Some(screen.clone());
        }
        let screen = self.screen?.of_object(transform, self.origin);
        self.pen.object = Some((*transform, screen.clone()));
        Some(screen)
    }

    /// Draws what lies in it of connected triangles.
    pub(crate) fn draw_connected(&mut self, level: crate::Simd, mesh: &Connected, at: &Transform) {
        let Some(screen) = self.object_screen(at) else { return };
        let Pen { surface, coverage, .. } = &mut *self.pen;
        surface.draw(level, mesh, &screen, self.target.lend(), coverage);
    }

    /// Covers what lies wholly within the outline of its pen.
    pub(crate) fn fill(&mut self, level: crate::Simd) {
        dispatch!(level.0, simd => self.fill_with(simd));
    }

    /// As [`fill`](Self::fill), where the level is known.
    #[inline(always)]
    pub(crate) fn fill_with<S: Simd>(&mut self, simd: S) {
        self.pen.outline.fill(simd, self.target.lend());
    }
}
