//! Checks that run commands: what they write, and whether a claim holds by it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use clap::Parser;
use cullet_cli::neighbours::{BAKER, LAB, elsewhere};
use cullet_command::bakery;
use cullet_command::exit;
use cullet_command::files::take_json;
use serde::Serialize;
use serde_json::{Value, json};

use super::formula::{value, written};
use super::{Item, held};

/// Result of a check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Sentence that says what was measured here, with its numbers.
    pub measured: String,
    /// Outcome of the measurement.
    pub outcome: Outcome,
    /// Figures that are not those of the book, though these should be the same on every machine.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<String>,
}

/// Whether a claim holds here.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// It does.
    Holds,
    /// The text errs, which was shown; mended it holds.
    Mended,
    /// It holds, but for the number: another was found here, which the book explains.
    Differs,
    /// It does not, and nobody knew: why.
    Fails(String),
    /// It cannot be tried here: what is missing.
    NotHere(String),
}

impl Outcome {
    /// The outcome in a word or two.
    pub(super) fn word(&self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Mended => "the text errs",
            Self::Differs => "differs",
            Self::Fails(_) => "FAILS",
            Self::NotHere(_) => "not here",
        }
    }
}

/// Stands for the folder of models in a command.
const DATA: &str = "DATA/";
/// Models that `cullet fetch` gets: their paths in a folder of data with a folder for each, and its
/// own names.
const FETCHED: [(&str, &str); 2] =
    [("stanford-bunny/bun_zipper.ply", "bunny.ply"), ("armadillo/armadillo.obj", "armadillo.ply")];

/// Commands that were run, each once.
#[derive(Debug, Default)]
pub struct Runs {
    data: Option<PathBuf>,
    done: BTreeMap<String, Ran>,
}

/// How a command ended.
#[derive(Debug)]
enum Ran {
    /// Its JSON, with the exit code as `exit`.
    Wrote(Value),
    /// A model that is absent.
    Lacks(String),
    Failed(String),
}

impl Runs {
    /// None yet; models lie in a folder.
    #[must_use]
    pub fn new(data: Option<PathBuf>) -> Self {
        Self { data, done: BTreeMap::new() }
    }

    /// Runs the commands of an item, and says what they find; `None` of one that only tests show.
    pub fn check(&mut self, item: &Item) -> Option<Finding> {
        if item.check.run.is_empty() {
            return None;
        }
        let told = |outcome| Some(Finding { measured: item.told(), outcome, others: Vec::new() });
        for words in &item.check.run {
            if !self.done.contains_key(words) {
                let ran = self.run(words);
                self.done.insert(words.clone(), ran);
            }
        }
        let mut all = Vec::new();
        for words in &item.check.run {
            match &self.done[words] {
                Ran::Wrote(json) => all.push(json),
                Ran::Lacks(model) => return told(Outcome::NotHere(format!("the model {model}"))),
                Ran::Failed(why) => return told(Outcome::Fails(format!("cullet {words}: {why}"))),
            }
        }
        judged(item, &all).map_or_else(|why| told(Outcome::Fails(why)), Some)
    }

    fn run(&self, words: &str) -> Ran {
        let mut args = vec!["cullet".to_owned()];
        for word in words.split(' ') {
            let Some(model) = word.strip_prefix(DATA) else {
                args.push(word.to_owned());
                continue;
            };
            match self.model(model) {
                Some(path) => args.push(path.to_string_lossy().into_owned()),
                None => return Ran::Lacks(model.to_owned()),
            }
        }
        args.extend(["--json".to_owned(), "-".to_owned()]);
        // Two commands write pictures too, whether these are wanted or not.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let (process, number) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let folder = std::env::temp_dir().join(format!("cullet-lecture-{process}-{number}"));
        if matches!(&*args[1], "report" | "reproduce") {
            args.extend(["--out".to_owned(), folder.to_string_lossy().into_owned()]);
        }
        let ran = match parsed(&args).map(take_json) {
            Ok((Ok(exit), Some(Value::Object(mut json)))) => {
                json.insert("exit".to_owned(), json!(exit as u8));
                Ran::Wrote(Value::Object(json))
            }
            Ok((Ok(exit), _)) => Ran::Failed(format!("exit code {}, and no JSON", exit as u8)),
            Ok((Err(failure), _)) => Ran::Failed(failure.message),
            Err(why) => Ran::Failed(why),
        };
        let _ = std::fs::remove_dir_all(&folder);
        ran
    }

