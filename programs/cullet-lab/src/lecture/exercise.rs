//! Exercises of the book, with answers.

use serde::Deserialize;
use thiserror::Error;

/// An exercise of the book.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[non_exhaustive]
pub struct Exercise {
    /// Its name, such as `frustum-1`.
    pub id: String,
    /// The file of `docs/src` that poses it.
    pub chapter: String,
    /// The question, with its numbers.
    pub question: String,
    /// The words that one may answer with; empty where a number is sought.
    pub choices: Vec<String>,
    /// The answer.
    pub answer: Answer,
    /// How far a number may be off.
    pub tolerance: f64,
    /// The unit of the number; empty where it has none.
    pub unit: String,
    /// Why that is the answer.
    pub solution: String,
}

/// An answer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Answer {
    /// A number.
    Number(f64),
    /// One of the choices.
    Choice(String),
}

/// An answer that is none: of another kind than what is sought.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NoAnswer {
    /// A number is sought.
    #[error("'{0}' is no number; a number{1} is sought")]
    Number(String, String),
    /// A word is sought that is among the choices.
    #[error("'{0}' is not among the choices: {1}")]
    Choice(String, String),
}

/// What an answer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judged {
    /// The answer.
    Right,
    /// Not far from it, as a number that was rounded too much is.
    Near,
    /// Neither.
    Wrong,
}

/// A number that is off by no more than this share of the answer is near it.
const NEAR: f64 = 0.05;

/// Units, and what people write in their place.
const UNITS: [(&str, &[&str]); 5] = [
    ("pixels", &["pixel", "px"]),
    ("degrees", &["degree", "deg", "°"]),
    ("m", &["metres", "metre"]),
    ("bytes", &["byte"]),
    ("ms", &["milliseconds"]),
];

impl Exercise {
    /// Judges an answer. A number may have its unit behind it, commas between thousands, or % for a hundredth; the case of words does not
    /// matter.
    ///
    /// # Errors
    /// If it is no number where one is sought, or none of the choices.
    pub fn judge(&self, given: &str) -> Result<Judged, NoAnswer> {
        let given = given.trim();
        match &self.answer {
            Answer::Number(right) => {
                let number = self.number(given).ok_or_else(|| {
                    let unit = if self.unit.is_empty() {
                        String::new()
                    } else {
                        format!(" of {}", self.unit)
                    };
                    NoAnswer::Number(given.to_owned(), unit)
                })?;
                let off = (number - right).abs();
                // What is written with few digits is meant as written.
                Ok(if off <= self.tolerance + 1e-9 * right.abs() {
                    Judged::Right
                } else if off <= NEAR * right.abs() && right.fract() != 0.0 {
                    Judged::Near
                } else {
                    Judged::Wrong
                })
            }
            Answer::Choice(right) => {
                let same = |word: &str| word.eq_ignore_ascii_case(given);
                if self.choices.iter().any(|c| same(c)) {
                    Ok(if same(right) { Judged::Right } else { Judged::Wrong })
                } else {
                    Err(NoAnswer::Choice(given.to_owned(), self.choices.join(", ")))
                }
            }
        }
    }

    /// The number that is written, without its unit.
    fn number(&self, given: &str) -> Option<f64> {
        let same = UNITS.iter().find(|(unit, _)| *unit == self.unit).map_or(&[][..], |(_, s)| *s);
        let mut units = std::iter::once(self.unit.as_str()).chain(same.iter().copied());
        let bare = units.find_map(|unit| given.strip_suffix(unit).filter(|_| !unit.is_empty()));
        let (bare, factor) = match given.strip_suffix('%') {
            Some(share) => (share, 0.01),
            None => (bare.unwrap_or(given), 1.0),
        };
        let bare = bare.trim().replace(',', "").replace('−', "-");
        bare.parse::<f64>().ok().filter(|n| n.is_finite()).map(|n| n * factor)
    }
}

/// All exercises, in the order of the book's chapters. Cost: reads some kilobytes of JSON at each call.
#[must_use]
pub fn exercises() -> Vec<Exercise> {
    // A test holds that it can be read.
    serde_json::from_str(include_str!("exercises.json")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(id: &str) -> Exercise {
        exercises().into_iter().find(|e| e.id == id).unwrap_or_else(|| panic!("there is no {id}"))
    }

    #[test]
    fn all_can_be_read_and_their_own_answers_are_right() {
        let all = exercises();
        assert!(all.len() >= 40, "{}", all.len());
        for exercise in all {
            let own = match &exercise.answer {
                Answer::Number(number) => number.to_string(),
                Answer::Choice(word) => word.clone(),
            };
            assert_eq!(exercise.judge(&own), Ok(Judged::Right), "{}", exercise.id);
            assert!(exercise.judge("a wholly other word").is_err(), "{}", exercise.id);
            for other in exercise.choices.iter().filter(|c| **c != own) {
                assert_eq!(exercise.judge(other), Ok(Judged::Wrong), "{}", exercise.id);
            }
        }
    }

    #[test]
    fn numbers_are_read_as_people_write_them() {
        let mut exercise = named("why-1");
        for given in ["2.4", " 2.40", "+2.4", "240%", "240 %"] {
            assert_eq!(exercise.judge(given), Ok(Judged::Right), "{given}");
        }
        assert_eq!(exercise.judge("2.5"), Ok(Judged::Near));
        assert_eq!(exercise.judge("2.6"), Ok(Judged::Wrong));
        assert!(matches!(exercise.judge("NaN"), Err(NoAnswer::Number(..))));
        (exercise.answer, exercise.tolerance) = (Answer::Number(-1200.0), 0.0);
        exercise.unit = "pixels".to_owned();
        for given in ["-1200", "−1,200", "-1200 px", "-1200px", "-1200 pixels"] {
            assert_eq!(exercise.judge(given), Ok(Judged::Right), "{given}");
        }
        // A whole number is not rounded by anybody.
        assert_eq!(exercise.judge("-1201"), Ok(Judged::Wrong));
        assert!(exercise.judge("-1200 m").is_err());
    }
}
