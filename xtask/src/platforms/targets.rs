//! The machines.

use crate::cross::{ARM, WINDOWS};

/// A machine that answers are compared with.
pub(super) struct Target {
    pub(super) name: &'static str,
    /// Rust's name for it.
    pub(super) triple: &'static str,
    /// Words before a program that run it.
    pub(super) runner: &'static [&'static str],
    pub(super) environment: &'static [(&'static str, &'static str)],
    /// Whether the scalar level is held against the others.
    pub(super) has_scalar: bool,
    /// The compiler that its C library is tested by, if it is.
    pub(super) c_compiler: Option<&'static [&'static str]>,
    pub(super) c_library: &'static str,
    pub(super) c_flags: &'static [&'static str],
    /// End of the names of programs.
    pub(super) ending: &'static str,
    /// A line of the shell that succeeds where its compilers and its emulator are there, and the
    /// packages of Debian that have them.
    pub(super) probe: &'static str,
    pub(super) packages: &'static [&'static str],
    pub(super) further: Further,
    /// Whether it differs from another here by its system libraries or by its width alone: such are
    /// left to who wants the whole.
    pub(super) is_like_another: bool,
}

/// Tests besides the answers and the C library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Further {
    None,
    /// Tests of the engine.
    Engine,
    /// Programs under Wine.
    Programs,
}

/// This one.
pub(super) const HOST: Target = Target {
    name: "this machine",
    triple: "x86_64-unknown-linux-gnu",
    runner: &["env"],
    environment: &[],
    has_scalar: true,
    c_compiler: None,
    c_library: "libcullet.a",
    c_flags: &[],
    ending: "",
    probe: "true",
    packages: &[],
    further: Further::None,
    is_like_another: false,
};

/// Tells glibc that the processor has no fused multiply-add, as those before 2013.
pub(super) const WITHOUT_FMA: &str =
    "glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX2,-FMA,-FMA4,-AVX512F";

pub(super) const OTHERS: &[Target] = &[
    Target {
        name: "x86-64 with musl",
        triple: "x86_64-unknown-linux-musl",
        has_scalar: false,
        is_like_another: true,
        ..HOST
    },
    Target {
        name: "32-bit x86",
        triple: "i686-unknown-linux-gnu",
        has_scalar: false,
        c_compiler: Some(&["gcc", "-m32"]),
        c_flags: &["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl"],
        // (Debian's gcc-multilib conflicts with its compilers for ARM, that of a version does not.)
        probe: "echo 'int main() { return 0; }' | gcc -m32 -x c - -o /dev/null",
        packages: &["gcc-12-multilib"],
        is_like_another: true,
        ..HOST
    },
    Target {
        name: ARM.name,
        triple: ARM.triple,
        runner: ARM.runner,
        environment: ARM.environment,
        c_compiler: Some(&[ARM.compiler]),
        c_flags: &["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl"],
        probe: ARM.probe,
        packages: ARM.packages,
        further: Further::Engine,
        ..HOST
    },
    Target {
        name: "WebAssembly with SIMD",
        triple: "wasm32-wasip1",
        runner: &["node", "--no-warnings", "xtask/src/platforms/wasi.mjs"],
        environment: &[("CARGO_TARGET_WASM32_WASIP1_RUSTFLAGS", "-Ctarget-feature=+simd128")],
        has_scalar: false,
        ending: ".wasm",
        probe: "command -v node",
        packages: &["nodejs"],
        ..HOST
    },
    Target {
        name: WINDOWS.name,
        triple: WINDOWS.triple,
        has_scalar: false,
        runner: WINDOWS.runner,
        environment: WINDOWS.environment,
        c_compiler: Some(&[WINDOWS.compiler]),
        c_library: "cullet.dll",
        c_flags: &["-lpthread"],
        ending: ".exe",
        probe: WINDOWS.probe,
        packages: WINDOWS.packages,
        further: Further::Programs,
        ..HOST
    },
];

/// A machine that the engine is compiled for, never run on.
pub(super) struct Checked {
    pub(super) name: &'static str,
    pub(super) check: &'static [&'static str],
}

const LIBRARIES: &[&str] =
    &["check", "--package", "cullet", "--package", "cullet-cells", "--package", "cullet-mesh"];

const WITHOUT_STD: &[&str] = &["check", "--package", "cullet-cells", "--no-default-features"];

pub(super) const CHECKED: &[Checked] = &[
    Checked { name: "aarch64-linux-android", check: LIBRARIES },
    Checked { name: "aarch64-apple-darwin", check: LIBRARIES },
    Checked { name: "aarch64-apple-ios", check: LIBRARIES },
    Checked { name: "x86_64-pc-windows-msvc", check: LIBRARIES },
    Checked { name: "aarch64-unknown-none", check: WITHOUT_STD },
    // It has no atomics of 64 bits either.
    Checked { name: "thumbv7em-none-eabihf", check: WITHOUT_STD },
];