    /// A model of the data folder, by its path in it, or as `cullet fetch` names it.
    fn model(&self, file: &str) -> Option<PathBuf> {
        let folder = self.data.as_deref().unwrap_or(Path::new("models"));
        let fetched = FETCHED.iter().find(|(name, _)| *name == file).map(|(_, fetched)| *fetched);
        let places = [Some(file), fetched].into_iter().flatten();
        places.map(|file| folder.join(file)).find(|path| path.is_file())
    }
}

/// A command line of any of the programs whose commands are in this one.
#[derive(Debug, Parser)]
struct Line<C: clap::Subcommand> {
    #[command(subcommand)]
    command: C,
}

/// Returns a closure that runs a command line, in this process.
fn parsed(args: &[String]) -> Result<Box<dyn FnOnce() -> exit::Outcome>, String> {
    fn line<C: clap::Subcommand>(args: &[String]) -> Result<C, String> {
        Ok(Line::try_parse_from(args).map_err(|e| e.to_string())?.command)
    }
    bakery::provide(cullet_baker::bakery());
    match elsewhere(&args[1]).map(|command| command.program.name) {
        None => {
            let mut command: cullet_cli::Command = line(args)?;
            command.settle();
            Ok(Box::new(move || command.run(true)))
        }
        Some(name) if name == BAKER.name => {
            let command: cullet_baker::Command = line(args)?;
            Ok(Box::new(move || command.run(true)))
        }
        Some(name) if name == LAB.name => {
            let mut command: crate::Command = line(args)?;
            command.settle();
            Ok(Box::new(move || command.run(true)))
        }
        Some(name) => Err(format!("it is a command of {name}, which cannot be run from here")),
    }
}

/// Whether a comparison holds of two numbers.
type Comparison = fn(f64, f64) -> bool;

/// Operators of comparisons; longer ones first, so that `>=` is not read as `>`.
const OPERATORS: [(&str, Comparison); 6] = [
    (" >= ", |a, b| a >= b),
    (" <= ", |a, b| a <= b),
    (" == ", |a, b| a == b),
    (" != ", |a, b| a != b),
    (" > ", |a, b| a > b),
    (" < ", |a, b| a < b),
];

/// Judges an item by the JSON of its commands.
fn judged(item: &Item, runs: &[&Value]) -> Result<Finding, String> {
    let (mut figures, mut others) = (Vec::new(), Vec::new());
    for figure in &item.figures {
        let held = held(figure);
        let Some((_, formula)) = figure.split_once(" = ") else {
            figures.push(held.to_owned());
            continue;
        };
        let found = value(formula, runs).map_err(|e| format!("{formula}: {e}"))?;
        let now = written(found, decimals(held), held);
        if !figure.contains(" ~ ") && !agrees(held, found) {
            others.push(format!("{held} was {formula}, which is {now}"));
        }
        figures.push(now);
    }
    let measured = item.sentence(figures.into_iter());
    let mut outcome = item.outcome();
    let comparisons = &item.check.holds;
    for (words, run) in item.check.run.iter().zip(runs) {
        if run["exit"] != 0 && !comparisons.iter().any(|c| c.contains("/exit")) {
            outcome = Outcome::Fails(format!("cullet {words}: exit code {}", run["exit"]));
        }
    }
    for comparison in comparisons {
        let operator = OPERATORS.iter().find(|(symbol, _)| comparison.contains(symbol));
        let (symbol, holds) = operator.ok_or(format!("{comparison}: there is no comparison"))?;
        let of = |text: &str| value(text, runs).map_err(|e| format!("{comparison}: {e}"));
        let (left, right) = comparison.split_once(symbol).unwrap_or_default();
        let (left, right) = (of(left)?, of(right)?);
        if !holds(left, right) {
            outcome = Outcome::Fails(format!("{comparison}: it is {left}, against {right}"));
        }
    }
    Ok(Finding { measured, outcome, others })
}

