//! The program `cullet`: reports what a scene draws for nothing.
#![forbid(unsafe_code)]

use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args: Vec<OsString> = std::env::args_os().collect();
    cullet_cli::entry::run(&args).into()
}
