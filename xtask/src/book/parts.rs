//! Parts of a chapter on a kind of culling: each has the same ones in the same order, so that who
//! knows one chapter finds their way in all.

use std::ops::RangeInclusive;

use super::chapters;
use crate::tools::Done;

/// Parts of the summary whose chapters are each of a kind.
const KINDS: [&str; 6] = [
    "Kinds of culling",
    "Queries",
    "Cells and portals",
    "Levels of detail",
    "Clipping",
    "Scenes that move",
];

/// A part: its name, what its heading contains or, where that is one word, is, and whether a
/// chapter must have it.
struct Part {
    name: &'static str,
    headings: &'static [&'static str],
    is_required: bool,
}

/// The name of the part that a block of code is: it may have any heading, or none.
const ALGORITHM: &str = "algorithm";

/// Lines that the code of an algorithm has.
const ALGORITHM_LINES: RangeInclusive<usize> = 6..=30;

/// Languages of fences in which an algorithm is written: none, for words in the form of a program,
/// or that of the engine.
const ALGORITHM_LANGUAGES: [&str; 2] = ["", "rust"];

/// First words of lines by which code decides something or repeats it; a list of formulas or of
/// commands has none.
const CONTROL: [&str; 4] = ["for", "if", "while", "repeat"];

/// The parts below the idea, the picture, the derivation and the algorithm, which have headings of
/// their own.
const PARTS: [Part; 7] = [
    Part {
        name: "what goes wrong",
        headings: &[
            "what goes wrong",
            "the trap of",
            "traps in",
            "defects of a mesh",
            "how wrong is it",
        ],
        is_required: true,
    },
    Part {
        name: "what it costs",
        headings: &["what it costs", "how fast", "what can be reached", "measured"],
        is_required: true,
    },
    Part {
        name: "when not to use it",
        headings: &[
            "when not to",
            "and when not",
            "when it does not pay",
            "when the cpu is the better",
        ],
        is_required: true,
    },
    Part { name: "equivalents", headings: &["in opengl, wgpu and direct3d"], is_required: true },
    Part { name: "try it", headings: &["try it"], is_required: false },
    Part { name: "exercises", headings: &["exercises"], is_required: false },
    Part { name: "further reading", headings: &["further reading"], is_required: true },
];

/// Chapters that stand among those of kinds and are of none, each with the reason.
const OTHERS: [(&str, &str); 5] = [
    ("profile.md", "it finds what a frame waits for, and drops nothing"),
    ("cells.md", "where the input of portals and sets comes from"),
    ("distributed.md", "how bakes of any kind run on many machines"),
    ("baking.md", "a file, not a way to drop something"),
    ("baking-file.md", "a file, not a way to drop something"),
];

/// Parts that a chapter does not have, each with the reason.
const WITHOUT: [(&str, &str, &str); 1] = [(
    "popping.md",
    "what goes wrong",
    "all of it is what goes wrong with two kinds, and its cure",
)];

/// Every chapter of a kind has its parts, in their order.
pub(super) fn all_in_order() -> Done {
    let chapters = chapters()?;
    let text = |name: &str| chapters.iter().find(|(n, _)| n == name).map(|(_, text)| text.as_str());
    let listed = of_kinds(text("SUMMARY.md").unwrap_or_default());
    if let Some((name, _)) = OTHERS.iter().find(|(name, _)| !listed.contains(name)) {
        return Err(format!("{name} is excepted, but is no chapter among those of kinds"));
    }
    let mut wrong = Vec::new();
    for name in listed.into_iter().filter(|name| OTHERS.iter().all(|(other, _)| other != name)) {
        match text(name) {
            Some(text) => {
                let without: Vec<&str> =
                    WITHOUT.iter().filter(|w| w.0 == name).map(|w| w.1).collect();
                wrong.extend(faults(text, &without).into_iter().map(|f| format!("{name}: {f}")));
            }
            None => wrong.push(format!("{name} is not there")),
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n       ")) }
}

/// Files of the chapters that the summary has under the headings of kinds.
fn of_kinds(summary: &str) -> Vec<&str> {
    let mut is_kind = false;
    let mut files = Vec::new();
    for line in summary.lines() {
        if let Some(heading) = line.strip_prefix("# ") {
            is_kind = KINDS.contains(&heading);
        } else if let Some((_, link)) = line.split_once("](").filter(|_| is_kind) {
            files.extend(link.split(')').next());
        }
    }
    files
}

/// A block of code: fenced, or indented by four below an empty line.
struct Block<'a> {
    /// How many lines outside of fences stand before it.
    at: usize,
    language: &'a str,
    lines: Vec<&'a str>,
}

impl Block<'_> {
    /// Whether it may be an algorithm: neither too short nor too long, and it decides or repeats
    /// something.
    fn is_algorithm(&self) -> bool {
        let first = |line: &&str| line.split_whitespace().next().unwrap_or_default().to_owned();
        let is_control = |word: String| CONTROL.contains(&word.as_str());
        ALGORITHM_LANGUAGES.contains(&self.language)
            && ALGORITHM_LINES.contains(&self.lines.len())
            && self.lines.iter().map(first).any(is_control)
    }
}

