//! Bounding volumes: plain old data, fitted to points so that containment holds under rounding.

mod aabb;
mod batch;
mod convert;
mod plane;
mod sphere;

pub use aabb::Aabb;
pub(crate) use aabb::{round_down, round_up};
pub(crate) use batch::LANES;

pub use batch::{Batch, Block, BoxBlock, Boxes, SphereBlock, Spheres};
pub use plane::{Plane, Side};
pub use sphere::Sphere;

pub(crate) use plane::{ROUNDING, dot2, meet_homogeneous, unit};
