//! Frustum culling: boxes and spheres against the planes of a view.
//!
//! [`single`] answers for one thing and holds the `_ref` oracles, [`batch`] answers for many with SIMD,
//! [`compare`] says which bound suits a scene, [`tree`] asks whole nodes first, [`groups`] the groups of a
//! scene graph, [`exact`] drops big boxes that the plane test keeps by mistake.

pub mod batch;
pub mod compare;
pub mod exact;
pub mod groups;
pub mod single;
pub mod tree;
