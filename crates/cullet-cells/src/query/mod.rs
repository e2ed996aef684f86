//! Queries of a scene that games and tools make, and no frame: line of sight, volume to volume,
//! lights, regions of eyes and motions.
//!
//! They stand beside the [`Culler`](cullet::Culler) and read a [`Scene`](cullet::Scene) alone, so
//! that any thread may query. Each says which way it may err; none claims that something is hidden
//! unless that is proved.
//!
//! | query | answer |
//! |---|---|
//! | [`line_of_sight`], [`lines_of_sight`] | whether something opaque stands between two points, which triangle, and where: exact |
//! | [`box_to_box`] | whether all of a box is hidden from all of another: proved, or not |
//! | [`cull_lights`] | which lights can change a picture, why the others cannot, and which casters matter for those |
//! | [`RegionCuller`] | what may be seen from anywhere in a box of eyes |
//! | [`MotionQuery`] | what will be needed along a way, and how far along it |

mod body;
mod lights;
mod linear;
mod motion;
mod region;
mod segment;
mod sight;
mod triangle;
mod volume;

pub use lights::{
    LightAnswer, LightOptions, LightReason, LightRow, cull_light_casters, cull_lights,
};
pub use motion::{Motion, MotionQuery, Needed};
pub use region::{EyeBox, RegionCuller, RegionError, RegionState, RegionVisible, RegionWork};
pub use sight::{
    Blocker, BlockingSides, Find, Segment, Sight, SightOptions, line_of_sight, lines_of_sight,
};
pub use volume::{BoxSight, HiddenBy, VolumeOptions, box_to_box};
