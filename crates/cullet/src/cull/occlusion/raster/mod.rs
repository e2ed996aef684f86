//! Rasterising: the buffer of tiles, and drawing into it what lies on the screen.
//!
//! Each file names those before it alone:
//!
//! ```text
//! steps, row ─► screen, bounds, plane ─► blocks, span ─┬─► outline, clip ────────┬─► canvas ─► buffer
//!                                                      └─► connected ─► surface ─┘
//! ```
//!
//! An *outline* is convex, and fills the pixels that lie wholly within all its edges. A *surface*
//! is triangles that share edges: pixels that several of them cover together are covered too.

mod blocks;
mod bounds;
mod buffer;
mod canvas;
mod clip;
mod connected;
mod outline;
mod plane;
mod row;
mod screen;
mod span;
mod steps;
mod surface;

pub(crate) use blocks::BLOCK;
pub use blocks::TILE;
pub(crate) use bounds::Rectangles;
pub use bounds::ScreenBounds;
pub use buffer::OcclusionBuffer;
pub(crate) use canvas::Canvas;
pub(crate) use clip::clip_near;
#[cfg(feature = "serde")]
pub(crate) use connected::corners_of;
pub(crate) use connected::{Connected, LANES as FACETS, MOST_VERTICES, NEVER};
pub(crate) use outline::Edges;
pub(crate) use plane::Plane;
pub(crate) use row::{Row, meet};
pub(crate) use screen::{Clip, Doubt, ObjectScreen, Screen, Spot, reach};
