//! Diagrams that teach back-face culling and clipping, drawn from what the library computes.

mod circle;
mod clip;
mod clip_w;
mod coverage;
mod masks;
mod regions;
mod sheet;
mod surface;
mod volume;

pub use circle::{conservative_set, normal_partition};
pub use clip::{clip_polygon, outcodes};
pub use clip_w::{clip_w, pipeline, pipeline_costs};
pub use coverage::coverage;
pub use masks::normal_mask;
pub use regions::back_regions;
pub(super) use surface::{COLORS, caption};
pub use surface::{clusters, cones};
pub use volume::{VolumeFigure, culling_volume};

/// Green, as the lectures show it: what faces away.
pub(super) const BACK: [u8; 3] = [0x00, 0x9E, 0x73];
/// What does not face away for sure.
pub(super) const KEPT: [u8; 3] = [0xE8, 0xE4, 0xDA];
/// The eye and its lines of sight.
pub(super) const SIGHT: [u8; 3] = [0xD5, 0x5E, 0x00];
/// What is shown in comparison.
pub(super) const OTHER: [u8; 3] = [0x00, 0x72, 0xB2];
/// What is there and lost: exact, but not in the conservative answer.
pub(super) const LOST: [u8; 3] = [0xE6, 0x9F, 0x00];
