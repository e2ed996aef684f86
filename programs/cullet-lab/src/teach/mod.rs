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

use cullet::Stage;

use cullet_draw::palette::reason_color;

pub use circle::{conservative_set, normal_partition};
pub use clip::{clip_polygon, outcodes};
pub use clip_w::{clip_w, pipeline, pipeline_costs};
pub use coverage::coverage;
pub use masks::normal_mask;
pub use regions::back_regions;
pub use surface::{clusters, cones};
pub use volume::{CullingVolume, VolumeFigure, culling_volume};

/// Back faces, as in every picture.
pub(super) const BACK: [u8; 3] = reason_color(Some(Stage::Backface));
/// Instances and triangles outside, as in every picture.
pub(super) const OUTSIDE: [u8; 3] = reason_color(Some(Stage::Frustum));
/// Colour of what is kept, so dark that it shows on paper.
pub(super) const KEPT: [u8; 3] = [0xE8, 0xE4, 0xDA];
