//! Systems that libraries are built for on this one: the compiler of C that links for each, and what
//! runs its programs here.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::compiler::Compiler;
use crate::runner::Skip;
use crate::tools::{Done, apart, command, install_words, output, run};

/// A system that is not this one.
pub(crate) struct Cross {
    pub(crate) name: &'static str,
    /// Rust's name for it.
    pub(crate) triple: &'static str,
    /// Compiler of C, which links for Rust too.
    pub(crate) compiler: &'static str,
    pub(crate) strip: &'static str,
    /// Words before a program that run it.
    pub(crate) runner: &'static [&'static str],
    /// Variables for cargo and for programs.
    pub(crate) environment: &'static [(&'static str, &'static str)],
    /// A line of the shell that succeeds where compilers and emulator are there, and the packages of
    /// Debian that have them.
    pub(crate) probe: &'static str,
    pub(crate) packages: &'static [&'static str],
}

pub(crate) const ARM: Cross = Cross {
    name: "64-bit ARM",
    triple: "aarch64-unknown-linux-gnu",
    compiler: "aarch64-linux-gnu-gcc",
    strip: "aarch64-linux-gnu-strip",
    runner: &["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"],
    environment: &[
        ("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", "aarch64-linux-gnu-gcc"),
        ("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER", "qemu-aarch64 -L /usr/aarch64-linux-gnu"),
    ],
    probe: "command -v aarch64-linux-gnu-g++ && command -v qemu-aarch64",
    packages: &["g++-aarch64-linux-gnu", "libc6-dev-arm64-cross", "qemu-user"],
};

pub(crate) const WINDOWS: Cross = Cross {
    name: "64-bit Windows",
    triple: "x86_64-pc-windows-gnu",
    compiler: "x86_64-w64-mingw32-gcc",
    strip: "x86_64-w64-mingw32-strip",
    runner: &["wine"],
    environment: &[
        ("CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER", "x86_64-w64-mingw32-gcc"),
        ("CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUNNER", "wine"),
        ("WINEDEBUG", "-all"),
    ],
    probe: "command -v x86_64-w64-mingw32-gcc && command -v wine",
    packages: &["gcc-mingw-w64-x86-64", "wine", "wine64"],
};

impl Cross {
    /// Returns what is missing to build `what` for it, if anything is.
    pub(crate) fn missing(&self, what: &str) -> Option<Skip> {
        let skip = |cure| Some(Skip::new(format!("{what} for {}", self.name), cure));
        if !matches!(Compiler::installed(self.triple), Some(Compiler::Rustup)) {
            return skip(format!("rustup target add {}", self.triple));
        }
        if output(self.compiler, &["--version"]).is_none() {
            return skip(install_words(self.packages));
        }
        None
    }

    /// Returns what is missing to build `what` and to run it, if anything is.
    pub(crate) fn missing_to_run(&self, what: &str) -> Option<Skip> {
        let has_runner = || output("sh", &["-c", self.probe]).is_some();
        self.missing(what).or_else(|| {
            (!has_runner()).then(|| {
                Skip::new(format!("{what} for {}", self.name), install_words(self.packages))
            })
        })
    }

    /// Returns a command of cargo that builds for it below `folder`.
    pub(crate) fn cargo(&self, args: &[&str], folder: &Path) -> Command {
        let mut cargo = Compiler::Rustup.cargo(args, self.triple, folder);
        cargo.envs(self.environment.iter().copied());
        cargo
    }

    /// Returns a command that runs one of its programs, which finds libraries of Windows in
    /// `libraries`.
    pub(crate) fn command(&self, program: &Path, libraries: &[PathBuf]) -> Command {
        let mut command = command(self.runner[0], &self.runner[1..]);
        command.arg(program).envs(self.environment.iter().copied());
        if self.runner == ["wine"] {
            command.env("WINEPATH", wine_path(libraries));
        }
        command
    }
}

/// Returns folders as the variable `WINEPATH` takes them.
pub(crate) fn wine_path(folders: &[PathBuf]) -> String {
    let names: Vec<_> = folders.iter().map(|path| format!("Z:{}", path.display())).collect();
    names.join(";").replace('/', "\\")
}

/// Wine 8 lacks this library of Windows, from which Rust takes the seeds of its maps.
const SEEDS: &str = "\
#include <windows.h>
#include <ntsecapi.h>
BOOL WINAPI ProcessPrng(PBYTE at, SIZE_T count) { return RtlGenRandom(at, (ULONG)count); }
";

/// Folder of the library of seeds, once [`prepare_wine`] has made it.
pub(crate) fn wine_seeds() -> PathBuf {
    apart("platforms").join("wine")
}

/// Makes the library of seeds.
pub(crate) fn prepare_wine() -> Done {
    let beside = wine_seeds();
    let library = beside.join("bcryptprimitives.dll");
    if library.exists() {
        return Ok(());
    }
    fs::create_dir_all(&beside).map_err(|e| format!("{}: {e}", beside.display()))?;
    let source = beside.join("seeds.c");
    fs::write(&source, SEEDS).map_err(|e| format!("{}: {e}", source.display()))?;
    let mut compile = command(WINDOWS.compiler, &["-shared", "-o"]);
    compile.args([&library, &source]).arg("-ladvapi32");
    run(compile)
}
