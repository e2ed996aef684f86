//! The figures of README and docs that a command of `cullet` gives: run again, and held against the
//! text.
//!
//! `docs/figures.json` names each once. What is compared is what would be written, so that the last
//! digit of the text is the tolerance: a count has none.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;

use crate::tools::{Done, cargo, command, data, root, target};

mod dates;
#[path = "../../programs/cullet-lab/src/lecture/formula.rs"]
mod formula;

/// The list, from the root.
const LIST: &str = "docs/figures.json";
/// Stands for the folder of the test data in a command.
const DATA: &str = "DATA";
/// Stands for a figure in a phrase.
const HOLE: &str = "{}";

/// A phrase of a page with the figures in it.
struct Phrase {
    /// Path from the root.
    file: String,
    /// The text, with a hole for each figure; it is in the file once.
    text: String,
    figures: Vec<Figure>,
}

/// Where a figure comes from, and how it is written.
struct Figure {
    /// Arguments of `cullet`, without `--json -`.
    run: String,
    /// A formula of what the command writes.
    value: String,
    /// The divisor.
    over: Option<String>,
    /// The factor.
    times: f64,
    decimals: usize,
}

/// How a command ended.
enum Ran {
    Wrote(Value),
    /// Test data that is absent.
    Lacks(String),
    Failed(String),
}

/// Runs the commands of the figures whose file or command contains `filter`, prints what stands in
/// the text and what they give now, and writes it there if `write`; else a difference is an error.
pub(crate) fn compare(filter: &str, write: bool) -> Done {
    dates::all_dated()?;
    let chosen: Vec<Phrase> = phrases()?.into_iter().filter(|p| p.matches(filter)).collect();
    if chosen.is_empty() {
        return Err(format!("no figure of {LIST} has {filter:?} in its file or its command"));
    }
    cargo(&["build", "--quiet", "--release", "--package", "cullet-cli"])?;
    let mut ran = BTreeMap::new();
    let (mut differ, mut wrong, mut skipped) = (0, Vec::new(), Vec::new());
    println!("{:>14} {:>14}  where", "in the book", "now");
    for phrase in &chosen {
        let text = read(&phrase.file)?;
        let found = find(&text, &phrase.text).map_err(|e| format!("{}: {e}", phrase.file))?;
        let mut now = Vec::new();
        for (figure, &(start, end)) in phrase.figures.iter().zip(&found) {
            let held = &text[start..end];
            let given = match ran.entry(&figure.run).or_insert_with(|| run(&figure.run)) {
                Ran::Wrote(json) => {
                    figure.of(json).map(|v| formula::written(v, figure.decimals, held))
                }
                Ran::Lacks(file) => {
                    skipped.push(format!("{file}: {}", figure.run));
                    Ok(held.to_owned())
                }
                Ran::Failed(why) => Err(why.clone()),
            };
            let given = given.unwrap_or_else(|why| {
                wrong.push(format!("cullet {}: {why}", figure.run));
                held.to_owned()
            });
            let mark = if given == held { ' ' } else { '*' };
            differ += usize::from(given != held);
            println!("{held:>14} {given:>14} {mark}{}: {}", phrase.file, figure.run);
            now.push(given);
        }
        if write {
            let path = root().join(&phrase.file);
            let new = replaced(&text, &found, &now);
            fs::write(&path, new).map_err(|e| format!("{}: {e}", path.display()))?;
        }
    }
    skipped.sort();
    skipped.dedup();
    for line in skipped {
        println!("skipped, for want of {line}");
    }
    if !wrong.is_empty() {
        wrong.dedup();
        return Err(wrong.join("\n       "));
    }
    match differ {
        0 => Ok(()),
        n if write => {
            println!("{n} written anew");
            Ok(())
        }
        n => Err(format!("{n} of the book's figures are not those of today; --write mends them")),
    }
}

