//! What the tests of this crate share.
#![allow(dead_code, reason = "each test binary uses its own part of this")]

use std::path::{Path, PathBuf};

use cullet_io::{LoadOptions, Model, load_bytes};

/// The folder of test models: `CULLET_DATA`, or `../shared/data` beside the workspace. Where there is
/// none the test says that it is skipped; with `CULLET_REQUIRE_DATA=1` it fails instead.
pub(crate) fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("CULLET_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    if folder.is_dir() {
        return Some(folder);
    }
    let required = std::env::var_os("CULLET_REQUIRE_DATA").is_some_and(|v| v == "1");
    assert!(!required, "no test data at {}", folder.display());
    println!("skipped: no test data at {}; set CULLET_DATA", folder.display());
    None
}

/// A model from memory that must load.
pub(crate) fn of(name: &str, bytes: &[u8]) -> Model {
    load_bytes(name, bytes, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}
