//! Queries: what else hierarchy and occlusion buffer can answer, beside what one view sees.
//!
//! | query | answers |
//! |---|---|
//! | [`RegionCuller`] | what may be seen from anywhere in a box of eyes |
//! | [`MotionQuery`] | what will be needed along a way, and how far along it |

mod motion;
mod region;

pub use motion::{Motion, MotionQuery, Needed};
pub use region::{EyeBox, RegionCuller, RegionError, RegionState, RegionVisible, RegionWork};
