//! Cells and portals: what a walk reaches against rays, and what the stage drops.

mod shapes;
mod stage;
mod walk;
