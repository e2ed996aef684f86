//! A bake as rounds of units.

use cullet_io::baked::{graph_hash, hash};
use std::ops::Range;

use cullet_cells::cell::CellGraph;

use super::flow::Flow;
use super::known::Known;
use super::lines::Line;
use super::openings::Openings;
use super::pvs::Pvs;
use super::settings::{PvsPreset, PvsSettings};
use super::unit::UnitResult;

use crate::rows::{clear, ones};
use crate::threads;
use crate::work::{self, Rounds, RunEnd, RunOptions};
use cullet_draw::Random;

/// Changed whenever results change, so that units of another version are not taken for this one's.
const VERSION: u32 = 1;

/// Rounds of the first side at the most. More rounds know more of what others found, and wait for
/// each other more often.
const ROUNDS: usize = 16;
/// A round has so many cells at least, but for the last.
const LEAST_CELLS: usize = 16;
/// Rounds of the second side: few pairs are left.
const SECOND_ROUNDS: usize = 2;

/// Work of the cells of a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    /// Lines through their own portals.
    Lines,
    /// Decide their pairs with cells that come later.
    First,
    /// Decide what was left of their pairs with cells that came before.
    Second,
}

/// A bake of a cell graph's potentially visible sets, in rounds.
///
/// Its items are cells; what one finds is a pure function of graph, settings and what the rounds
/// before found, whoever runs it, when and on how many threads.
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
    rounds: Vec<(Task, Range<u32>)>,
    /// Expected costs of the cells of each round, and of the cells of all rounds before.
    costs: Vec<Vec<f64>>,
    before: Vec<f64>,
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
        let cell_count = cells;
        let costs: Vec<Vec<f64>> = rounds
            .iter()
            .map(|(task, cells)| {
                let seen = |place: u32| known.candidates(order[place as usize]);
                cells.clone().map(|place| expected(*task, place, seen(place), cell_count)).collect()
            })
            .collect();
        let sums = costs.iter().scan(0.0, |sum, costs| {
            let before = *sum;
            *sum += costs.iter().sum::<f64>();
            Some(before)
        });
        Self {
            key: key_of(graph, settings),
            before: sums.collect(),
            candidates: known.possible.count() - u64::from(cells),
            openings,
            settings: *settings,
            known,
            order,
            place,
            rounds,
            costs,
            round: 0,
            lines: Vec::new(),
        }
    }

    /// How many rounds there are.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        self.rounds.len() as u32
    }

    /// Bytes in memory, but for little.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.openings.bytes() + self.known.bytes() + (self.lines.len() * size_of::<Line>()) as u64
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

    /// Runs what is left, from the round that is next on. `step` is called after each cell with the
    /// share of the time that is expected to be over, and says whether to go on; what is already in
    /// the folder is passed over.
    ///
    /// # Errors
    /// If a unit cannot be written to the folder, or that cannot be read.
    pub fn run(
        &mut self,
        options: &RunOptions<'_>,
        step: &(dyn Fn(f64) -> bool + Sync),
    ) -> std::io::Result<RunEnd> {
        work::run(self, options, step)
    }

    /// The result: whatever is not proven hidden by now is kept, so that it is sound even before
    /// the last round.
    #[must_use]
    pub fn finish(self) -> Pvs {
        Pvs::new(&self.openings, self.key, self.known, self.candidates, &self.lines)
    }
}

impl Rounds for Bake {
    type Part = UnitResult;

    fn key(&self) -> u64 {
        self.key
    }

    fn round(&self) -> u32 {
        self.round
    }

    fn is_last(&self) -> bool {
        self.round + 1 >= self.rounds()
    }

    fn costs(&self) -> Vec<f64> {
        self.costs.get(self.round as usize).cloned().unwrap_or_default()
    }

    /// Estimates the share of the work that is done. After a fifth of the time, it says between 0.4
    /// and 2.1 times what is left, on the five maps of `data/portals` that take longest. Counting
    /// only cells, it said between a tenth and a hundredth on four of these maps.
    fn share(&self, cost: f64) -> f64 {
        let all: f64 = self.costs.iter().flatten().sum();
        let before = self.before.get(self.round as usize).copied().unwrap_or(all);
        if all > 0.0 { ((before + cost) / all).min(1.0) } else { 1.0 }
    }

    fn run_items(
        &self,
        items: Range<u32>,
        threads: usize,
        step: &(dyn Fn(u32) -> bool + Sync),
    ) -> Option<UnitResult> {
        let (_, cells) = self.rounds.get(self.round as usize)?;
        let results = threads::run_while(
            threads,
            items.len(),
            || Flow::new(&self.openings, &self.known, &self.settings),
            |flow, k| self.run_cell(flow, cells.start + items.start + k as u32),
            |k| step(items.start + k as u32),
        )?;
        let mut sum = UnitResult::default();
        results.into_iter().for_each(|result| sum.append(result));
        Some(sum)
    }

    fn bytes_of(part: &UnitResult) -> Vec<u8> {
        part.to_bytes()
    }

    fn read(&self, _: Range<u32>, bytes: &[u8]) -> Option<UnitResult> {
        let width = self.known.might.width();
        UnitResult::from_bytes(bytes, self.openings.len(), self.openings.cells(), width)
    }

    fn merge(&mut self, parts: Vec<UnitResult>) {
        for part in &parts {
            let lines = &mut self.lines;
            self.known.merge(part, |line| lines.push(part.found.lines[line]));
        }
        self.known.settle(&self.openings);
        self.round += 1;
    }
}

/// Returns the expected cost of the cell at `place` in an order of `count`, that may see `seen`
/// others. Cells that see much take nearly all of the time, and come last; the very last find most
/// of their pairs decided. Fitted to the five maps of `data/portals` that take longest.
fn expected(task: Task, place: u32, seen: u64, count: u32) -> f64 {
    let seen = seen as f64;
    let cost = seen * seen * seen.sqrt() * (1.0 - f64::from(place) / f64::from(count)).sqrt();
    match task {
        // They take next to nothing beside what follows.
        Task::Lines => seen,
        Task::First => cost,
        Task::Second => cost * 0.02,
    }
}

/// Bakes a graph's potentially visible sets on so many threads.
#[must_use]
pub fn bake(graph: &CellGraph, settings: &PvsSettings, threads: usize) -> Pvs {
    let mut bake = Bake::new(graph, settings, threads);
    // Without a folder nothing can fail, and nobody stops it.
    let _ = bake.run(&RunOptions { threads, ..RunOptions::default() }, &|_| true);
    bake.finish()
}

/// Hash of all that the result depends on.
fn key_of(graph: &CellGraph, settings: &PvsSettings) -> u64 {
    let mut bytes = VERSION.to_le_bytes().to_vec();
    bytes.extend(settings.bytes());
    bytes.extend(graph_hash(graph).to_le_bytes());
    hash(&bytes)
}
