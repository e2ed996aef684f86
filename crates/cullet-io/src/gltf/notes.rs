//! Warnings about a file, kept to a readable length.

use crate::Warning;

/// More than this of warnings says nothing more to a reader, but a hostile file could make
/// millions.
const MOST: usize = 200;

/// Collects warnings.
#[derive(Debug, Default)]
pub(super) struct Notes {
    warnings: Vec<Warning>,
    left_out: u64,
}

impl Notes {
    pub(super) fn push(&mut self, item: impl Into<String>, message: impl Into<String>) {
        if self.warnings.len() < MOST {
            self.warnings.push(Warning { item: item.into(), message: message.into() });
        } else {
            self.left_out += 1;
        }
    }

    pub(super) fn into_warnings(mut self) -> Vec<Warning> {
        if self.left_out > 0 {
            let message = format!("{} more are not listed", self.left_out);
            self.warnings.push(Warning { item: "warnings".into(), message });
        }
        self.warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_counted_not_kept() {
        let mut notes = Notes::default();
        (0..MOST + 7).for_each(|i| notes.push(format!("node {i}"), "invalid"));
        let warnings = notes.into_warnings();
        assert_eq!(warnings.len(), MOST + 1);
        assert_eq!(warnings[MOST].to_string(), "warnings: 7 more are not listed");
    }
}
