//! Items that know nothing of each other.

use std::ops::Range;

use super::Rounds;
use crate::threads;
use cullet_io::baked::hash;

/// Work of one round, whose items each make some bytes.
pub struct OneRound<F> {
    key: u64,
    costs: Vec<f64>,
    make: F,
    found: Option<Vec<Vec<u8>>>,
}

impl<F> std::fmt::Debug for OneRound<F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OneRound").field("key", &self.key).finish_non_exhaustive()
    }
}

impl<F: Fn(u32) -> Option<Vec<u8>> + Sync> OneRound<F> {
    /// Work under a key, with what each item is expected to cost. `make` gives the bytes of an
    /// item, a function of the key and the item alone; `None` ends the work there.
    pub fn new(key: u64, costs: Vec<f64>, make: F) -> Self {
        Self { key, costs, make, found: None }
    }

    /// Returns what each item made, in their order; `None` unless all is done.
    pub fn finish(self) -> Option<Vec<Vec<u8>>> {
        // Of nothing nothing is to be done.
        self.found.or_else(|| self.costs.is_empty().then(Vec::new))
    }
}

impl<F: Fn(u32) -> Option<Vec<u8>> + Sync> Rounds for OneRound<F> {
    type Part = Vec<Vec<u8>>;

    fn key(&self) -> u64 {
        self.key
    }

    fn round(&self) -> u32 {
        u32::from(self.found.is_some())
    }

    fn is_last(&self) -> bool {
        true
    }

    fn costs(&self) -> Vec<f64> {
        if self.found.is_some() { Vec::new() } else { self.costs.clone() }
    }

    fn share(&self, cost: f64) -> f64 {
        let all: f64 = self.costs.iter().sum();
        if all > 0.0 { cost / all } else { 1.0 }
    }

    fn run_items(
        &self,
        items: Range<u32>,
        threads: usize,
        step: &(dyn Fn(u32) -> bool + Sync),
    ) -> Option<Self::Part> {
        let at = |k: usize| items.start + k as u32;
        let make = |_: &mut (), k: usize| (self.make)(at(k));
        let made = threads::run_while(threads, items.len(), || (), make, |k| step(at(k)))?;
        made.into_iter().collect()
    }

    /// A number and so many lengths, all of 64 bits; the bytes one after another; a checksum.
    fn bytes_of(part: &Self::Part) -> Vec<u8> {
        let lengths = part.iter().map(Vec::len);
        let mut bytes: Vec<u8> = std::iter::once(part.len())
            .chain(lengths)
            .flat_map(|n| (n as u64).to_le_bytes())
            .collect();
        part.iter().for_each(|item| bytes.extend_from_slice(item));
        let sum = hash(&bytes);
        bytes.extend_from_slice(&sum.to_le_bytes());
        bytes
    }

    fn read(&self, items: Range<u32>, bytes: &[u8]) -> Option<Self::Part> {
        let (rest, sum) = bytes.split_last_chunk::<8>()?;
        if hash(rest) != u64::from_le_bytes(*sum) {
            return None;
        }
        let (count, mut rest) = rest.split_first_chunk::<8>()?;
        if u64::from_le_bytes(*count) != items.len() as u64 {
            return None;
        }
        let mut lengths = Vec::with_capacity(items.len());
        for _ in items {
            let (length, after) = rest.split_first_chunk::<8>()?;
            lengths.push(usize::try_from(u64::from_le_bytes(*length)).ok()?);
            rest = after;
        }
        let mut part = Vec::with_capacity(lengths.len());
        for length in lengths {
            let (item, after) = rest.split_at_checked(length)?;
            part.push(item.to_vec());
            rest = after;
        }
        rest.is_empty().then_some(part)
    }

    fn merge(&mut self, parts: Vec<Self::Part>) {
        self.found = Some(parts.into_iter().flatten().collect());
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::work::{RunEnd, RunOptions, UnitFolder, run};

    fn bytes(item: u32) -> Vec<u8> {
        vec![item as u8; (item % 5) as usize]
    }

    #[test]
    fn shares_join_to_what_one_makes_and_damage_is_made_again() {
        let path = std::env::temp_dir().join(format!("cullet-one-round-{}", std::process::id()));
        let folder = UnitFolder::new(&path).expect("a folder");
        let costs: Vec<f64> = (0..40).map(f64::from).collect();
        let runs = AtomicU32::new(0);
        let make = |item| {
            runs.fetch_add(1, Ordering::Relaxed);
            Some(bytes(item))
        };
        let expected: Vec<_> = (0..40).map(bytes).collect();
        let mut done = 0;
        for share in [[2, 3], [0, 3]] {
            let mut work = OneRound::new(7, costs.clone(), make);
            let options = RunOptions {
                folder: Some(&folder),
                share: Some(share),
                units: 3,
                ..RunOptions::default()
            };
            assert_eq!(run(&mut work, &options, &|_| true).expect("runs"), RunEnd::Share);
            assert!(work.finish().is_none());
            assert!(runs.load(Ordering::Relaxed) > done, "{share:?}");
            done = runs.load(Ordering::Relaxed);
        }
        assert!(done < 40);
        let unit = folder.units(7, 0).expect("units")[0].clone();
        let mut torn = folder.read(7, 0, &unit).expect("bytes");
        torn[9] ^= 1;
        folder.write(7, 0, &unit, &torn).expect("written");
        let mut work = OneRound::new(7, costs.clone(), make);
        let options = RunOptions { folder: Some(&folder), threads: 2, ..RunOptions::default() };
        assert_eq!(run(&mut work, &options, &|_| true).expect("runs"), RunEnd::Whole);
        assert_eq!(work.finish().expect("all"), expected);
        assert_eq!(runs.load(Ordering::Relaxed), 40 + unit.len() as u32);
        let _ = std::fs::remove_dir_all(path);
    }

    #[test]
    fn parts_are_read_as_they_were_written_and_nothing_else_is() {
        let work = OneRound::new(1, vec![1.0; 9], |item| Some(bytes(item)));
        let part = work.run_items(2..7, 1, &|_| true).expect("made");
        let whole = OneRound::<fn(u32) -> Option<Vec<u8>>>::bytes_of(&part);
        assert_eq!(work.read(2..7, &whole), Some(part));
        assert_eq!(work.read(2..6, &whole), None);
        for end in 0..whole.len() {
            assert_eq!(work.read(2..7, &whole[..end]), None);
        }
        for at in 0..whole.len() {
            let mut other = whole.clone();
            other[at] ^= 4;
            assert_eq!(work.read(2..7, &other), None);
        }
    }

    #[test]
    fn an_item_that_makes_nothing_ends_the_work() {
        let mut work = OneRound::new(1, vec![1.0; 3], |item| (item < 2).then(Vec::new));
        let end = run(&mut work, &RunOptions::default(), &|_| true).expect("runs");
        assert_eq!(end, RunEnd::Stopped);
        let mut none = OneRound::new(1, vec![], |_| None);
        assert_eq!(run(&mut none, &RunOptions::default(), &|_| true).expect("runs"), RunEnd::Whole);
        assert_eq!(none.finish(), Some(vec![]));
    }
}
