//! A folder of finished units.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Ending of the files.
const ENDING: &str = "unit";

/// A folder in which units lie as files, each named by what it is a function of: the key of the
/// work, the round, and the first item and the one after the last.
#[derive(Clone, Debug)]
pub struct UnitFolder {
    path: PathBuf,
}

impl UnitFolder {
    /// A folder, which is made where it is not there.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn new(path: &Path) -> std::io::Result<Self> {
        std::fs::create_dir_all(path)?;
        Ok(Self { path: path.to_owned() })
    }

    /// The file of a unit.
    #[must_use]
    pub fn file(&self, key: u64, round: u32, items: &Range<u32>) -> PathBuf {
        let Range { start, end } = items;
        self.path.join(format!("{key:016x}-{round}-{start}-{end}.{ENDING}"))
    }

    /// The bytes of a unit, if they lie there.
    #[must_use]
    pub fn read(&self, key: u64, round: u32, items: &Range<u32>) -> Option<Vec<u8>> {
        std::fs::read(self.file(key, round, items)).ok()
    }

    /// The items of the units of a round that lie there, whether they are whole or not; in no
    /// order. Cost: the folder's list.
    ///
    /// # Errors
    /// If the folder cannot be listed.
    pub fn units(&self, key: u64, round: u32) -> std::io::Result<Vec<Range<u32>>> {
        let begin = format!("{key:016x}-{round}-");
        let mut units = Vec::new();
        for entry in std::fs::read_dir(&self.path)? {
            let name = entry?.file_name();
            let items = name.to_str().and_then(|name| name.strip_prefix(&begin));
            let items = items.and_then(|rest| rest.strip_suffix(".unit")?.split_once('-'));
            let items = items.and_then(|(a, b)| Some(a.parse().ok()?..b.parse().ok()?));
            units.extend(items);
        }
        Ok(units)
    }

    /// Writes a unit beside and renames, so that whoever looks finds all of it or nothing. Where
    /// that fails, nothing is left.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(
        &self,
        key: u64,
        round: u32,
        items: &Range<u32>,
        bytes: &[u8],
    ) -> std::io::Result<()> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let file = self.file(key, round, items);
        // Others may be at the same unit, in this process and on other machines, where process
        // numbers come again: they write the same bytes, and what is torn between two is noticed by
        // its checksum.
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let beside = file.with_extension(format!("{}-{number}.part", std::process::id()));
        let written = std::fs::write(&beside, bytes).and_then(|()| std::fs::rename(&beside, &file));
        written.inspect_err(|_| {
            let _ = std::fs::remove_file(&beside);
        })
    }
}
