//! The tests of the readers in one program: by itself each file would have all that it uses compiled and linked anew.
//! Those that count what is allocated stand apart, each alone in its process.

mod baked_file;
mod by_hand;
mod deform;
mod details;
mod formats;
mod glb;
mod gltf_baked;
mod gltf_broken;
mod gltf_cells;
mod gltf_impostor;
mod gltf_models;
mod gltf_original;
mod gltf_reports;
mod gltf_stand_ins;
mod gltf_world;
mod pose;
mod save;
mod save_far;
mod schema;
