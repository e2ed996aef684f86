//! The states of the page that the book shows.

use std::fs;
use std::path::Path;

use cullet_viewer::link::from_text;
use cullet_viewer::world::{Source, World};

/// Where `cullet serve` and `cargo xtask web` put the page if nobody says otherwise.
const PAGE: &str = "http://127.0.0.1:8080/#";

/// The chapter and the state of each address of the page in the book.
fn states() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src");
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).expect("the book is part of the source").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if !name.ends_with(".md") {
            continue;
        }
        let text = fs::read_to_string(entry.path()).expect("a chapter is text");
        for rest in text.split(PAGE).skip(1) {
            let end = rest.find(|c: char| c.is_whitespace() || ")\"`>".contains(c));
            // In HTML an address has its ampersands written out.
            let state = rest[..end.unwrap_or(rest.len())].replace("&amp;", "&");
            all.push((name.clone(), state));
        }
    }
    all
}

#[test]
fn every_state_that_the_book_shows_opens() {
    let states = states();
    for (chapter, text) in &states {
        let state = from_text(text).unwrap_or_else(|e| panic!("{chapter}: {text}: {e}"));
        let source = Source::of_text(&state.scene);
        assert!(matches!(source, Source::Builtin(_)), "{chapter}: {} is a file", state.scene);
        World::load(&source).unwrap_or_else(|e| panic!("{chapter}: {text}: {e}"));
    }
    for chapter in ["backface.md", "clipping.md", "frustum.md", "hierarchy.md", "occlusion.md"] {
        let of: Vec<&str> =
            states.iter().filter(|(c, _)| c == chapter).map(|(_, s)| s.as_str()).collect();
        // Once as a link and once as a frame: readers of one must not miss what the other shows.
        assert!(of.len() == 2 && of[0] == of[1], "{chapter} shows {of:?}");
    }
}
