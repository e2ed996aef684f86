//! The program, run as its users run it: for the tests beside this file.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

pub(crate) fn cullet(args: &[&str]) -> Output {
    cullet_with_costs("/nonexistent/costs.json", args)
}

/// Runs the program with its costs kept in a file of the test's own, never the user's.
pub(crate) fn cullet_with_costs(file: &str, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cullet"));
    command.args(args).env("CULLET_COSTS", file).output().unwrap()
}

pub(crate) fn code(args: &[&str]) -> i32 {
    cullet(args).status.code().unwrap()
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

pub(crate) fn json(path: impl AsRef<Path>) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// A scene and views small enough for any test.
pub(crate) const SMALL: &[&str] =
    &["solids:n=20", "--views", "3", "--size", "160x90", "--samples", "2"];

pub(crate) fn small<'a>(command: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[command], SMALL, more].concat()
}
