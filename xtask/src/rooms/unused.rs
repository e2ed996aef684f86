//! Nothing of the engine is public that no other crate, binding, example or page of the book names.
//!
//! Names are looked up as words: of functions that share a name with others the check says too
//! little, never too much.

use std::collections::BTreeSet;
use std::fs;

use crate::tools::{Done, output, root};

const ENGINE: &str = "crates/cullet/src/";

/// Files whose names are no use: tests, which may reach for whatever there is, and what serves
/// them.
const TESTS: [&str; 3] = ["/tests/", "/tests.rs", "crates/cullet-testkit/"];

/// Public functions that only tests name so far, each with the reason why it stays.
const KNOWN: &[(&str, &[&str])] = &[
    (
        "callers outside the workspace: nothing else does what these do",
        &["explain_among", "eyes_apart", "hide_boxes", "index_range", "set_size_weight"],
    ),
    (
        "tests of other crates need them, which cannot reach into the engine",
        &[
            "basis",
            "commit_parts",
            "has_corners",
            "is_limited",
            "is_outside_beyond_planes",
            "is_small_size",
            "is_zero_area",
            "piece_count",
            "same_counts",
            "side_of",
            "surface_area",
            "to_object_space",
            "with_margin",
            "within_map",
        ],
    ),
];

/// Returns an error that names each public function and constant that nothing outside the engine
/// names.
pub(crate) fn check() -> Done {
    let listed = output("git", &["-C", &root().to_string_lossy(), "ls-files"])
        .ok_or("git ls-files cannot be run")?;
    let read = |name: &str| fs::read_to_string(root().join(name)).unwrap_or_default();
    let mut words = BTreeSet::new();
    let is_source = |name: &&str| [".rs", ".md"].iter().any(|end| name.ends_with(end));
    let is_test = |name: &str| TESTS.iter().any(|part| name.contains(part));
    for name in listed.lines().filter(is_source) {
        if !name.starts_with(ENGINE) && !is_test(name) {
            let text = read(name);
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            words.extend(text.split(|c| !is_word(c)).map(str::to_owned));
        }
    }
    let mut found = Vec::new();
    for name in listed.lines().filter(|name| name.starts_with(ENGINE)) {
        let text = read(name);
        let items = public_items(&text).filter(|item| !words.contains(*item));
        let items = items.filter(|item| KNOWN.iter().all(|(_, known)| !known.contains(item)));
        found.extend(items.map(|item| format!("{item} in {name}")));
    }
    match found.len() {
        0 => Ok(()),
        count => Err(format!(
            "{count} public functions and constants of the engine that nothing outside it names:\n       {}",
            found.join("\n       ")
        )),
    }
}

/// Names of the functions and constants that a file makes public, its tests left out.
fn public_items(text: &str) -> impl Iterator<Item = &str> {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    code.lines().filter_map(|line| {
        let rest = line.trim_start().strip_prefix("pub ")?;
        let rest =
            rest.strip_prefix("const fn ").or_else(|| rest.strip_prefix("fn ")).or_else(|| {
                let named = rest.strip_prefix("const ")?;
                Some(named)
            })?;
        rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn public_functions_and_constants_are_found() {
        let text = "pub fn a() {}\n    pub const fn b(x: u32) {}\npub(crate) fn c() {}\npub const D: u32 = 1;\n\
                    pub struct E;\n#[cfg(test)]\nmod tests {\n    pub fn f() {}\n}\n";
        assert_eq!(public_items(text).collect::<Vec<_>>(), ["a", "b", "D"]);
    }
}
