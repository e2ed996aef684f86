//! Log of what changed, so that what depends on a scene follows at the cost of what changed.

use alloc::vec::Vec;

use super::Scene;

/// A change of a scene's instances, as [`Scene::changes_since`] tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneChange {
    /// The instance that is in this slot now came or may have other bounds.
    Moved(u32),
    /// The slot has another instance, or none, which is where it was.
    Permuted(u32),
    /// Each slot may have another instance, or other bounds.
    All,
}

/// An entry of the log.
#[derive(Clone, Copy, Debug)]
enum Entry {
    /// Index of the handle of an instance, which a commit may put into another slot.
    Moved(u32),
    Permuted(u32),
    All,
}

/// The latest changes of a scene, if somebody wants them.
#[derive(Debug, Default)]
pub(super) struct Log {
    is_on: bool,
    /// Number of the first entry.
    first: u64,
    entries: Vec<Entry>,
}

/// The log keeps as many entries, and as many as there are instances.
const LEAST: usize = 4096;

impl Log {
    fn push(&mut self, entry: Entry, instances: usize) {
        if self.entries.len() >= LEAST.max(instances) {
            let half = self.entries.len() / 2;
            self.entries.drain(..half);
            self.first += half as u64;
        }
        self.entries.push(entry);
    }
}

impl Scene {
    /// Logs changes from here on, for [`changes_since`](Self::changes_since). Cost: a few bytes for
    /// each change, and no more than eight for each instance.
    pub fn log_changes(&mut self) {
        self.log.is_on = true;
    }

    /// Returns the number of changes that were logged, from which
    /// [`changes_since`](Self::changes_since) goes on.
    #[must_use]
    pub fn logged(&self) -> u64 {
        self.log.first + self.log.entries.len() as u64
    }

    /// Returns what changed since there were `logged` changes, in that order; `None` where that is
    /// not known: changes are [logged](Self::log_changes) from a later one on, or there were more
    /// than the log keeps. Removed instances are not told of.
    #[must_use]
    pub fn changes_since(&self, logged: u64) -> Option<impl Iterator<Item = SceneChange> + '_> {
        let from = logged.checked_sub(self.log.first).filter(|_| self.log.is_on)?;
        let entries = self.log.entries.get(from as usize..)?;
        Some(entries.iter().filter_map(|&entry| {
            Some(match entry {
                Entry::Moved(index) => {
                    SceneChange::Moved(self.hierarchy.slot_of_index(index as usize)? as u32)
                }
                Entry::Permuted(slot) => SceneChange::Permuted(slot),
                Entry::All => SceneChange::All,
            })
        }))
    }

    /// Notes that the instance of a slot may be elsewhere.
    #[inline]
    pub(super) fn log_moved(&mut self, slot: u32) {
        if self.log.is_on
            && let Some(handle) = self.hierarchy.handle(slot)
        {
            self.log.push(Entry::Moved(handle.index), self.hierarchy.index_count());
        }
    }

    /// Notes that slots have others' instances, as of these moves.
    pub(super) fn log_moves(&mut self, moves: &[[u32; 2]]) {
        if self.log.is_on {
            let count = self.hierarchy.index_count();
            moves.iter().for_each(|&[_, slot]| self.log.push(Entry::Permuted(slot), count));
        }
    }

    /// Notes that all slots may have others' instances, or others' bounds.
    pub(super) fn log_all(&mut self) {
        if self.log.is_on {
            self.log.push(Entry::All, self.hierarchy.index_count());
        }
    }
}
