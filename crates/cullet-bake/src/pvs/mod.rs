//! Potentially visible sets of cells joined by portals.

mod bake;
mod flood;
mod flow;
mod lines;
mod openings;
mod polygon;
mod rows;
mod threads;

pub use bake::{Pvs, Settings, bake};
pub use rows::BitRows;
