//! The elliptic cone of a cluster: one small bound for the planes of all its triangles.
//!
//! A cluster is back-facing where the eye is behind the planes of all its triangles: in the
//! intersection of their back half-spaces, a convex region. The cone is a simpler region inside of
//! that one, so that what it culls is proved. Other bounds, and how they compare, are in
//! `cullet-lab`.

mod batch;
mod ellipse;
mod elliptic;
mod eye;
mod fit;

pub use batch::EllipticCones;
pub use elliptic::EllipticCone;
pub use eye::ClusterEye;
pub use fit::{Apex, ClusterPlanes};
