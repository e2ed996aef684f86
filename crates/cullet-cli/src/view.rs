//! `cullet view`: finds the viewer, a program of its own, and starts it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;

use crate::exit::{Exit, Failure, Outcome};

/// The viewer's name, without the ending that some systems give programs.
const VIEWER: &str = "cullet-viewer";

pub(crate) const HELP: &str = "\
The viewer is a program of its own, so that building this one stays quick. It is looked for beside this
program, then in PATH. What follows the scene is handed on: cullet view city --help lists it.

Examples
  cullet view                            the built-in city
  cullet view model.glb
  cullet view city --state 'layout=split&ghosts.form=solid'
  cullet view office --size 960x600 --screenshot office.png";

/// What to view.
#[derive(Clone, Debug, Args)]
pub(crate) struct ViewArgs {
    /// A file or a built-in scene, then options of the viewer
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "SCENE|FILE")]
    rest: Vec<OsString>,
}

/// Runs the command: ends when the viewer does.
pub(crate) fn run(args: &ViewArgs) -> Outcome {
    let beside = std::env::current_exe().ok();
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let viewer = find(beside.as_deref(), &folders).ok_or_else(missing)?;
    let ended = Command::new(&viewer).args(&args.rest).status().map_err(|e| {
        Failure::input(format!("{}: the viewer cannot be started: {e}", viewer.display()))
    })?;
    // The viewer has said why on its own.
    Ok(match ended.code() {
        Some(0) => Exit::Fine,
        Some(2) => Exit::Usage,
        None => Exit::Interrupted,
        Some(_) => Exit::Input,
    })
}

fn missing() -> Failure {
    Failure::input(format!(
        "the viewer '{VIEWER}' is neither beside this program nor in PATH. Build it in the folder of the \
         source:\n  cargo build --release -p {VIEWER}\nor let cargo start it:\n  cargo run --release -p {VIEWER} \
         -- city"
    ))
}

/// The viewer beside the program `beside`, or in one of the `folders` of a PATH.
fn find(beside: Option<&Path>, folders: &std::ffi::OsStr) -> Option<PathBuf> {
    let name = format!("{VIEWER}{}", std::env::consts::EXE_SUFFIX);
    let own = beside.and_then(Path::parent).map(Path::to_owned);
    own.into_iter()
        .chain(std::env::split_paths(folders))
        .map(|folder| folder.join(&name))
        .find(|path| path.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_viewer_beside_goes_before_that_in_the_path() {
        let root = std::env::temp_dir().join(format!("cullet-view-{}", std::process::id()));
        let (own, other) = (root.join("own"), root.join("other"));
        let name = format!("{VIEWER}{}", std::env::consts::EXE_SUFFIX);
        for folder in [&own, &other] {
            std::fs::create_dir_all(folder).unwrap();
        }
        let path = other.as_os_str();
        let program = own.join("cullet");
        assert_eq!(find(Some(&program), path), None);
        std::fs::write(other.join(&name), "").unwrap();
        assert_eq!(find(Some(&program), path), Some(other.join(&name)));
        std::fs::write(own.join(&name), "").unwrap();
        assert_eq!(find(Some(&program), path), Some(own.join(&name)));
        assert_eq!(find(None, std::ffi::OsStr::new("")), None);
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn a_missing_viewer_is_told_with_what_to_do() {
        let told = missing();
        assert_eq!(told.exit, Exit::Input);
        assert!(told.message.contains("cargo build --release -p cullet-viewer"));
    }
}
