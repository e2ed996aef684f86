//! What three lectures and a paper say of culling, item by item, each checked here.
//!
//! An [`Item`] is a claim, a formula, a method, a picture or a table, in words of our own, with where it [stands](Place), the command and the
//! viewer's state that show it, and a check, which measures it by the engine and gives a [`Finding`]. Where a text errs, the
//! item says so and the check shows both: that what is written fails, and that what should be written holds.
//!
//! ```
//! use crate::lecture::{Lab, items};
//!
//! let lab = Lab::default();
//! let example = items().find(|item| item.number == 21).expect("all numbers are there");
//! let finding = (example.check)(&lab)?;
//! assert!(finding.is_right(), "{}", finding.measured);
//! # Ok::<(), crate::lecture::LabError>(())
//! ```
//!
//! The book's [`exercises`] stand here too, with their answers.
//!
//! The texts: [`Text`]. Facts carry over from them; sentences, slides and pictures are other people's and do not.
#![forbid(unsafe_code)]

mod exercise;
mod finding;
mod geometry;
mod item;
mod items;
mod lab;
mod text;
mod tools;

pub use exercise::{Answer, Exercise, Judged, NoAnswer, exercises};
pub use finding::{Finding, Outcome};
pub use item::{Item, Live, Place};
pub use items::items;
pub use lab::{Lab, LabError};
pub use text::{NoSuchText, Text};
