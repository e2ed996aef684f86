//! A bake as rounds of units.

use cullet::cell::CellGraph;

use super::flow::Flow;
use super::known::Known;
use super::lines::Line;
use super::openings::Openings;
use super::pvs::Pvs;
use super::settings::{PvsPreset, PvsSettings};
use super::unit::{UnitFolder, UnitResult};
use crate::hash::{hash, hash_of};
use crate::random::Random;
use crate::rows::{clear, ones};
use crate::threads;

/// Changed whenever results change, so that units of another version are not taken for this one's.
const VERSION: u32 = 1;

/// Rounds of the first side at the most. More rounds know more of what others found, and wait for each other more often.
const ROUNDS: usize = 16;
/// A round has so many cells at least, but for the last.
const LEAST_CELLS: usize = 16;
/// Rounds of the second side: few pairs are left.
const SECOND_ROUNDS: usize = 2;
/// Units of a round at the most.
const UNITS: usize = 16;

/// What the cells of a round do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    /// Lines through their own portals.
    Lines,
    /// Decide their pairs with cells that come later.
    First,
    /// Decide what was left of their pairs with cells that came before.
    Second,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunEnd {
    /// Everything is decided that will be: [`Bake::finish`].
    Whole,
    /// This unit's share is done and lies in the folder.
    Share,
    /// It was stopped; what was finished lies in the folder, if there is one.
    Stopped,
}

/// How and where a bake runs. Nothing of it changes the result.
#[derive(Clone, Copy, Debug)]
pub struct RunOptions<'a> {
    /// Threads, 1 or more.
    pub threads: usize,
    /// Where finished units are written, and looked for.
    pub folder: Option<&'a UnitFolder>,
    /// This process's share, `[i, n]` with i from 0: it does its own units first, and of the last round no others.
    pub share: Option<[u32; 2]>,
}

impl Default for RunOptions<'_> {
    fn default() -> Self {
        Self { threads: 1, folder: None, share: None }
    }
}

/// A bake of a cell graph's potentially visible sets, in rounds.
///
/// Each round is cut into units; a unit is a pure function of graph, settings and what the rounds before found, whoever
/// runs it, when and on how many threads. Between rounds all is [merged](Self::merge).
#[derive(Debug)]
pub struct Bake {
    openings: Openings,
    settings: PvsSettings,
    key: u64,
    known: Known,
    candidates: u64,
    /// Cells, those first that see least: they decide pairs with others for less than these would.
    order: Vec<u32>,
    /// Where each cell is in that order.
    place: Vec<u32>,
    rounds: Vec<(Task, std::ops::Range<u32>)>,
    round: u32,
    lines: Vec<Line>,
}

impl Bake {
    /// Prepares a bake: floods through whole portals. Cost: about a hundredth of the whole.
    #[must_use]
    pub fn new(graph: &CellGraph, settings: &PvsSettings, threads: usize) -> Self {
        let openings = Openings::new(graph, settings.sound_tolerance());
        let known = Known::new(&openings, threads);
        let cells = graph.cell_count();
        let mut order: Vec<u32> = (0..cells).collect();
        order.sort_by_key(|&cell| known.candidates(cell));
        let mut place = vec![0; cells as usize];
        for (k, &cell) in order.iter().enumerate() {
            place[cell as usize] = k as u32;
        }
        let mut rounds = vec![(Task::Lines, 0..cells)];
        if settings.preset == PvsPreset::Full {
            let rounds_of = |task, count: usize| {
                let step = (cells as usize).div_ceil(count).max(LEAST_CELLS) as u32;
                (0..cells).step_by(step as usize).map(move |k| (task, k..(k + step).min(cells)))
            };
            rounds.extend(rounds_of(Task::First, ROUNDS));
            rounds.extend(rounds_of(Task::Second, SECOND_ROUNDS));
        }
        Self {
            key: key_of(graph, settings),
            candidates: known.possible.count() - u64::from(cells),
            openings,
            settings: *settings,
            known,
            order,
            place,
            rounds,
            round: 0,
            lines: Vec::new(),
        }
    }

    /// Hash of what the result depends on: graph, settings and version.
    #[must_use]
    pub fn key(&self) -> u64 {
        self.key
    }

