//! The tests of the passes in one program: by itself each file would have all that it uses compiled and linked anew.

mod common;
mod gpu_cones;
mod gpu_devices;
mod gpu_frames;
mod gpu_hidden;
mod gpu_levels;
mod gpu_lists;
mod gpu_proof;
mod gpu_pyramid;
mod gpu_samples;
mod gpu_sizes;
mod gpu_triangles;
