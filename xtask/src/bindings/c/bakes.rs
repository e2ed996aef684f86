//! Bakes from C: a build that has them, the same bytes as the crates make, and a library without
//! them that opens what was baked.

use std::fs;
use std::path::Path;

use super::Host;
use crate::tools::{Done, cargo_program, command, run};

pub(super) const FEATURES: &str = "scenes,files,queries,bake";
/// The one that the tests of all packages are built in, so that most of it is there.
pub(super) const BUILT: &str = "release";

/// Bakes files in each way of compiling, and opens them with the library of all other parts.
pub(super) fn test(whole: &Host, sanitised: &[&str]) -> Done {
    let host = Host::install_in("bake", BUILT, &[("CULLET_FEATURES", FEATURES)])?;
    let folder = host.work.join("baked");
    for flags in [&[], sanitised] {
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let files: &[&Path] = &[&folder];
        host.run(&host.compile("gcc", "tests/bake.c", flags)?, files)?;
        whole.run(&whole.compile("gcc", "tests/sets.c", flags)?, files)?;
        host.run(&host.compile("g++", "tests/wrapper_bake.cpp", flags)?, files)?;
    }
    // Seconds, and a seed.
    let flags = [sanitised, &["-DBAKES"]].concat();
    let random = host.compile("gcc", "tests/random/random.c", &flags)?;
    host.run(&random, &["5", "3"].map(Path::new))?;
    let words = ["test", "--profile", BUILT, "-p", "cullet-c", "--features", "bake", "--lib"];
    run(command(&cargo_program(), &words))
}
