//! Links of the book: each leads to a chapter, a heading or a file that is there.
//!
//! mdBook builds a page whose links are dead without a word. This reads the chapters themselves, so
//! it needs no mdBook.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::tools::{Done, root};

/// The chapters, from the root.
const SRC: &str = "docs/src";
/// Where the viewer's page lies in a published book: [`book`](crate::book) puts it there.
const VIEWER: &str = "viewer/";

/// Every link of a chapter, and of README into the book, leads somewhere, and every chapter is in
/// the summary.
pub(crate) fn all_alive() -> Done {
    let src = root().join(SRC);
    let mut pages = BTreeMap::new();
    let entries = fs::read_dir(&src).map_err(|e| format!("{}: {e}", src.display()))?;
    for path in entries.flatten().map(|e| e.path()) {
        if path.extension().is_some_and(|e| e == "md") {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            pages.insert(name, read(&path)?);
        }
    }
    let readme = read(&root().join("README.md"))?;
    let mut wrong = unlisted(&pages);
    for (name, text) in &pages {
        wrong.extend(dead(name, text, &pages, &src));
    }
    let into_book = links(&readme).filter_map(|l| l.strip_prefix("docs/src/"));
    wrong.extend(into_book.filter_map(|l| dead_link("README.md", l, &pages, &src)));
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n       ")) }
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// Chapters that the summary does not name: mdBook leaves them out.
fn unlisted(pages: &BTreeMap<String, String>) -> Vec<String> {
    let Some(summary) = pages.get("SUMMARY.md") else {
        return vec!["there is no SUMMARY.md".into()];
    };
    let listed: BTreeSet<&str> = links(summary).collect();
    let names = pages.keys().filter(|n| *n != "SUMMARY.md" && !listed.contains(n.as_str()));
    names.map(|n| format!("{n} is not in SUMMARY.md")).collect()
}

fn dead<'a>(
    name: &'a str,
    text: &'a str,
    pages: &'a BTreeMap<String, String>,
    src: &'a Path,
) -> impl Iterator<Item = String> + 'a {
    links(text).filter_map(move |link| dead_link(name, link, pages, src))
}

/// Returns the fault of a link of a page; `None` where nothing is wrong, or it leads out of the
/// book.
fn dead_link(
    page: &str,
    link: &str,
    pages: &BTreeMap<String, String>,
    src: &Path,
) -> Option<String> {
    let out = link.contains("://") || link.starts_with("mailto:") || link.starts_with(VIEWER);
    if out {
        return None;
    }
    let (file, anchor) = link.split_once('#').map_or((link, None), |(f, a)| (f, Some(a)));
    let file = if file.is_empty() { page } else { file };
    let Some(text) = pages.get(file) else {
        let there = src.join(file).is_file();
        return (!there).then(|| format!("{page} links to {link}, and {file} is not there"));
    };
    let anchor = anchor?;
    let is_there = anchors(text).contains(anchor);
    (!is_there).then(|| format!("{page} links to {link}, and {file} has no such heading"))
}

/// Targets of the links and pictures of a text that are not in a block of code.
fn links(text: &str) -> impl Iterator<Item = &str> {
    prose(text)
        .flat_map(|line| line.split("](").skip(1).filter_map(|rest| rest.split([')', ' ']).next()))
}

/// The lines outside fences.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    })
}

/// The names by which a chapter's headings can be linked to, as mdBook makes them: letters, digits,
/// `_` and `-` stay, white space becomes `-`, all else goes; the second of equal ones gets `-1`,
/// and so on.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut used: BTreeMap<String, usize> = BTreeMap::new();
    let heading =
        |line: &str| line.starts_with('#').then(|| without_links(line.trim_start_matches('#')));
    let names = prose(text).filter_map(heading).map(|words| {
        let keep = |c: char| match c {
            c if c.is_alphanumeric() || c == '_' || c == '-' => Some(c.to_ascii_lowercase()),
            c if c.is_whitespace() => Some('-'),
            _ => None,
        };
        words.trim().chars().filter_map(keep).collect::<String>()
    });
    let mut all = BTreeSet::new();
    for name in names {
        let count = used.entry(name.clone()).or_default();
        all.insert(if *count == 0 { name } else { format!("{name}-{count}") });
        *count += 1;
    }
    all
}

/// A heading's words, of links in it the text alone.
fn without_links(words: &str) -> String {
    let mut parts = words.split("](");
    let mut text = parts.next().unwrap_or_default().replace('[', "");
    for part in parts {
        text += &part.split_once(')').map_or("", |(_, rest)| rest).replace('[', "");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_link_of_the_book_leads_somewhere() {
        all_alive().unwrap();
    }

    #[test]
    fn headings_are_named_as_mdbook_names_them() {
        let text = "# A title\n\n## The trap of w ≤ 0\n\n## `verify`, twice\n\n## Equal\n\n## Equal\n\n\
                    ```\n# a comment\n```\n\n### Of [a link](x.md) too\n";
        let has: Vec<String> = anchors(text).into_iter().collect();
        let expected =
            ["a-title", "equal", "equal-1", "of-a-link-too", "the-trap-of-w--0", "verify-twice"];
        assert_eq!(has, expected);
    }

    #[test]
    fn dead_links_are_found() {
        let a =
            "# A\n\n[b](b.md), [there](b.md#there), ![p](no.png) [self](#a) [out](https://x.org)\n";
        let pages: BTreeMap<String, String> =
            [("a.md", a), ("b.md", "# B\n"), ("SUMMARY.md", "- [A](a.md)\n")]
                .map(|(n, t)| (n.into(), t.into()))
                .into();
        let found: Vec<String> = dead("a.md", a, &pages, Path::new("/nowhere")).collect();
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains("b.md#there") && found[1].contains("no.png"));
        assert_eq!(unlisted(&pages), ["b.md is not in SUMMARY.md"]);
    }
}
