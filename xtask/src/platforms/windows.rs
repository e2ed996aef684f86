//! The programs under Wine: names of files that Windows' users have, and the same bytes as here.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::built::{Built, built, cargo, folder, text};
use super::targets::Target;
use crate::plain;
use crate::tools::{Done, command, run};

/// A cube's corner, with ends of lines as Windows' editors write them.
const MODEL: &str = "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv 0 0 1\r\nf 1 3 2\r\nf 1 2 4\r\nf 1 4 3\r\n";

/// Builds the programs.
pub(super) fn build(target: &Target) -> Done {
    let words = ["build", "--package", "cullet-cli", "--package", "cullet-baker", "--bins"];
    run(cargo(target, &words))
}

/// The program: paths with spaces, letters beyond ASCII, and longer than Windows likes; what it
/// says and writes is what it says and writes here.
pub(super) fn test(target: &Target) -> Done {
    let own = plain::program("cullet")?;
    let here = |name: &str| command(&text(&own.with_file_name(name)), &[]);
    let there = |name: &str| Built { target, program: built(target, &format!("{name}.exe")) };
    let base = folder().join("wine/files");
    let _ = fs::remove_dir_all(&base);
    for name in ["plain", "Räume und Türen 測試"] {
        let folder = written(&base.join(name))?;
        let both = |name: &str, args: &[&str], file: Option<&str>| {
            let (mut own, mut other) = (here(name), there(name).command(args));
            own.args(args).current_dir(&folder);
            other.current_dir(&folder);
            same(own, other, file.map(|file| folder.join(file)))
        };
        both("cullet", &["info", "a b é.obj"], None)?;
        both("cullet", &["info", "nicht da.obj"], None)?;
        both("cullet", &["picture", "shaded", "a b é.obj", "--out", "ü.png"], Some("ü.png"))?;
        let cut = ["cut", "a b é.obj", "--plane", "1,1,1,0.4", "-o", "ß.glb"];
        both("cullet-baker", &cut, Some("ß.glb"))?;
    }
    // More letters than a path of Windows has as a rule.
    let long = written(&base.join("lång".repeat(30)).join("längre".repeat(25)))?;
    let file = format!("Z:{}", text(&long.join("a b é.obj"))).replace('/', "\\");
    run(there("cullet").command(&["info", &file]))?;
    let mut report = there("cullet").command(&["report", "city:cells=4,objects=60"]);
    report.args(["--out", "bericht 1"]).current_dir(&base);
    run(report)?;
    let page = base.join("bericht 1/index.html");
    if page.is_file() { Ok(()) } else { Err(format!("{} was not written", page.display())) }
}

/// Makes a folder with a model in it.
fn written(folder: &Path) -> Result<PathBuf, String> {
    let fail = |e: std::io::Error| format!("{}: {e}", folder.display());
    fs::create_dir_all(folder).map_err(fail)?;
    fs::write(folder.join("a b é.obj"), MODEL).map_err(fail)?;
    Ok(folder.to_owned())
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
