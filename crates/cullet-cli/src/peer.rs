//! Programs of their own that commands start: the viewer, the server. They are apart so that building this
//! one stays quick.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

use cullet_command::exit::{Exit, Failure, Outcome};

/// A program beside this one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer {
    /// Its name, which is its package's too, without the ending that some systems give programs.
    pub(crate) name: &'static str,
    /// Its name, for people.
    pub(crate) what: &'static str,
    /// A value of it, as an example.
    pub(crate) example: &'static str,
}

impl Peer {
    /// Starts it and ends when it does.
    pub(crate) fn run(&self, args: &[OsString]) -> Outcome {
        let beside = std::env::current_exe().ok();
        let folders = std::env::var_os("PATH").unwrap_or_default();
        let program = self.find(beside.as_deref(), &folders).ok_or_else(|| self.missing())?;
        let ended = Command::new(&program).args(args).status().map_err(|e| {
            let (what, program) = (self.what, program.display());
            Failure::input(format!("{program}: {what} cannot be started: {e}"))
        })?;
        // It has said why on its own.
        Ok(match ended.code() {
            Some(0) => Exit::Fine,
            Some(2) => Exit::Usage,
            None => Exit::Interrupted,
            Some(_) => Exit::Input,
        })
    }

    fn missing(&self) -> Failure {
        let Self { name, what, example } = self;
        Failure::input(format!(
            "{what} '{name}' is neither beside this program nor in PATH. Build it in the folder of the \
             source:\n  cargo build --release -p {name}\nor let cargo start it:\n  cargo run --release -p \
             {name} -- {example}"
        ))
    }

    /// The one beside the program `beside`, or in one of the `folders` of a PATH.
    fn find(&self, beside: Option<&Path>, folders: &OsStr) -> Option<PathBuf> {
        let name = format!("{}{}", self.name, std::env::consts::EXE_SUFFIX);
        let own = beside.and_then(Path::parent).map(Path::to_owned);
        own.into_iter()
            .chain(std::env::split_paths(folders))
            .map(|folder| folder.join(&name))
            .find(|path| path.is_file())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PEER: Peer = Peer { name: "cullet-peer", what: "the peer", example: "city" };

    #[test]
    fn the_peer_beside_goes_before_that_in_the_path() {
        let root = std::env::temp_dir().join(format!("cullet-peer-{}", std::process::id()));
        let (own, other) = (root.join("own"), root.join("other"));
        let name = format!("{}{}", PEER.name, std::env::consts::EXE_SUFFIX);
        for folder in [&own, &other] {
            std::fs::create_dir_all(folder).unwrap();
        }
        let path = other.as_os_str();
        let program = own.join("cullet");
        assert_eq!(PEER.find(Some(&program), path), None);
        std::fs::write(other.join(&name), "").unwrap();
        assert_eq!(PEER.find(Some(&program), path), Some(other.join(&name)));
        std::fs::write(own.join(&name), "").unwrap();
        assert_eq!(PEER.find(Some(&program), path), Some(own.join(&name)));
        assert_eq!(PEER.find(None, OsStr::new("")), None);
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn a_missing_peer_is_told_with_what_to_do() {
        let told = PEER.missing();
        assert_eq!(told.exit, Exit::Input);
        assert!(told.message.contains("cargo build --release -p cullet-peer"));
    }
}
