//! The tests of the engine in one program: by itself each file would have all that it uses compiled and linked anew.
//! Those that count what is allocated stand apart, each alone in its process.

mod backface;
mod backface_bulk;
mod bounds;
mod bounds_frustum;
mod bounds_only;
mod candidates;
mod culler;
mod culler_backface;
mod culler_occlusion;
mod detail;
mod draws;
mod funnel;
mod hierarchy;
mod horizon;
mod horizon_point;
mod many_meshes;
mod mesh;
mod occlusion;
mod occlusion_adverse;
mod occlusion_jobs;
mod occlusion_metamorphic;
mod occlusion_query;
mod readme;
mod removed_meshes;
mod serde;
mod shadow;
mod shadow_view;
mod sides;
mod simd_levels;
mod standing;
mod stereo;
mod threads;
mod view;
mod view_project;
