//! The rasteriser that is measured, as the measurement sees it.

use cullet::View;
use cullet::bounds::Boxes;

/// Outside of the picture: an answer, as it stands in a file of answers.
pub const OUTSIDE: u8 = 0;
/// In the picture, for all that is known.
pub const VISIBLE: u8 = 1;
/// In the frustum and proved hidden.
pub const HIDDEN: u8 = 2;

/// An occlusion buffer with what a scene draws, piece by piece.
pub(super) trait Rasteriser {
    /// Empties the buffer for a view.
    fn clear(&mut self, view: &View);

    /// Draws pieces in this order.
    fn draw(&mut self, pieces: &[u32]);

    /// Draws pieces in this order, but those whose box is hidden by what is drawn so far. Returns
    /// how many it drew.
    fn draw_unless_hidden(&mut self, pieces: &[u32]) -> usize;

    /// Whether that passes over more than what is hidden, so that tests are held against it.
    fn is_thrifty(&self) -> bool {
        false
    }

    /// Says of each box whether it is outside, visible or hidden, by what is drawn.
    fn test(&mut self, boxes: &Boxes, answers: &mut [u8]);
}
