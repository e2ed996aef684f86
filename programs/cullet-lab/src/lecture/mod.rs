//! Statements of three lectures and a paper about culling, item by item, each with what shows it:
//! `docs/lectures.json`.
//!
//! An [`Item`] is a claim, a formula, a method, a picture or a table, in words of our own, with
//! where it [stands](Place), what is measured of it, the command and the viewer's state that show
//! it, and a [`Check`]: commands whose figures are compared, or tests. Where a text errs, the check
//! shows both: that what is written fails, and that what should be written holds.
//!
//! The file is JSON and not TOML for its readers: the page of slides reads it as it lies there, and
//! the programs that read it have a reader of JSON anyway.

mod check;
mod command;
mod formula;
mod page;
mod print;

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

pub use check::{Finding, Outcome, Runs, agrees};
pub use command::{HELP, LectureArgs};
pub use page::page;

pub(crate) use command::run;

/// Texts, and what they say.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lectures {
    /// The texts.
    pub texts: Vec<Text>,
    /// All items, ascending by number.
    pub items: Vec<Item>,
}

/// A lecture, or a paper.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Text {
    /// Name on the command line.
    pub name: String,
    /// Authors, title and year.
    pub about: String,
}

/// Something that a text says or shows: a claim, a formula, a method, a picture or a table.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Item {
    /// Number, 1 to 101, in the order of the subject.
    pub number: u32,
    /// Title.
    pub title: String,
    /// Places in the texts.
    pub places: Vec<Place>,
    /// Statement of the item, in our own words.
    pub claim: String,
    /// The number or the formula that a text gives, if it gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub said: Option<String>,
    /// Sentence about what is measured here, with a `{}` for each of the figures.
    pub measured: String,
    /// The figures of the sentence as they are in the book: `1,234`, or `1,234 = FORMULA` of the
    /// commands of the check. One with a `~` behind it varies from machine to machine.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<String>,
    /// Whether the claim holds but for the number, which the book explains.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub differs: bool,
    /// Where a text errs: what it says, what is right, and why. The check shows both.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// The command that shows it, or another of the same kind.
    pub command: String,
    /// The viewer's scene of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub live: Option<Live>,
    /// Where the book explains it: a file of `docs/src`, and a heading of it.
    pub chapter: String,
    /// Check that shows it.
    pub check: Check,
}

/// Where an item stands in a text.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// The text's name.
    pub text: String,
    /// The slide by its number, the section, the table or the figure; the slide's title where
    /// slides have no numbers.
    pub at: String,
}

/// A scene in the viewer.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Live {
    /// A built-in scene, with its settings.
    pub scene: String,
    /// The viewer's state, as in its links.
    pub state: String,
}

/// Check that shows a claim: commands and comparisons of the figures that they write, tests, or
/// both.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Command lines of `cullet`, without its name and without `--json -`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub run: Vec<String>,
    /// Conditions on their JSON: two formulas with `<`, `<=`, `>`, `>=`, `==` or `!=` between them.
    ///
    /// A command that ends with another exit code than 0 fails the item, unless a comparison is of
    /// `/exit`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holds: Vec<String>,
    /// Tests, as `crates/cullet/tests/view.rs::all_six_normals_point_out`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub test: Vec<String>,
    /// Words of these tests, or of their files, that hold what the measured sentence says.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub says: Vec<String>,
}

static LECTURES: LazyLock<Lectures> = LazyLock::new(|| {
    let file = include_str!("../../../../docs/lectures.json");
    serde_json::from_str(file).unwrap_or_else(|e| panic!("docs/lectures.json: {e}"))
});

/// All texts and items.
#[must_use]
pub fn lectures() -> &'static Lectures {
    &LECTURES
}

impl Item {
    /// The measured sentence with the figures that the book has.
    #[must_use]
    pub fn told(&self) -> String {
        self.sentence(self.figures.iter().map(|figure| held(figure).to_owned()))
    }

    /// The measured sentence with these figures.
    fn sentence(&self, figures: impl Iterator<Item = String>) -> String {
        figures.fold(self.measured.clone(), |text, figure| text.replacen("{}", &figure, 1))
    }

    /// Whether the claim holds, in a word or two.
    fn outcome(&self) -> Outcome {
        match (&self.fault, self.differs) {
            (Some(_), _) => Outcome::Mended,
            (None, true) => Outcome::Differs,
            (None, false) => Outcome::Holds,
        }
    }

    /// Places in words.
    fn stands(&self) -> String {
        let words = self.places.iter().map(|p| format!("{}, {}", p.text, p.at));
        words.collect::<Vec<_>>().join("; ")
    }

    /// Whether a text has it.
    fn is_of(&self, text: &str) -> bool {
        self.places.iter().any(|place| place.text == text)
    }
}

impl Check {
    /// Returns the shell commands that run the tests.
    fn commands(&self) -> impl Iterator<Item = String> {
        self.test.iter().map(|test| {
            let (file, name) = test.split_once("::").unwrap_or((test, ""));
            let package = match file.split('/').nth(1) {
                Some("cullet") if file.starts_with("programs") => "cullet-cli",
                folder => folder.unwrap_or_default(),
            };
            format!("cargo test --release -p {package} {name}")
        })
    }
}

/// A figure as the book has it, without the formula behind it.
fn held(figure: &str) -> &str {
    let text = figure.split(" = ").next().unwrap_or(figure);
    text.trim_end_matches(" ~")
}
