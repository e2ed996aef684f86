//! The program `cullet`, which the wheel brings along: a report needs no Rust.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program on `args`, of which the first is its name, and returns its exit code. A wrong command line
/// ends the process.
#[pyfunction]
pub(crate) fn program(py: Python<'_>, args: Vec<OsString>) -> u8 {
    py.detach(|| cullet_cli::entry::run(&args)) as u8
}
