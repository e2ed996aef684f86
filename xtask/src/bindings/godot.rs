//! The extension for Godot: a workspace of its own, for godot-rust wants a newer compiler than the
//! rest and has a licence that nothing else depends on.

use std::path::{Path, PathBuf};

use crate::runner::{End, Ended, Skip};
use crate::tools::{
    Done, apart, cache, command, install_words, is_ci, is_whole, output, root, run,
};

/// The oldest compiler that godot-rust builds with.
const OLDEST: [u32; 2] = [1, 94];

/// Builds the extension and runs its tests in Godot, those that draw where there is a screen.
pub(crate) fn test() -> Ended {
    let skip = |what: &str, cure: String| Ok(End::Skipped(Skip::new(what, cure)));
    if !has_compiler() {
        let cure = format!("rustup update, to Rust {}.{} or newer", OLDEST[0], OLDEST[1]);
        return skip("the extension for Godot", cure);
    }
    let manifest = root().join("bindings/godot/Cargo.toml");
    let manifest = manifest.to_string_lossy();
    let target = apart("godot");
    for words in [&["build", "--release"][..], &["test", "--release"]] {
        let mut cargo =
            command("cargo", &[words, &["--locked", "--manifest-path", &manifest]].concat());
        cargo.env("CARGO_TARGET_DIR", &target).env("CARGO_INCREMENTAL", "0");
        run(cargo)?;
    }
    let library = target.join("release/libcullet_godot.so");
    let mut skipped = Vec::new();
    let archive = archive(&library, &target, &manifest, &mut skipped)?;
    let Some(godot) = godot() else {
        let cure = "set CULLET_GODOT to a Godot 4.6";
        skipped.push(Skip::new("the extension in Godot: not run", cure));
        return Ok(End::Partly(skipped));
    };
    if let Some(archive) = archive {
        let paths = [&godot, &archive, &target.join("empty")];
        let paths = paths.map(|path| path.to_string_lossy().into_owned());
        let words: Vec<&str> = paths.iter().map(String::as_str).collect();
        let script = root().join("bindings/godot/tests/archive.sh");
        run(command(&script.to_string_lossy(), &words))?;
    }
    let work = target.join("project");
    if output("sh", &["-c", "command -v xvfb-run"]).is_none() {
        in_godot(&godot, &library, &work, &["headless"], "")?;
        let cure = install_words(&["xvfb", "xauth"]);
        skipped.push(Skip::new("Godot's pictures with the extension and without", cure));
    } else if is_whole() {
        in_godot(&godot, &library, &work, &[], "")?;
    } else {
        in_godot(&godot, &library, &work, &["headless", "mobile"], "")?;
        in_godot(&godot, &library, &work, &["gl_compatibility", "forward_plus"], FEW)?;
    }
    Ok(if skipped.is_empty() { End::Passed } else { End::Partly(skipped) })
}

/// Cases that the renderers draw each in its own way: shadows, lamps, glass and fog.
const FEW: &str = "city_sun casts lamps surfaces fog";

/// Runs the tests in Godot with these renderers, or with all, and these cases, or all.
fn in_godot(godot: &Path, library: &Path, work: &Path, renderers: &[&str], cases: &str) -> Done {
    let paths = [godot, library, work].map(|path| path.to_string_lossy().into_owned());
    let script = root().join("bindings/godot/tests/run.sh");
    let mut tests = command(&script.to_string_lossy(), &[]);
    tests.args(paths).args(renderers);
    if !cases.is_empty() {
        tests.env("CULLET_CASES", cases);
    }
    run(tests)
}

/// A system that the release archive holds a library for beside that of Linux on x86-64.
struct Further {
    triple: &'static str,
    linker: &'static str,
    packages: &'static [&'static str],
    built: &'static str,
    named: &'static str,
}

/// None of them is run here.
const FURTHER: [Further; 2] = [
    Further {
        triple: "aarch64-unknown-linux-gnu",
        linker: "aarch64-linux-gnu-gcc",
        packages: &["gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross"],
        built: "libcullet_godot.so",
        named: "libcullet_godot.arm64.so",
    },
    Further {
        triple: "x86_64-pc-windows-gnu",
        linker: "x86_64-w64-mingw32-gcc",
        packages: &["gcc-mingw-w64-x86-64"],
        built: "cullet_godot.dll",
        named: "cullet_godot.dll",
    },
];

