//! Where the tests of a crate are one program, every file of them is in it: cargo does not look for others there.

use std::fs;
use std::path::Path;

use crate::tools::{Done, root};

/// The program that has the tests of a crate.
const ALL: &str = "tests/all.rs";

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
    let (all, manifest) = (read(&folder.join(ALL))?, read(&folder.join("Cargo.toml"))?);
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
        .map(|name| format!("{}: {name} is in neither {ALL} nor Cargo.toml", tests.display()))
        .collect())
}

fn is_left_out(name: &str, all: &str, manifest: &str) -> bool {
    let (module, apart) = (format!("mod {name};"), format!("name = \"{name}\""));
    let is_program = manifest.split("[[test]]").skip(1).any(|rest| rest.contains(&apart));
    !all.lines().any(|line| line == module) && !is_program
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_nothing_names_is_found() {
        let (all, manifest) = ("//! All.\n\nmod a;\n", "name = \"b\"\n[[test]]\nname = \"c\"\n");
        let found: Vec<&str> =
            ["a", "b", "c"].into_iter().filter(|n| is_left_out(n, all, manifest)).collect();
        assert_eq!(found, ["b"]);
        check().unwrap();
    }
}
