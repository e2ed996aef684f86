//! The items as a page of the book.

use std::fmt::Write;

use crate::lecture::{Item, Outcome, Text};

use super::record::{Checked, Record, places, word};

const HEAD: &str = "\
# The lectures, item by item

Three lectures and a paper are what this project set out to make real. Each thing that they say or show is an item here: what is claimed, in words of our own; what
is measured of it on a machine with two cores; and where a text errs, what is right. `cullet lecture NUMBER` measures one on yours and says how to see it,
`cullet lecture --check` all. **[As slides](viewer/lectures.html)**, each beside its live scene or its chapter. This page is written by `cullet lecture --check --page docs/src/lectures.md`, and a test holds every outcome.

";

/// The page.
pub(super) fn page(record: &Record) -> String {
    let mut page = HEAD.to_owned();
    for text in Text::ALL {
        let _ = writeln!(page, "- **{}**: {}.", text.name(), text.reference());
    }
    let _ = writeln!(page, "\n| | item | where | chapter | here |\n|---|---|---|---|---|");
    for Checked { item, found, .. } in &record.items {
        let chapter = item.chapter.split_once('#').map_or(item.chapter, |(file, _)| file);
        let outcome = found.as_ref().map_or("", |f| word(&f.outcome));
        let _ = writeln!(
            page,
            "| [{n}](#{}) | {} | {} | [{}]({}) | {outcome} |",
            anchor(&heading(item)),
            cell(item.title),
            cell(&places(item.places)),
            chapter.trim_end_matches(".md"),
            item.chapter,
            n = item.number
        );
    }
    page.push('\n');
    for Checked { item, found, .. } in &record.items {
        let _ = writeln!(page, "### {}\n\n{}\n", heading(item), item.claim);
        if let Some(said) = item.said {
            let _ = writeln!(page, "The text: {said}.\n");
        }
        match found.as_ref().map(|f| (&f.outcome, &f.measured)) {
            Some((Outcome::NotHere(missing), _)) => {
                let _ = writeln!(page, "Not tried here: {missing}.\n");
            }
            Some((_, measured)) => {
                let _ = writeln!(page, "*Here: {measured}.*\n");
            }
            None => {}
        }
        if let Some(fault) = item.fault {
            let _ = writeln!(page, "**The text errs.** {fault}\n");
        }
        let _ = write!(page, "`{}`", item.command);
        if let Some(live) = item.live {
            let _ =
                write!(page, " · [live](viewer/index.html#scene={}&{})", live.scene, live.state);
        }
        let _ = writeln!(page, " · [chapter]({})\n", item.chapter);
    }
    page
}

fn heading(item: &Item) -> String {
    format!("{}. {}", item.number, item.title)
}

/// The name by which a heading can be linked to, as mdBook makes it.
fn anchor(heading: &str) -> String {
    let keep = |c: char| match c {
        c if c.is_alphanumeric() || matches!(c, '_' | '-') => Some(c.to_ascii_lowercase()),
        c if c.is_whitespace() => Some('-'),
        _ => None,
    };
    heading.chars().filter_map(keep).collect()
}

/// Text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
