//! Counts over the instances, triangles and pixels of a view, for reports on what it draws for
//! nothing.

mod backfaces;
mod bounds;
mod pixels;
mod twins;

pub use backfaces::{BackfaceCounts, BackfaceTest, facing_away};
pub use bounds::{BoundsCounts, BoundsTest};
pub use pixels::{PixelCounts, pixels_of_meshes};
pub use twins::twins;
