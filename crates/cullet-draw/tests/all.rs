//! The tests of the renderer in one program: by itself each file would have all that it uses compiled and linked anew.

mod cells;
mod clip_line;
mod clip_polygon;
mod clipped;
mod golden;
mod impostor;
mod occlusion;
mod occlusion_engine;
mod occlusion_verify;
mod outcode;
mod region;
mod render;
mod stereo;
mod surface_distances;
