//! How the program ends: exit codes, and failures that become one.

use std::process::ExitCode;

/// Meaning of the exit code. The numbers are a promise to scripts; `cullet --help` lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// All is well.
    Fine = 0,
    /// Something visible was culled.
    FalseCull = 1,
    /// The command line is wrong.
    Usage = 2,
    /// The input cannot be read, or is invalid; or the output cannot be written.
    Input = 3,
    /// The input is over a limit.
    Limit = 4,
    /// A `--fail-if` holds, or more is slower than `--most-slower` allows.
    FailIf = 5,
    /// A fault of this program.
    Internal = 70,
    /// Stopped by Ctrl-C, with a valid report of what was done.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a command stopped, with a message for people.
#[derive(Debug)]
pub struct Failure {
    /// The code to end with.
    pub exit: Exit,
    /// The failure, and what to try.
    pub message: String,
}

impl Failure {
    /// The command line is wrong.
    pub fn usage(message: impl ToString) -> Self {
        Self { exit: Exit::Usage, message: message.to_string() }
    }

    /// A file cannot be read, written or understood.
    pub fn input(message: impl ToString) -> Self {
        Self { exit: Exit::Input, message: message.to_string() }
    }

    /// A file that cannot be written.
    pub fn write(path: &std::path::Path, error: &std::io::Error) -> Self {
        Self::input(format!("{}: cannot be written: {error}", path.display()))
    }
}

/// Result of a command.
pub type Outcome = Result<Exit, Failure>;
