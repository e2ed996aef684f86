//! The parts that only a page needs: its start, its state in a form that programs can read, files
//! that go in and out, and scenes that are made in a worker.
//!
//! A page has one thread, which draws. A file is therefore parsed, and a built-in scene made, in a
//! worker, with the same code in a memory of its own, and comes back [packed](crate::packed) into
//! bytes; unpacking is cut into pieces between which the page goes on. The worker unpacks the same
//! bytes and keeps the scene, for it is the one that [decides](crate::decide) what of it is drawn.

#[cfg(target_arch = "wasm32")]
mod files;
#[cfg(target_arch = "wasm32")]
mod load;
#[cfg(target_arch = "wasm32")]
mod mirror;
#[cfg(target_arch = "wasm32")]
mod page;
#[cfg(target_arch = "wasm32")]
mod spoken;
#[cfg(target_arch = "wasm32")]
mod start;
#[cfg(target_arch = "wasm32")]
mod worker;

#[cfg(target_arch = "wasm32")]
pub(crate) use files::{choose, download};
#[cfg(target_arch = "wasm32")]
pub(crate) use load::{load, remake};
#[cfg(target_arch = "wasm32")]
pub(crate) use mirror::Mirror;
#[cfg(target_arch = "wasm32")]
pub(crate) use page::{set_address, tell_lost};
#[cfg(target_arch = "wasm32")]
pub(crate) use spoken::{obey, tell};
#[cfg(target_arch = "wasm32")]
pub(crate) use worker::{Keeper, thrown};
