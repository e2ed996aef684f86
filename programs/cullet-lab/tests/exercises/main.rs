//! Answers of the book's exercises, computed by the engine and held against those in the chapters.
//!
//! A number of the book is a promise of what the engine does, so it is found by the engine's own
//! functions. Where an exercise is on numbers that it gives itself and nothing of the engine
//! computes, its function says so.

mod geometry;
mod hidden;
mod regions;
mod shapes;
mod sides;
mod sizes;
mod subject;

use std::collections::BTreeSet;
use std::error::Error;

use cullet_lab::quiz::{Judged, exercises};

/// An answer as one would type it, or why there is none.
type Computed = Result<String, Box<dyn Error>>;

/// An exercise by its name, and what computes its answer.
type Entry = (&'static str, fn() -> Computed);

/// Returns the entries of every exercise.
fn table() -> Vec<Entry> {
    let before = [subject::ENTRIES, geometry::ENTRIES, sides::ENTRIES, sizes::ENTRIES].concat();
    [&before, hidden::ENTRIES, regions::ENTRIES, shapes::ENTRIES].concat()
}

/// A number as an answer.
fn number(value: f64) -> Computed {
    Ok(value.to_string())
}

/// A choice as an answer: the engine's own word for it. The case of letters does not matter.
fn word(value: impl std::fmt::Debug) -> Computed {
    Ok(format!("{value:?}"))
}

/// Where something ends that holds at `low` and not at `high`, to the last bits.
fn end_of(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    assert!(holds(low) && !holds(high), "no end between {low} and {high}");
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if holds(middle) { &mut low } else { &mut high }) = middle;
    }
    low
}

#[test]
fn each_exercise_is_computed_once() {
    let table = table();
    let computed: BTreeSet<&str> = table.iter().map(|entry| entry.0).collect();
    assert_eq!(computed.len(), table.len(), "one stands twice");
    let exercises = exercises().expect("all are whole");
    let stored: BTreeSet<&str> = exercises.iter().map(|exercise| exercise.id).collect();
    assert_eq!(stored.len(), exercises.len(), "one is stored twice");
    let missing: Vec<_> = stored.difference(&computed).collect();
    assert!(missing.is_empty(), "nothing computes {missing:?}");
    let unknown: Vec<_> = computed.difference(&stored).collect();
    assert!(unknown.is_empty(), "there is no exercise {unknown:?}");
}

#[test]
fn each_answer_is_what_the_engine_computes() {
    let table = table();
    let mut wrong = Vec::new();
    for exercise in exercises().expect("all are whole") {
        let Some((id, compute)) = table.iter().find(|entry| entry.0 == exercise.id) else {
            continue; // the test above fails then
        };
        let computed = compute().unwrap_or_else(|error| panic!("{id}: {error}"));
        println!("{id}: {computed}, the chapter has {:?}", exercise.answer);
        match exercise.judge(&computed) {
            Ok(Judged::Right) => {}
            Ok(_) => wrong.push(format!("{id}: {computed}, the chapter has {:?}", exercise.answer)),
            Err(none) => wrong.push(format!("{id}: {none}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_chapter_poses_what_is_not_read() {
    let known = exercises().expect("all are whole");
    let book = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src");
    let mut posed = 0;
    for file in std::fs::read_dir(&book).expect("the book").flatten() {
        let name = file.file_name().to_string_lossy().into_owned();
        if !name.ends_with(".md") {
            continue;
        }
        let text = std::fs::read_to_string(file.path()).expect("a chapter");
        for (at, _) in text.match_indices(" ANSWER`") {
            let id = text[..at].rsplit(' ').next().unwrap_or_default();
            let is_known = known.iter().any(|e| e.id == id && e.chapter == name);
            assert!(is_known, "{name} poses {id}, which is not below its exercises");
            posed += 1;
        }
    }
    assert_eq!(posed, known.len());
}
