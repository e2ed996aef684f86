//! Archives of libraries for more systems than this one: the C library and the extension for Godot.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::current_version;
use super::folders::{artefacts, at, empty, first_example, machine, pack, text};
use crate::bindings::godot;
use crate::cross::{Cross, prepare_wine, wine_seeds};
use crate::runner::{End, Ended, Skip};
use crate::tools::{Done, cargo_program, command, install_words, output, root, run, target};

/// Last line of the first example in C, on every system.
const SAYS: &str = "3 of 5 boxes may be visible";

/// Archive of the C library for this system.
pub(super) fn c() -> Ended {
    archive_of_c(None)
}

/// Archive of the C library for another system, used there by what runs its programs here.
pub(super) fn c_for(cross: &Cross) -> Ended {
    if let Some(skip) = cross.missing_to_run("the archive of the C library") {
        return Ok(End::Skipped(skip));
    }
    archive_of_c(Some(cross))
}

/// Makes the archive, then compiles and runs the first example against what is in it, with the shared
/// and with the static library.
fn archive_of_c(cross: Option<&Cross>) -> Ended {
    let machine = cross.map_or_else(machine, |cross| Ok(cross.triple.to_owned()))?;
    if machine.contains("windows")
        && let Some(skip) = no_zip("the archive of the C library for Windows")
    {
        return Ok(End::Skipped(skip));
    }
    let name = format!("cullet-c-{}-{machine}", current_version()?);
    let stage = empty("stage")?;
    let script = text(&root().join("bindings/c/install.sh"));
    let mut install = command("sh", &[&script, &text(&stage.join(&name))]);
    install.env("CARGO", cargo_program()).env("CARGO_TARGET_DIR", target());
    if let Some(cross) = cross {
        install.envs(cross.environment.iter().copied());
        install.env("CULLET_TARGET", cross.triple).env("STRIP", cross.strip);
    }
    run(install)?;
    fs::copy(root().join("bindings/c/README.md"), stage.join(&name).join("README.md"))
        .map_err(|e| at(&stage, e))?;
    let prefix = pack(&stage, &name)?;
    let user = empty(&format!("c-user-{machine}"))?;
    let example = first_example(&root().join("bindings/c/README.md"), "c")?;
    fs::write(user.join("first.c"), example).map_err(|e| at(&user, e))?;
    if cross.is_some_and(|cross| cross.runner == ["wine"]) {
        prepare_wine()?;
    }
    let shared = "$CC -std=c11 first.c -o shared.exe $(pkg-config --cflags --libs cullet)";
    let own = "$CC -std=c11 first.c -o static.exe $(pkg-config --cflags cullet) $LIBRARY \
               $(pkg-config --static --libs cullet | sed 's/-lcullet//')";
    let mut ways = vec![(shared, "shared.exe"), (own, "static.exe")];
    let mut end = End::Passed;
    if machine.contains("windows") {
        holds_exports(&prefix)?;
        let line = "$CC -std=c11 first.c -o msvc.exe $(pkg-config --cflags cullet) $IMPORTS";
        match prefix.join("lib/cullet.lib").exists() {
            true => ways.push((line, "msvc.exe")),
            false => {
                let what = "an import library for MSVC in the archive of the C library";
                end = End::Partly(vec![Skip::new(what, install_words(&["llvm"]))]);
            }
        }
    }
    for (line, program) in ways {
        let mut compile = Command::new("sh");
        compile.args(["-euc", line]).current_dir(&user);
        compile.env("CC", cross.map_or("gcc", |cross| cross.compiler));
        compile.env("LIBRARY", prefix.join("lib/libcullet.a"));
        compile.env("IMPORTS", prefix.join("lib/cullet.lib"));
        compile.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
        run(compile)?;
        let folders = [prefix.join("bin"), wine_seeds()];
        let program = user.join(program);
        let run_there = |cross: &Cross| cross.command(&program, &folders);
        let mut first = cross.map_or_else(|| command(&text(&program), &[]), run_there);
        first.env("LD_LIBRARY_PATH", prefix.join("lib"));
        says(first, SAYS)?;
    }
    Ok(end)
}

/// `cullet.def`, of which MSVC makes an import library, names each function of the header that is in
/// the library: all but bakes.
fn holds_exports(prefix: &Path) -> Done {
    let read = |name: &str| {
        let path = prefix.join(name);
        fs::read_to_string(&path).map_err(|e| at(&path, e))
    };
    let (header, exports) = (read("include/cullet.h")?, read("lib/cullet.def")?);
    let declared = header.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_lowercase()));
    let names = declared.filter_map(|line| line.split_once('(')?.0.rsplit([' ', '*']).next());
    let names = names.filter(|name| name.starts_with("cullet_"));
    let is_there = |name: &str| exports.lines().any(|line| line.trim() == name);
    let is_baked = |name: &str| name.starts_with("cullet_bake_") || name == "cullet_scene_save";
    let wrong: Vec<&str> = names.filter(|name| is_there(name) == is_baked(name)).collect();
    if wrong.is_empty() {
        return Ok(());
    }
    Err(format!("lib/cullet.def lacks, or has too much: {}", wrong.join(", ")))
}

/// Runs a program whose last line is `expected`.
fn says(mut program: Command, expected: &str) -> Done {
    let out = program.output().map_err(|e| format!("{program:?}: {e}"))?;
    let said = String::from_utf8_lossy(&out.stdout);
    print!("$ {program:?}\n{said}{}", String::from_utf8_lossy(&out.stderr));
    let is_right = said.lines().last().is_some_and(|line| line.trim_end() == expected);
    if out.status.success() && is_right {
        return Ok(());
    }
    Err(format!("{program:?}: {}, and its last line is not \"{expected}\"", out.status))
}

/// Says what is missing where there is no program to make an archive for Windows.
fn no_zip(what: &str) -> Option<Skip> {
    let has = output("sh", &["-c", "command -v zip && command -v unzip"]).is_some();
    (!has).then(|| Skip::new(what, install_words(&["zip", "unzip"])))
}

/// Archive of the extension for Godot, with a library for each system whose compiler is there.
pub(super) fn godot() -> Ended {
    let (archive, skips) = match godot::release_archive()? {
        Ok(made) => made,
        Err(skip) => return Ok(End::Skipped(skip)),
    };
    let name = archive.file_name().map(Path::new).unwrap_or(&archive);
    fs::copy(&archive, artefacts().join(name)).map_err(|e| at(&archive, e))?;
    Ok(if skips.is_empty() { End::Passed } else { End::Partly(skips) })
}
