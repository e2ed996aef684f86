//! Files that commands write.

use std::cell::RefCell;
use std::io::Write;
use std::path::{Path, PathBuf};

use cullet_io::{Model, Saved, save};
use serde_json::Value;

use crate::console::Console;
use crate::exit::{Exit, Failure, Outcome};

thread_local! {
    /// The JSON that a command wrote to the standard output while [`take_json`] runs it.
    static TAKEN: RefCell<Option<Value>> = const { RefCell::new(None) };
}

/// Runs a command with `--json -` on this thread, and returns its JSON in place of writing it.
pub fn take_json(run: impl FnOnce() -> Outcome) -> (Outcome, Option<Value>) {
    TAKEN.set(Some(Value::Null));
    let outcome = run();
    (outcome, TAKEN.take().filter(|json| !json.is_null()))
}

/// Writes what a command made: the model, and its figures as JSON, each where a path was given.
///
/// # Errors
/// If one of them cannot be written.
pub fn write_results(
    model: &Model,
    out: Option<&Path>,
    record: &impl serde::Serialize,
    json: Option<&Path>,
    console: &Console,
) -> Result<(), Failure> {
    if let Some(path) = out {
        save_model(model, path, console)?;
        console.line(format!("{} written", path.display()));
    }
    json.map_or(Ok(()), |path| write_json(path, record))
}

/// Saves a model, and says what the file does not have of it.
///
/// # Errors
/// If it cannot be written.
pub fn save_model(model: &Model, path: &Path, console: &Console) -> Result<Saved, Failure> {
    let saved = save(model, path).map_err(Failure::input)?;
    for note in &saved.notes {
        console.note(format!("note: {}: {note}", path.display()));
    }
    Ok(saved)
}

/// Writes JSON to a file, or to the standard output for `-`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value)
        .map_err(|e| Failure { exit: Exit::Internal, message: format!("JSON: {e}") })?;
    text.push('\n');
    if path == Path::new("-") {
        if TAKEN.with_borrow(Option::is_some) {
            TAKEN.set(serde_json::from_str(&text).ok());
            return Ok(());
        }
        let _ = std::io::stdout().lock().write_all(text.as_bytes());
        return Ok(());
    }
    std::fs::write(path, text).map_err(|e| Failure::write(path, &e))
}

/// Writes beside the file and renames, so that whoever reads it never finds half of it.
///
/// # Errors
/// If it cannot be written.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let fail = |e: std::io::Error| Failure::write(path, &e);
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let beside = PathBuf::from(beside);
    std::fs::write(&beside, bytes).map_err(fail)?;
    std::fs::rename(&beside, path).map_err(fail)
}
