//! Work in items, run by a command: one after the other, or this process's share of them where
//! units are kept.

use std::path::Path;

use crate::args::UnitArgs;
use crate::console::{Console, interrupted};
use crate::exit::Failure;

/// Work whose items know nothing of each other.
pub struct Items<'a> {
    /// Share of the work that this process does, and where units are kept.
    pub units: &'a UnitArgs,
    /// File that it is of: units are kept beside it where no folder is named.
    pub of: &'a Path,
    /// All that results are a function of besides the contents of [`files`](Self::files): units of
    /// other options are of another work.
    pub options: String,
    /// Files whose contents results are a function of.
    pub files: Vec<String>,
    /// Expected cost of each item, in any measure.
    pub costs: Vec<f64>,
    /// Makes an item: its result as bytes, or `None` where the work is to stop.
    pub make: &'a (dyn Fn(u32) -> Option<Vec<u8>> + Sync),
}

impl std::fmt::Debug for Items<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Items")
            .field("of", &self.of)
            .field("costs", &self.costs)
            .finish_non_exhaustive()
    }
}

/// How work in items ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemsEnd {
    /// All items are done.
    Whole,
    /// The share of this process is done.
    Share,
    /// Ctrl-C, or an item that could not be made.
    Stopped,
}

/// How it ended, and the results of all items where they are kept and all are done, whoever made
/// them.
pub type ItemsResult = Result<(ItemsEnd, Option<Vec<Vec<u8>>>), Failure>;

impl Items<'_> {
    /// Reads results that were kept.
    ///
    /// # Errors
    /// If one cannot be read, which no checksum tells.
    pub fn read<T: serde::de::DeserializeOwned>(
        &self,
        made: &[Vec<u8>],
    ) -> Result<Vec<T>, Failure> {
        let all: Result<Vec<T>, _> =
            made.iter().map(|bytes| serde_json::from_slice(bytes)).collect();
        all.map_err(|_| {
            let at = self.units.path(self.of).unwrap_or_default();
            Failure::input(format!("{}: units of another cullet; delete it", at.display()))
        })
    }

    /// Does all of the work on this process, with a bar, and keeps nothing.
    pub(crate) fn run_whole(&self, console: &Console) -> ItemsResult {
        let whole = self.costs.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let bar = console.share_bar();
        let mut done = 0.0;
        let mut end = ItemsEnd::Whole;
        for (item, cost) in (0..).zip(&self.costs) {
            if (self.make)(item).is_none() {
                end = ItemsEnd::Stopped;
                break;
            }
            done += cost;
            bar.to(done / whole);
            // What is done is kept, also where it was the last.
            if interrupted() && item as usize + 1 < self.costs.len() {
                end = ItemsEnd::Stopped;
                break;
            }
        }
        bar.finish();
        Ok((end, None))
    }
}
