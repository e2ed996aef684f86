//! Spelling and reading level of texts, by tools that others make, [typos](https://github.com/crate-ci/typos) and
//! [textstat](https://textstat.org), in a Python environment that CI makes for them.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use super::chapters;
use crate::bindings::python::{environment, interpreter, pip, program};
use crate::runner::Skip;
use crate::tools::{Done, cache, command, install, install_words, is_ci, output, root};

/// What the environment is made of. The next textstat fetches a dictionary whenever it finds none.
const TOOLS: &[&str] = &["typos==1.52.*", "textstat==0.7.4", "setuptools==80.*"];
/// What an environment takes of the system.
const SYSTEM: &[&str] = &["python3-venv"];
/// Flesch's reading ease that no chapter may fall below: 90 is for children, 60 plain English, 30 a scientific paper. The
/// hardest had 73 when this was set.
const EASE: f64 = 70.0;
/// Words of prose from which on a chapter's ease means something.
const FEW: usize = 100;
/// Texts whose spelling is checked, as git lists them: those for readers, and the comments of all Rust.
const SPELLED: &[&str] = &["*.md", "*.rs"];

/// Checks both; or what is skipped, where the tools are missing and this is not CI.
pub(super) fn check() -> Result<Option<Skip>, String> {
    let what = "spelling and reading level of the texts";
    let folder = cache().join("book-tools");
    if !is_made(&folder) && !is_ci() {
        let cure = format!("{}; CI=true cargo xtask test book", install_words(SYSTEM));
        return Ok(Some(Skip::new(what, cure)));
    }
    if !is_made(&folder) {
        make(&folder)?;
    }
    spelling(&folder)?;
    reading(&folder)?;
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

/// The reading ease of each chapter is at least the least allowed.
fn reading(folder: &Path) -> Done {
    const SCRIPT: &str = "import json, sys, textstat\n\
        texts = json.load(sys.stdin)\n\
        print(json.dumps({name: textstat.flesch_reading_ease(text) for name, text in texts.items()}))";
    let long = |text: &String| text.split_whitespace().count() >= FEW;
    let texts: BTreeMap<String, String> = chapters()?
        .into_iter()
        .map(|(name, text)| (name, prose(&text)))
        .filter(|(name, text)| name != "SUMMARY.md" && long(text))
        .collect();
    let json = serde_json::to_string(&texts).map_err(|e| e.to_string())?;
    let python = program(folder, "python");
    let said = given(command(&python.to_string_lossy(), &["-c", SCRIPT]), &json)?;
    let scores: BTreeMap<String, f64> =
        serde_json::from_str(&said).map_err(|e| format!("textstat said {said}: {e}"))?;
    let mut sorted: Vec<_> = scores.iter().collect();
    sorted.sort_by(|a, b| a.1.total_cmp(b.1));
    let least: Vec<String> = sorted.iter().take(5).map(|(n, s)| format!("{n} {s:.0}")).collect();
    println!("reading ease of {} chapters; the hardest: {}", scores.len(), least.join(", "));
    let hard = sorted.iter().filter(|(_, score)| **score < EASE);
    let hard: Vec<String> = hard.map(|(name, score)| format!("{name} {score:.1}")).collect();
    if hard.is_empty() {
        return Ok(());
    }
    Err(format!("reading ease below {EASE}; shorter sentences and words help: {}", hard.join(", ")))
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

/// The sentences of a chapter, without headings, tables, code, formulas and lists of sources.
fn prose(text: &str) -> String {
    let text = text.split("\n## Further reading").next().unwrap_or_default();
    let mut fenced = false;
    let mut paragraphs = vec![String::new()];
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
            continue;
        }
        let is_code = fenced || line.starts_with("    ");
        if is_code || line.starts_with(['#', '|', '<', '!']) || line.trim().is_empty() {
            paragraphs.push(String::new());
            continue;
        }
        let item = line.trim_start();
        let numbered = item.trim_start_matches(|c: char| c.is_ascii_digit()).strip_prefix(". ");
        let marked = item.strip_prefix("- ").or_else(|| item.strip_prefix("> ")).or(numbered);
        if marked.is_some() {
            paragraphs.push(String::new());
        }
        if let Some(last) = paragraphs.last_mut() {
            *last += marked.unwrap_or(item);
            last.push(' ');
        }
    }
    let whole = paragraphs.iter().map(|p| plain(p)).filter(|p| !p.is_empty());
    whole.fold(String::new(), |all, paragraph| {
        let ends = paragraph.ends_with(['.', '!', '?']);
        all + &paragraph + if ends { "\n" } else { ".\n" }
    })
}

/// A paragraph without marks: of links their words alone, and a word in the place of code.
fn plain(paragraph: &str) -> String {
    let mut text = String::new();
    for (i, part) in paragraph.split('`').enumerate() {
        text += if i % 2 == 0 { part } else { "code" };
    }
    let mut parts = text.split("](");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        out += part.split_once(')').map_or("", |(_, rest)| rest);
    }
    out.retain(|c| !['*', '[', ']'].contains(&c));
    without_points(out.trim())
}

/// A text whose numbers have no point or comma in them, which would end a sentence.
fn without_points(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let is_digit =
        |at: Option<usize>| at.and_then(|at| letters.get(at)).is_some_and(char::is_ascii_digit);
    let in_number = |at: usize| is_digit(at.checked_sub(1)) && is_digit(at.checked_add(1));
    let stays = |(at, c): &(usize, &char)| !(matches!(c, '.' | ',') && in_number(*at));
    letters.iter().enumerate().filter(stays).map(|(_, c)| *c).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_alone_are_measured() {
        let text = "# Title\n\nOne *sentence* of `some code` and [a link](x.md#y),\nin two lines.\n\n    x = 1\n\n\
                    | a | b |\n\n```\ncode\n```\n\n- an item of 1,234.5\n- another one,\n  longer\n1. first\n\n![p](p.png)\n\n\
                    ## Further reading\n\n- J. Clark, *Hierarchical Geometric Models*, 1976.\n";
        let lines = "One sentence of code and a link, in two lines.\nan item of 12345.\nanother one, longer.\nfirst.\n";
        assert_eq!(prose(text), lines);
    }
}
