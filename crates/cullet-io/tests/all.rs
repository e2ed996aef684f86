//! The tests of the readers in one program: by itself each file would have all that it uses compiled and linked anew.
//! Those that count what is allocated stand apart, each alone in its process.

mod baked_file;
mod bsp_maps;
mod bsp_seeds;
mod bsp_small;
mod bsp_verify;
mod by_hand;
mod deform;
mod details;
mod formats;
mod gltf_baked;
mod gltf_broken;
mod gltf_cells;
mod gltf_impostor;
mod gltf_models;
mod gltf_original;
mod gltf_stand_ins;
mod occscn_make;
mod office_portals;
mod pose;
mod prt;
mod recording;
mod rooms;
mod save;
mod scenes;
mod scenes_paths;
mod schema;
mod tileset;
