//! The tests of cells and queries in one program: by itself each file would have all that it uses compiled and linked anew.

mod portal;
mod query_lights;
mod query_motion;
mod query_region;
mod query_sight;
mod query_volume;
