//! Errors of loading: each names the file, the item, the value, the limit, and what to try.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a file cannot be loaded.
#[derive(Debug, Error)]
#[error("{}: {kind}", path.display())]
pub struct LoadError {
    /// The file.
    pub path: PathBuf,
    /// The defect.
    pub kind: ErrorKind,
}

/// Defect of a file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The file, or one that it names, cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// Not a kind of file that is loaded here; says what to try.
    #[error("{0}")]
    Unsupported(String),
    /// Something in it is wrong: which item, and what with its value and limit.
    #[error("{item}: {message}")]
    Invalid {
        /// The item: a line, an accessor, a node.
        item: String,
        /// The defect, with the value and the limit.
        message: String,
    },
    /// It is larger than a limit of [`LoadOptions`](crate::LoadOptions).
    #[error("{item}: {count} exceeds the limit of {limit}")]
    OverLimit {
        /// The item that is over the limit.
        item: String,
        /// How many.
        count: u64,
        /// How many at the most.
        limit: u64,
    },
}

impl ErrorKind {
    /// An [`ErrorKind::Invalid`].
    #[must_use]
    pub fn invalid(item: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Invalid { item: item.into(), message: message.into() }
    }

    /// The error of a file.
    #[must_use]
    pub fn at(self, path: &Path) -> LoadError {
        LoadError { path: path.to_owned(), kind: self }
    }
}
