//! The tests of the bakes in one program: by itself each file would have all that it uses compiled and linked anew.

mod clusters;
mod hierarchy;
mod jobs;
mod joined;
mod level_chain;

mod merged;
mod occluders;
mod pvs;
mod room_volumes;
mod rooms;
mod sampled;
mod sampled_edit;
mod stand_in;
