//! Links of the book as it was built: each leads to a file that is there, and to a place in it that
//! is there.
//!
//! A page must open under any path of a host, and from the file system: no link begins at a host's
//! root, and none leads to a folder, which only a server turns into a page.

mod html;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::PAGE;
use crate::tools::Done;
use html::Html;

/// Files of a site, by their paths from its root; of a page of HTML with what it has.
type Site = BTreeMap<String, Option<Html>>;

/// Every link of every page in a folder leads somewhere; those to the viewer's page only have to
/// where it lies there.
pub(super) fn all_alive(folder: &Path) -> Done {
    let mut site = Site::new();
    gather(folder, "", &mut site)?;
    let links: usize = site.values().flatten().map(|page| page.links.len()).sum();
    let wrong = dead(&site);
    if links == 0 {
        return Err(format!("{}: there is no link in it", folder.display()));
    }
    println!("{links} links in {} pages", site.values().flatten().count());
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n       ")) }
}

fn gather(folder: &Path, prefix: &str, site: &mut Site) -> Done {
    let fail = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    for entry in fs::read_dir(folder).map_err(|e| fail(folder, e))?.flatten() {
        let path = entry.path();
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if path.is_dir() {
            gather(&path, &format!("{name}/"), site)?;
            continue;
        }
        let html = match path.extension().is_some_and(|e| e == "html") {
            true => {
                let text = fs::read_to_string(&path).map_err(|e| fail(&path, e))?;
                Some(Html::read(&text).map_err(|why| format!("{name}: {why}"))?)
            }
            false => None,
        };
        site.insert(name, html);
    }
    Ok(())
}

/// Returns the faults of a site's links, a line each.
fn dead(site: &Site) -> Vec<String> {
    let pages = site.iter().filter_map(|(name, page)| Some((name, page.as_ref()?)));
    pages
        .flat_map(|(name, page)| page.links.iter().map(move |link| (name, link)))
        .filter_map(|(name, link)| {
            let why = dead_link(site, name, link)?;
            Some(format!("{name} links to {link}: {why}"))
        })
        .collect()
}

/// Why a link of a page is wrong.
fn dead_link(site: &Site, page: &str, link: &str) -> Option<String> {
    if let Some((scheme, rest)) = scheme(link) {
        return external(scheme, rest);
    }
    let (path, fragment) = link.split_once('#').map_or((link, None), |(p, f)| (p, Some(f)));
    let path = path.split('?').next().unwrap_or_default();
    if path.starts_with('/') {
        return Some("it begins at the root of a host".into());
    }
    let target = if path.is_empty() {
        page.to_owned()
    } else {
        match resolve(page, &decode(path)) {
            Some(target) => target,
            None => return Some("it leads out of the book".into()),
        }
    };
    let inside = target.strip_prefix(PAGE).is_some_and(|rest| rest.starts_with('/'));
    let has_page = site.keys().any(|name| name.starts_with(&format!("{PAGE}/")));
    if inside && !has_page {
        return None;
    }
    if target.is_empty() || target.ends_with('/') {
        return Some("a folder is no page where there is no server".into());
    }
    let Some(found) = site.get(&target) else {
        return Some(format!("{target} is not there"));
    };
    // After the viewer's name stands what it is to show.
    let fragment = fragment.filter(|f| !inside && !f.is_empty() && *f != "top")?;
    let ids = &found.as_ref()?.ids;
    let is_there = ids.contains(fragment) || ids.contains(&decode(fragment));
    (!is_there).then(|| format!("{target} has no such place"))
}

/// The scheme of a link, if it has one, and the rest.
fn scheme(link: &str) -> Option<(&str, &str)> {
    if let Some(rest) = link.strip_prefix("//") {
        return Some(("", rest));
    }
    let (scheme, rest) = link.split_once(':')?;
    let is_one = scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    is_one.then_some((scheme, rest))
}

