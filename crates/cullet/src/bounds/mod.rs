//! Bounding volumes: plain old data, fitted to points so that containment holds under rounding.

mod aabb;
mod batch;
mod fit;
mod obb;
mod plane;
mod sphere;

pub use aabb::Aabb;
pub use batch::{Boxes, Spheres};
pub use obb::Obb;
pub use plane::{Plane, Side};
pub use sphere::Sphere;
