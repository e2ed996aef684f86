//! Drawings of the book: every SVG is well-formed and says in words what it shows, and so does every picture of a chapter.

use std::fs;

use super::chapters;
use crate::tools::{Done, root};

/// Where pictures lie, from the root.
const FOLDER: &str = "docs/src/pictures";

/// Every SVG can be read and has a title, and every picture that a chapter shows has words in its place.
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

/// What is wrong with a drawing.
fn fault(text: &str) -> Option<String> {
    let tags = match read(text) {
        Ok(tags) => tags,
        Err(why) => return Some(why),
    };
    let Some(Tag { name: "svg", attributes }) = tags.first() else {
        return Some("it is no <svg>".into());
    };
    if !attributes.contains(&("xmlns", "http://www.w3.org/2000/svg")) {
        return Some("without xmlns no browser shows it".into());
    }
    let is_told = tags.iter().any(|t| t.name == "title")
        || attributes.iter().any(|(name, value)| *name == "aria-label" && !value.is_empty());
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

/// A tag that begins something.
struct Tag<'a> {
    name: &'a str,
    attributes: Vec<(&'a str, &'a str)>,
}

/// Reads XML as far as drawings need it; an error says why it is not well-formed.
fn read(text: &str) -> Result<Vec<Tag<'_>>, String> {
    let mut open = Vec::new();
    let mut tags = Vec::new();
    let mut rest = text.trim();
    if rest.starts_with("<?") {
        rest = rest.split_once("?>").ok_or("its first line has no end")?.1.trim_start();
    }
    loop {
        let (between, tail) = rest.split_at(rest.find('<').unwrap_or(rest.len()));
        entities_sound(between)?;
        if open.is_empty() && !between.trim().is_empty() {
            return Err(format!("text outside of it: {}", between.trim()));
        }
        if tail.is_empty() {
            break;
        }
        if let Some(comment) = tail.strip_prefix("<!--") {
            rest = comment.split_once("-->").ok_or("a comment has no end")?.1;
            continue;
        }
        let (inside, after) = tail[1..].split_once('>').ok_or("a tag has no end")?;
        rest = after;
        if let Some(name) = inside.strip_prefix('/') {
            let name = name.trim();
            match open.pop() {
                Some(last) if last == name => {}
                Some(last) => return Err(format!("<{last}> is ended by </{name}>")),
                None => return Err(format!("</{name}> ends nothing")),
            }
            continue;
        }
        let is_whole = inside.ends_with('/');
        let tag = tag(inside.trim_end_matches('/'))?;
        if open.is_empty() && !tags.is_empty() {
            return Err(format!("<{}> stands beside the first tag", tag.name));
        }
        if !is_whole {
            open.push(tag.name);
        }
        tags.push(tag);
    }
    match open.pop() {
        Some(name) => Err(format!("<{name}> has no end")),
        None => Ok(tags),
    }
}

fn tag(inside: &str) -> Result<Tag<'_>, String> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || "-_:.".contains(c);
    let (name, mut rest) = inside.split_at(inside.find(|c| !is_name(c)).unwrap_or(inside.len()));
    let wrong = || format!("cannot be read: <{inside}>");
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        return Err(wrong());
    }
    let mut attributes: Vec<(&str, &str)> = Vec::new();
    while !rest.trim().is_empty() {
        if !rest.starts_with(char::is_whitespace) {
            return Err(wrong());
        }
        let (key, tail) = rest.trim_start().split_once('=').ok_or_else(wrong)?;
        let quote = tail.chars().next().filter(|c| matches!(c, '"' | '\'')).ok_or_else(wrong)?;
        let (value, tail) = tail[1..].split_once(quote).ok_or_else(wrong)?;
        if key.is_empty() || !key.chars().all(is_name) || value.contains('<') {
            return Err(wrong());
        }
        if attributes.iter().any(|(known, _)| *known == key) {
            return Err(format!("{key} is there twice: <{inside}>"));
        }
        entities_sound(value)?;
        attributes.push((key, value));
        rest = tail;
    }
    Ok(Tag { name, attributes })
}

/// XML knows five names of characters, and numbers.
fn entities_sound(text: &str) -> Done {
    for part in text.split('&').skip(1) {
        let name = part.split_once(';').map_or("", |(name, _)| name);
        let is_number = name.strip_prefix('#').is_some_and(|n| {
            let digits = n.strip_prefix('x').map_or((n, 10), |hex| (hex, 16));
            u32::from_str_radix(digits.0, digits.1).is_ok()
        });
        if !is_number && !["amp", "lt", "gt", "quot", "apos"].contains(&name) {
            let shown: String = part.chars().take(12).collect();
            return Err(format!("&{shown} is no character of XML"));
        }
    }
    Ok(())
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
        for (inside, why) in [
            ("", "neither"),
            ("<g>", "is ended by"),
            ("<g/></svg><g>", "beside the first"),
            ("<p x=1/>", "cannot be read"),
            ("<p x='1' x='2'/>", "twice"),
            ("<p x='1'y='2'/>", "cannot be read"),
            ("&nbsp;", "no character"),
            ("a & b", "no character"),
        ] {
            let found = fault(&svg(inside)).unwrap_or_default();
            assert!(found.contains(why), "{inside}: {found}");
        }
        assert!(fault("<svg><title>t</title></svg>").is_some_and(|why| why.contains("xmlns")));
        assert!(fault("<html></html>").is_some());
    }

    #[test]
    fn pictures_without_words_are_told() {
        let text = "![](a.png) ![b](b.png) <svg viewBox=\"0\"><svg role=\"img\" aria-label=\"c\">";
        assert_eq!(speechless(text).len(), 2);
    }
}
