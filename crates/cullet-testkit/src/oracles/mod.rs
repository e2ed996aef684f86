//! Expected results, by slow and plain means that share nothing with the engine's.

pub mod alone;
pub mod clip;
pub mod frustum;
pub mod sight;
pub mod visible;
