//! Cells and portals: what a walk reaches against rays, what the stage drops, and sets of cells.

mod sets;
mod shapes;
mod stage;
mod walk;
