//! Items with what was measured of them.

use crate::lecture::{Finding, Item, Outcome, Place};
use serde::Serialize;

/// Items with what was measured.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    schema: u32,
    pub(super) items: Vec<Checked>,
}

impl Record {
    pub(super) fn of(items: impl IntoIterator<Item = Checked>) -> Self {
        Self { schema: 1, items: items.into_iter().collect() }
    }
}

/// An item, and what its check found.
#[derive(Debug, Serialize)]
pub(super) struct Checked {
    #[serde(flatten)]
    pub(super) item: &'static Item,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) found: Option<Finding>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) seconds: Option<f64>,
}

impl Checked {
    pub(super) fn unmeasured(item: &'static Item) -> Self {
        Self { item, found: None, seconds: None }
    }

    pub(super) fn new(item: &'static Item, found: Finding, seconds: f64) -> Self {
        Self { item, found: Some(found), seconds: Some(seconds) }
    }

    /// Whether something came out that nobody told of.
    pub(super) fn is_wrong(&self) -> bool {
        self.found.as_ref().is_some_and(|f| match f.outcome {
            Outcome::Fails => true,
            Outcome::Mended => self.item.fault.is_none(),
            Outcome::Holds | Outcome::Differs => self.item.fault.is_some(),
            Outcome::NotHere(_) => false,
        })
    }
}

/// An outcome in a word or two.
pub(super) fn word(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome::Holds => "holds",
        Outcome::Mended => "the text errs",
        Outcome::Differs => "differs",
        Outcome::Fails => "FAILS",
        Outcome::NotHere(_) => "not here",
    }
}

/// Where an item stands, in words.
pub(super) fn places(places: &[Place]) -> String {
    let words: Vec<String> = places
        .iter()
        .map(|p| if p.at.is_empty() { p.text.to_string() } else { format!("{}, {}", p.text, p.at) })
        .collect();
    words.join("; ")
}
