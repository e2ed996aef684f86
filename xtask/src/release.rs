//! Checks for a release: packages that can be made, versions in step, the oldest compiler that is
//! promised, and changes of the public interface since a version.

mod folders;
mod libraries;
mod rehearsal;

use std::fs;
use std::path::Path;

use crate::runner::{End, Ended, Skip, all};
use crate::tools::{Done, apart, cargo, cargo_install_words, command, is_ci, output, root, run};

pub(crate) use rehearsal::rehearse;

/// The crates that are published, as options for cargo: all libraries and programs whose manifest
/// does not say otherwise.
pub(crate) fn published() -> Result<Vec<String>, String> {
    let mut names = Vec::new();
    for folder in ["crates", "programs"].map(|folder| root().join(folder)) {
        let crates = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        for entry in crates.flatten() {
            let manifest = fs::read_to_string(entry.path().join("Cargo.toml")).unwrap_or_default();
            let name = manifest.lines().find_map(|line| line.strip_prefix("name = "));
            if let Some(name) = name.filter(|_| !manifest.contains("\npublish = false\n")) {
                names.push(name.trim_matches('"').to_owned());
            }
        }
    }
    names.sort();
    Ok(names.into_iter().flat_map(|name| ["--package".to_owned(), name]).collect())
}

/// Every published crate can be packaged. They are not built from their packages: that would be all
/// of the workspace once more, and what a crate needs beside it is held by `features`.
pub(crate) fn packages() -> Ended {
    versions_in_step()?;
    let published = published()?;
    let mut words = vec!["package", "--quiet", "--no-verify", "--allow-dirty"];
    words.extend(published.iter().map(String::as_str));
    all(cargo(&words))
}

/// The bindings have the engine's version: who reads that of a package knows what it answers like.
fn versions_in_step() -> Done {
    let read =
        |path: &Path| fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()));
    let ours = current_version()?;
    let folder = root().join("bindings");
    let bindings = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for entry in bindings.flatten() {
        for manifest in ["Cargo.toml", "package.json", "pyproject.toml"] {
            let path = entry.path().join(manifest);
            if !path.exists() {
                continue;
            }
            match version(&read(&path)?) {
                // Taken from elsewhere: from the workspace, or from the crate.
                None => {}
                Some(version) if version == ours => {}
                Some(other) => {
                    return Err(format!(
                        "{} is version {other}, the engine {ours}",
                        path.display()
                    ));
                }
            }
        }
    }
    Ok(())
}

/// Returns the version of the workspace.
fn current_version() -> Result<String, String> {
    let path = root().join("Cargo.toml");
    let manifest = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    version(&manifest).map(str::to_owned).ok_or_else(|| "Cargo.toml: no version".into())
}

/// The version that a manifest states in a line of its own, in TOML or JSON.
fn version(manifest: &str) -> Option<&str> {
    manifest.lines().map(str::trim).find_map(|line| {
        let rest =
            line.strip_prefix("version = ").or_else(|| line.strip_prefix("\"version\": "))?;
        rest.trim_end_matches(',').strip_prefix('"')?.strip_suffix('"')
    })
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

/// The engine is checked with the oldest compiler. Where that cannot be had, only `lints` holds the
/// promise: clippy knows since when each function of the standard library is there.
pub(crate) fn oldest_compiler() -> Ended {
    let version = oldest()?;
    let is_there = || output("rustup", &["run", &version, "rustc", "--version"]).is_some();
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
    // In a folder of its own: another compiler would build all build scripts and macros anew at
    // each turn.
    check.env("CARGO_TARGET_DIR", apart("oldest")).env_remove("RUSTUP_TOOLCHAIN");
    check.env_remove("CARGO").env_remove("RUSTC");
    all(run(check))
}

/// Lists the changes of the published crates' public interface since a commit or a tag, and whether
/// the version says so.
pub(crate) fn semver(since: &str) -> Done {
    const PACKAGE: &str = "cargo-semver-checks";
    if output(PACKAGE, &["semver-checks", "--version"]).is_none() {
        return Err(format!("needed: {}", cargo_install_words(PACKAGE)));
    }
    let published = published()?;
    let mut words = vec!["semver-checks", "--baseline-rev", since];
    words.extend(published.iter().map(String::as_str));
    cargo(&words)
}

#[cfg(test)]
mod tests {
    use super::version;

    #[test]
    fn a_version_is_found_in_each_kind_of_manifest() {
        assert_eq!(version("[package]\nname = \"a\"\nversion = \"0.2.0\"\n"), Some("0.2.0"));
        assert_eq!(
            version("{\n  \"version\": \"1.0.0\",\n  \"type\": \"module\"\n}"),
            Some("1.0.0")
        );
        assert_eq!(version("version.workspace = true\nfoo = { version = \"3\" }"), None);
    }
}
