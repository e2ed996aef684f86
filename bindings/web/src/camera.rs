//! Cameras as a page has them.

use cullet::view::ViewError;
use cullet::{Depth, View};

/// How a page's matrix has depth.
const WEBGL: u32 = 2;

/// The view of a matrix, world to clip space, column-major. Depth is 0 standard, 1 reversed, or 2
/// from −1 to 1 as in WebGL.
///
/// # Errors
/// If the matrix shows no volume, or the viewport has no pixel.
pub(crate) fn view_of(
    mut matrix: [f64; 16],
    depth: u32,
    viewport: [u32; 2],
) -> Result<View, ViewError> {
    if depth == WEBGL {
        for column in 0..4 {
            let at = column * 4;
            matrix[at + 2] = 0.5 * (matrix[at + 2] + matrix[at + 3]);
        }
    }
    let depth = if depth == 1 { Depth::Reversed } else { Depth::Standard };
    View::from_matrix(matrix, depth, viewport)
}
