//! The tests of the tiles in one program: by itself each file would have all that it uses compiled and linked anew.

mod folder;
mod occluders;
mod sight;
mod stand_ins;
mod world;
