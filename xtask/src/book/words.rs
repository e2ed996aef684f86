//! Spelling of texts, by [typos](https://github.com/crate-ci/typos), in a Python environment that
//! CI makes for it.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::bindings::python::{environment, interpreter, pip, program};
use crate::runner::Skip;
use crate::tools::{Done, cache, command, install, install_words, is_ci, output, root};

/// Packages of the environment.
const TOOLS: &[&str] = &["typos==1.52.*"];
/// System packages that an environment needs.
const SYSTEM: &[&str] = &["python3-venv"];
/// Texts whose spelling is checked, as git lists them: those for readers, and the comments of all
/// Rust.
const SPELLED: &[&str] = &["*.md", "*.rs"];

/// Checks the spelling; or returns what is skipped, where the tool is missing and this is not CI.
pub(super) fn check() -> Result<Option<Skip>, String> {
    let what = "spelling of the texts";
    let folder = cache().join("book-tools");
    if !is_made(&folder) && !is_ci() {
        let cure = format!("{}; CI=true cargo xtask test book", install_words(SYSTEM));
        return Ok(Some(Skip::new(what, cure)));
    }
    if !is_made(&folder) {
        make(&folder)?;
    }
    spelling(&folder)?;
    Ok(None)
}

/// Says of what the environment was made: one of other tools is made anew.
fn stamp(folder: &Path) -> PathBuf {
    folder.join("made-of")
}

fn is_made(folder: &Path) -> bool {
    fs::read_to_string(stamp(folder)).is_ok_and(|text| text == TOOLS.join(" "))
}

fn make(folder: &Path) -> Done {
    let mut python = interpreter();
    if python.is_none() {
        install(SYSTEM)?;
        python = interpreter();
    }
    let python = python.ok_or_else(|| format!("needed: {}", install_words(SYSTEM)))?;
    environment(&python, folder)?;
    pip(folder, TOOLS)?;
    let stamp = stamp(folder);
    fs::write(&stamp, TOOLS.join(" ")).map_err(|e| format!("{}: {e}", stamp.display()))
}

/// British, as `typos.toml` at the root says.
fn spelling(folder: &Path) -> Done {
    let list = output("git", &[&["ls-files"], SPELLED].concat());
    let files = list.ok_or("git ls-files failed: spelling is checked of what git knows")?;
    // Those that were removed and not yet committed are listed, too.
    let there: Vec<&str> = files.lines().filter(|file| root().join(file).is_file()).collect();
    println!("spelling of {} files", there.len());
    let config = root().join("typos.toml");
    let typos = program(folder, "typos");
    let mut typos = command(&typos.to_string_lossy(), &["--format", "brief", "--file-list", "-"]);
    typos.arg("--config").arg(config);
    given(typos, &there.join("\n")).map(|_| ()).map_err(|said| {
        format!("spelling (write it right, or teach typos.toml a name):\n       {said}")
    })
}

/// Runs a command that is given a text; returns what it prints, as the error where it fails.
fn given(mut command: std::process::Command, text: &str) -> Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let fail = |e: std::io::Error| format!("{name}: {e}");
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(fail)?;
    let mut input = child.stdin.take().ok_or("no way to write to it")?;
    let text = text.to_owned();
    // What it prints may fill its pipe before it has read everything.
    let writer = std::thread::spawn(move || input.write_all(text.as_bytes()));
    let out = child.wait_with_output().map_err(fail)?;
    let _ = writer.join();
    let said = String::from_utf8_lossy(&out.stdout).into_owned();
    if out.status.success() {
        return Ok(said);
    }
    Err(format!("{said}{}", String::from_utf8_lossy(&out.stderr)).trim().to_owned())
}
