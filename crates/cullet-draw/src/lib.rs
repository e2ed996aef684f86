//! The reference renderer.
#![forbid(unsafe_code)]
