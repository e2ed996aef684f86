//! The canvas: all that drawing into a buffer needs, borrowed from it.

use alloc::vec::Vec;

use crate::simd::dispatch;

use super::blocks::BlocksMut;
use super::connected::Connected;
use super::outline::Outline;
use super::screen::{Clip, ObjectScreen, Screen};
use super::surface::{Projection, Surface};
use crate::transform::Transform;

/// Blocks of an [`OcclusionBuffer`](super::OcclusionBuffer) into which occluders are drawn, and the
/// memory of drawing.
#[derive(Debug)]
pub(crate) struct Canvas<'a> {
    pub(crate) target: BlocksMut<'a>,
    pub(super) screen: Option<&'a Screen>,
    pub(super) origin: [f64; 3],
    /// No nearer than this is drawn of the next shape. What hides its box so hides all of it, row
    /// by row.
    pub(crate) nearest: f32,
    pub(crate) pen: &'a mut Pen,
}

/// Memory of drawing, and what is known of the shape before.
#[derive(Clone, Debug)]
pub(crate) struct Pen {
    pub(crate) outline: Outline,
    /// Corners of a convex body before the divide, and where eight at a time are on the screen.
    pub(crate) clips: Vec<Clip>,
    pub(crate) places: Vec<[[f64; 8]; 3]>,
    /// Made when a surface is drawn.
    surface: Option<Surface>,
    /// Columns and rows of blocks.
    blocks: [usize; 2],
    /// The screen of the object that was drawn last: many shapes may stand as one object.
    pub(super) object: Option<(Transform, ObjectScreen)>,
    /// The projection of surfaces of that object, where one was drawn; `None` within where there is
    /// none.
    projection: Option<Option<Projection>>,
}

impl Pen {
    /// One for a buffer of so many columns and rows of blocks.
    pub(super) fn new(columns: usize, rows: usize) -> Self {
        Self {
            outline: Outline::default(),
            clips: Vec::new(),
            places: Vec::new(),
            surface: None,
            blocks: [columns, rows],
            object: None,
            projection: None,
        }
    }

    /// Forgets the last object.
    pub(super) fn begin(&mut self) {
        (self.object, self.projection) = (None, None);
    }
}

impl Canvas<'_> {
    /// The screen of an object; `None` where the buffer has none yet.
    pub(crate) fn object_screen(&mut self, transform: &Transform) -> Option<ObjectScreen> {
        self.turn_to(transform)?;
        self.pen.object.as_ref().map(|(_, screen)| screen.clone())
    }

    /// Has the pen keep the screen of an object; `None` where the buffer has none yet.
    fn turn_to(&mut self, transform: &Transform) -> Option<()> {
        if !matches!(&self.pen.object, Some((last, _)) if last == transform) {
            let screen = self.screen?.of_object(transform, self.origin);
            self.pen.object = Some((*transform, screen));
            self.pen.projection = None;
        }
        Some(())
    }

    /// Draws a patch.
    pub(crate) fn draw_connected(&mut self, simd: crate::Simd, patch: &Connected, at: &Transform) {
        if self.turn_to(at).is_none() {
            return;
        }
        let size = self.target.size;
        let Pen { surface, object, projection, blocks: [columns, rows], .. } = &mut *self.pen;
        let Some((_, screen)) = object else { return };
        let projection = projection.get_or_insert_with(|| Projection::new(screen, size));
        let Some(projection) = projection else { return };
        let surface = surface.get_or_insert_with(|| Surface::new(*columns, *rows));
        let (target, nearest) = (&mut self.target, self.nearest);
        dispatch!(simd, simd => surface.draw(simd, patch, (screen, nearest), projection, target));
    }

    /// Covers what lies wholly within the outline of its pen.
    pub(crate) fn fill(&mut self, simd: crate::Simd) {
        dispatch!(simd, simd => self.pen.outline.fill(simd, &mut self.target));
    }
}
