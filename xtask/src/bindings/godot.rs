//! The extension for Godot: a workspace of its own, for godot-rust wants a newer compiler than the
//! rest and has a licence that nothing else depends on.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cross::{ARM, Cross, WINDOWS};
use crate::runner::{End, Ended, Skip};
use crate::tools::{
    Done, apart, cache, command, install_words, is_ci, is_whole, output, root, run,
};

/// The oldest compiler that godot-rust builds with.
const OLDEST: [u32; 2] = [1, 94];

/// Builds the extension and runs its tests in Godot, those that draw where there is a screen. The
/// archive holds the library of this system alone: `cargo xtask release --dry-run` makes it whole.
pub(crate) fn test() -> Ended {
    let library = match build()? {
        Ok(library) => library,
        Err(skip) => return Ok(End::Skipped(skip)),
    };
    run(cargo(&["test", "--release"]))?;
    let target = folder();
    let mut skipped = Vec::new();
    let archive = archive(&library, &[], &mut skipped)?;
    let Some(godot) = godot() else {
        let cure = "set CULLET_GODOT to a Godot 4.6";
        skipped.push(Skip::new("the extension in Godot: not run", cure));
        return Ok(End::Partly(skipped));
    };
    if let Some(archive) = archive {
        use_archive(&godot, &archive)?;
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

/// Makes the release archive with a library for each system whose compiler is there, and tests it in
/// Godot where that is there. Returns it with what was skipped; or why there is none.
pub(crate) fn release_archive() -> Result<Result<(PathBuf, Vec<Skip>), Skip>, String> {
    let library = match build()? {
        Ok(library) => library,
        Err(skip) => return Ok(Err(skip)),
    };
    let mut skipped = Vec::new();
    let Some(archive) = archive(&library, &FURTHER, &mut skipped)? else {
        return skipped.pop().map(Err).ok_or_else(|| "no archive for Godot".into());
    };
    match godot() {
        Some(godot) => use_archive(&godot, &archive)?,
        None => {
            let cure = "set CULLET_GODOT to a Godot 4.6";
            skipped.push(Skip::new("the archive in Godot: not run", cure));
        }
    }
    Ok(Ok((archive, skipped)))
}

/// Where the extension is built.
fn folder() -> PathBuf {
    apart("godot")
}

/// A command of cargo for the extension.
fn cargo(words: &[&str]) -> Command {
    of_extension(command("cargo", words))
}

fn of_extension(mut cargo: Command) -> Command {
    cargo.arg("--locked").arg("--manifest-path").arg(manifest());
    cargo.env("CARGO_TARGET_DIR", folder()).env("CARGO_INCREMENTAL", "0");
    cargo
}

fn manifest() -> PathBuf {
    root().join("bindings/godot/Cargo.toml")
}

/// Builds the library of this system; or says why it cannot be built.
pub(crate) fn build() -> Result<Result<PathBuf, Skip>, String> {
    if !has_compiler() {
        let cure = format!("rustup update, to Rust {}.{} or newer", OLDEST[0], OLDEST[1]);
        return Ok(Err(Skip::new("the extension for Godot", cure)));
    }
    run(cargo(&["build", "--release"]))?;
    Ok(Ok(folder().join("release/libcullet_godot.so")))
}

/// Unpacks an archive into an empty project of Godot, and culls there.
fn use_archive(godot: &Path, archive: &Path) -> Done {
    let script = root().join("bindings/godot/tests/archive.sh");
    let mut test = command(&script.to_string_lossy(), &[]);
    test.arg(godot).arg(archive).arg(folder().join("empty"));
    run(test)
}

/// A system that the release archive holds a library for beside that of Linux on x86-64, with the
/// library's name as built and in the archive.
struct Further {
    cross: &'static Cross,
    built: &'static str,
    named: &'static str,
}

/// None of them is run here.
const FURTHER: [Further; 2] = [
    Further { cross: &ARM, built: "libcullet_godot.so", named: "libcullet_godot.arm64.so" },
    Further { cross: &WINDOWS, built: "cullet_godot.dll", named: "cullet_godot.dll" },
];

/// Makes the archive, with a library for each of `further` whose compiler is installed, and prints
/// its checksum. Returns `None` where there is no program to make it.
fn archive(
    library: &Path,
    further: &[Further],
    skipped: &mut Vec<Skip>,
) -> Result<Option<PathBuf>, String> {
    if output("sh", &["-c", "command -v zip && command -v unzip"]).is_none() {
        skipped.push(Skip::new("the archive for Godot", install_words(&["zip", "unzip"])));
        return Ok(None);
    }
    let target = folder();
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
    for Further { cross, built, named } in further {
        if let Some(skip) = cross.missing("the library for Godot") {
            skipped.push(skip);
            continue;
        }
        run(of_extension(cross.cargo(&["build", "--release"], &target)))?;
        let built = target.join(cross.triple).join("release").join(built);
        std::fs::copy(built, bin.join(named)).map_err(failed)?;
    }
    let name = format!("cullet-godot-{}.zip", version()?);
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
fn version() -> Result<String, String> {
    let manifest = manifest();
    let at = manifest.display();
    let text = std::fs::read_to_string(&manifest).map_err(|e| format!("{at}: {e}"))?;
    let line = text.lines().find_map(|line| line.strip_prefix("version = \""));
    let version = line.and_then(|rest| rest.strip_suffix('"'));
    version.map(str::to_owned).ok_or_else(|| format!("{at}: no version"))
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
