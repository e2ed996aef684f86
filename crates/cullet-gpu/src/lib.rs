//! Culling as [wgpu] compute passes, with the answers of the engine: the same lists, byte for byte, whichever device makes
//! them.
//!
//! Devices round f32 differently: one that multiplies and adds in one step, as WGSL allows it, gives another answer for one of
//! 25 boxes that lie near a plane. So instances are tested in integers. Their boxes are stored relative to a [`Grid`] for each
//! [block](Blocks) of 256, as steps that fit 16 bits, rounded outward; planes are brought to the grid by the CPU, rounded so that
//! "outside" is only said where it is true. [`visible_ref`] is the same test on the CPU, and what the passes are held against.
//!
//! ```text
//!  Scene ──► Blocks ──upload──► boxes                      once, then what changed
//!              │
//!  View ──► BlockPlanes ─────► blocks in use, their planes  each frame, by the CPU: 1/256 of the tests
//!              │
//!              ▼
//!            test ──► bits ──► counts ──scan──► places ──scatter──► slots, in order ──► arguments of the draws
//! ```
#![forbid(unsafe_code)]

mod blocks;
mod device;
mod error;
mod grid;
mod lists;
mod pass;
mod planes;
mod pyramid;

pub use blocks::{BLOCK, Blocks};
pub use device::Gpu;
pub use error::GpuError;
pub use grid::{Grid, GridBox};
pub use lists::visible_ref;
pub use pass::{InstancePass, Lists};
pub use planes::{BlockPlanes, GridPlane, InUse};
pub use pyramid::{Pyramid, PyramidPass, level_sizes, pyramid_ref};
