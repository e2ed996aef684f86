//! The tests of the topology of meshes in one program.

mod models;
mod topology;
