//! All rounds of a work, one after the other.

use std::ops::Range;
use std::sync::Mutex;

use super::split::own_first;
use super::{Rounds, UnitFolder, split, tile};

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunEnd {
    /// Everything is done.
    Whole,
    /// This process's share is done and lies in the folder.
    Share,
    /// It was stopped; what was finished lies in the folder, if there is one.
    Stopped,
}

/// How and where work runs. Nothing of it changes the result.
#[derive(Clone, Copy, Debug)]
pub struct RunOptions<'a> {
    /// Threads, 1 or more.
    pub threads: usize,
    /// Where finished units are written, and looked for.
    pub folder: Option<&'a UnitFolder>,
    /// This process's share, `[i, n]` with i from 0: it does its own units first, and of the last
    /// round no others.
    pub share: Option<[u32; 2]>,
    /// Units of a round at the most, where there is a folder; with a share at least as many as
    /// there are shares.
    pub units: u32,
}

/// Enough that the last unit is waited for only briefly, and few enough that files are not many.
const UNITS: u32 = 32;

impl Default for RunOptions<'_> {
    fn default() -> Self {
        Self { threads: 1, folder: None, share: None, units: UNITS }
    }
}

/// Runs what is left, from the round that is next on. `step` is called after each item with the
/// share of the whole that is over, and says whether to go on. What lies in the folder is passed
/// over, however it was split. After [`RunEnd::Stopped`] the rounds that were ended are merged; to
/// go on within the next, begin anew with the same folder.
///
/// # Errors
/// If the folder cannot be read, or a unit cannot be written to it. What was finished before is
/// kept.
pub fn run<R: Rounds>(
    work: &mut R,
    options: &RunOptions<'_>,
    step: &(dyn Fn(f64) -> bool + Sync),
) -> std::io::Result<RunEnd> {
    let threads = options.threads.max(1);
    let key = if options.folder.is_some() { work.key() } else { 0 };
    loop {
        let costs = work.costs();
        if costs.is_empty() {
            return Ok(if options.share.is_some() { RunEnd::Share } else { RunEnd::Whole });
        }
        let round = Round { work, costs: &costs, threads, step, done: Mutex::new(0.0) };
        let Some(folder) = options.folder else {
            let Some(part) = round.run(0..costs.len() as u32) else { return Ok(RunEnd::Stopped) };
            work.merge(vec![part]);
            continue;
        };
        // Of the last round nobody needs what others find.
        let only_own = options.share.is_some() && work.is_last();
        match round.in_folder(folder, key, options, only_own)? {
            None => return Ok(RunEnd::Stopped),
            Some(_) if only_own => return Ok(RunEnd::Share),
            Some(parts) => work.merge(parts),
        }
    }
}

/// A round under way.
struct Round<'a, R> {
    work: &'a R,
    costs: &'a [f64],
    threads: usize,
    step: &'a (dyn Fn(f64) -> bool + Sync),
    /// Cost of the items that are done.
    done: Mutex<f64>,
}

impl<R: Rounds> Round<'_, R> {
    fn count(&self) -> u32 {
        self.costs.len() as u32
    }

    /// Counts items as done.
    fn end(&self, items: Range<u32>) -> bool {
        let cost: f64 = self.costs[items.start as usize..items.end as usize].iter().sum();
        let done = self.done.lock().map_or(0.0, |mut done| {
            *done += cost;
            *done
        });
        (self.step)(self.work.share(done))
    }

    fn run(&self, items: Range<u32>) -> Option<R::Part> {
        self.work.run_items(items, self.threads, &|item| self.end(item..item + 1))
    }

    /// Runs the items of which no unit lies in the folder, and leaves units there; all parts, in
    /// order, or those that there are, where only its own are wanted.
    fn in_folder(
        &self,
        folder: &UnitFolder,
        key: u64,
        options: &RunOptions<'_>,
        only_own: bool,
    ) -> std::io::Result<Option<Vec<R::Part>>> {
        let round = self.work.round();
        let [share, shares] = options.share.unwrap_or([0, 1]);
        let planned = split(self.costs, options.units.max(shares));
        let (mut have, left) = self.there(folder, key, &[])?;
        // So that the bar begins where the work does.
        for (items, _) in &have {
            self.end(items.clone());
        }
        for items in missing(&planned, &left, [share, shares], only_own) {
            // Another process may have ended it meanwhile.
            let read = folder.read(key, round, &items);
            let part = match read.and_then(|bytes| self.work.read(items.clone(), &bytes)) {
                Some(part) => {
                    self.end(items.clone());
                    part
                }
                None => {
                    let Some(part) = self.run(items.clone()) else { return Ok(None) };
                    folder.write(key, round, &items, &R::bytes_of(&part))?;
                    part
                }
            };
            have.push((items, part));
        }
        have.sort_by_key(|(items, _)| items.start);
        Ok(Some(have.into_iter().map(|(_, part)| part).collect()))
    }

    /// The units of the round that lie there and are whole, end to end, and what is left between
    /// them.
    #[expect(clippy::type_complexity, reason = "units with their parts, and the gaps")]
    fn there(
        &self,
        folder: &UnitFolder,
        key: u64,
        damaged: &[Range<u32>],
    ) -> std::io::Result<(Vec<(Range<u32>, R::Part)>, Vec<Range<u32>>)> {
        let round = self.work.round();
        let mut units = folder.units(key, round)?;
        units.retain(|items| !damaged.contains(items));
        let (tiles, gaps) = tile(units, self.count());
        let mut have = Vec::new();
        for items in tiles {
            let read = folder.read(key, round, &items);
            match read.and_then(|bytes| self.work.read(items.clone(), &bytes)) {
                Some(part) => have.push((items, part)),
                // Others may lie across it.
                None => return self.there(folder, key, &[damaged, &[items]].concat()),
            }
        }
        Ok((have, gaps))
    }
}

/// Returns the work that is left, cut where units end: a share's own first, then, unless
/// `only_own`, that of others from the far end, as the others start from the near one.
fn missing(
    planned: &[Range<u32>],
    left: &[Range<u32>],
    [share, shares]: [u32; 2],
    only_own: bool,
) -> Vec<Range<u32>> {
    let bound = |share: u32| planned.len() * share as usize / shares.max(1) as usize;
    let own = bound(share)..bound(share + 1);
    let count = if only_own { own.len() } else { planned.len() };
    let mut list = Vec::new();
    for unit in own_first(own, planned.len()).take(count) {
        let Range { start, end } = planned[unit];
        let cut = left.iter().map(|gap| gap.start.max(start)..gap.end.min(end));
        list.extend(cut.filter(|items| !items.is_empty()));
    }
    list
}
