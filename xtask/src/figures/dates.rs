//! Times depend on the machine: what the book says of them has a date and a machine beside it.

use std::fs;

use crate::tools::{Done, root};

/// How the line begins that every section with times in a table has; a date follows.
const MEASURED: &str = "Measured on ";

/// Every section of README and docs that has times in a table says when and on what they were
/// measured.
pub(crate) fn all_dated() -> Done {
    for (name, text) in pages()? {
        let mut bare = undated(&text);
        if let Some(section) = bare.next() {
            return Err(format!(
                "{name}: {section:?} has times in a table, and no line \"{MEASURED}DATE on a MACHINE\""
            ));
        }
    }
    Ok(())
}

/// The pages of the book, and the README, by their names.
fn pages() -> Result<Vec<(String, String)>, String> {
    let src = root().join("docs/src");
    let mut paths = vec![root().join("README.md")];
    let entries = fs::read_dir(&src).map_err(|e| format!("{}: {e}", src.display()))?;
    paths.extend(entries.flatten().map(|e| e.path()));
    paths.retain(|p| p.extension().is_some_and(|e| e == "md"));
    paths.sort();
    let read = |p: &std::path::PathBuf| {
        let text = fs::read_to_string(p).map_err(|e| format!("{}: {e}", p.display()))?;
        Ok((p.file_name().unwrap_or_default().to_string_lossy().into_owned(), text))
    };
    paths.iter().map(read).collect()
}

/// The headings of sections with times in a table and no date.
fn undated(text: &str) -> impl Iterator<Item = &str> {
    text.split("\n## ")
        .filter(|s| s.lines().any(is_timed) && !is_dated(s))
        .map(|s| s.lines().next().unwrap_or_default())
}

/// A row of a table with a unit of time in it.
fn is_timed(line: &str) -> bool {
    let words = || line.split(|c: char| !c.is_alphanumeric());
    line.starts_with('|') && words().any(|w| ["ns", "µs", "ms"].contains(&w))
}

/// A date as `2026-11-22` after the words, and a machine after that.
fn is_dated(section: &str) -> bool {
    section.split(MEASURED).skip(1).any(|rest| {
        let date: Vec<&str> = rest.get(..10).unwrap_or_default().split('-').collect();
        let digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
        date.len() == 3 && date.iter().all(|d| digits(d)) && rest[10..].starts_with(" on a")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_section_with_times_in_a_table_has_their_date_and_machine() {
        all_dated().unwrap();
    }

    #[test]
    fn times_without_a_date_are_found() {
        let table = "| what | time |\n|---|---|\n| a test | 3 ns |\n";
        let of = |text: &str| undated(text).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(of(&format!("# A\n\n## Fast\n\n{table}")), ["Fast"]);
        assert_eq!(of(&format!("# A\n\n## Fast\n\nMeasured soon.\n\n{table}")), ["Fast"]);
        let dated =
            format!("# A\n\n## Fast\n\nMeasured on 2026-11-21 on a two-core machine:\n\n{table}");
        assert!(of(&dated).is_empty());
        assert!(of("# A\n\n## Fast\n\nA test takes 3 ns.\n").is_empty());
    }

    #[test]
    fn no_page_links_to_the_readers_own_machine() {
        for (name, text) in pages().unwrap() {
            for place in ["127.0.0.1", "localhost"] {
                for link in [format!("](http://{place}"), format!("=\"http://{place}")] {
                    assert!(!text.contains(&link), "{name}: {link}");
                }
            }
            assert!(!text.contains("<iframe"), "{name} has a frame");
        }
    }
}