/// Makes the release archive, with a library for each system whose compiler is installed, and prints
/// its checksum. Returns `None` where there is no program to make it.
fn archive(
    library: &Path,
    target: &Path,
    manifest: &str,
    skipped: &mut Vec<Skip>,
) -> Result<Option<PathBuf>, String> {
    if output("sh", &["-c", "command -v zip && command -v unzip"]).is_none() {
        skipped.push(Skip::new("the archive for Godot", install_words(&["zip", "unzip"])));
        return Ok(None);
    }
    let staged = target.join("archive");
    let bin = staged.join("addons/cullet/bin");
    let failed = |e: std::io::Error| format!("{}: {e}", staged.display());
    if staged.exists() {
        std::fs::remove_dir_all(&staged).map_err(failed)?;
    }
    std::fs::create_dir_all(&bin).map_err(failed)?;
    let addon = root().join("bindings/godot/addons/cullet");
    // Its files, and none of `bin`.
    for entry in std::fs::read_dir(&addon).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        if entry.path().is_file() {
            let to = staged.join("addons/cullet").join(entry.file_name());
            std::fs::copy(entry.path(), to).map_err(failed)?;
        }
    }
    std::fs::copy(library, bin.join("libcullet_godot.so")).map_err(failed)?;
    let targets = output("rustup", &["target", "list", "--installed"]).unwrap_or_default();
    // Two builds more are for whoever makes a release.
    for further in FURTHER.iter().filter(|_| is_whole()) {
        let what = || format!("the library for Godot on {}", further.triple);
        if !targets.lines().any(|line| line == further.triple) {
            skipped.push(Skip::new(what(), format!("rustup target add {}", further.triple)));
            continue;
        }
        if output(further.linker, &["--version"]).is_none() {
            skipped.push(Skip::new(what(), install_words(further.packages)));
            continue;
        }
        let words = ["build", "--release", "--locked", "--manifest-path", manifest];
        let mut cargo = command("cargo", &[&words[..], &["--target", further.triple]].concat());
        let name = further.triple.to_uppercase().replace('-', "_");
        cargo.env(format!("CARGO_TARGET_{name}_LINKER"), further.linker);
        cargo.env("CARGO_TARGET_DIR", target).env("CARGO_INCREMENTAL", "0");
        run(cargo)?;
        let built = target.join(further.triple).join("release").join(further.built);
        std::fs::copy(built, bin.join(further.named)).map_err(failed)?;
    }
    let name = format!("cullet-godot-{}.zip", version(manifest)?);
    let archive = target.join(&name);
    if archive.exists() {
        std::fs::remove_file(&archive).map_err(failed)?;
    }
    let mut zip = command("zip", &["-q", "-X", "-9", "-r", &archive.to_string_lossy(), "addons"]);
    zip.current_dir(&staged);
    run(zip)?;
    let sum = output("sha256sum", &[&archive.to_string_lossy()]);
    let sum = sum.ok_or("sha256sum: no checksum of the archive")?;
    println!("{}", sum.trim());
    Ok(Some(archive))
}

/// Returns the version of the extension's package.
fn version(manifest: &str) -> Result<String, String> {
    let text = std::fs::read_to_string(manifest).map_err(|e| format!("{manifest}: {e}"))?;
    let line = text.lines().find_map(|line| line.strip_prefix("version = \""));
    let version = line.and_then(|rest| rest.strip_suffix('"'));
    version.map(str::to_owned).ok_or_else(|| format!("{manifest}: no version"))
}

/// Whether the compiler of this workspace is new enough.
fn has_compiler() -> bool {
    let version = output("rustc", &["--version"]).unwrap_or_default();
    let numbers = version.split_whitespace().nth(1).unwrap_or_default();
    let mut numbers = numbers.split('.').filter_map(|n| n.parse::<u32>().ok());
    let found = [numbers.next(), numbers.next()].map(Option::unwrap_or_default);
    found >= OLDEST
}

/// Returns Godot: the one that `CULLET_GODOT` names, or one that was fetched into the cache. CI
/// fetches it where it can.
fn godot() -> Option<PathBuf> {
    let named = std::env::var_os("CULLET_GODOT").filter(|path| !path.is_empty());
    if let Some(named) = named {
        return Some(PathBuf::from(named));
    }
    let folder = cache().join("tools/godot");
    let program = folder.join("godot");
    if !program.is_file() && is_ci() {
        let script = root().join("bindings/godot/tests/get-godot.sh");
        let words = [folder.to_string_lossy().into_owned()];
        if let Err(error) = run(command(&script.to_string_lossy(), &[&words[0]])) {
            println!("Godot could not be fetched: {error}");
        }
    }
    program.is_file().then_some(program)
}
