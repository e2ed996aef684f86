//! Checks for a release: packages that can be made, the oldest compiler that is promised, and changes of the
//! public interface since a version.

use std::fs;

use crate::runner::{End, Ended, Skip, all};
use crate::tools::{
    Done, cargo, cargo_install_words, command, is_ci, optional, output, root, run, target,
};

/// The crates that are published, as options for cargo: all below `crates` whose manifest does not say otherwise.
fn published() -> Result<Vec<String>, String> {
    let folder = root().join("crates");
    let crates = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut names = Vec::new();
    for entry in crates.flatten() {
        let manifest = fs::read_to_string(entry.path().join("Cargo.toml")).unwrap_or_default();
        if !manifest.is_empty() && !manifest.lines().any(|line| line == "publish = false") {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names.sort();
    Ok(names.into_iter().flat_map(|name| ["--package".to_owned(), name]).collect())
}

/// Every published crate can be packaged. They are not built from their packages: that would be all of the workspace
/// once more, and what a crate needs beside it is held by `features`.
pub(crate) fn packages() -> Ended {
    let published = published()?;
    let mut words = vec!["package", "--quiet", "--no-verify", "--allow-dirty"];
    words.extend(published.iter().map(String::as_str));
    all(cargo(&words))
}

/// The oldest compiler that the workspace promises, such as `1.89`.
fn oldest() -> Result<String, String> {
    let path = root().join("Cargo.toml");
    let manifest = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let version = manifest.lines().find_map(|line| line.strip_prefix("rust-version = "));
    version
        .map(|v| v.trim_matches('"').to_owned())
        .ok_or_else(|| "Cargo.toml: no rust-version".into())
}

/// The engine is checked with the oldest compiler. Where that cannot be had, only `lints` holds the promise: clippy knows
/// since when each function of the standard library is there.
pub(crate) fn oldest_compiler() -> Ended {
    let version = oldest()?;
    let is_there = || optional("rustup", &["run", &version, "rustc", "--version"]).is_some();
    let install = ["toolchain", "install", &version, "--profile", "minimal"];
    if !is_there() && is_ci() {
        // It ends with an error where there is no network, which is told below.
        output("rustup", &install);
    }
    if !is_there() {
        let what = format!("the engine, compiled with Rust {version}");
        return Ok(End::Skipped(Skip::new(what, format!("rustup {}", install.join(" ")))));
    }
    let check = ["run", &version, "cargo", "check", "--package", "cullet", "--all-features"];
    let mut check = command("rustup", &check);
    // In a folder of its own: another compiler would build all build scripts and macros anew at each turn.
    check.env("CARGO_TARGET_DIR", target().join("oldest")).env_remove("RUSTUP_TOOLCHAIN");
    check.env_remove("CARGO").env_remove("RUSTC");
    all(run(check))
}

/// Lists the changes of the published crates' public interface since a commit or a tag, and whether the version says so.
pub(crate) fn semver(since: &str) -> Done {
    const PACKAGE: &str = "cargo-semver-checks";
    if optional(PACKAGE, &["semver-checks", "--version"]).is_none() {
        return Err(format!("needed: {}", cargo_install_words(PACKAGE)));
    }
    let published = published()?;
    let mut words = vec!["semver-checks", "--baseline-rev", since];
    words.extend(published.iter().map(String::as_str));
    cargo(&words)
}
