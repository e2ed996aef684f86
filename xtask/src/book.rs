//! The book: its chapters checked, built without a warning or a dead link, and published with the
//! viewer's page in it, where its chapters link to.

mod built;
mod parts;
mod published;
mod svg;
mod words;

use std::fs;
use std::path::{Path, PathBuf};

use crate::links;
use crate::pictures;
use crate::runner::{End, Ended, Skip};
use crate::tools::{Done, cargo_install_words, command, has_program, output, root};
use crate::web;

pub(crate) use published::test as published;

/// Where the page lies in the book; chapters link to states of it.
const PAGE: &str = "viewer";
/// The program that builds the book.
const PACKAGE: &str = "mdbook";

/// Where the book is built.
fn folder() -> PathBuf {
    root().join("docs/book")
}

/// The step of `test`: what can be read in the chapters, then the book as it is built of them.
pub(crate) fn test() -> Ended {
    pictures::all_there()?;
    svg::all_sound()?;
    links::all_alive()?;
    parts::all_in_order()?;
    let mut skips: Vec<Skip> = words::check()?.into_iter().collect();
    if has_mdbook()? {
        run_mdbook()?;
        built::all_alive(&folder())?;
    } else {
        skips.push(Skip::new("the book, built", cargo_install_words(PACKAGE)));
    }
    Ok(if skips.is_empty() { End::Passed } else { End::Partly(skips) })
}

/// Builds the page, then the book, then puts the one into the other.
pub(crate) fn build() -> Done {
    if output(PACKAGE, &["--version"]).is_none() {
        return Err(format!("needed: {}", cargo_install_words(PACKAGE)));
    }
    web::build()?;
    let book = put_together()?;
    println!("{}: publish it as it is; any server of plain files does", book.display());
    Ok(())
}

/// The book with the page that was built in it, every link of it looked at.
fn put_together() -> Result<PathBuf, String> {
    run_mdbook()?;
    let book = folder();
    copy(&web::page(), &book.join(PAGE))?;
    built::all_alive(&book)?;
    Ok(book)
}

/// Without its server and its search, which take half of its dependencies.
fn has_mdbook() -> Result<bool, String> {
    has_program(PACKAGE, &["--no-default-features"])
}

/// Builds the book; what mdBook warns of is an error.
fn run_mdbook() -> Done {
    let mut build = command(PACKAGE, &["build", "docs"]);
    // It has to say what it sees, in plain letters.
    build.env_remove("RUST_LOG").env_remove("MDBOOK_LOG").env("NO_COLOR", "1");
    println!("$ mdbook build docs");
    let out = build.output().map_err(|e| format!("mdbook: {e}"))?;
    let said = [out.stdout, out.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    print!("{said}");
    if !out.status.success() {
        return Err(format!("mdbook build docs: {}", out.status));
    }
    let warnings = warnings(&said);
    if warnings.is_empty() { Ok(()) } else { Err(warnings.join("\n       ")) }
}

/// The lines in which mdBook warns: its level stands first in them, or after a date and a time.
fn warnings(said: &str) -> Vec<&str> {
    let is_level = |word: &str| matches!(word.trim_matches(['[', ']']), "WARN" | "ERROR");
    let dated = |line: &str| line.starts_with(|c: char| c.is_ascii_digit());
    let warns = |line: &&str| {
        let skipped = if dated(line) { 2 } else { 0 };
        line.split_whitespace().nth(skipped).is_some_and(is_level)
    };
    said.lines().filter(warns).collect()
}

/// Copies the files of a folder that has no others in it.
fn copy(from: &Path, to: &Path) -> Done {
    let fail = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    fs::create_dir_all(to).map_err(|e| fail(to, e))?;
    for entry in fs::read_dir(from).map_err(|e| fail(from, e))?.flatten() {
        let path = entry.path();
        fs::copy(&path, to.join(entry.file_name())).map_err(|e| fail(&path, e))?;
    }
    Ok(())
}

/// The chapters: their files' names and texts, in the order of their names.
fn chapters() -> Result<Vec<(String, String)>, String> {
    let src = root().join("docs/src");
    let fail = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let mut chapters = Vec::new();
    for path in fs::read_dir(&src).map_err(|e| fail(&src, e))?.flatten().map(|e| e.path()) {
        if path.extension().is_some_and(|e| e == "md") {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            chapters.push((name, fs::read_to_string(&path).map_err(|e| fail(&path, e))?));
        }
    }
    chapters.sort();
    Ok(chapters)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_mdbook_warns_of_is_found_in_old_and_new_words() {
        let said = " INFO Book building has started\n WARN unexpected HTML end tag `</b>`\n\
                    2026-11-26 10:00:00 [ERROR] (mdbook): no such file\n INFO of WARN and ERROR\n";
        let found = warnings(said);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains("</b>") && found[1].contains("no such file"));
    }
}
