//! Links of a page of HTML, and the places in it that can be linked to: its tags, read one after
//! another.

use std::collections::BTreeSet;

/// Links and places of a page.
#[derive(Debug, Default)]
pub(super) struct Html {
    /// Names that a link may have after `#`.
    pub(super) ids: BTreeSet<String>,
    /// Addresses that it links to, shows or runs.
    pub(super) links: Vec<String>,
}

/// Attributes whose value is an address.
const ADDRESSES: [&str; 4] = ["href", "src", "data", "poster"];
/// Tags in which nothing is a tag but their own end.
const RAW: [&str; 4] = ["script", "style", "textarea", "title"];

impl Html {
    /// Reads a page; an error says what of it cannot be read, or makes it depend on where it lies.
    pub(super) fn read(text: &str) -> Result<Self, String> {
        let mut page = Self::default();
        let mut rest = text;
        while let Some(at) = rest.find('<') {
            rest = &rest[at..];
            if rest.starts_with("<!--") {
                rest = after(rest, "-->").ok_or("a comment has no end")?;
            } else if rest[1..].starts_with(|c: char| c.is_ascii_alphabetic()) {
                let (name, tail) = page.tag(rest)?;
                rest = tail;
                if RAW.contains(&name.as_str()) {
                    let end = find_end(rest, &name).ok_or(format!("{name} has no end"))?;
                    rest = &rest[end..];
                }
            } else if rest[1..].starts_with(['/', '!', '?']) {
                rest = after(rest, ">").ok_or("a tag has no end")?;
            } else {
                rest = &rest[1..];
            }
        }
        Ok(page)
    }

    /// Reads a tag that begins here; returns its name, in small letters, and what follows it.
    fn tag<'a>(&mut self, text: &'a str) -> Result<(String, &'a str), String> {
        let ends_name = |c: char| c.is_whitespace() || c == '/' || c == '>';
        let (name, mut rest) = cut(&text[1..], ends_name);
        let name = name.to_ascii_lowercase();
        loop {
            rest = rest.trim_start_matches(|c: char| c.is_whitespace() || c == '/');
            if let Some(tail) = rest.strip_prefix('>') {
                return Ok((name, tail));
            }
            let (attribute, tail) = cut(rest, |c| ends_name(c) || c == '=');
            if attribute.is_empty() {
                return Err(format!("cannot be read: <{name} {}", first_words(rest)));
            }
            let mut value = "";
            rest = tail.trim_start();
            if let Some(tail) = rest.strip_prefix('=') {
                (value, rest) = self::value(tail.trim_start())
                    .ok_or_else(|| format!("a value has no end: <{name} {attribute}"))?;
            }
            self.take(&name, &attribute.to_ascii_lowercase(), &entities(value))?;
        }
    }

    fn take(&mut self, tag: &str, attribute: &str, value: &str) -> Result<(), String> {
        if tag == "base" {
            return Err("a base makes its links depend on where it lies".into());
        }
        if attribute == "id" || (tag == "a" && attribute == "name") {
            let is_new = self.ids.insert(value.to_owned());
            if !is_new && attribute == "id" {
                return Err(format!("two places are called {value}"));
            }
        }
        if ADDRESSES.contains(&attribute) {
            self.links.push(value.trim().to_owned());
        }
        if attribute == "srcset" {
            let first = |one: &str| one.split_whitespace().next().map(str::to_owned);
            self.links.extend(value.split(',').filter_map(first));
        }
        Ok(())
    }
}

/// Splits the text before the first character that `ends` it.
fn cut(text: &str, ends: impl Fn(char) -> bool) -> (&str, &str) {
    text.split_at(text.find(ends).unwrap_or(text.len()))
}

fn after<'a>(text: &'a str, end: &str) -> Option<&'a str> {
    text.find(end).map(|at| &text[at + end.len()..])
}

/// A value in quotes or without, and what follows it.
fn value(text: &str) -> Option<(&str, &str)> {
    match text.chars().next()? {
        quote @ ('"' | '\'') => text[1..].split_once(quote),
        _ => Some(cut(text, |c| c.is_whitespace() || c == '>')),
    }
}

/// Where the end of a tag begins.
fn find_end(text: &str, name: &str) -> Option<usize> {
    let ends = |at: &(usize, &str)| {
        let found = text.as_bytes().get(at.0 + 2..at.0 + 2 + name.len());
        found.is_some_and(|found| found.eq_ignore_ascii_case(name.as_bytes()))
    };
    text.match_indices("</").find(ends).map(|(at, _)| at)
}

fn first_words(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Turns `&amp;` and the like into what they stand for; what is none stays.
fn entities(text: &str) -> String {
    let mut parts = text.split('&');
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let entity = part.split_once(';').and_then(|(name, rest)| Some((entity(name)?, rest)));
        match entity {
            Some((c, rest)) => {
                out.push(c);
                out += rest;
            }
            None => {
                out.push('&');
                out += part;
            }
        }
    }
    out
}

fn entity(name: &str) -> Option<char> {
    let number =
        |digits: &str, base| u32::from_str_radix(digits, base).ok().and_then(char::from_u32);
    match name {
        "amp" => Some('&'),
        "lt" => Some('<'),
        "gt" => Some('>'),
        "quot" => Some('"'),
        "apos" => Some('\''),
        _ => match name.strip_prefix("#x").or_else(|| name.strip_prefix("#X")) {
            Some(digits) => number(digits, 16),
            None => number(name.strip_prefix('#')?, 10),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_and_places_are_read_however_they_are_written() {
        let text = r##"<!DOCTYPE html><!-- <a href="no"> --><IMG SRC='a.png' alt="1 > 0"/><a  id = x href=b.html>b</a>
            <script>const s = "<a href='no'>";</script><style>a > b {}</style><p>1 < 2 &amp; 3 </p>
            <a href="c.html?a=1&amp;b=&#x27;&#39;&no;#d" name="y">c</a><input disabled><img srcset="1.png 1x, 2.png 2x">"##;
        let page = Html::read(text).unwrap();
        assert_eq!(page.links, ["a.png", "b.html", "c.html?a=1&b=''&no;#d", "1.png", "2.png"]);
        assert_eq!(page.ids.iter().map(String::as_str).collect::<Vec<_>>(), ["x", "y"]);
    }

    #[test]
    fn what_cannot_be_read_is_told() {
        for (text, why) in [
            ("<a href=\"x>", "a value has no end"),
            ("<!-- x", "a comment has no end"),
            ("<script>", "script has no end"),
            ("<a href=x", "cannot be read"),
            ("</a", "a tag has no end"),
            ("<base href=\"/\">", "depend on where it lies"),
            ("<p id=a></p><p id=a></p>", "two places are called a"),
        ] {
            let error = Html::read(text).unwrap_err();
            assert!(error.contains(why), "{text}: {error}");
        }
    }
}
