//! What only a page needs: its start, what it says in a form that programs can read, and files that are
//! parsed in a worker.
//!
//! A page has one thread, which draws. A file is therefore parsed in a worker, with the same code in a
//! memory of its own, and comes back [packed] into bytes; unpacking is cut into pieces between which the
//! page goes on.

mod bytes;
pub mod packed;

#[cfg(target_arch = "wasm32")]
mod load;
#[cfg(target_arch = "wasm32")]
mod page;

#[cfg(target_arch = "wasm32")]
pub(crate) use load::load;
#[cfg(target_arch = "wasm32")]
pub(crate) use page::{set_address, tell};
