//! Imports between the files of a crate: `use` trees and paths that begin at `crate`, `super`,
//! `self` or a module beside.
//!
//! It reads text, not Rust: items made by macros are not seen. An item that a parent re-exports by
//! `pub use` is taken from the file that defines it. Modules for tests are left out; they stand
//! last in their file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

type Module = Vec<String>;

/// The files of a crate by their modules, and what each hands on under which name.
pub(super) struct Files {
    source: BTreeMap<Module, (PathBuf, String)>,
    exports: BTreeMap<(Module, String), (Module, Vec<String>)>,
}

impl Files {
    /// Reads all of a crate's `src`.
    pub(super) fn read(src: &Path) -> Result<Self, String> {
        let mut source = BTreeMap::new();
        let mut folders = vec![src.to_owned()];
        while let Some(folder) = folders.pop() {
            let fail = |e: std::io::Error| format!("{}: {e}", folder.display());
            for entry in std::fs::read_dir(&folder).map_err(fail)? {
                let path = entry.map_err(fail)?.path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|e| e == "rs") {
                    let text = std::fs::read_to_string(&path).map_err(fail)?;
                    let is_root = path.file_name().is_some_and(|n| n == "main.rs");
                    if !(is_root && src.join("lib.rs").exists()) {
                        source.insert(module(&path, src), (path, text));
                    }
                }
            }
        }
        let tests: Vec<Module> =
            source.iter().flat_map(|(m, (_, text))| test_files(m, text)).collect();
        source.retain(|m, _| !tests.iter().any(|t| m.starts_with(t)));
        source.values_mut().for_each(|(_, text)| *text = without_tests(text));
        let mut files = Self { source, exports: BTreeMap::new() };
        for (at, (_, text)) in &files.source {
            for (_, path) in uses(text).into_iter().filter(|u| u.0) {
                if let (Some(name), Some(start)) = (path.last(), files.start(at, &path)) {
                    files.exports.insert((at.clone(), name.clone()), start);
                }
            }
        }
        Ok(files)
    }

    /// Every arrow: a file, and one that it names. What a module takes from those that it lies in
    /// counts where `strict`: else they are one room, and the outer ones hold what the inner ones
    /// share.
    pub(super) fn arrows(&self, strict: bool) -> BTreeSet<(PathBuf, PathBuf)> {
        let mut found = BTreeSet::new();
        for (at, (file, text)) in &self.source {
            let body = body(text);
            let words: BTreeSet<&str> = body.split(|c| !is_word(c)).collect();
            // A name that is only re-exported is no dependency.
            let imports = uses(text).into_iter().filter(|(handed_on, path)| {
                !handed_on || path.last().is_some_and(|name| words.contains(name.as_str()))
            });
            let inline = body.split(|c| !is_word(c) && c != ':').filter(|w| w.contains("::"));
            let inline = inline.map(|w| w.split("::").map(str::to_owned).collect());
            for path in imports.map(|(_, path)| path).chain(inline) {
                let target = self.start(at, &path).map(|(module, rest)| self.end(module, &rest));
                let target = target.filter(|m| strict || !at.starts_with(m));
                if let Some((other, _)) = target.and_then(|m| self.source.get(&m))
                    && other != file
                {
                    found.insert((file.clone(), other.clone()));
                }
            }
        }
        found
    }

    /// Where a path begins: a module, and what follows. `None` where that is in another crate.
    fn start(&self, at: &[String], path: &[String]) -> Option<(Module, Vec<String>)> {
        let mut module = at.to_vec();
        let mut rest = path;
        match path.first()?.as_str() {
            "crate" => module.clear(),
            "self" => {}
            "super" => {
                while rest.first().is_some_and(|s| s == "super") {
                    module.pop();
                    rest = &rest[1..];
                }
                return Some((module, rest.to_vec()));
            }
            child => {
                module.push(child.to_owned());
                self.source.contains_key(&module).then_some(())?;
            }
        }
        Some((module, rest[1..].to_vec()))
    }

    /// The module that has what a path names, whoever hands it on.
    fn end(&self, mut module: Module, path: &[String]) -> Module {
        // As many steps as no honest path takes.
        let (mut rest, mut steps) = (path.to_vec(), 0);
        while let (Some(name), true) = (rest.first().cloned(), steps < 16) {
            let child: Module = module.iter().cloned().chain([name.clone()]).collect();
            if self.source.contains_key(&child) {
                (module, rest) = (child, rest[1..].to_vec());
            } else if let Some((next, after)) = self.exports.get(&(module.clone(), name)) {
                (module, rest) = (next.clone(), after.clone());
            } else {
                break;
            }
            steps += 1;
        }
        module
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// `src/a/mod.rs` and `src/a.rs` are `a`.
fn module(path: &Path, src: &Path) -> Module {
    let inside = path.strip_prefix(src).unwrap_or(path).with_extension("");
    let mut names: Module =
        inside.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
    let last = names.last().map(String::as_str);
    if last == Some("mod") || names.len() == 1 && matches!(last, Some("lib" | "main")) {
        names.pop();
    }
    names
}

/// Files that are there for tests alone.
fn test_files(at: &[String], text: &str) -> Vec<Module> {
    let after = |part: &str| {
        let (name, _) = part.trim_start().strip_prefix("mod ")?.split_once([';', ' '])?;
        Some(at.iter().cloned().chain([name.to_owned()]).collect())
    };
    text.split("#[cfg(test)]").skip(1).filter_map(after).collect()
}

/// Without comments, and up to the module of tests.
fn without_tests(text: &str) -> String {
    let tests = text.match_indices("#[cfg(test)]").find(|(i, cfg)| {
        let next = text[i + cfg.len()..].trim_start().lines().next().unwrap_or_default();
        next.contains("mod ") && next.ends_with('{')
    });
    let text = tests.map_or(text, |(i, _)| &text[..i]);
    text.lines().flat_map(|l| [l.split("//").next().unwrap_or_default(), "\n"]).collect()
}

/// The statements `use`: whether each hands on, and its text.
fn statements(text: &str) -> impl Iterator<Item = (bool, &str)> {
    let starts = text.match_indices("use ").filter_map(|(i, word)| {
        let line = text[..i].rfind('\n').map_or(0, |n| n + 1);
        let before = text[line..i].trim();
        let is_use = before.is_empty() || before == "pub" || before.starts_with("pub(");
        is_use.then_some((!before.is_empty(), i + word.len()))
    });
    starts.filter_map(|(handed_on, i)| Some((handed_on, &text[i..i + text[i..].find(';')?])))
}

/// The code without its statements `use`.
fn body(text: &str) -> String {
    statements(text).fold(text.to_owned(), |rest, (_, tree)| rest.replacen(tree, "", 1))
}

/// Every path of the statements `use`, and whether it is handed on.
fn uses(text: &str) -> Vec<(bool, Vec<String>)> {
    let mut all = Vec::new();
    for (handed_on, tree) in statements(text) {
        let mut paths = Vec::new();
        expand("", tree, &mut paths);
        all.extend(paths.into_iter().map(|path| (handed_on, path)));
    }
    all
}

fn expand(before: &str, tree: &str, paths: &mut Vec<Vec<String>>) {
    let (mut depth, mut start) = (0, 0);
    for (i, c) in tree.char_indices().chain([(tree.len(), ',')]) {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            let part = tree[start..i].trim();
            start = i + 1;
            if let Some((head, inner)) = part.split_once('{') {
                expand(&format!("{before}{head}"), inner.strip_suffix('}').unwrap_or(inner), paths);
            } else if !part.is_empty() {
                let path = format!("{before}{part}");
                let path = path.split(" as ").next().unwrap_or_default().split("::");
                paths.push(path.map(|s| s.trim().to_owned()).filter(|s| s != "self").collect());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_are_expanded_and_tests_and_comments_left_out() {
        let text = "use std::fmt;\npub(crate) use a::{B, c::{self, D as E}};\n// use x::Y;\nfn f() {}\n\
                    #[cfg(test)]\nmod tests {\n    use crate::z;\n}\n";
        let found: Vec<String> = uses(&without_tests(text))
            .into_iter()
            .map(|(handed_on, path)| format!("{handed_on} {}", path.join("::")))
            .collect();
        assert_eq!(found, ["false std::fmt", "true a::B", "true a::c", "true a::c::D"]);
        assert!(body(&without_tests(text)).contains("fn f()"));
    }

    #[test]
    fn an_arrow_leads_to_the_file_that_defines_and_not_to_the_one_that_hands_on() {
        let folder = std::env::temp_dir().join(format!("cullet-rooms-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("a")).unwrap();
        for (name, text) in [
            ("lib.rs", "mod a;\nmod b;\npub use a::Thing;\n"),
            ("a/mod.rs", "mod thing;\npub use thing::Thing;\npub struct Own;\n"),
            ("a/thing.rs", "pub struct Thing(super::Own);\n"),
            ("b.rs", "use crate::Thing;\nfn f() { crate::a::g() }\n"),
        ] {
            std::fs::write(folder.join(name), text).unwrap();
        }
        let files = Files::read(&folder).unwrap();
        let named = |strict| -> Vec<String> {
            let short = |p: &Path| p.strip_prefix(&folder).unwrap().display().to_string();
            let arrows = files.arrows(strict);
            arrows.iter().map(|(a, b)| format!("{} {}", short(a), short(b))).collect()
        };
        assert_eq!(named(false), ["b.rs a/mod.rs", "b.rs a/thing.rs"]);
        assert_eq!(named(true), ["a/thing.rs a/mod.rs", "b.rs a/mod.rs", "b.rs a/thing.rs"]);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
