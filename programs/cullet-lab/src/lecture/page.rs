//! The items as a page of the book.

use std::fmt::Write;

use super::{Item, lectures};

const HEAD: &str = "\
# The lectures, item by item

Three lectures and a paper are what this project set out to make real. Each thing that they say or show is an item here: what is claimed, in words of our own; what
is measured of it; and where a text errs, what is right. `cullet lecture NUMBER` shows one, measures it on your machine or names the test that shows it, and says how to see it;
`cullet lecture --check` does so with all. **[As slides](viewer/lectures.html)**, each beside its live scene or its chapter. The items are in `docs/lectures.json`, of which
`cullet lecture --page docs/src/lectures.md` writes this page; tests hold its figures.

";

/// The page, which depends on nothing but `docs/lectures.json`.
#[must_use]
pub fn page() -> String {
    let mut page = HEAD.to_owned();
    for text in &lectures().texts {
        let _ = writeln!(page, "- **{}**: {}.", text.name, text.about);
    }
    let _ = writeln!(page, "\n| | item | where | chapter | here |\n|---|---|---|---|---|");
    for item in &lectures().items {
        let chapter = item.chapter.split_once('#').map_or(&*item.chapter, |(file, _)| file);
        let _ = writeln!(
            page,
            "| [{n}](#{}) | {} | {} | [{}]({}) | {} |",
            anchor(&heading(item)),
            cell(&item.title),
            cell(&item.stands()),
            chapter.trim_end_matches(".md"),
            item.chapter,
            item.outcome().word(),
            n = item.number
        );
    }
    page.push('\n');
    for item in &lectures().items {
        let _ = writeln!(page, "### {}\n\n{}\n", heading(item), item.claim);
        if let Some(said) = &item.said {
            let _ = writeln!(page, "The text: {said}.\n");
        }
        let _ = writeln!(page, "*Here: {}.*\n", item.told());
        if let Some(fault) = &item.fault {
            let _ = writeln!(page, "**The text errs.** {fault}\n");
        }
        let _ = write!(page, "`{}`", item.command);
        if let Some(live) = &item.live {
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
