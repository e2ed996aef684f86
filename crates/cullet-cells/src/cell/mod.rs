//! Cells and the portals between them: what rooms and corridors hide, known without drawing
//! anything.
//!
//! A *cell* is a region of space in which nothing stands between two points: a room, or a part of
//! one. A *portal* is an opening between two cells: a convex polygon. Whoever stands in a cell sees
//! what is in it, and of the others what portals let through. Which that are,
//! [`portal`](crate::portal) finds for a view.
//!
//! | | |
//! |---|---|
//! | [`CellGraph`] | which cells there are, and what leads from one to the next; doors, one-way portals, mirrors |
//! | [`CellShapes`] | where they are: convex pieces, and the walls around them |
//! | [`CellLocator`] | what a scene needs to know of places, where somebody else knows them better, as a BSP tree does |

mod error;
mod graph;
mod locate;
mod shapes;
mod tree;
mod ways;

pub use error::{CellError, PieceProblem, PortalProblem};
pub use graph::{CellGraph, Mirror, Portal};
pub use locate::CellLocator;
pub use shapes::{CellPiece, CellShapes};
