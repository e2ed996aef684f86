//! Exercises of the book: the chapters pose them, and have the answers in comments beside them.

use thiserror::Error;

/// An exercise of the book.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Exercise {
    /// Name, such as `frustum-1`.
    pub id: &'static str,
    /// The file of `docs/src` that poses it.
    pub chapter: &'static str,
    /// Introduction of the chapter to its exercises, such as the camera that all of them are about.
    pub context: String,
    /// The question, with its numbers.
    pub question: String,
    /// The words that one may answer with; empty where a number is sought.
    pub choices: Vec<&'static str>,
    /// The answer.
    pub answer: Answer,
    /// How far a number may be off.
    pub tolerance: f64,
    /// The unit of the number; empty where it has none.
    pub unit: &'static str,
    /// Why that is the answer.
    pub solution: String,
}

/// An answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// A number.
    Number(f64),
    /// One of the choices.
    Choice(&'static str),
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

/// Verdict on an answer.
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
    /// Judges an answer. A number may have its unit behind it, commas between thousands, or % for a
    /// hundredth; the case of words does not matter.
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
        let mut units = std::iter::once(self.unit).chain(same.iter().copied());
        let bare = units.find_map(|unit| given.strip_suffix(unit).filter(|_| !unit.is_empty()));
        let (bare, factor) = match given.strip_suffix('%') {
            Some(share) => (share, 0.01),
            None => (bare.unwrap_or(given), 1.0),
        };
        let bare = bare.trim().replace(',', "").replace('−', "-");
        bare.parse::<f64>().ok().filter(|n| n.is_finite()).map(|n| n * factor)
    }
}

macro_rules! chapters {
    ($($name:literal)+) => {
        [$(($name, include_str!(concat!("../../../../docs/src/", $name)))),+]
    };
}

/// The chapters with exercises, in the order of the book.
const CHAPTERS: [(&str, &str); 26] = chapters![
    "why.md" "bottleneck.md" "kinds.md" "frustum.md" "hierarchy.md" "backface.md"
    "backface-masks.md" "backface-clusters.md" "degenerate.md" "detail.md" "portals.md" "shadows.md"
    "occlusion.md" "occluders.md" "gpu.md" "queries.md" "queries-region.md" "pvs.md" "pvs-scene.md"
    "levels.md" "merged.md" "popping.md" "impostors.md" "clipping.md" "cutting.md" "moving.md"
];

/// All exercises, in the order of the book's chapters. Cost: reads the chapters at each call.
///
/// # Errors
/// The first exercise of a chapter that is not whole, and what it lacks; a test holds that there is
/// none.
pub fn exercises() -> Result<Vec<Exercise>, String> {
    let mut all = Vec::new();
    for (chapter, text) in CHAPTERS {
        all.extend(posed(chapter, text)?);
    }
    Ok(all)
}

/// The exercises of a chapter: below their heading, each with a name in bold, its question, its
/// answer in a comment and a folded solution. Other paragraphs there are of all that follow.
fn posed(chapter: &'static str, text: &'static str) -> Result<Vec<Exercise>, String> {
    let (_, section) = text.split_once("\n## Exercises\n").unwrap_or_default();
    let section = section.split("\n## ").next().unwrap_or_default();
    let (mut all, mut context) = (Vec::new(), String::new());
    for part in section.split_inclusive("</details>") {
        let Some((before, posed)) = part.split_once("**") else { continue };
        let (id, posed) = posed.split_once(".** ").unwrap_or_default();
        let lacks = |what: &str| format!("{chapter}: {id} has no {what}");
        context = [&*context, &*one_line(before)].join(" ").trim().to_owned();
        let asks = format!("`cullet quiz {id} ANSWER`");
        let (question, rest) = posed.split_once(&asks).ok_or_else(|| lacks(&asks))?;
        let (_, rest) = rest.split_once(&format!("<!-- {id}: ")).ok_or_else(|| lacks("answer"))?;
        let (answer, rest) = rest.split_once(" -->").ok_or_else(|| lacks("end of its answer"))?;
        let (_, solution) = rest.split_once("</summary>").ok_or_else(|| lacks("solution"))?;
        let question = one_line(question.trim_end().trim_end_matches("Check with"));
        let solution = one_line(solution.trim_end_matches("</details>"));
        let (answer, choices, tolerance, unit) =
            read(answer).ok_or_else(|| lacks("sound answer"))?;
        let context = context.clone();
        all.push(Exercise {
            id,
            chapter,
            context,
            question,
            choices,
            answer,
            tolerance,
            unit,
            solution,
        });
    }
    Ok(all)
}

