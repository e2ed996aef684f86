//! The extension for Godot: a workspace of its own, for godot-rust wants a newer compiler than the
//! rest and has a licence that nothing else depends on.

use std::path::PathBuf;

use crate::runner::{End, Ended, Skip};
use crate::tools::{apart, cache, command, install_words, is_ci, output, root, run};

/// The oldest compiler that godot-rust builds with.
const OLDEST: [u32; 2] = [1, 94];

/// Builds the extension and runs its tests in Godot, those that draw where there is a screen.
pub(crate) fn test() -> Ended {
    let skip = |what: &str, cure: String| Ok(End::Skipped(Skip::new(what, cure)));
    if !has_compiler() {
        let cure = format!("rustup update, to Rust {}.{} or newer", OLDEST[0], OLDEST[1]);
        return skip("the extension for Godot", cure);
    }
    let manifest = root().join("bindings/godot/Cargo.toml");
    let manifest = manifest.to_string_lossy();
    let target = apart("godot");
    for words in [&["build", "--release"][..], &["test", "--release"]] {
        let mut cargo =
            command("cargo", &[words, &["--locked", "--manifest-path", &manifest]].concat());
        cargo.env("CARGO_TARGET_DIR", &target).env("CARGO_INCREMENTAL", "0");
        run(cargo)?;
    }
    let Some(godot) = godot() else {
        return skip(
            "the extension in Godot: not run",
            "set CULLET_GODOT to a Godot 4.6".to_owned(),
        );
    };
    let library = target.join("release/libcullet_godot.so");
    let work = target.join("project");
    let paths = [&godot, &library, &work].map(|path| path.to_string_lossy().into_owned());
    let script = root().join("bindings/godot/tests/run.sh");
    let mut words: Vec<&str> = paths.iter().map(String::as_str).collect();
    let draws = output("sh", &["-c", "command -v xvfb-run"]).is_some();
    if !draws {
        words.push("headless");
    }
    run(command(&script.to_string_lossy(), &words))?;
    if draws {
        return Ok(End::Passed);
    }
    let cure = install_words(&["xvfb", "xauth"]);
    Ok(End::Partly(vec![Skip::new("Godot's pictures with the extension and without", cure)]))
}

/// Whether the compiler of this workspace is new enough.
fn has_compiler() -> bool {
    let version = output("rustc", &["--version"]).unwrap_or_default();
    let numbers = version.split_whitespace().nth(1).unwrap_or_default();
    let mut numbers = numbers.split('.').filter_map(|n| n.parse::<u32>().ok());
    let found = [numbers.next(), numbers.next()].map(Option::unwrap_or_default);
    found >= OLDEST
}

/// Returns Godot: the one that `CULLET_GODOT` names, or one that was fetched into the cache. CI
/// fetches it where it can.
fn godot() -> Option<PathBuf> {
    let named = std::env::var_os("CULLET_GODOT").filter(|path| !path.is_empty());
    if let Some(named) = named {
        return Some(PathBuf::from(named));
    }
    let folder = cache().join("tools/godot");
    let program = folder.join("godot");
    if !program.is_file() && is_ci() {
        let script = root().join("bindings/godot/tests/get-godot.sh");
        let words = [folder.to_string_lossy().into_owned()];
        if let Err(error) = run(command(&script.to_string_lossy(), &[&words[0]])) {
            println!("Godot could not be fetched: {error}");
        }
    }
    program.is_file().then_some(program)
}
