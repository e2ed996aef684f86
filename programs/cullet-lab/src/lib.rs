//! Measurements and teaching for `cullet`: benches, figures of published work measured again,
//! lectures compared with the engine, pictures that teach, and [other methods](methods) of the
//! literature.
//!
//! Not published. `cullet` starts the program for the commands that it has.
#![forbid(unsafe_code)]

#[cfg(feature = "program")]
mod animation;
#[cfg(feature = "program")]
pub mod args;
#[cfg(feature = "program")]
pub mod bench;
#[cfg(feature = "program")]
pub mod calibrate;
#[cfg(feature = "program")]
mod check_occlusion;
#[cfg(feature = "program")]
pub mod claims;
#[cfg(feature = "program")]
mod compare_occluders;
#[cfg(feature = "program")]
mod fetch;
#[cfg(feature = "program")]
mod film;
#[cfg(feature = "program")]
mod fly;
#[cfg(feature = "program")]
pub mod joint;
#[cfg(feature = "program")]
pub mod lecture;
pub mod methods;
#[cfg(feature = "program")]
pub mod occscn;
#[cfg(feature = "program")]
mod occscn_command;
#[cfg(feature = "program")]
mod picture;
#[cfg(feature = "program")]
pub mod quiz;
#[cfg(feature = "program")]
mod replay;
#[cfg(feature = "program")]
pub mod reproduce;
#[cfg(feature = "program")]
pub mod shapes;
#[cfg(feature = "program")]
mod stopwatch;
#[cfg(feature = "program")]
pub mod teach;

#[cfg(feature = "program")]
pub use args::Command;
