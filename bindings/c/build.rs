//! Gives the shared library the name that programs look it up by, and lets the linker join functions
//! that are the same, where it can.

use std::path::Path;
use std::process::{Command, Stdio};
use std::{env, fs};

/// Functions of the same code are kept once: many types are destroyed alike. Nothing here compares
/// addresses of functions.
const JOIN: &str = "-Wl,--icf=all";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let of = |name| env::var(name).unwrap_or_default();
    if of("CARGO_CFG_TARGET_OS") == "linux" {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libcullet.so.0");
        if of("OPT_LEVEL") != "0" && links_with(JOIN) {
            println!("cargo:rustc-cdylib-link-arg={JOIN}");
        }
    }
}

/// Whether an empty library links with an option: lld knows more of them than the linker of GNU, and
/// which is taken depends on compiler, target and settings.
fn links_with(option: &str) -> bool {
    let of = |name| env::var(name).ok().filter(|value| !value.is_empty());
    let (Some(rustc), Some(target), Some(folder)) = (of("RUSTC"), of("TARGET"), of("OUT_DIR"))
    else {
        return false;
    };
    let source = Path::new(&folder).join("empty.rs");
    if fs::write(&source, "").is_err() {
        return false;
    }
    let mut compile = Command::new(rustc);
    compile.args(["--crate-type", "cdylib", "--target", &target, "--out-dir", &folder]).arg(source);
    if let Some(linker) = of("RUSTC_LINKER") {
        compile.arg(format!("-Clinker={linker}"));
    }
    if let Some(flags) = of("CARGO_ENCODED_RUSTFLAGS") {
        compile.args(flags.split('\x1f'));
    }
    compile.arg(format!("-Clink-arg={option}"));
    let status = compile.stdout(Stdio::null()).stderr(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
}
