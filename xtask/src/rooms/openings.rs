//! Check that doc comments of crates, programs, bindings, examples and xtask open with a noun or a
//! verb, and not with a word that needs another one before it.

use std::fs;

use crate::tools::{Done, output, root};

/// Words that open a sentence without its noun.
const LEANING: [&str; 8] = ["Of ", "That of ", "Those ", "With ", "By ", "As ", "What ", "Which "];

/// Folders whose Rust files are checked.
const CHECKED: [&str; 5] = ["bindings/", "crates/", "examples/", "programs/", "xtask/"];

/// Returns an error that names each doc comment in the checked folders that opens with one.
pub(crate) fn check() -> Done {
    let listed = output("git", &["-C", &root().to_string_lossy(), "ls-files"])
        .ok_or("git ls-files cannot be run")?;
    let mut found = Vec::new();
    for name in listed.lines().filter(|name| is_checked(name)) {
        // A file that was just removed is still listed.
        let text = fs::read_to_string(root().join(name)).unwrap_or_default();
        found.extend(leaning(&text).map(|(line, doc)| format!("{name}:{line}: {doc}")));
    }
    if found.is_empty() {
        return Ok(());
    }
    Err(format!(
        "doc comments that open without a noun or a verb:\n       {}",
        found.join("\n       ")
    ))
}

/// Tests whether a file of the tree, named from the root, is checked.
fn is_checked(name: &str) -> bool {
    name.ends_with(".rs") && CHECKED.iter().any(|folder| name.starts_with(folder))
}

/// First lines of doc comments that lean, with their numbers.
fn leaning(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let doc =
        |line: &'_ str| line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).is_some();
    let mut within = false;
    text.lines().map(str::trim).enumerate().filter_map(move |(index, line)| {
        let opens = doc(line) && !within;
        within = doc(line);
        let words = line.get(3..)?.trim_start();
        (opens && LEANING.iter().any(|word| words.starts_with(word))).then_some((index + 1, line))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_first_line_of_a_doc_comment_counts() {
        let text = "/// Of a view.\nfn a() {}\n    /// The cell\n    /// Of a view.\n// Of a view.\n/// Offers.\n";
        assert_eq!(leaning(text).collect::<Vec<_>>(), [(1, "/// Of a view.")]);
    }

    #[test]
    fn rust_files_of_crates_programs_and_bindings_are_checked() {
        let names = ["crates/a/src/lib.rs", "programs/b/tests/c.rs", "bindings/d/src/e.rs"];
        assert!(names.into_iter().all(is_checked));
        assert!(
            !["crates/a/README.md", "fuzz/f.rs", "docs/crates/g.rs"].into_iter().any(is_checked)
        );
    }
}