/// Reads `WORD (WORD, OTHER WORD)`, or `NUMBER ± TOLERANCE UNIT` without the one or the other: the
/// answer, the choices, the tolerance and the unit.
fn read(answer: &'static str) -> Option<(Answer, Vec<&'static str>, f64, &'static str)> {
    if let Some((word, choices)) = answer.split_once(" (") {
        let choices: Vec<&str> = choices.strip_suffix(')')?.split(", ").collect();
        return choices.contains(&word).then_some((Answer::Choice(word), choices, 0.0, ""));
    }
    let (number, rest) = answer.split_once(' ').unwrap_or((answer, ""));
    let (tolerance, unit) = match rest.strip_prefix("± ") {
        None => ("0", rest),
        Some(rest) => rest.split_once(' ').unwrap_or((rest, "")),
    };
    let tolerance = tolerance.parse().ok().filter(|t| *t >= 0.0)?;
    Some((Answer::Number(number.parse().ok()?), Vec::new(), tolerance, unit))
}

/// Text in one line.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(id: &str) -> Exercise {
        let all = exercises().expect("all are whole");
        all.into_iter().find(|e| e.id == id).unwrap_or_else(|| panic!("there is no {id}"))
    }

    #[test]
    fn all_can_be_read_and_their_own_answers_are_right() {
        let all = exercises().expect("all are whole");
        assert!(all.len() >= 65, "{}", all.len());
        for exercise in all {
            let own = match exercise.answer {
                Answer::Number(number) => number.to_string(),
                Answer::Choice(word) => word.to_owned(),
            };
            assert_eq!(exercise.judge(&own), Ok(Judged::Right), "{}", exercise.id);
            assert!(exercise.judge("a wholly other word").is_err(), "{}", exercise.id);
            assert!(!exercise.question.is_empty() && !exercise.solution.is_empty(), "{exercise:?}");
            for other in exercise.choices.iter().filter(|c| **c != own) {
                assert_eq!(exercise.judge(other), Ok(Judged::Wrong), "{}", exercise.id);
            }
        }
    }

    #[test]
    fn an_exercise_is_read_with_what_stands_before_it() {
        let text = "# A\n\n## Exercises\n\nIt is **2 m** wide.\n\n**a-1.** How\nlong? `cullet quiz a-1 ANSWER`\n\
                    <!-- a-1: -0.5 ± 0.01 m -->\n\n<details><summary>Solution</summary>\n\nAs told.\n\n</details>\n\n## More\n";
        let text: &'static str = Box::leak(text.replace("**2 m**", "2 m").into_boxed_str());
        let [exercise] = &posed("a.md", text).expect("whole")[..] else { panic!("one") };
        assert_eq!(
            (exercise.id, &*exercise.context, &*exercise.question),
            ("a-1", "It is 2 m wide.", "How long?")
        );
        assert_eq!(
            (exercise.answer, exercise.tolerance, exercise.unit),
            (Answer::Number(-0.5), 0.01, "m")
        );
        assert_eq!(exercise.solution, "As told.");
        assert_eq!(
            read("yes (yes, no)"),
            Some((Answer::Choice("yes"), vec!["yes", "no"], 0.0, ""))
        );
        for none in ["perhaps (yes, no)", "many", "1 ± -2", "yes (yes, no"] {
            assert_eq!(read(none), None, "{none}");
        }
        let without = Box::leak(text.replace("<!-- a-1: -0.5 ± 0.01 m -->", "").into_boxed_str());
        assert_eq!(posed("a.md", without), Err("a.md: a-1 has no answer".to_owned()));
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
        exercise.unit = "pixels";
        for given in ["-1200", "−1,200", "-1200 px", "-1200px", "-1200 pixels"] {
            assert_eq!(exercise.judge(given), Ok(Judged::Right), "{given}");
        }
        // A whole number is not rounded by anybody.
        assert_eq!(exercise.judge("-1201"), Ok(Judged::Wrong));
        assert!(exercise.judge("-1200 m").is_err());
    }
}
