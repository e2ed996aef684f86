//! Frustum culling: boxes and spheres against the planes of a view.
//!
//! [`batch`] tests one box or many with SIMD, [`tree`] tests whole nodes first, [`exact`] drops big
//! boxes that the plane test keeps by mistake, [`triangles`] tests triangles.

pub mod batch;
pub mod exact;
pub mod tree;
pub mod triangles;
