//! The tests of this crate in one program.

mod masks;
mod models;
mod topology;
