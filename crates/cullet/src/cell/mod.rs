//! Cells and the portals between them: what rooms and corridors hide, known without drawing anything.
//!
//! A *cell* is a region of space in which nothing stands between two points: a room, or a part of one. A *portal* is an
//! opening between two cells: a convex polygon. Whoever stands in a cell sees what is in it, and of the others what portals
//! let through.

mod graph;

pub use graph::{CellError, CellGraph, Portal, PortalProblem};
