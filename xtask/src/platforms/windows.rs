//! The programs under Wine: names of files that Windows' users have, and the same bytes as here.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{Built, built, cargo, folder, targets::Target, text};
use crate::plain;
use crate::tools::{Done, command, output, run};

/// Wine 8 lacks this library of Windows, from which Rust takes the seeds of its maps.
const SEEDS: &str = "\
#include <windows.h>
#include <ntsecapi.h>
BOOL WINAPI ProcessPrng(PBYTE at, SIZE_T count) { return RtlGenRandom(at, (ULONG)count); }
";

/// A cube's corner, with ends of lines as Windows' editors write them.
const MODEL: &str = "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv 0 0 1\r\nf 1 3 2\r\nf 1 2 4\r\nf 1 4 3\r\n";

/// Where programs find libraries: that of seeds, the C library, and those of the compiler of C++.
pub(super) fn path(target: &Target) -> String {
    let mut folders = vec![folder().join("wine"), built(target, "")];
    for library in ["libstdc++-6.dll", "libgcc_s_seh-1.dll", "libwinpthread-1.dll"] {
        let found = output("x86_64-w64-mingw32-g++", &[&format!("-print-file-name={library}")]);
        let file = found.map(|file| PathBuf::from(file.trim()));
        folders.extend(file.and_then(|file| Some(file.parent()?.to_owned())));
    }
    let names: Vec<_> = folders.iter().map(|path| format!("Z:{}", text(path))).collect();
    names.join(";").replace('/', "\\")
}

/// Makes the library of seeds.
pub(super) fn prepare() -> Done {
    let beside = folder().join("wine");
    let library = beside.join("bcryptprimitives.dll");
    if !library.exists() {
        fs::create_dir_all(&beside).map_err(|e| format!("{}: {e}", beside.display()))?;
        let source = beside.join("seeds.c");
        fs::write(&source, SEEDS).map_err(|e| format!("{}: {e}", source.display()))?;
        let mut compile = command("x86_64-w64-mingw32-gcc", &["-shared", "-o"]);
        compile.args([&library, &source]).arg("-ladvapi32");
        run(compile)?;
    }
    Ok(())
}

/// The program: paths with spaces, letters beyond ASCII, and longer than Windows likes; what it
/// says and writes is what it says and writes here.
pub(super) fn test(target: &Target) -> Done {
    run(cargo(
        target,
        &["build", "--package", "cullet-cli", "--package", "cullet-baker", "--bins"],
    ))?;
    let here = |name: &str| plain::program(name);
    let there = |name: &str| Built { target, program: built(target, &format!("{name}.exe")) };
    let base = folder().join("wine/files");
    let _ = fs::remove_dir_all(&base);
    let long = format!("{}/{}", "lång".repeat(30), "längre".repeat(25));
    let folders = ["plain", "Räume und Türen 測試", &long].map(|name| base.join(name));
    for folder in &folders {
        fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        fs::write(folder.join("a b é.obj"), MODEL).map_err(|e| e.to_string())?;
        let both = |name: &str, args: &[&str], file: Option<&str>| {
            let mut own = command(&text(&here(name)?), args);
            let mut other = there(name).command(args);
            own.current_dir(folder);
            other.current_dir(folder);
            same(own, other, file.map(|file| folder.join(file)))
        };
        both("cullet", &["info", "a b é.obj"], None)?;
        both("cullet", &["picture", "a b é.obj", "-o", "ü.png"], Some("ü.png"))?;
        both(
            "cullet-baker",
            &["cut", "a b é.obj", "--plane", "1,1,1,0.4", "-o", "ß.glb"],
            Some("ß.glb"),
        )?;
        both("cullet", &["info", "nicht da.obj"], None)?;
    }
    let report = there("cullet").command(&["report", "city:cells=4,objects=60", "-o", "bericht 1"]);
    run({
        let mut report = report;
        report.current_dir(&base);
        report
    })?;
    let page = base.join("bericht 1/index.html");
    if page.is_file() { Ok(()) } else { Err(format!("{} was not written", page.display())) }
}

/// Runs the program here and there: exit code, what it prints but for how paths are written, and
/// the file must be the same.
fn same(mut own: Command, mut other: Command, file: Option<PathBuf>) -> Done {
    println!("$ {other:?}");
    let mut ran = [&mut own, &mut other].into_iter().map(|command| {
        let out = command.output().map_err(|e| format!("{command:?}: {e}"))?;
        let printed = String::from_utf8_lossy(&out.stdout).replace('\\', "/");
        let bytes = file.as_deref().map(read).transpose()?;
        if let Some(file) = &file {
            fs::remove_file(file).map_err(|e| format!("{}: {e}", file.display()))?;
        }
        Ok::<_, String>((out.status.code(), printed, bytes))
    });
    let (Some(expected), Some(found)) = (ran.next(), ran.next()) else { return Ok(()) };
    let (expected, found) = (expected?, found?);
    drop(ran);
    if expected == found {
        return Ok(());
    }
    Err(format!(
        "{other:?}: {:?} {:?}, and here {:?} {:?}",
        found.0, found.1, expected.0, expected.1
    ))
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    fs::read(path).map_err(|e| format!("{}: {e}", path.display()))
}
