//! The tests of the bakes in one program: by itself each file would have all that it uses compiled and linked anew.

mod clusters;
mod hierarchy;
mod joint;
mod level_chain;
mod level_distances;
mod merged;
mod occluders;
mod pvs;
mod rooms;
mod sampled;
mod stand_in;
