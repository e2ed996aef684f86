//! Distances between surfaces: what says how far a simplified mesh is from the original, without a
//! look at how it was made.

mod deviation;
mod distance;
mod exact;
mod quantile;
mod samples;

pub use deviation::{Deviation, SHARE_ABOVE, SurfaceSlices, deviation};
pub use distance::SurfaceTree;
pub use exact::{closest_point, nearest_ref};
pub use quantile::LargestDistances;
pub use samples::{SurfacePoint, inner_points, surface_points};
