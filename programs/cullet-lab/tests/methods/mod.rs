//! The tests of the methods in one program: by itself each file would have all that it uses
//! compiled and linked anew.

mod clusters;
mod data;
mod groups;
mod lost;
mod nodes;
mod patch;
mod planes;
mod refusals;
mod screen;
