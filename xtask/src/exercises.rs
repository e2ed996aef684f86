//! The exercises of the book: what a chapter poses and what `exercises.json` of the crate `cullet-lecture` answers are the same list.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use crate::tools::{Done, root};

/// The list, from the root; `cullet quiz` answers by it.
const LIST: &str = "crates/cullet-lecture/src/exercises.json";

/// Every exercise of the list is posed in its chapter, and every one of a chapter is in the list, with an answer that fits its kind.
pub(crate) fn all_told() -> Done {
    let path = root().join(LIST);
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let list: Vec<Value> = serde_json::from_str(&text).map_err(|e| format!("{LIST}: {e}"))?;
    let mut known = BTreeSet::new();
    for exercise in &list {
        let id = field(exercise, "id")?;
        if !known.insert(id.to_owned()) {
            return Err(format!("{LIST}: {id} is there twice"));
        }
        is_sound(exercise).map_err(|why| format!("{LIST}: {id}: {why}"))?;
        let chapter = field(exercise, "chapter")?;
        let text = chapter_text(chapter)?;
        for shown in [format!("**{id}.**"), format!("`cullet quiz {id} ANSWER`")] {
            if !text.contains(&shown) {
                return Err(format!("{LIST}: {chapter} does not have {shown}"));
            }
        }
    }
    let chapters: BTreeSet<&str> = list.iter().filter_map(|e| e["chapter"].as_str()).collect();
    for chapter in chapters {
        let text = chapter_text(chapter)?;
        let posed = text.split("`cullet quiz ").skip(1).filter_map(|r| r.split(' ').next());
        if let Some(id) = posed.into_iter().find(|id| !known.contains(*id)) {
            return Err(format!("{chapter} poses {id}, which is not in {LIST}"));
        }
    }
    Ok(())
}

fn chapter_text(chapter: &str) -> Result<String, String> {
    let path = root().join("docs/src").join(chapter);
    fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))
}

/// A text of an exercise that must not be empty.
fn field<'a>(exercise: &'a Value, name: &str) -> Result<&'a str, String> {
    let text = exercise[name].as_str().filter(|t| !t.is_empty());
    text.ok_or_else(|| format!("{LIST}: an exercise without {name}: {exercise}"))
}

/// Whether the answer is of the exercise's kind.
fn is_sound(exercise: &Value) -> Done {
    for name in ["question", "solution", "computed_by"] {
        field(exercise, name)?;
    }
    let choices = exercise["choices"].as_array().ok_or("no array of choices")?;
    match field(exercise, "kind")? {
        "number" if exercise["answer"].is_number() && choices.is_empty() => {
            let tolerance = exercise["tolerance"].as_f64().ok_or("no tolerance")?;
            if tolerance >= 0.0 { Ok(()) } else { Err("a tolerance below 0".into()) }
        }
        "choice" if choices.len() > 1 && choices.contains(&exercise["answer"]) => Ok(()),
        kind => Err(format!("the answer is none of a {kind}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_exercise_is_posed_and_answered() {
        all_told().unwrap();
    }

    #[test]
    fn an_answer_that_is_no_choice_is_refused() {
        let of = |text: &str| is_sound(&serde_json::from_str(text).unwrap());
        let rest = r#""question": "?", "solution": "!", "computed_by": "it""#;
        let choice = |answer: &str| {
            of(&format!(
                r#"{{"kind": "choice", "choices": ["a", "b"], "answer": "{answer}", {rest}}}"#
            ))
        };
        assert!(choice("a").is_ok() && choice("c").is_err());
        let number = r#"{"kind": "number", "choices": [], "answer": "3", "tolerance": 0, "#;
        assert!(of(&format!("{number}{rest}}}")).is_err(), "a number in quotes");
    }
}
