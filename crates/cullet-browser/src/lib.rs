//! The lists of [`cullet_gpu`], byte for byte the same from the CPU, from a device of this machine and from a browser's.
//!
//! Its scenes and views are made by additions, multiplications, divisions and square roots alone, which are the same on every machine;
//! sines are not. [`answers`] says what the CPU lists of them, and, where there is a device, whether that lists the same. The example
//! `lists` prints the answers of this machine, the function `run` of the module that is compiled for a browser returns those of the
//! browser, and `cargo xtask test lists` compares the two.
//!
//! Devices are opened with what any browser with WebGPU has: eight storage buffers a stage, no optional feature.
#![forbid(unsafe_code)]

mod answers;
mod device;
mod lists;
#[cfg(target_arch = "wasm32")]
mod page;
mod scenes;

pub use answers::{Answer, answers, report};
pub use device::least;
#[cfg(target_arch = "wasm32")]
pub use page::run;
