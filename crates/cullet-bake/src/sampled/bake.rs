//! The bake: rounds of units, and what they found joined in their order.

use std::collections::VecDeque;

use super::cells::ViewCells;
use super::line::Tracer;
use super::sets::ScenePvs;
use super::tree::RayTree;
use super::unit::{Discovery, Findings, Known, Work};
use super::{SampledError, SampledSettings};
use crate::random::Random;
use crate::rows::BitRows;
use crate::threads;

/// Units of a round that have no aim, that are aimed at random, and that follow up what was found.
const FREE: usize = 64;
const AIMED: usize = 24;
const FOLLOWING: usize = 96;

/// Discoveries that a unit follows up.
const FOLLOWED: usize = 64;

/// Discoveries that wait to be followed up; more are not. They take half a GiB.
const WAITING: usize = 1 << 23;

/// Bytes that rows may take.
const MOST_BYTES: u64 = 8 << 30;

/// A bake under way.
#[derive(Debug)]
pub struct SampledBake<'a> {
    tree: &'a RayTree<'a>,
    cells: &'a ViewCells,
    settings: SampledSettings,
    beside: Vec<Vec<u32>>,
    visible: BitRows,
    once: BitRows,
    /// How many bits each row of `once` has.
    singles: Vec<u32>,
    looks: Vec<u64>,
    open: Vec<bool>,
    waiting: VecDeque<Discovery>,
    rays: u64,
    rounds: u32,
}

/// Bakes until the settings are met, on so many threads. See [`SampledBake`].
///
/// # Errors
/// If a setting is out of its range, there is no cell, or rows would take too much memory.
pub fn bake_sampled(
    tree: &RayTree<'_>,
    cells: &ViewCells,
    settings: &SampledSettings,
    threads: usize,
) -> Result<ScenePvs, SampledError> {
    let mut bake = SampledBake::new(tree, cells, settings)?;
    while !bake.is_done() {
        bake.round(threads);
    }
    Ok(bake.finish())
}

impl<'a> SampledBake<'a> {
    /// Begins.
    ///
    /// # Errors
    /// If a setting is out of its range, there is no cell, or rows would take too much memory.
    pub fn new(
        tree: &'a RayTree<'a>,
        cells: &'a ViewCells,
        settings: &SampledSettings,
    ) -> Result<Self, SampledError> {
        settings.check()?;
        if cells.is_empty() {
            return Err(SampledError::Cells { cells: 0, limit: 1 << 24 });
        }
        let (count, targets) = (cells.len(), tree.targets().count());
        // Two are held, and one more where sets are joined.
        let bytes = 3 * u64::from(count) * u64::from(targets).div_ceil(64) * 8;
        if bytes > MOST_BYTES {
            return Err(SampledError::Rows { cells: count, targets, bytes, limit: MOST_BYTES });
        }
        let beside = (0..count)
            .map(|c| {
                let mut near = cells.near(&cells.boxes()[c as usize], 0.0);
                near.retain(|&other| other != c);
                near
            })
            .collect();
        Ok(Self {
            tree,
            cells,
            settings: *settings,
            beside,
            visible: BitRows::new(count, targets),
            once: BitRows::new(count, targets),
            singles: vec![0; count as usize],
            looks: vec![0; count as usize],
            open: vec![false; count as usize],
            waiting: VecDeque::new(),
            rays: 0,
            rounds: 0,
        })
    }

    /// Whether the settings are met: the budget of rays is spent, or so little is estimated to be missing, and nothing of
    /// what was found waits to be followed up.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.rays >= self.settings.rays
            || self.rounds > 0
                && self.settings.missing > 0.0
                && self.waiting.len() <= FOLLOWED
                && self.missing() <= self.settings.missing
    }

    /// How much of the budget is spent, 0 to 1.
    #[must_use]
    pub fn spent(&self) -> f64 {
        (self.rays as f64 / self.settings.rays as f64).min(1.0)
    }

    /// Rays traced until now.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Mean over the cells of the share of looks that is estimated to go to what is not found yet.
    #[must_use]
    pub fn missing(&self) -> f64 {
        let shares = self.missing_of_cells();
        shares.iter().map(|&m| f64::from(m)).sum::<f64>() / shares.len().max(1) as f64
    }

    fn missing_of_cells(&self) -> Vec<f32> {
        let share = |(&once, &looks): (&u32, &u64)| match looks {
            // Nothing is known.
            0 => 1.0,
            looks => (f64::from(once) / looks as f64).min(1.0) as f32,
        };
        self.singles.iter().zip(&self.looks).map(share).collect()
    }

    /// One round: a fixed number of units, some hundred thousand rays, on so many threads, which change nothing but time.
    pub fn round(&mut self, threads: usize) {
        let mut units = vec![Work::Free; FREE];
        units.extend(std::iter::repeat_n(Work::Aimed, AIMED));
        for _ in 0..FOLLOWING {
            let some = self.waiting.len().min(FOLLOWED);
            if some == 0 {
                break;
            }
            units.push(Work::Follow(self.waiting.drain(..some).collect()));
        }
        let known = Known {
            tree: self.tree,
            cells: self.cells,
            beside: &self.beside,
            visible: &self.visible,
            once: &self.once,
            open: &self.open,
        };
        let (seed, round) = (self.settings.seed, self.rounds);
        let findings = threads::run(
            threads.max(1),
            units.len(),
            Tracer::default,
            |tracer, unit| {
                let mut random = Random::new(seed, [round, unit as u32]);
                known.run(&units[unit], &mut random, tracer)
            },
            || true,
        );
        // Nobody stops it.
        for found in findings.unwrap_or_default() {
            self.take(&found);
        }
        self.rounds += 1;
    }

    /// Takes in what a unit found. In the order of the units, so that it is the same for any number of threads.
    fn take(&mut self, found: &Findings) {
        for &(discovery, lines) in &found.seen {
            let Discovery { cell, target, .. } = discovery;
            let singles = &mut self.singles[cell as usize];
            if !self.visible.has(cell, target) {
                self.visible.set(cell, target);
                if lines == 1 {
                    self.once.set(cell, target);
                    *singles += 1;
                }
                if self.waiting.len() < WAITING {
                    self.waiting.push_back(discovery);
                }
            } else if lines > 0 && self.once.has(cell, target) {
                self.once.clear(cell, target);
                *singles -= 1;
            }
        }
        self.looks.iter_mut().zip(&found.looks).for_each(|(sum, &n)| *sum += u64::from(n));
        found.open.iter().for_each(|&cell| self.open[cell as usize] = true);
        self.rays += found.rays;
    }

    /// Ends with what was found, and adds what the settings keep besides.
    #[must_use]
    pub fn finish(self) -> ScenePvs {
        let missing = self.missing_of_cells();
        let buried = (0..self.cells.len()).filter(|&c| !self.open[c as usize]).collect();
        ScenePvs::new(
            self.tree,
            self.cells,
            &self.settings,
            self.visible,
            missing,
            buried,
            self.rays,
        )
    }
}
