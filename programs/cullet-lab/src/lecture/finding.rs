//! What a check found.

use serde::Serialize;

/// What a check found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What was measured here, in a sentence with its numbers.
    pub measured: String,
    /// What follows.
    pub outcome: Outcome,
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
    /// It does not, and nobody knew: a defect of the text, or of this program.
    Fails,
    /// It cannot be tried here: what is missing.
    NotHere(String),
}

impl Finding {
    /// What is claimed was found.
    pub fn holds(measured: impl Into<String>) -> Self {
        Self { measured: measured.into(), outcome: Outcome::Holds }
    }

    /// What the text says was found wrong, and what it should say right.
    pub fn mended(measured: impl Into<String>) -> Self {
        Self { measured: measured.into(), outcome: Outcome::Mended }
    }

    /// The claim holds with another number.
    pub fn differs(measured: impl Into<String>) -> Self {
        Self { measured: measured.into(), outcome: Outcome::Differs }
    }

    /// What is claimed was not found.
    pub fn fails(measured: impl Into<String>) -> Self {
        Self { measured: measured.into(), outcome: Outcome::Fails }
    }

    /// Holds if it was seen; fails otherwise.
    pub fn if_so(seen: bool, measured: impl Into<String>) -> Self {
        if seen { Self::holds(measured) } else { Self::fails(measured) }
    }

    /// It cannot be tried here, for want of something.
    pub fn not_here(missing: impl Into<String>) -> Self {
        Self { measured: String::new(), outcome: Outcome::NotHere(missing.into()) }
    }

    /// Whether the claim was tried and came out as it is told.
    #[must_use]
    pub fn is_right(&self) -> bool {
        matches!(self.outcome, Outcome::Holds | Outcome::Mended | Outcome::Differs)
    }
}
