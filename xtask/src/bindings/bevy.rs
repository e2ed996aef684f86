//! The plugin for Bevy: a workspace of its own, for Bevy wants a newer compiler than the rest.

use std::process::Command;

use super::golden;
use crate::graphics;
use crate::runner::{End, Ended, Skip};
use crate::tools::{Done, alone, apart, command, is_ci, output, root, run};

/// The compiler that it is tested with.
const TOOLCHAIN: &str = "1.99.1";

/// Words by which rustup installs it.
const INSTALL: [&str; 5] = ["toolchain", "install", TOOLCHAIN, "--profile", "minimal"];

/// Builds the plugin and runs its tests, those that draw where there is a driver of Vulkan.
pub(crate) fn test() -> Ended {
    if !has_compiler()? {
        let cure = format!("rustup {}", INSTALL.join(" "));
        return Ok(End::Skipped(Skip::new("the plugin for Bevy", cure)));
    }
    let draws = graphics::is_there();
    tests(draws)?;
    if draws {
        return Ok(End::Passed);
    }
    let drawn = Skip::new(
        "Bevy's pictures with the plugin and without",
        crate::tools::install_words(graphics::DEBIAN),
    );
    Ok(End::Partly(vec![drawn]))
}

/// Builds the plugin and all of its tests.
pub(crate) fn build() -> Done {
    if has_compiler()? { run(cargo_test(&["--no-run"])) } else { Ok(()) }
}

/// Whether the compiler is there, once CI has installed it.
fn has_compiler() -> Result<bool, String> {
    let is_there = || output("rustup", &["run", TOOLCHAIN, "rustc", "--version"]).is_some();
    if !is_there() && is_ci() {
        let _alone = alone("rustup")?;
        if !is_there() && run(command("rustup", &INSTALL)).is_ok() {
            println!("installed: Rust {TOOLCHAIN}");
        }
    }
    Ok(is_there())
}

fn tests(draws: bool) -> Done {
    let which: &[&str] = if draws {
        &[]
    } else {
        &[
            "--lib",
            "--test",
            "apps",
            "--test",
            "check",
            "--test",
            "golden",
            "--test",
            "lights",
            "--test",
            "occlusion",
        ]
    };
    let mut cargo = cargo_test(which);
    cargo.env("CULLET_GOLDEN", golden::folder()).env("WGPU_BACKEND", "vulkan");
    run(cargo)
}

/// Cargo's `test` by that compiler, with more words.
fn cargo_test(which: &[&str]) -> Command {
    let manifest = root().join("bindings/bevy/Cargo.toml");
    let manifest = manifest.to_string_lossy();
    let words = ["run", TOOLCHAIN, "cargo", "test", "--locked", "--manifest-path", &manifest];
    // The words behind `rustup run` name the compiler; this is what a person would type instead.
    println!("cargo +{TOOLCHAIN} test --manifest-path {manifest}");
    let mut cargo = command("rustup", &[&words[..], which].concat());
    // The compiler of whoever runs this must not win over the one that is named.
    for name in ["RUSTUP_TOOLCHAIN", "CARGO", "RUSTC", "RUSTDOC"] {
        cargo.env_remove(name);
    }
    cargo.env("CARGO_TARGET_DIR", apart("bevy"));
    cargo.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0");
    cargo
}
