//! Drawings of the book: every SVG is well-formed and says in words what it shows, and so does
//! every picture of a chapter.

use std::fs;

use roxmltree::Document;

use super::chapters;
use crate::tools::{Done, root};

/// Where pictures lie, from the root.
const FOLDER: &str = "docs/src/pictures";
const SVG: &str = "http://www.w3.org/2000/svg";

/// Every SVG can be read and has a title, and every picture that a chapter shows has words in its
/// place.
pub(super) fn all_sound() -> Done {
    let folder = root().join(FOLDER);
    let mut wrong = Vec::new();
    for path in fs::read_dir(&folder).map_err(|e| format!("{FOLDER}: {e}"))?.flatten() {
        let path = path.path();
        if path.extension().is_some_and(|e| e == "svg") {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let text = fs::read_to_string(&path).map_err(|e| format!("{FOLDER}/{name}: {e}"))?;
            wrong.extend(fault(&text).map(|why| format!("{FOLDER}/{name}: {why}")));
        }
    }
    for (name, text) in chapters()? {
        wrong.extend(speechless(&text).into_iter().map(|what| format!("{name}: {what}")));
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n       ")) }
}

/// Returns the fault of a drawing.
fn fault(text: &str) -> Option<String> {
    let document = match Document::parse(text) {
        Ok(document) => document,
        Err(why) => return Some(why.to_string()),
    };
    let svg = document.root_element();
    if !svg.has_tag_name((SVG, "svg")) {
        return Some(format!(
            "it is no <svg>, or lacks xmlns=\"{SVG}\", without which no browser shows it"
        ));
    }
    let is_told = svg.descendants().any(|node| node.has_tag_name((SVG, "title")))
        || svg.attribute("aria-label").is_some_and(|words| !words.is_empty());
    (!is_told).then(|| "it has neither a <title> nor an aria-label".into())
}

/// Pictures of a chapter that have no words for who does not see them.
fn speechless(text: &str) -> Vec<String> {
    let plain = text.match_indices("![](").map(|(at, _)| {
        let file = text[at + 4..].split(')').next().unwrap_or_default();
        format!("{file} has no words in its place")
    });
    let drawn = text.split("<svg").skip(1).filter_map(|rest| {
        let tag = rest.split('>').next().unwrap_or_default();
        let is_told = tag.contains("role=\"img\"") && tag.contains("aria-label=\"");
        (!is_told).then(|| format!("<svg{tag}> has no role=\"img\" or no aria-label"))
    });
    plain.chain(drawn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_drawing_of_the_book_is_sound() {
        all_sound().unwrap();
    }

    #[test]
    fn drawings_that_no_browser_shows_are_told() {
        let svg =
            |inside: &str| format!("<svg xmlns=\"http://www.w3.org/2000/svg\">{inside}</svg>");
        let title = "<title>t</title>";
        assert_eq!(
            fault(&svg(&format!("<!-- <a> -->{title}<g><path d='M0 0'/>&#8804; &amp;</g>"))),
            None
        );
        for inside in ["<g>", "<g/></svg><g>", "<p x=1/>", "<p x='1' x='2'/>", "&nbsp;", "a & b"] {
            assert!(fault(&svg(&format!("{title}{inside}"))).is_some(), "{inside}");
        }
        assert!(fault(&svg("")).is_some_and(|why| why.contains("neither")));
        assert!(fault("<svg><title>t</title></svg>").is_some_and(|why| why.contains("xmlns")));
        assert!(fault("<html></html>").is_some());
    }

    #[test]
    fn pictures_without_words_are_told() {
        let text = "![](a.png) ![b](b.png) <svg viewBox=\"0\"><svg role=\"img\" aria-label=\"c\">";
        assert_eq!(speechless(text).len(), 2);
    }
}
