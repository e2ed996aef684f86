//! Impostors: how a mesh is looked at from all around, how what was seen is drawn in its place, and
//! how far that is from it.
//!
//! Any direction lies among three of the frames. Each says of a point whether it may be of the
//! mesh: not where its texel is not covered, and not before the surface that it saw. A ray hits the
//! first point that none of the three sees past. Parts of the mesh that all of them saw are drawn
//! in their place, also between the frames; what is left is the size of a texel and what none of
//! them saw, and that is measured.

mod capture;
mod cards;
mod measure;
mod rays;
mod sheet;
mod trace;

pub use capture::{ImpostorOptions, capture_impostor};
pub use cards::{ImpostorCards, impostor_cards};
pub use measure::{ImpostorJudge, ImpostorMeasure, make_impostor, measure_impostor};
pub(crate) use rays::Rays;
pub use sheet::{ImpostorPlane, impostor_sheet};
pub(crate) use trace::Tracer;
