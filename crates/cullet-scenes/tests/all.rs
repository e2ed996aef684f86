//! The tests of scenes and paths in one program: by itself each file would have all that it uses compiled and linked anew.
//! The one that counts what is allocated stands apart, alone in its process.

mod office_portals;
mod scenes;
mod scenes_paths;
