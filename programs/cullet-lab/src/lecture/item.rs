//! An item of the texts.

use serde::Serialize;

use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::text::Text;

/// Something that a text says or shows: a claim, a formula, a method, a picture or a table.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Item {
    /// Its number, 1 to 101, in the order of the subject.
    pub number: u8,
    /// What it is called.
    pub title: &'static str,
    /// Where it stands.
    pub places: &'static [Place],
    /// What is said, in words of our own.
    pub claim: &'static str,
    /// The number that a text gives, if it gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub said: Option<&'static str>,
    /// Where a text errs: what it says, what is right, and why. The check shows both.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<&'static str>,
    /// The command that shows it, or another of the same kind.
    pub command: &'static str,
    /// What the viewer shows of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub live: Option<Live>,
    /// Where the book explains it: a file of `docs/src`, and a heading of it.
    pub chapter: &'static str,
    /// Measures it here.
    #[serde(skip)]
    pub check: fn(&Lab) -> Result<Finding, LabError>,
}

/// Where an item stands in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Place {
    /// The text.
    pub text: Text,
    /// The slide by its number, the section, the table or the figure; the slide's title where slides have no numbers.
    pub at: &'static str,
}

/// A scene in the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Live {
    /// A built-in scene, with its settings.
    pub scene: &'static str,
    /// The viewer's state, as in its links.
    pub state: &'static str,
}

pub(crate) const fn zachmann(at: &'static str) -> Place {
    Place { text: Text::Zachmann, at }
}

pub(crate) const fn ucsd(at: &'static str) -> Place {
    Place { text: Text::Ucsd, at }
}

pub(crate) const fn kaist(at: &'static str) -> Place {
    Place { text: Text::Kaist, at }
}

pub(crate) const fn zhang_hoff(at: &'static str) -> Place {
    Place { text: Text::ZhangHoff, at }
}

/// The one that others are written from, so that each item says only what it has.
pub(crate) const BLANK: Item = Item {
    number: 0,
    title: "",
    places: &[],
    claim: "",
    said: None,
    fault: None,
    command: "",
    live: None,
    chapter: "",
    check: |_| Ok(Finding::fails("nothing was measured")),
};
