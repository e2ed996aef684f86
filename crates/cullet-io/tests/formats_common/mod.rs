//! What the tests of this crate share.
#![allow(dead_code, reason = "each test binary uses its own part of this")]

use cullet_io::{LoadOptions, Model, load_bytes};

/// A model from memory that must load.
pub(crate) fn of(name: &str, bytes: &[u8]) -> Model {
    load_bytes(name, bytes, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}
