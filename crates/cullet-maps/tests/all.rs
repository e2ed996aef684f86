//! The tests of maps and tiles in one program: by itself each file would have all that it uses compiled and linked anew.
//! The one that counts what is allocated stands apart, alone in its process.

mod bsp_maps;
mod bsp_seeds;
mod bsp_small;
mod bsp_verify;
mod occscn;
mod occscn_make;
mod prt;
mod recording;
mod tileset;
mod tileset_forms;
mod tileset_globe;
