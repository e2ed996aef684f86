//! Programs of other machines: built for them, and run by what emulates them.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::targets::Target;
use crate::compiler::Compiler;
use crate::cross;
use crate::tools::{apart, command, output};

/// Built light: most of it runs once, some of it emulated.
const PROFILE: &str = "light";

/// Folder of all builds.
pub(super) fn folder() -> PathBuf {
    apart("platforms")
}

/// A program of a target, and what runs it.
pub(super) struct Built<'a> {
    pub(super) target: &'a Target,
    pub(super) program: PathBuf,
}

impl Built<'_> {
    pub(super) fn command(&self, args: &[&str]) -> Command {
        let mut command = command(self.target.runner[0], &self.target.runner[1..]);
        command.arg(&self.program).args(args).envs(self.target.environment.iter().copied());
        if self.target.runner == ["wine"] {
            command.env("WINEPATH", wine_path(self.target));
        }
        command
    }
}

/// A command of cargo for a target, by the compiler that was found to be there.
pub(super) fn cargo(target: &Target, args: &[&str]) -> Command {
    let compiler = Compiler::installed(target.triple).unwrap_or(Compiler::Rustup);
    let mut cargo = compiler.cargo(args, target.triple, &folder());
    cargo.args(["--profile", PROFILE]).envs(target.environment.iter().copied());
    cargo
}

/// Where cargo leaves what it builds for a target.
pub(super) fn built(target: &Target, file: &str) -> PathBuf {
    folder().join(target.triple).join(PROFILE).join(file)
}

/// Where programs find libraries: that of seeds, the C library, and those of the compiler.
fn wine_path(target: &Target) -> String {
    let mut folders = vec![cross::wine_seeds(), built(target, "")];
    for library in ["libgcc_s_seh-1.dll", "libwinpthread-1.dll"] {
        let found = output(cross::WINDOWS.compiler, &[&format!("-print-file-name={library}")]);
        let file = found.map(|file| PathBuf::from(file.trim()));
        folders.extend(file.and_then(|file| Some(file.parent()?.to_owned())));
    }
    cross::wine_path(&folders)
}

pub(super) fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}