/// Runs a command, if the data that it needs is there, and returns its output.
fn run(words: &str) -> Ran {
    let data = data().unwrap_or_default();
    let mut args = vec!["--quiet".to_owned()];
    for word in words.split(' ') {
        args.push(match word.strip_prefix(DATA) {
            None => word.to_owned(),
            Some(name) => {
                let path = data.join(name.trim_start_matches('/'));
                if !path.is_file() {
                    return Ran::Lacks(name.trim_start_matches('/').to_owned());
                }
                path.to_string_lossy().into_owned()
            }
        });
    }
    args.extend(["--json".to_owned(), "-".to_owned()]);
    let program = target().join("release/cullet");
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let out = match command(&program.to_string_lossy(), &args).output() {
        Ok(out) if out.status.success() => out.stdout,
        Ok(out) => {
            let why = String::from_utf8_lossy(&out.stderr);
            return Ran::Failed(format!("{}: {}", out.status, why.trim()));
        }
        Err(e) => return Ran::Failed(e.to_string()),
    };
    match serde_json::from_slice(&out) {
        Ok(json) => Ran::Wrote(json),
        Err(e) => Ran::Failed(format!("it wrote no JSON: {e}")),
    }
}

impl Phrase {
    fn matches(&self, filter: &str) -> bool {
        self.file.contains(filter) || self.figures.iter().any(|f| f.run.contains(filter))
    }
}

impl Figure {
    fn of(&self, json: &Value) -> Result<f64, String> {
        let over = self.over.as_deref().unwrap_or("1");
        let formula = format!("( {} ) / ( {over} ) * {}", self.value, self.times);
        formula::value(&formula, &[json])
    }
}

/// Where in `text` the holes of `phrase` are filled by numbers: the phrase must be there once.
fn find(text: &str, phrase: &str) -> Result<Vec<(usize, usize)>, String> {
    let pieces: Vec<&str> = phrase.split(HOLE).collect();
    let mut found = text.match_indices(pieces[0]).filter_map(|(at, _)| filled(text, at, &pieces));
    match (found.next(), found.next()) {
        (Some(holes), None) => Ok(holes),
        (None, _) => Err(format!("there is no {phrase:?} with numbers in it")),
        (Some(_), Some(_)) => Err(format!("{phrase:?} is there more than once")),
    }
}

/// The holes of a phrase, given as the pieces between them, if it stands at `at`.
fn filled(text: &str, at: usize, pieces: &[&str]) -> Option<Vec<(usize, usize)>> {
    let mut holes = Vec::new();
    let mut end = at + pieces[0].len();
    for piece in &pieces[1..] {
        let start = end;
        let is_of_number = |c: char| c.is_ascii_digit() || matches!(c, ',' | '.' | ' ');
        let rest = &text[start..];
        let reach = rest.find(|c| !is_of_number(c)).unwrap_or(rest.len());
        // A number ends with a digit; what follows it may begin with a space, a comma or a full
        // stop.
        end = (1..=reach)
            .filter(|&n| rest.as_bytes()[n - 1].is_ascii_digit())
            .map(|n| start + n)
            .find(|&e| {
            text[e..].starts_with(piece) && !text[e..].starts_with(|c: char| c.is_ascii_digit())
        })?;
        if !rest.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        holes.push((start, end));
        end += piece.len();
    }
    Some(holes)
}

/// A text with its holes filled anew.
fn replaced(text: &str, holes: &[(usize, usize)], new: &[String]) -> String {
    let mut out = String::with_capacity(text.len());
    let mut last = 0;
    for (&(start, end), new) in holes.iter().zip(new) {
        out += &text[last..start];
        out += new;
        last = end;
    }
    out + &text[last..]
}

fn read(file: &str) -> Result<String, String> {
    fs::read_to_string(root().join(file)).map_err(|e| format!("{file}: {e}"))
}

