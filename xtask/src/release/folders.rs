//! Folders of a rehearsal: what would be uploaded, and the empty projects that use it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::tools::{Done, output, run, target};

/// Folder of what would be uploaded.
pub(super) fn artefacts() -> PathBuf {
    target().join("release-artefacts")
}

/// Folder of the empty projects that use it: outside of the checkout, whose settings cargo would find.
pub(super) fn work() -> PathBuf {
    std::env::temp_dir().join("cullet-release-rehearsal")
}

pub(super) fn at(path: &Path, error: std::io::Error) -> String {
    format!("{}: {error}", path.display())
}

pub(super) fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Makes an empty folder to use an artefact in.
pub(super) fn empty(name: &str) -> Result<PathBuf, String> {
    let folder = work().join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|e| at(&folder, e))?;
    Ok(folder)
}

/// Runs a program in a folder, with nothing from this checkout in its environment.
pub(super) fn run_in(folder: &Path, program: &Path, words: &[&str]) -> Done {
    let mut command = Command::new(program);
    command.args(words).current_dir(folder).env_remove("CARGO_TARGET_DIR");
    run(command)
}

/// Returns the first block of code of a README in a language.
pub(super) fn first_example(readme: &Path, language: &str) -> Result<String, String> {
    let text = fs::read_to_string(readme).map_err(|e| at(readme, e))?;
    let block = text.split(&format!("```{language}\n")).nth(1).and_then(|b| b.split("```").next());
    let none = || format!("{} has no example in {language}", readme.display());
    block.map(str::to_owned).ok_or_else(none)
}

/// Packs a folder of `parent` among the artefacts, as a `.zip` for Windows and else as a `.tar.gz`, and
/// unpacks that into an empty folder; returns the folder there.
pub(super) fn pack(parent: &Path, name: &str) -> Result<PathBuf, String> {
    let place = empty(&format!("unpacked-{name}"))?;
    if name.contains("windows") {
        let archive = text(&artefacts().join(format!("{name}.zip")));
        let _ = fs::remove_file(&archive);
        run_in(parent, Path::new("zip"), &["-q", "-X", "-9", "-r", &archive, name])?;
        run_in(&place, Path::new("unzip"), &["-q", &archive])?;
    } else {
        let archive = text(&artefacts().join(format!("{name}.tar.gz")));
        // Owned by nobody in particular, in a stable order.
        let words = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "-czf"];
        run_in(parent, Path::new("tar"), &[&words[..], &[&archive, name]].concat())?;
        run_in(&place, Path::new("tar"), &["-xzf", &archive])?;
    }
    Ok(place.join(name))
}

/// Returns the machine that this compiler builds for, as archives are named.
pub(super) fn machine() -> Result<String, String> {
    let said = output("rustc", &["-vV"]).ok_or("rustc cannot be run")?;
    let host = said.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "rustc -vV names no host".into())
}

#[cfg(test)]
mod tests {
    use super::first_example;
    use crate::tools::root;

    #[test]
    fn the_readme_of_each_artefact_has_a_first_example() {
        for (readme, language) in [
            ("crates/cullet/README.md", "rust"),
            ("bindings/c/README.md", "c"),
            ("bindings/python/README.md", "python"),
            ("bindings/web/README.md", "js"),
        ] {
            let readme = root().join(readme);
            assert!(first_example(&readme, language).unwrap().lines().count() > 4, "{readme:?}");
        }
        assert!(
            first_example(&root().join("README.md"), "cobol").unwrap_err().contains("no example")
        );
    }
}
