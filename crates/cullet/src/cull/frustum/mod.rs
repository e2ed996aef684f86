//! Frustum culling: boxes and spheres against the planes of a view.
//!
//! [`single`] answers for one thing and holds the `_ref` oracles, [`batch`] answers for many with SIMD,
//! [`compare`] says which bound suits a scene,
//! [`tree`] asks whole groups first, [`exact`] drops big boxes that the plane test keeps by mistake.

pub mod batch;
pub mod compare;
pub mod exact;
pub mod single;
pub mod tree;