/// The lines of a chapter outside of fences, and its blocks of code.
fn split(text: &str) -> (Vec<&str>, Vec<Block<'_>>) {
    let (mut lines, mut blocks) = (Vec::new(), Vec::<Block<'_>>::new());
    let (mut fenced, mut indented) = (false, false);
    for line in text.lines() {
        let at = lines.len();
        if let Some(language) = line.strip_prefix("```") {
            if !fenced {
                // What follows a comma tells the tests of Rust what to do.
                let language = language.split(',').next().unwrap_or_default();
                blocks.push(Block { at, language, lines: Vec::new() });
            }
            (fenced, indented) = (!fenced, false);
            continue;
        }
        // What is indented below a line of a list or a paragraph is more of that.
        let may_begin = indented || lines.last().is_none_or(|line: &&str| line.is_empty());
        let is_code = fenced || may_begin && line.starts_with("    ");
        if !fenced {
            if is_code && !indented {
                blocks.push(Block { at, language: "", lines: Vec::new() });
            }
            indented = is_code;
            lines.push(line);
        }
        if let Some(block) = blocks.last_mut().filter(|_| is_code && !line.trim().is_empty()) {
            block.lines.push(line);
        }
    }
    (lines, blocks)
}

/// Returns the parts that a chapter lacks, but for those that it is to be `without`, or has in
/// another order.
fn faults(text: &str, without: &[&str]) -> Vec<String> {
    let (lines, blocks) = split(text);
    let is_heading = |line: &&str| line.starts_with("##");
    let headings: Vec<(usize, String)> = lines
        .iter()
        .enumerate()
        .filter(|(_, line)| is_heading(line))
        .map(|(at, line)| (at, line.trim_start_matches('#').trim().to_lowercase()))
        .collect();
    let mut faults = Vec::new();
    let first = headings.first().map_or(lines.len(), |(at, _)| *at);
    let is_prose = |line: &&str| !line.is_empty() && !line.starts_with(['#', '!', '*', '|']);
    if !lines[..first].iter().any(is_prose) {
        faults.push("the idea has to stand before the first heading".into());
    }
    let places = PARTS.iter().map(|part| {
        let fits = |heading: &str| {
            let is = |words: &&str| {
                heading == *words || (words.contains(' ') && heading.contains(*words))
            };
            part.headings.iter().any(is)
        };
        headings.iter().find(|(_, heading)| fits(heading)).map(|(at, _)| *at)
    });
    let places: Vec<Option<usize>> = places.collect();
    let is_picture = |line: &&str| line.contains("![") || line.contains("<svg");
    match (lines.iter().position(is_picture), places[0]) {
        (None, _) => faults.push("there is no picture".into()),
        (Some(picture), Some(wrong)) if picture > wrong => {
            faults.push(format!("its first picture comes after {}", PARTS[0].name));
        }
        _ => {}
    }
    // It stands before what it leads to; a chapter may be without the first of these.
    let end = places.iter().flatten().next().copied().unwrap_or(lines.len());
    let is_there = blocks.iter().any(|block| block.at <= end && block.is_algorithm());
    match (is_there, without.contains(&ALGORITHM)) {
        (true, true) => faults.push(format!("{ALGORITHM} is there, and excepted")),
        (false, false) => {
            let (least, most) = (ALGORITHM_LINES.start(), ALGORITHM_LINES.end());
            faults.push(format!(
                "{ALGORITHM} is missing: before {}, code of {least} to {most} lines of which one begins with {}",
                PARTS[0].name,
                CONTROL.join(", ")
            ));
        }
        _ => {}
    }
    let mut before: Option<(usize, &str)> = None;
    for (part, place) in PARTS.iter().zip(places) {
        match (place, before) {
            (Some(_), _) if without.contains(&part.name) => {
                faults.push(format!("{} is there, and excepted", part.name));
            }
            (None, _) if part.is_required && !without.contains(&part.name) => {
                let words = part.headings[0];
                faults.push(format!("{} is missing: a heading with \"{words}\"", part.name));
            }
            (None, _) => {}
            (Some(at), Some((last, name))) if at < last => {
                faults.push(format!("{} comes before {name}, after which it belongs", part.name));
            }
            (Some(at), _) => before = Some((at, part.name)),
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_chapter_of_a_kind_has_its_parts_in_their_order() {
        all_in_order().unwrap();
    }

    #[test]
    fn what_is_missing_or_misplaced_is_told() {
        let whole = "# A\n\nThe idea.\n\n![p](p.png)\n\n## So\n\n```\n## Further reading\n```\n\n\
                     ```\na = 0\nb = 1\nfor each c:\n\n    if c:\n        a = b\nreturn a\n```\n\n## What goes wrong\n\n## How fast\n\n\
                     ## When not to use it\n\n## In OpenGL, wgpu and Direct3D\n\n## Exercises\n\n## Further reading\n";
        assert_eq!(faults(whole, &[]), Vec::<String>::new());
        let with = |from: &str, to: &str| faults(&whole.replacen(from, to, 1), &[]).join("; ");
        assert!(with("![p](p.png)", "").contains("no picture"));
        assert!(with("The idea.", "").contains("the idea"));
        assert!(with("## How fast", "## So fast").contains("what it costs is missing"));
        let swapped = whole
            .replace("## How fast", "## X")
            .replace("## When not", "## How fast\n\n## When not");
        assert_eq!(faults(&swapped, &[]), Vec::<String>::new());
        assert!(
            with("## Exercises\n\n## Further reading", "## Further reading\n\n## Exercises")
                .contains("further reading comes before exercises")
        );
        let late = whole.replace("![p](p.png)", "") + "![p](p.png)";
        assert!(faults(&late, &[])[0].contains("comes after what goes wrong"));
        // One heading may stand for two parts.
        let both = whole.replace(
            "## How fast\n\n## When not to use it",
            "## What it costs, and when not to use it",
        );
        assert_eq!(faults(&both, &[]), Vec::<String>::new());
    }

    /// A chapter that has all parts, with `code` in the place of its algorithm.
    fn with_code(code: &str) -> String {
        format!(
            "# A\n\nThe idea.\n\n![p](p.png)\n\n## So\n\n{code}\n\n## What goes wrong\n\n## How fast\n\n\
             ## When not to use it\n\n## In OpenGL, wgpu and Direct3D\n\n## Further reading\n"
        )
    }

    #[test]
    fn a_chapter_without_equivalents_is_told() {
        let whole = with_code("```\nfor a:\n b\n c\n d\n e\n f\n```");
        assert_eq!(faults(&whole, &[]), Vec::<String>::new());
        let told = faults(&whole.replace("## In OpenGL, wgpu and Direct3D\n", ""), &[]);
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].contains("equivalents is missing"), "{told:?}");
    }

    #[test]
    fn a_chapter_without_an_algorithm_is_told() {
        let told = |code: &str| faults(&with_code(code), &[]).join("; ");
        let algorithm = "for each a:\n    if b:\n        c\n        d\n    e\nf\n";
        let fenced = |language: &str| format!("```{language}\n{algorithm}```");
        assert_eq!(told(&fenced("")), "");
        assert_eq!(told(&fenced("rust,ignore")), "");
        let indented: Vec<String> = algorithm.lines().map(|line| format!("    {line}")).collect();
        assert_eq!(told(&indented.join("\n")), "");
        let missing = "algorithm is missing";
        assert!(told("").contains(missing));
        assert!(told(&format!("- A list:\n{}", indented.join("\n"))).contains(missing));
        for language in ["sh", "console", "text", "json"] {
            assert!(told(&fenced(language)).contains(missing), "{language}");
        }
        // Commands or formulas alone, one line too few, and too many.
        assert!(
            told("```\ncullet a\ncullet b\ncullet c\ncullet d\ncullet e\ncullet f\n```")
                .contains(missing)
        );
        assert!(told(&fenced("").replacen("f\n", "", 1)).contains(missing));
        assert!(told(&format!("```\n{}```", algorithm.repeat(6))).contains(missing));
        // Two blocks are not one, and one that comes after what goes wrong is too late.
        let halves = algorithm.replacen("    e\n", "```\n\nSo:\n\n```\n    e\n", 1);
        assert!(told(&format!("```\n{halves}```")).contains(missing));
        let late = with_code("") + "\n" + &fenced("");
        assert!(faults(&late, &[]).join("; ").contains(missing));
    }

    #[test]
    fn exceptions_that_are_none_are_told() {
        let whole = with_code("```\nfor a:\n b\n c\n d\n e\n f\n```");
        assert_eq!(faults(&with_code(""), &[ALGORITHM]), Vec::<String>::new());
        assert_eq!(faults(&whole, &[ALGORITHM]), ["algorithm is there, and excepted"]);
        assert_eq!(faults(&whole, &["equivalents"]), ["equivalents is there, and excepted"]);
    }

    #[test]
    fn chapters_of_kinds_are_found_in_the_summary() {
        let summary = "# Summary\n\n- [a](a.md)\n\n# Clipping\n\n- [b](b.md)\n  - [c](c.md)\n\n# Reference\n\n- [d](d.md)\n";
        assert_eq!(of_kinds(summary), ["b.md", "c.md"]);
    }
}