/// Returns the fault in the form of a link that leads out; whether it is alive is not checked.
fn external(scheme: &str, rest: &str) -> Option<String> {
    let fits = match scheme {
        "https" | "http" => {
            let host = rest.strip_prefix("//").and_then(|r| r.split(['/', '?', '#']).next());
            let is_host = |h: &str| {
                let name = h.split(':').next().unwrap_or_default();
                let labels = || name.split('.');
                let sound = |l: &str| {
                    !l.is_empty() && l.chars().all(|c| c.is_ascii_alphanumeric() || c == '-')
                };
                name == "localhost" || (labels().count() > 1 && labels().all(sound))
            };
            host.is_some_and(is_host) && !rest.contains(char::is_whitespace)
        }
        "mailto" => rest.contains('@'),
        "data" => true,
        _ => false,
    };
    (!fits).then(|| "it is no address".into())
}

/// The file that a path leads to from a page; nothing where that is above the root.
fn resolve(page: &str, path: &str) -> Option<String> {
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    let mut rest = path.split('/').peekable();
    while let Some(part) = rest.next() {
        let is_last = rest.peek().is_none();
        match part {
            "." | "" if !is_last => {}
            "." => parts.push(""),
            ".." => {
                parts.pop()?;
                if is_last {
                    parts.push("");
                }
            }
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

/// Turns `%20` and the like into what they stand for; what is none stays.
fn decode(text: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        let digits = tail.get(..2).and_then(|d| std::str::from_utf8(d).ok());
        let byte = digits.and_then(|d| u8::from_str_radix(d, 16).ok()).filter(|_| *first == b'%');
        bytes.push(byte.unwrap_or(*first));
        rest = if byte.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn site(pages: &[(&str, &str)]) -> Site {
        let read = |text: &str| Html::read(text).unwrap();
        let html = |name: &str, text: &str| name.ends_with(".html").then(|| read(text));
        pages.iter().map(|(name, text)| ((*name).to_owned(), html(name, text))).collect()
    }

    #[test]
    fn links_that_lead_nowhere_are_told_and_no_others() {
        let index = r##"<p id="here"><a href="#here">a</a> <a href="b.html#the-w--0">b</a> <img src='pictures/p.png'>
            <a href="deep/c.html?x=1#">c</a> <a href="https://x.org/y#z">out</a> <a href=b.html>plain</a>
            <a href="viewer/index.html#scene=city&amp;panels=false">page</a></p>"##;
        let c = r#"<a href="../index.html#here">up</a><a href="../b.html">b</a>"#;
        let b = r#"<h2 id="the-w--0">b</h2><a name="old">.</a>"#;
        let good =
            [("index.html", index), ("b.html", b), ("deep/c.html", c), ("pictures/p.png", "")];
        assert_eq!(dead(&site(&good)), Vec::<String>::new());
        for (link, why) in [
            ("#nowhere", "index.html has no such place"),
            ("b.html#nowhere", "b.html has no such place"),
            ("d.html", "d.html is not there"),
            ("pictures/q.png", "pictures/q.png is not there"),
            ("../b.html", "leads out"),
            ("/b.html", "root of a host"),
            ("deep/", "folder"),
            ("deep/..", "folder"),
            ("//x.org/y", "no address"),
            ("https://x y", "no address"),
            ("https:/x.org", "no address"),
            ("javascript:alert(1)", "no address"),
        ] {
            let page = format!("<a href=\"{link}\">wrong</a>");
            let mut all = good.to_vec();
            all[0].1 = &page;
            // What leads back to it leads to what it no longer has.
            all.remove(2);
            let wrong = dead(&site(&all));
            assert!(wrong.len() == 1 && wrong[0].contains(why), "{link}: {wrong:?}");
        }
        // The page is looked for once it is in the book.
        let mut published = good.to_vec();
        published.push(("viewer/main.js", ""));
        assert_eq!(dead(&site(&published)).len(), 1);
        published.push(("viewer/index.html", "<script src=main.js></script>"));
        assert_eq!(dead(&site(&published)), Vec::<String>::new());
    }

    #[test]
    fn letters_in_percent_are_read() {
        assert_eq!(decode("a%20b%E2%89%A4%zz%"), "a b≤%zz%");
        assert_eq!(resolve("a/b.html", "./../c/./d.html").as_deref(), Some("c/d.html"));
    }
}
