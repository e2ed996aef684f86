//! Five baked files and what the engine answers on them: what every host is held against.

use std::path::PathBuf;

use crate::checked;
use crate::runner::{End, Ended, Skip, all};
use crate::tools::{Done, command, cpp_compiler, install_words, run, target};

/// The files, and the scenes that they are baked from.
const SCENES: &[(&str, &str)] = &[
    ("city", "city:cells=8,objects=300"),
    ("office", "office:rooms=3,corridors=1,floors=1"),
    ("forest", "forest:n=600"),
    ("solids", "solids:n=48"),
    ("knobs", "knobs:n=12"),
];

/// Where the files and the answers are: what hosts' tests find as `CULLET_GOLDEN`.
pub(crate) fn folder() -> PathBuf {
    target().join("golden")
}

/// Bakes the files, writes the answers, and holds them against those that are kept.
pub(crate) fn test() -> Ended {
    if cpp_compiler().is_err() {
        let what = "the same baked files in every host";
        return Ok(End::Skipped(Skip::new(what, install_words(&["g++"]))));
    }
    all(make())
}

fn make() -> Done {
    let folder = folder();
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let (baker, golden) = (checked::program("cullet-baker")?, checked::program("cullet-golden")?);
    for (name, scene) in SCENES {
        let file = folder.join(name).with_extension("glb");
        let words = ["bake", scene, "--occluders", "-o", &file.to_string_lossy()];
        run(command(&baker.to_string_lossy(), &words))?;
    }
    run(command(&golden.to_string_lossy(), &[&folder.to_string_lossy()]))
}
