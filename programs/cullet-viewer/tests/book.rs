//! The states of the page that the book shows.

use std::fs;
use std::path::Path;

use cullet_viewer::link::from_text;
use cullet_viewer::world::{Source, World};

/// Where `cargo xtask book` puts the page, beside the chapters.
const PAGE: &str = "viewer/index.html#";
/// How a chapter opens the same in a window.
const COMMAND: &str = "cullet view ";

/// A picture of the page in a chapter.
#[derive(Default)]
struct Shown {
    chapter: String,
    /// States behind links to the page.
    links: Vec<String>,
    /// The same of commands: the scene, and what `--state` says.
    commands: Vec<String>,
}

/// Pictures of the page in the chapters of the book.
fn chapters() -> Vec<Shown> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src");
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).expect("the book is part of the source").flatten() {
        let chapter = entry.file_name().to_string_lossy().into_owned();
        if !chapter.ends_with(".md") {
            continue;
        }
        let text = fs::read_to_string(entry.path()).expect("a chapter is text");
        let mut shown = Shown { chapter, ..Shown::default() };
        for rest in text.split(PAGE).skip(1) {
            shown.links.extend(rest.split(')').next().map(str::to_owned));
        }
        for line in text.lines().filter_map(|l| l.strip_prefix(COMMAND)) {
            if let Some((scene, state)) = line.split_once(" --state ") {
                shown.commands.push(format!("scene={scene}&{}", state.trim_matches('\'')));
            }
        }
        all.push(shown);
    }
    all
}

#[test]
fn every_state_that_the_book_shows_opens() {
    let chapters = chapters();
    for Shown { chapter, links, .. } in &chapters {
        for text in links {
            let state = from_text(text).unwrap_or_else(|e| panic!("{chapter}: {text}: {e}"));
            let source = Source::of_text(&state.scene);
            assert!(matches!(source, Source::Builtin(_)), "{chapter}: {} is a file", state.scene);
            World::load(&source).unwrap_or_else(|e| panic!("{chapter}: {text}: {e}"));
        }
    }
    for name in ["backface.md", "clipping.md", "frustum.md", "hierarchy.md", "occlusion.md"] {
        let of = chapters.iter().find(|c| c.chapter == name).expect("it is a chapter");
        // Once as a link and once as a command: where one does nothing the other must show the
        // same.
        assert!(of.links.len() == 1 && of.links == of.commands, "{name} shows {:?}", of.links);
    }
}
