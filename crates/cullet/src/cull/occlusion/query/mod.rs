//! Queries: boxes tested against a buffer that is done.

mod batch;
mod nearest;
mod projector;
mod visibility;

pub(crate) use batch::BoxTests;
pub(crate) use nearest::Nearest;
pub(crate) use projector::BoxProjector;
pub use visibility::Visibility;