/// The list, read and found sound: as many figures as holes in each phrase.
fn phrases() -> Result<Vec<Phrase>, String> {
    let list: Value = serde_json::from_str(&read(LIST)?).map_err(|e| format!("{LIST}: {e}"))?;
    let list = list.as_array().ok_or(format!("{LIST} is no list"))?;
    list.iter().map(|p| phrase(p).map_err(|e| format!("{LIST}: {e} in {p}"))).collect()
}

fn phrase(item: &Value) -> Result<Phrase, String> {
    let file = word(item, "file")?;
    let text = word(item, "phrase")?;
    let figures = item["figures"].as_array().ok_or("no list \"figures\"")?;
    let figures = figures.iter().map(figure).collect::<Result<Vec<_>, _>>()?;
    let holes = text.matches(HOLE).count();
    if holes == 0 || holes != figures.len() {
        return Err(format!("{holes} holes and {} figures", figures.len()));
    }
    Ok(Phrase { file, text, figures })
}

fn figure(item: &Value) -> Result<Figure, String> {
    let decimals = item["decimals"].as_u64().unwrap_or(0);
    Ok(Figure {
        run: word(item, "run")?,
        value: word(item, "value")?,
        over: item["over"].as_str().map(str::to_owned),
        times: item["times"].as_f64().unwrap_or(1.0),
        decimals: usize::try_from(decimals).map_err(|e| e.to_string())?,
    })
}

fn word(item: &Value, key: &str) -> Result<String, String> {
    item[key].as_str().map(str::to_owned).ok_or(format!("no text {key:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_listed_phrase_is_in_its_file_once_with_numbers_in_it() {
        let all = phrases().unwrap();
        assert!(all.len() > 10, "{}", all.len());
        for phrase in all {
            let found = find(&read(&phrase.file).unwrap(), &phrase.text);
            let found = found.unwrap_or_else(|e| panic!("{}: {e}", phrase.file));
            assert_eq!(found.len(), phrase.figures.len(), "{}: {}", phrase.file, phrase.text);
        }
    }

    #[test]
    fn a_phrase_that_is_absent_or_there_twice_is_an_error() {
        assert_eq!(
            find("of 1,234 things 5 are", "of {} things {} are"),
            Ok(vec![(3, 8), (16, 17)])
        );
        assert!(find("of many things", "of {} things").is_err());
        assert!(find("of 1 things, of 2 things", "of {} things").is_err());
        assert_eq!(find("| 99 % | 15.0 | 0 |", "| {} % | {} | 0 |"), Ok(vec![(2, 4), (9, 13)]));
        assert_eq!(find("are 1 234. Then", "are {}. Then"), Ok(vec![(4, 9)]));
    }

    #[test]
    fn a_figure_is_written_as_the_text_has_it() {
        assert_eq!(formula::written(1_234_567.0, 0, "1,000"), "1,234,567");
        assert_eq!(formula::written(1_234_567.0, 0, "9 000"), "1 234 567");
        assert_eq!(formula::written(15.05, 1, "14.9"), "15.1");
        assert_eq!(formula::written(999.6, 0, "7"), "1,000");
        assert_eq!(formula::written(0.4, 0, "7"), "0");
        let text = "of 1,234 things 5 are";
        let holes = find(text, "of {} things {} are").unwrap();
        let new = ["9".to_owned(), "10,000".to_owned()];
        assert_eq!(replaced(text, &holes, &new), "of 9 things 10,000 are");
    }

    #[test]
    fn a_figure_is_computed_from_its_pointers() {
        let json = serde_json::json!({"all": 12, "gone": {"a": 4}, "of": 2, "list": [1, 1, 1]});
        let of = |value: &str, over: Option<&str>| {
            let value = serde_json::json!({"run": "x", "value": value, "over": over, "times": 100});
            figure(&value).unwrap().of(&json)
        };
        assert_eq!(of("/gone/a", Some("/all - /gone/a - /gone/b?")), Ok(50.0));
        assert_eq!(of("/list", Some("/of")), Ok(150.0));
        assert!(of("/gone/b", None).is_err());
        assert!(of("/all", Some("/gone/b?")).is_err());
    }
}
