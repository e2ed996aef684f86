//! Script of every film: frames by their place in it.

use cullet_command::console::grouped;
use cullet_command::exit::Failure;
use cullet_draw::Picture;

/// Draws frame after frame.
pub(super) trait Script {
    /// The frame at a share of the film, 0 at its first frame and 1 after its last; called in that
    /// order.
    fn frame(&mut self, share: f64) -> Result<Picture, Failure>;
}

/// A number as pictures write it: their font has no narrow space.
pub(super) fn plain(n: u64) -> String {
    grouped(n).replace('\u{202f}', ",")
}
