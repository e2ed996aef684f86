//! One room for each kind of culling. A room is plain functions over slices, usable with no scene;
//! a small form prepared once per view; and a slow `_ref` twin beside each fast path.

pub mod backface;
pub mod degenerate;
pub mod detail;
pub mod frustum;
pub mod horizon;
pub mod occlusion;
pub(crate) mod output;
pub mod shadow;

pub use output::Indices;
