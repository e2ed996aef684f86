//! Rasterising: the buffer of tiles, and drawing into it what lies on the screen.
//!
//! Each file names those before it alone:
//!
//! ```text
//! screen, bounds, plane, tile ─► tiles ─┬─► outline ──────────────────────────────────────┬─► band ─► buffer
//!                                       └─► primitives, connected ─► clip, shared_edges ─► surface ─┘
//! ```
//!
//! An *outline* is convex, and fills the pixels that lie wholly within all its edges. A *surface* is triangles that share
//! edges: pixels that several of them cover together are covered too. A *band* is some rows of tiles to draw into.

mod band;
mod bounds;
mod buffer;
mod clip;
mod connected;
mod outline;
mod plane;
mod primitives;
mod screen;
mod shared_edges;
mod surface;
mod tile;
mod tiles;

pub use band::Band;
pub(crate) use bounds::Rectangles;
pub use bounds::ScreenBounds;
pub use buffer::OcclusionBuffer;
pub(crate) use clip::clip_near;
pub(crate) use connected::{Connected, is_whole};
pub(crate) use outline::Edges;
pub(crate) use plane::Plane;
pub(crate) use primitives::LANES as TRIANGLES;
pub(crate) use screen::{Clip, Doubt, ObjectScreen, Screen, Spot, reach};
pub use tile::TILE;
pub(crate) use tiles::Tiles;
