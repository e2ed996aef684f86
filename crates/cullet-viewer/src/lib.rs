//! The viewer: what is culled, and why, in a window and in a browser.
#![forbid(unsafe_code)]

pub mod draw;
