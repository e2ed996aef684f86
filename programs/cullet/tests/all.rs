//! The tests of the program in one program: by itself each file would have all that it uses
//! compiled and linked anew. The lectures stand apart: they measure times.

mod advice;
mod cell_sets;
mod check_occlusion;
mod cluster;
mod costs;
mod cut;
mod explain;
mod fetch;
mod film;
mod fly;
mod lecture;
mod levels;
mod occlusion;
mod pictures;
mod program;
mod ran;
mod reproduce_assarsson_moller;
mod reproduce_johannsen_carter;
mod reproduce_zhang_hoff;
mod seen;
mod shares;
mod still_files;
mod truth;
mod verify_units;
mod words;