fn decimals(held: &str) -> usize {
    held.split_once('.').map_or(0, |(_, digits)| digits.len())
}

/// Whether a value is a figure as the book has it: within half a unit of its last digit and a
/// hundredth of it, for a last bit may make another view's triangle face away. A whole number below
/// fifty is exact.
#[must_use]
pub fn agrees(figure: &str, value: f64) -> bool {
    let text = held(figure);
    let Ok(told) = text.replace(',', "").parse::<f64>() else { return false };
    let unit = 0.1f64.powi(decimals(text) as i32);
    (value - told).abs() <= 0.5 * unit + 0.01 * told.abs() + 1e-12
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lecture::lectures;

    fn item(holds: &[&str]) -> Item {
        let mut item = lectures().items[0].clone();
        item.measured = "of {} {} go".to_owned();
        item.figures = vec!["1,200 = /all".to_owned(), "7 ~ = /gone".to_owned()];
        item.check.run = vec!["verify".to_owned()];
        item.check.holds = holds.iter().map(ToString::to_string).collect();
        item
    }

    #[test]
    fn comparisons_and_exit_codes_decide_and_figures_are_filled_in() {
        let json = |exit: u8| json!({"all": 1200, "gone": 9, "exit": exit});
        let of = |holds: &[&str], exit| judged(&item(holds), &[&json(exit)]);
        let found = of(&["/gone < /all", "/gone >= 9"], 0).expect("sound");
        assert_eq!((&*found.measured, &found.outcome), ("of 1,200 9 go", &Outcome::Holds));
        assert!(found.others.is_empty(), "{found:?}");
        let fails = |holds: &[&str], exit| {
            matches!(of(holds, exit).map(|f| f.outcome), Ok(Outcome::Fails(_)))
        };
        assert!(fails(&["/gone > /all"], 0) && fails(&["/gone == 9", "/gone != 9"], 0));
        assert!(fails(&["/gone == 9"], 1) && !fails(&["/gone == 9", "/exit == 1"], 1));
        assert!(of(&["/gone"], 0).is_err() && of(&["/none == 1"], 0).is_err());
    }

    #[test]
    fn a_figure_is_another_only_beyond_its_last_digit() {
        for (figure, value) in [("12", 12.4), ("0", 0.0), ("1,234", 1240.0), ("4.0 = /a", 3.96)] {
            assert!(agrees(figure, value), "{figure} {value}");
        }
        for (figure, value) in [("12", 13.0), ("0", 1.0), ("1,234", 1300.0), ("many", 1.0)] {
            assert!(!agrees(figure, value), "{figure} {value}");
        }
    }

    #[test]
    fn a_model_is_found_by_its_folder_or_as_it_was_fetched_and_else_it_is_said_to_lack() {
        let folder = cullet_testkit::Folder::new("fetched");
        let runs = Runs::new(Some(folder.path("").into()));
        let asked = "stanford-bunny/bun_zipper.ply";
        assert_eq!(runs.model(asked), None);
        assert!(
            matches!(runs.run("info DATA/stanford-bunny/bun_zipper.ply"), Ran::Lacks(m) if m == asked)
        );
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        assert!(folder.file("bunny.ply", ply).ends_with("bunny.ply"));
        assert!(runs.model(asked).is_some_and(|path| path.ends_with("bunny.ply")));
        assert!(
            matches!(runs.run("info DATA/stanford-bunny/bun_zipper.ply"), Ran::Wrote(j) if j["exit"] == 0)
        );
        assert!(matches!(runs.run("info --none"), Ran::Failed(_)));
        assert!(matches!(runs.run("view knobs"), Ran::Failed(_)));
    }
}
