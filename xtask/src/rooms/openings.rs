//! Doc comments of the engine open with a noun or a verb, not with a word that leans on what stands before it.

use std::fs;
use std::path::Path;

use crate::tools::{Done, root};

/// Words that open a sentence without its noun.
const LEANING: [&str; 8] = ["Of ", "That of ", "Those ", "With ", "By ", "As ", "What ", "Which "];

/// Returns an error that names each doc comment of the engine that opens with one.
pub(crate) fn check() -> Done {
    let mut found = Vec::new();
    let source = root().join("crates/cullet/src");
    visit(&source, &mut found)?;
    found.sort();
    if found.is_empty() {
        return Ok(());
    }
    Err(format!(
        "doc comments that open without a noun or a verb:\n       {}",
        found.join("\n       ")
    ))
}

fn visit(folder: &Path, found: &mut Vec<String>) -> Done {
    let fail = |e: std::io::Error| format!("{}: {e}", folder.display());
    for entry in fs::read_dir(folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        if path.is_dir() {
            visit(&path, found)?;
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = fs::read_to_string(&path).map_err(fail)?;
            let lines =
                leaning(&text).map(|(line, doc)| format!("{}:{line}: {doc}", path.display()));
            found.extend(lines);
        }
    }
    Ok(())
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
}
