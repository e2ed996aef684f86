//! Work that takes long, in rounds of items that anyone may do: on threads, in processes, on
//! machines.
//!
//! What an item finds is a pure function of what is baked and of what the rounds before found. So a
//! *unit*, some items of a round in a row, may be run anywhere, at any time and twice; and the
//! result is the same for any number of threads, any split into units, and after any loss.
//!
//! A finished unit is a file, named by what it is a function of, with a checksum, written beside
//! and renamed. Who needs it finds all of it or nothing. To go on after a stop, to join what others
//! did, and to do a share of the work are one thing: run what does not lie in the folder.

mod folder;
mod one_round;
mod run;
mod split;

use std::ops::Range;

pub use cullet_io::baked::hash as content_hash;
pub use folder::UnitFolder;
pub use one_round::OneRound;
pub use run::{RunEnd, RunOptions, run};
pub use split::{order_of_share, split, taper, tile};

/// Work in rounds.
///
/// Each round is a list of items. All that is merged from the rounds before is known to every item,
/// and what an item of the same round finds to none.
pub trait Rounds: Sync {
    /// Findings of some items.
    type Part;

    /// Hash of all that results depend on. Units of another key are of another work.
    fn key(&self) -> u64;

    /// The round that is next, from 0.
    fn round(&self) -> u32;

    /// Whether no other round follows the one that is next, as far as is known.
    fn is_last(&self) -> bool;

    /// Returns the expected cost of each item of the next round, in any measure, to cut the round
    /// into even units; empty once all is done.
    fn costs(&self) -> Vec<f64>;

    /// The share of the whole work, 0 to 1, that is over once items of so much cost are done in the
    /// round that is next.
    fn share(&self, cost: f64) -> f64;

    /// Runs some items of the round that is next, on so many threads. `step` is called with each
    /// that is done, from any thread, and says whether to go on; `None` where it did not.
    fn run_items(
        &self,
        items: Range<u32>,
        threads: usize,
        step: &(dyn Fn(u32) -> bool + Sync),
    ) -> Option<Self::Part>;

    /// The bytes of a part, with a checksum.
    fn bytes_of(part: &Self::Part) -> Vec<u8>;

    /// Reads such bytes, of these items of the round that is next; `None` where they are not whole,
    /// or name what there is not.
    fn read(&self, items: Range<u32>, bytes: &[u8]) -> Option<Self::Part>;

    /// Ends the round with all its parts, in the order of their items.
    fn merge(&mut self, parts: Vec<Self::Part>);
}
