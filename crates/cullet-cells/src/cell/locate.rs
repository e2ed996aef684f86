//! Places of cells, as a scene needs to know them.

use alloc::vec::Vec;
use core::fmt::Debug;

/// Where cells are: which holds a point, and which a box touches. [`CellShapes`](super::CellShapes)
/// know it by their pieces; who has something better for it, as the BSP tree of a map, gives that
/// to [`Cells::new`](crate::Cells::new) instead.
///
/// Boxes are given by their lowest and highest corners, in world space.
pub trait CellLocator: Debug + Send + Sync {
    /// The cell of a point; the lowest number where it is in several, as on the border between two.
    /// `None` where it is in none, and for one that is not finite.
    fn cell_of(&self, point: [f64; 3]) -> Option<u32>;

    /// Appends all cells that a box may touch, with half of the walls around them, in any order and
    /// with repetitions: one too many costs time, one that is missing is a mistake.
    fn cells_touching(&self, min: [f64; 3], max: [f64; 3], cells: &mut Vec<u32>);

    /// Whether all of a box is in cells and their walls, so that what is in the box is seen from
    /// cells alone. `false` in doubt: then an instance is seen from everywhere. A map around which
    /// all is solid says `true` of everything.
    fn is_within(&self, min: [f64; 3], max: [f64; 3]) -> bool;

    /// Whether all of a box is in cells and not in their walls: what a near plane cuts away there
    /// hides nothing. `false` in doubt: then portals hide nothing from an eye in the box.
    fn is_free(&self, min: [f64; 3], max: [f64; 3]) -> bool;

    /// How thick the walls around cells are, in which shut doors stand. Default 0.
    fn walls(&self) -> f64 {
        0.0
    }
}