    /// How many rounds there are.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        self.rounds.len() as u32
    }

    /// The round that is next; equal to [`Self::rounds`] at the end.
    #[must_use]
    pub fn round(&self) -> u32 {
        self.round
    }

    /// How many units the round has that is next; 0 at the end.
    #[must_use]
    pub fn units(&self) -> u32 {
        let cells = self.rounds.get(self.round as usize).map_or(0, |(_, cells)| cells.len());
        cells.min(UNITS) as u32
    }

    /// Cells of all rounds: so many steps [`Self::run`] has.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.rounds.iter().map(|(_, cells)| cells.len() as u64).sum()
    }

    /// The share of the time, from 0 to 1, that is expected to be over after each of the [steps](Self::steps): for a bar whose
    /// estimate means something. Cells that see much take nearly all of it, and come last; the very last find most of their pairs decided.
    /// Fitted to the five maps of `data/portals` that take longest: with a fifth of it over, it says between 0.4 and 2.1 times what
    /// is left. Counting cells alone it said between a tenth and a hundredth, on four of them.
    #[must_use]
    pub fn expected(&self) -> Vec<f64> {
        let count = self.order.len() as f64;
        let cost = |task: Task, place: u32| {
            let seen = self.known.candidates(self.order[place as usize]) as f64;
            let cost = seen.powf(2.5) * (1.0 - f64::from(place) / count).sqrt();
            match task {
                Task::Lines => 0.0,
                Task::First => cost,
                Task::Second => cost * 0.02,
            }
        };
        let steps = self.rounds.iter();
        let mut shares: Vec<f64> = steps
            .flat_map(|(task, cells)| cells.clone().map(|place| cost(*task, place)))
            .scan(0.0, |sum, cost| {
                *sum += cost;
                Some(*sum)
            })
            .collect();
        // Lines alone, or nothing to be seen anywhere: all steps count alike.
        let (all, count) = (shares.last().copied().unwrap_or(0.0), shares.len() as f64);
        for (step, share) in (1..).zip(&mut shares) {
            *share = if all > 0.0 { *share / all } else { f64::from(step) / count };
        }
        shares
    }

    /// Bytes in memory, but for little.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.openings.bytes() + self.known.bytes() + (self.lines.len() * size_of::<Line>()) as u64
    }

    /// The places in the order of a unit's cells.
    fn cells_of(&self, unit: u32) -> std::ops::Range<u32> {
        let Some((_, cells)) = self.rounds.get(self.round as usize) else { return 0..0 };
        let (count, units) = (cells.len() as u64, u64::from(self.units().max(1)));
        let at = |unit: u64| cells.start + (count * unit.min(units) / units) as u32;
        at(u64::from(unit))..at(u64::from(unit) + 1)
    }

    /// Runs a unit of the round that is next. `step` is called after each cell and says whether to go on; `None` where it
    /// did not.
    pub fn run_unit(
        &self,
        unit: u32,
        threads: usize,
        step: &(impl Fn() -> bool + Sync),
    ) -> Option<UnitResult> {
        let results = self.run_cells(self.cells_of(unit), threads, step)?;
        let mut sum = UnitResult::default();
        results.into_iter().for_each(|result| sum.append(result));
        Some(sum)
    }

    fn run_cells(
        &self,
        cells: std::ops::Range<u32>,
        threads: usize,
        step: &(impl Fn() -> bool + Sync),
    ) -> Option<Vec<UnitResult>> {
        let stopped = std::sync::atomic::AtomicBool::new(false);
        let order = std::sync::atomic::Ordering::Relaxed;
        let results = threads::run(
            threads,
            cells.len(),
            || Flow::new(&self.openings, &self.known, &self.settings),
            |flow, k| {
                let result = self.run_cell(flow, cells.start + k as u32);
                if !step() {
                    stopped.store(true, order);
                }
                result
            },
            || !stopped.load(order),
        )?;
        (!stopped.load(order)).then_some(results)
    }

    /// The work of the cell at a place of the order.
    fn run_cell(&self, flow: &mut Flow<'_>, place: u32) -> UnitResult {
        let Some(&(task, _)) = self.rounds.get(self.round as usize) else {
            return UnitResult::default();
        };
        let cell = self.order[place as usize];
        let random = Random::new(self.settings.seed, [task as u32, cell]);
        let mut wanted = self.known.open(cell);
        let mut result = UnitResult::default();
        if task == Task::Lines {
            wanted.fill(0);
            flow.begin(cell, &wanted, random);
            flow.local_lines();
        } else {
            // Of the two cells of a pair the first in the order is tried first.
            for other in ones(&wanted.clone()) {
                if (self.place[other as usize] < place) == (task == Task::First) {
                    clear(&mut wanted, other);
                }
            }
            flow.begin(cell, &wanted, random);
            if task == Task::First {
                flow.aim();
            }
            for opening in self.openings.leaving(cell) {
                flow.through(opening, &mut result);
            }
            result.hidden = ones(&flow.wanted).map(|other| [cell, other]).collect();
        }
        result.found = std::mem::take(&mut flow.found);
        result
    }

    /// Ends a round with the results of all of its units, in their order.
    pub fn merge(&mut self, results: &[UnitResult]) {
        for result in results {
            let lines = &mut self.lines;
            self.known.merge(result, |line| lines.push(result.found.lines[line]));
        }
        self.known.settle(&self.openings);
        self.round += 1;
    }

    /// Runs what is left, from the round that is next on. `step` is called after each cell that was worked on, and says
    /// whether to go on; what is already in the folder is passed over.
    ///
    /// # Errors
    /// If a unit cannot be written to the folder.
    pub fn run(
        &mut self,
        options: &RunOptions<'_>,
        step: &(impl Fn() -> bool + Sync),
    ) -> std::io::Result<RunEnd> {
        let threads = options.threads.max(1);
        while self.round < self.rounds() {
            let Some(folder) = options.folder else {
                let cells = self.cells_of(0).start..self.cells_of(self.units()).start;
                let Some(results) = self.run_cells(cells, threads, step) else {
                    return Ok(RunEnd::Stopped);
                };
                self.merge(&results);
                continue;
            };
            let units = self.units();
            let [share, shares] = options.share.unwrap_or([0, 1]).map(u64::from);
            let bound = |share: u64| (u64::from(units) * share / shares.max(1)) as u32;
            let own = bound(share)..bound(share + 1);
            let is_last = self.round + 1 == self.rounds();
            // Others do theirs from the other end meanwhile.
            let others = (own.end..units).chain(0..own.start).rev();
            let mine = options.share.is_some() && is_last;
            let list: Vec<u32> = own.clone().chain(others.filter(|_| !mine)).collect();
            for unit in list {
                if folder.has(self.key, [self.round, unit]) && self.read(folder, unit).is_some() {
                    (0..self.cells_of(unit).len()).for_each(|_| {
                        step();
                    });
                    continue;
                }
                let Some(result) = self.run_unit(unit, threads, step) else {
                    return Ok(RunEnd::Stopped);
                };
                folder.write(self.key, [self.round, unit], &result.to_bytes())?;
            }
            if mine {
                return Ok(RunEnd::Share);
            }
            let results: Option<Vec<_>> = (0..units).map(|unit| self.read(folder, unit)).collect();
            // What is read here was there a moment ago, unless somebody empties the folder.
            let results =
                results.ok_or_else(|| std::io::Error::other("a finished unit has gone"))?;
            self.merge(&results);
        }
        Ok(RunEnd::Whole)
    }

    /// A unit of the round that is next, if it lies in the folder and is whole.
    fn read(&self, folder: &UnitFolder, unit: u32) -> Option<UnitResult> {
        let bytes = folder.read(self.key, [self.round, unit])?;
        let width = self.known.might.width();
        UnitResult::from_bytes(&bytes, self.openings.len(), self.openings.cells(), width)
    }

    /// The result: whatever is not proven hidden by now is kept, so that it is sound even before the last round.
    #[must_use]
    pub fn finish(self) -> Pvs {
        Pvs::new(&self.openings, self.key, self.known, self.candidates, &self.lines)
    }
}

/// Bakes a graph's potentially visible sets on so many threads.
#[must_use]
pub fn bake(graph: &CellGraph, settings: &PvsSettings, threads: usize) -> Pvs {
    let mut bake = Bake::new(graph, settings, threads);
    // Without a folder nothing can fail, and nobody stops it.
    let _ = bake.run(&RunOptions { threads, ..RunOptions::default() }, &|| true);
    bake.finish()
}

/// Hash of all that the result depends on.
fn key_of(graph: &CellGraph, settings: &PvsSettings) -> u64 {
    let mut bytes = VERSION.to_le_bytes().to_vec();
    bytes.extend(settings.bytes());
    bytes.extend(hash_of(graph).to_le_bytes());
    hash(&bytes)
}
