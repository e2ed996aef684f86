//! Expected results, by slow and plain means that share nothing with the engine's.

pub mod alone;
pub mod clip;
pub mod exact;
pub mod frustum;
pub mod shadow;
pub mod sight;
pub mod triangles;
pub mod visible;
