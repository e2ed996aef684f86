//! Cells and portals: a plan of them, the chain of portals in a view, and which cells see each
//! other.

mod chain;
mod matrix;
mod overview;
mod plan;
mod sight;
mod walk;

pub use chain::portals;
pub use matrix::{PairShown, matrix_order, pvs_matrix};
pub use overview::cells;
pub use sight::{DoorInView, ShownPortal, shown_portals, shut_doors, walk_order};
pub use walk::PortalWalk;

/// Open portals on a plan.
const OPEN: [u8; 3] = [0x1B, 0x8A, 0x4B];
/// Shut ones, everywhere.
pub(super) const SHUT: [u8; 3] = [0xD8, 0x2C, 0x20];

/// The colour of what is seen through so many portals, 1 or more: all beyond the fifth alike. Told
/// apart from red, the colour of shut doors.
#[must_use]
pub fn depth_color(depth: u32) -> [u8; 3] {
    const COLORS: [[u8; 3]; 6] = [
        [0xF6, 0xE7, 0xA8],
        [0x6F, 0xD6, 0x77],
        [0x34, 0xC3, 0xC4],
        [0x4C, 0x9B, 0xF2],
        [0x97, 0x82, 0xF2],
        [0xE0, 0x82, 0xDA],
    ];
    COLORS[(depth as usize).min(COLORS.len() - 1)]
}

/// The words for that colour.
fn depth_words(depth: u32) -> String {
    match depth {
        0 => "the cell of the eye".to_owned(),
        1 => "through 1 portal".to_owned(),
        n if n >= 5 => "through 5 or more".to_owned(),
        n => format!("through {n}"),
    }
}
