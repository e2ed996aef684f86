//! Back-face culling.

mod mask;
mod mask_cull;
mod quantised;

pub use mask::{
    BackfaceMask, MaskError, MaskGrid, MaskUse, NormalMask, NormalMasks, ViewCone,
    corner_directions,
};
pub use mask_cull::{append_unmasked, count_masked, cull_masked, cull_masked_ref};
pub use quantised::{Planes8, Planes16};

pub mod cluster;
