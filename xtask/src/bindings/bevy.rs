//! The plugin for Bevy: a workspace of its own, for Bevy wants a newer compiler than the rest.

use super::golden;
use crate::graphics;
use crate::runner::{End, Ended, Skip};
use crate::tools::{Done, apart, command, is_ci, output, root, run};

/// The compiler that it is tested with.
const TOOLCHAIN: &str = "1.99.1";

/// Builds the plugin and runs its tests, those that draw where there is a driver of Vulkan.
pub(crate) fn test() -> Ended {
    let install = ["toolchain", "install", TOOLCHAIN, "--profile", "minimal"];
    let cure = || format!("rustup {}", install.join(" "));
    let skip = || Ok(End::Skipped(Skip::new("the plugin for Bevy", cure())));
    let has_compiler = || output("rustup", &["run", TOOLCHAIN, "rustc", "--version"]);
    if has_compiler().is_none() {
        if !is_ci() || run(command("rustup", &install)).is_err() {
            return skip();
        }
        println!("installed: Rust {TOOLCHAIN}");
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

fn tests(draws: bool) -> Done {
    let toolchain = format!("+{TOOLCHAIN}");
    let manifest = root().join("bindings/bevy/Cargo.toml");
    let manifest = manifest.to_string_lossy();
    let words = ["run", TOOLCHAIN, "cargo", "test", "--locked", "--manifest-path", &manifest];
    // The words behind `rustup run` name the compiler; this is what a person would type instead.
    println!("cargo {toolchain} test --manifest-path {manifest}");
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
    let mut cargo = command("rustup", &[&words[..], which].concat());
    // The compiler of whoever runs this must not win over the one that is named.
    for name in ["RUSTUP_TOOLCHAIN", "CARGO", "RUSTC", "RUSTDOC"] {
        cargo.env_remove(name);
    }
    cargo.env("CARGO_TARGET_DIR", apart("bevy"));
    cargo.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0");
    cargo.env("CULLET_GOLDEN", golden::folder()).env("WGPU_BACKEND", "vulkan");
    run(cargo)
}
