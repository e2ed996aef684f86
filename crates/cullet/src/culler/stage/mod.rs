//! The stages: each a function from the frame, its own cache and a set to a row of the funnel, with
//! what it says of one instance beside it.

pub(super) mod backface;
mod bands;
pub(super) mod candidates;
pub(super) mod degenerate;
mod density;
pub(super) mod detail;
pub(super) mod frustum;
mod hidden;
pub(super) mod layer;
pub(super) mod lod;
mod occluders;
pub(super) mod occlusion;
mod samples;
mod stake;
mod stand_ins;
