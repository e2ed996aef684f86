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

impl Exercise {
    /// Whether an answer is right. A number may have its unit behind it, commas between thousands, and %; the case of words does not matter.
    ///
    /// # Errors
    /// If it is no number where one is sought, or none of the choices.
    pub fn is_right(&self, given: &str) -> Result<bool, NoAnswer> {
        let given = given.trim();
        match &self.answer {
            Answer::Number(right) => {
                let bare = given.strip_suffix(self.unit.as_str()).unwrap_or(given).trim();
                let bare = bare.trim_end_matches('%').trim().replace(',', "").replace('−', "-");
                let number = bare.parse::<f64>().ok().filter(|n| n.is_finite());
                let unit =
                    if self.unit.is_empty() { String::new() } else { format!(" of {}", self.unit) };
                let number = number.ok_or_else(|| NoAnswer::Number(given.to_owned(), unit))?;
                // What is written with few digits is meant as written.
                Ok((number - right).abs() <= self.tolerance + 1e-9 * right.abs())
            }
            Answer::Choice(right) => {
                let same = |word: &str| word.eq_ignore_ascii_case(given);
                if self.choices.iter().any(|c| same(c)) {
                    Ok(same(right))
                } else {
                    Err(NoAnswer::Choice(given.to_owned(), self.choices.join(", ")))
                }
            }
        }
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
            assert_eq!(exercise.is_right(&own), Ok(true), "{}", exercise.id);
            assert!(exercise.is_right("a wholly other word").is_err(), "{}", exercise.id);
            for other in exercise.choices.iter().filter(|c| **c != own) {
                assert_eq!(exercise.is_right(other), Ok(false), "{}", exercise.id);
            }
        }
    }

    #[test]
    fn numbers_are_read_as_people_write_them() {
        let mut exercise = named("why-1");
        for given in ["2.4", " 2.40", "+2.4"] {
            assert_eq!(exercise.is_right(given), Ok(true), "{given}");
        }
        assert_eq!(exercise.is_right("2.5"), Ok(false));
        assert!(matches!(exercise.is_right("NaN"), Err(NoAnswer::Number(..))));
        (exercise.answer, exercise.tolerance) = (Answer::Number(-1200.0), 0.0);
        exercise.unit = "px".to_owned();
        for given in ["-1200", "−1,200", "-1200 px", "-1200px"] {
            assert_eq!(exercise.is_right(given), Ok(true), "{given}");
        }
    }
}
