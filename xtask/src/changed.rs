//! Steps of CI that need not run again: nothing that they depend on has changed since they passed.
//! The commit at which each passed is kept in the cache.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use crate::runner::{End, Ended, Step};
use crate::tools::{cache, cargo_program, is_set, output};

/// Dependencies of a step: packages, with all that they are built from, and files beside them, by
/// how their paths begin or, after `*`, end.
struct Inputs {
    step: &'static str,
    packages: &'static [&'static str],
    files: &'static [&'static str],
}

const INPUTS: &[Inputs] = &[
    Inputs { step: "licences", packages: &[], files: &["deny.toml", "*Cargo.toml"] },
    Inputs { step: "packages", packages: &[], files: &["*.toml", "*.json", "*.md", "*/build.rs"] },
    Inputs { step: "oldest", packages: &["cullet"], files: &[] },
    Inputs { step: "readers", packages: &["cullet-baker"], files: &[] },
    Inputs { step: "web", packages: &["cullet-viewer"], files: &["docs/"] },
    Inputs { step: "published", packages: &["cullet-viewer"], files: &["docs/", "README.md"] },
    Inputs { step: "lists", packages: &["cullet-viewer", "cullet-gpu"], files: &[] },
    Inputs { step: "host-c", packages: &["cullet-c", "cullet-baker"], files: &[] },
    Inputs {
        step: "host-csharp",
        packages: &["cullet-c", "cullet-baker"],
        files: &["bindings/csharp/", "docs/src/csharp.md"],
    },
    Inputs {
        step: "host-python",
        packages: &["cullet-python", "cullet-baker", "cullet-lab"],
        files: &[],
    },
    Inputs { step: "host-web", packages: &["cullet-web", "cullet-baker"], files: &[] },
    Inputs {
        step: "host-bevy",
        packages: &["cullet-io", "cullet-baker"],
        files: &["bindings/bevy/"],
    },
    Inputs { step: "host-godot", packages: &["cullet-bake"], files: &["bindings/godot/"] },
    Inputs { step: "platforms", packages: &["cullet-lab", "cullet-c"], files: &[] },
];

/// Files that all steps depend on.
const COMMON: &[&str] = &["xtask/", ".ci/", ".cargo/", "Cargo.toml", "Cargo.lock"];

/// Whether a step of a name need not run.
pub(crate) fn is_kept(name: &str) -> bool {
    kept_since(name).is_some()
}

/// The commit at which a step passed, if nothing that it depends on has changed since.
fn kept_since(name: &str) -> Option<String> {
    let inputs = INPUTS.iter().find(|inputs| inputs.step == name)?;
    let record = fs::read_to_string(passed(name)).unwrap_or_default();
    // Another compiler may find what this one did not.
    let since = record.strip_suffix(&compiler()).unwrap_or_default().trim();
    let is_kept = !is_set("CULLET_ALL", "1") && is_unchanged(inputs, since);
    is_kept.then(|| since.to_owned())
}

fn compiler() -> String {
    output("rustc", &["--version"]).unwrap_or_default()
}

/// Runs a step, unless nothing has changed; remembers where it passed.
pub(crate) fn run(step: &Step) -> Ended {
    if !INPUTS.iter().any(|inputs| inputs.step == step.name) {
        return (step.run)();
    }
    if let Some(since) = kept_since(step.name) {
        return Ok(End::Unchanged(since.chars().take(8).collect()));
    }
    let file = passed(step.name);
    let ended = (step.run)();
    // Whoever changes the checkout meanwhile is on his own: CI's clone is nobody else's.
    match (&ended, output("git", &["rev-parse", "HEAD"])) {
        (Ok(End::Passed), Some(commit)) => {
            let folder = file.parent().unwrap_or(&file);
            fs::create_dir_all(folder)
                .and_then(|()| fs::write(&file, commit + &compiler()))
                .map_err(|e| format!("{}: {e}", file.display()))?;
        }
        // What fails at this commit is tried again at the next, whatever that changes.
        _ => {
            let _ = fs::remove_file(&file);
        }
    }
    ended
}

/// Where it is kept at which commit a step passed.
fn passed(step: &str) -> PathBuf {
    cache().join("passed").join(step)
}

