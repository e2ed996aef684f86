//! Compilers for other machines than this one: rustup's, and where it cannot fetch their standard
//! library, Debian's compiler and the library's source.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::tools::{cargo_program, command, install, install_words, is_ci, output};

/// Debian's compiler, library source and cargo, of one version.
pub(crate) const DEBIAN: &[&str] = &["rustc-web", "cargo-web", "rust-web-src"];

/// Compiler for a target.
pub(crate) enum Compiler {
    /// The one that runs this program.
    Rustup,
    /// Debian's, which compiles the standard library along.
    Debian,
}

impl Compiler {
    /// The one that is there for a target.
    pub(crate) fn installed(target: &str) -> Option<Self> {
        let library = output("rustc", &["--print", "target-libdir", "--target", target]);
        if library.is_some_and(|l| Path::new(l.trim()).is_dir()) {
            return Some(Self::Rustup);
        }
        let sysroot = output("/usr/bin/rustc", &["--print", "sysroot"])?;
        let source = Path::new(sysroot.trim()).join("lib/rustlib/src/rust/library");
        let is_there = source.is_dir() && Path::new("/usr/bin/cargo").is_file();
        is_there.then_some(Self::Debian)
    }

    /// The one for a target, installed where that needs no password.
    pub(crate) fn get(target: &str) -> Result<Self, String> {
        if let Some(compiler) = Self::installed(target) {
            return Ok(compiler);
        }
        if output("rustup", &["target", "add", target]).is_none() {
            install(DEBIAN)?;
        }
        let missing = || format!("there is no compiler for {target}: {}", words(target));
        Self::installed(target).ok_or_else(missing)
    }

    /// The one for a target that is there, or that CI can get; `None` where nobody is to install
    /// anything.
    pub(crate) fn find(target: &str) -> Result<Option<Self>, String> {
        if is_ci() { Self::get(target).map(Some) } else { Ok(Self::installed(target)) }
    }

    /// A command of cargo for a target, in a folder of its own below the target folder: with
    /// another compiler at work in the native one, all build scripts and macros would be built anew
    /// at each turn.
    pub(crate) fn cargo(&self, args: &[&str], target: &str, folder: &Path) -> Command {
        let mut cargo = match self {
            Self::Rustup => command(&cargo_program(), args),
            Self::Debian => {
                println!(
                    "no installed {target}: the standard library is compiled with Debian's rustc-web"
                );
                let mut cargo = command("/usr/bin/cargo", args);
                cargo.env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1");
                cargo.arg("-Zbuild-std=std,panic_abort");
                cargo
            }
        };
        cargo.args(["--target", target]).env("CARGO_TARGET_DIR", folder);
        cargo
    }
}

/// The command that installs a compiler for a target.
pub(crate) fn words(target: &str) -> String {
    format!("rustup target add {target}, or {}", install_words(DEBIAN))
}

/// Debian ships no linker for wasm with its compiler: rustup's, or that of a package `lld-NN`.
pub(crate) fn wasm_linker() -> Result<PathBuf, String> {
    let line = |args: &[&str]| output("rustc", args).unwrap_or_default();
    let version = line(&["-vV"]);
    let host = version.lines().find_map(|l| l.strip_prefix("host: ")).unwrap_or_default();
    let sysroot = line(&["--print", "sysroot"]);
    let own = Path::new(sysroot.trim()).join("lib/rustlib").join(host).join("bin/rust-lld");
    if own.is_file() {
        return Ok(own);
    }
    // The newest: one that is older than the compiler does not read what it writes.
    let mut found: Vec<(u32, PathBuf)> = fs::read_dir("/usr/bin")
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|e| {
            let name = e.file_name().into_string().ok()?;
            Some((name.strip_prefix("wasm-ld-")?.parse().ok()?, e.path()))
        })
        .collect();
    found.sort();
    let newest = found.pop().map(|(_, path)| path);
    newest.ok_or_else(|| "there is no linker for wasm: apt-get install lld-22".to_owned())
}
