//! Where the tests of a crate are one program, every file of them is in it: cargo does not look for
//! others there.

use std::fs;
use std::path::Path;

use crate::tools::{Done, root};

/// The program that has the tests of a crate.
const ALL: &str = "tests/all.rs";
/// The package that builds the tests of other crates too.
const TESTKIT: &str = "crates/cullet-testkit/Cargo.toml";

/// Every file of tests of every crate is run.
pub(crate) fn check() -> Done {
    let mut left_out = Vec::new();
    for folder in ["crates", "programs"].map(|folder| root().join(folder)) {
        let crates = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        for folder in crates.flatten().map(|e| e.path()).filter(|p| p.join(ALL).is_file()) {
            left_out.extend(left_out_of(&folder)?);
        }
    }
    left_out.sort();
    if left_out.is_empty() { Ok(()) } else { Err(left_out.join("\n       ")) }
}

/// The files of tests of a crate that neither its program of tests nor its manifest names.
fn left_out_of(folder: &Path) -> Result<Vec<String>, String> {
    let read =
        |path: &Path| fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()));
    let (all, own) = (read(&folder.join(ALL))?, read(&folder.join("Cargo.toml"))?);
    let testkit = read(&root().join(TESTKIT))?;
    let at = folder.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let manifest = own + &programs_at(&testkit, at);
    let tests = folder.join("tests");
    let files = fs::read_dir(&tests).map_err(|e| format!("{}: {e}", tests.display()))?;
    let paths = files.flatten().map(|e| e.path());
    let names = paths.filter_map(|path| {
        let is_source = path.extension().is_some_and(|e| e == "rs");
        let is_folder = path.join("mod.rs").is_file() || path.join("main.rs").is_file();
        (is_source || is_folder).then(|| path.file_stem()?.to_str().map(str::to_owned)).flatten()
    });
    let left_out = names.filter(|name| is_left_out(name, &all, &manifest));
    Ok(left_out
        .map(|name| {
            format!("{}: {name} is in none of {ALL}, Cargo.toml and {TESTKIT}", tests.display())
        })
        .collect())
}

/// The programs of tests in the folder of a crate that the testkit builds, as the crate's own
/// manifest would name them.
fn programs_at(testkit: &str, folder: &str) -> String {
    let begins = format!("path = \"../{folder}/tests/");
    let names = testkit.lines().filter_map(|l| l.strip_prefix(&begins)?.strip_suffix(".rs\""));
    names.map(|name| format!("[[test]]\nname = \"{name}\"\n")).collect()
}

fn is_left_out(name: &str, all: &str, manifest: &str) -> bool {
    let module = format!("mod {name};");
    let apart = [format!("name = \"{name}\""), format!("path = \"tests/{name}.rs\"")];
    let names_it = |rest: &str| apart.iter().any(|line| rest.contains(line));
    let is_program = manifest.split("[[test]]").skip(1).any(names_it);
    !all.lines().any(|line| line == module) && !is_program
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_nothing_names_is_found() {
        let (all, manifest) = (
            "//! All.\n\nmod a;\n",
            "name = \"b\"\n[[test]]\nname = \"c\"\npath = \"tests/d.rs\"\n",
        );
        let found: Vec<&str> =
            ["a", "b", "c", "d"].into_iter().filter(|n| is_left_out(n, all, manifest)).collect();
        assert_eq!(found, ["b"]);
        let testkit = "path = \"../x/tests/b.rs\"\npath = \"../y/tests/a.rs\"\n";
        let manifest = programs_at(testkit, "x");
        assert_eq!(
            [is_left_out("a", "", &manifest), is_left_out("b", "", &manifest)],
            [true, false]
        );
        check().unwrap();
    }
}