/// Whether git and cargo can say that a commit had the same inputs.
fn is_unchanged(inputs: &Inputs, since: &str) -> bool {
    if since.is_empty() {
        return false;
    }
    let Some(changed) = output("git", &["diff", "--name-only", "--no-renames", since, "HEAD"])
    else {
        return false;
    };
    let words = ["metadata", "--no-deps", "--offline", "--format-version", "1"];
    let metadata = output(&cargo_program(), &words);
    let metadata = metadata.and_then(|text| serde_json::from_str(&text).ok());
    let folders = metadata.map(|metadata| folders(&metadata, inputs.packages));
    folders.is_some_and(|folders| !changed.lines().any(|file| is_input(file, inputs, &folders)))
}

fn is_input(file: &str, inputs: &Inputs, folders: &BTreeSet<String>) -> bool {
    let fits = |pattern: &&str| match pattern.strip_prefix('*') {
        Some(end) => file.ends_with(end),
        None => file.starts_with(pattern),
    };
    COMMON.iter().chain(inputs.files).any(fits) || folders.iter().any(|f| file.starts_with(f))
}

/// The folders of packages of the workspace and of those that they depend on, from its root and
/// ending with `/`.
fn folders(metadata: &serde_json::Value, packages: &[&str]) -> BTreeSet<String> {
    let root = metadata["workspace_root"].as_str().unwrap_or_default();
    let inside = |path: &str| Some(format!("{}/", path.strip_prefix(root)?.strip_prefix('/')?));
    let all = metadata["packages"].as_array().map_or(&[][..], Vec::as_slice);
    let folder = |package: &serde_json::Value| {
        inside(package["manifest_path"].as_str()?.strip_suffix("/Cargo.toml")?)
    };
    let is_named = |p: &&serde_json::Value| packages.iter().any(|name| p["name"] == *name);
    let mut queue: Vec<String> = all.iter().filter(is_named).filter_map(folder).collect();
    let mut found = BTreeSet::new();
    while let Some(next) = queue.pop() {
        if let Some(package) = all.iter().find(|p| folder(p).as_ref() == Some(&next)) {
            let needed = package["dependencies"].as_array().into_iter().flatten();
            queue.extend(needed.filter_map(|d| inside(d["path"].as_str()?)));
            queue.retain(|folder| !found.contains(folder));
        }
        found.insert(next);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metadata() -> serde_json::Value {
        let package = |name: &str, needs: &[&str]| {
            let needs: Vec<_> = needs
                .iter()
                .map(|n| serde_json::json!({"path": format!("/r/crates/{n}")}))
                .collect();
            serde_json::json!({"name": name, "manifest_path": format!("/r/crates/{name}/Cargo.toml"), "dependencies": needs})
        };
        let packages = [
            package("a", &["b"]),
            package("b", &["c"]),
            package("c", &["b"]),
            package("d", &["a"]),
        ];
        serde_json::json!({"workspace_root": "/r", "packages": packages})
    }

    #[test]
    fn a_package_changes_with_what_it_is_built_from_and_not_with_what_is_built_from_it() {
        let found: Vec<String> = folders(&metadata(), &["a"]).into_iter().collect();
        assert_eq!(found, ["crates/a/", "crates/b/", "crates/c/"]);
        assert_eq!(folders(&metadata(), &["c"]).len(), 2);
    }

    #[test]
    fn a_step_depends_on_its_folders_its_files_and_what_all_depend_on() {
        let inputs = Inputs { step: "x", packages: &["a"], files: &["docs/", "*.json"] };
        let folders = folders(&metadata(), inputs.packages);
        for (file, expected) in [
            ("crates/b/src/lib.rs", true),
            ("crates/d/src/lib.rs", false),
            ("crates/ab/src/lib.rs", false),
            ("docs/src/web.md", true),
            ("crates/d/package.json", true),
            ("README.md", false),
            ("Cargo.lock", true),
            ("xtask/src/main.rs", true),
        ] {
            assert_eq!(is_input(file, &inputs, &folders), expected, "{file}");
        }
    }

    #[test]
    fn a_step_without_a_record_runs() {
        assert!(!is_unchanged(&INPUTS[0], ""));
        assert!(!is_unchanged(&INPUTS[0], "0123456789012345678901234567890123456789"));
    }

    #[test]
    fn packages_of_the_list_are_there() {
        let words = ["metadata", "--no-deps", "--offline", "--format-version", "1"];
        let metadata = output(&cargo_program(), &words).expect("cargo metadata");
        let metadata = serde_json::from_str(&metadata).expect("JSON");
        for name in INPUTS.iter().flat_map(|inputs| inputs.packages) {
            assert!(!folders(&metadata, &[name]).is_empty(), "{name}");
        }
    }
}
