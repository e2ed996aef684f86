//! The bake: rounds of units, and what they found joined in their order.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::cells::ViewCells;
use super::line::Tracer;
use super::near::NearTargets;
use super::plan::{FOLLOWED, RAYS_AROUND, Sweep, Waiting, plan};
use super::sets::{ScenePvs, scene_hash};
use super::tree::RayTree;
use super::unit::{Discovery, Findings, Known, LINES, Work};
use super::unit_file;
use super::{SampledError, SampledSettings};
use crate::hash::hash;
use crate::pvs::{RunEnd, RunOptions, UnitFolder};
use crate::random::Random;
use crate::rows::BitRows;
use crate::threads;

/// Changed whenever results change, so that units of another version are not taken for this one's.
const VERSION: u32 = 1;

/// Bytes that rows may take.
const MOST_BYTES: u64 = 8 << 30;

/// Files of a round.
const UNITS: usize = 16;

/// A bake under way.
///
/// Each round is a list of units of work that is known when it begins; a unit is a pure function of scene, cells, settings,
/// what the rounds before found, and its number. So the result is the same for any number of threads, and however the
/// work is shared between processes.
#[derive(Debug)]
pub struct SampledBake<'a> {
    tree: &'a RayTree<'a>,
    cells: &'a ViewCells,
    settings: SampledSettings,
    beside: Vec<Vec<u32>>,
    near: NearTargets,
    visible: BitRows,
    looks: Vec<Looks>,
    open: Vec<bool>,
    sweeps: Vec<Sweep>,
    waiting: Waiting,
    rays: u64,
    /// What a line around which is looked took in the last round.
    rays_around: u64,
    rounds: u32,
}

/// Looks of lines without an aim from a cell, and how many of them met what was not known when their round began.
#[derive(Clone, Copy, Debug, Default)]
struct Looks {
    /// All, but for those in `now`.
    before: u64,
    /// The newer half of those, and what was unknown of it.
    newer: [u64; 2],
    now: [u64; 2],
}

impl Looks {
    /// Takes in those of a round.
    fn end_round(&mut self) {
        if self.now[0] > self.before {
            self.before += self.now[0];
            self.newer = std::mem::take(&mut self.now);
        }
    }

    /// The share of the newer looks that met something unknown.
    fn missing(&self) -> f32 {
        let [looks, unknown] = std::array::from_fn(|k| self.newer[k] + self.now[k]);
        // Nothing is known.
        if looks == 0 { 1.0 } else { (unknown as f64 / looks as f64).min(1.0) as f32 }
    }
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
    // Without a folder nothing can fail, and nobody stops it.
    let _ = bake.run(&RunOptions { threads, ..RunOptions::default() }, &|_| true);
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
        // What was found is held beside what is kept, and both once more where sets are joined.
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
            near: NearTargets::new(tree),
            visible: BitRows::new(count, targets),
            looks: vec![Looks::default(); count as usize],
            open: vec![false; count as usize],
            sweeps: vec![Sweep::default(); count as usize],
            waiting: Waiting::new(),
            rays: 0,
            rays_around: RAYS_AROUND,
            rounds: 0,
        })
    }

    /// Hash of what units depend on: scene, granularity, cells, seed and version. Not on the budget: who gives a larger one
    /// goes on from the units that are there.
    #[must_use]
    pub fn key(&self) -> u64 {
        let mut bytes = VERSION.to_le_bytes().to_vec();
        bytes.extend(scene_hash(self.tree.scene).to_le_bytes());
        bytes.push(self.tree.targets().granularity() as u8);
        self.tree.kept().iter().for_each(|t| bytes.extend(t.to_le_bytes()));
        let ends = self.cells.boxes().iter().flatten();
        ends.for_each(|v| v.to_array().iter().for_each(|n| bytes.extend(n.to_le_bytes())));
        // Neither when it ends nor what is kept besides: finished units serve a larger budget and other choices of that.
        bytes.extend(self.settings.seed.to_le_bytes());
        hash(&bytes)
    }

    /// Whether the settings are met: the budget of rays is spent; or so little is estimated to be missing, each cell was
    /// swept, and nothing of what was found waits to be followed up.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.rays >= self.settings.rays
            || self.rounds > 0
                && self.settings.missing > 0.0
                && self.waiting.len() <= FOLLOWED
                && self.sweeps.iter().all(|s| s.times > 0)
                && self.missing() <= self.settings.missing
    }

    /// How much of the budget is spent, 0 to 1.
    #[must_use]
    pub fn spent(&self) -> f64 {
        self.share(self.rays)
    }

    fn share(&self, rays: u64) -> f64 {
        (rays as f64 / self.settings.rays as f64).min(1.0)
    }

    /// Rays traced until now.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Mean over the cells of the share of looks that is estimated to go to what is not found yet.
    #[must_use]
    pub fn missing(&self) -> f64 {
        let sum = self.looks.iter().map(|l| f64::from(l.missing())).sum::<f64>();
        sum / self.looks.len().max(1) as f64
    }

    /// Runs what is left. `step` is called after each unit with the share of the budget that is spent, and says whether to
    /// go on. With a folder, units that lie there are not run again and those that are finished are left there, 16 files a
    /// round; with a share as well this process does its own first, and ends with [`RunEnd::Share`]. After
    /// [`RunEnd::Stopped`] it holds the rounds that were ended; to go on, begin anew with the same folder.
    ///
    /// # Errors
    /// If a unit cannot be written to the folder.
    pub fn run(
        &mut self,
        options: &RunOptions<'_>,
        step: &(impl Fn(f64) -> bool + Sync),
    ) -> std::io::Result<RunEnd> {
        let key = if options.folder.is_some() { self.key() } else { 0 };
        while !self.is_done() {
            let units = plan(self.rays, self.rays_around, &mut self.waiting, &self.sweeps);
            let every: Vec<usize> = (0..units.len()).collect();
            let spent = AtomicU64::new(self.rays);
            let found = match options.folder {
                None => self.run_units(&units, &every, options.threads, &spent, step),
                Some(folder) => self.in_folder(&units, (folder, key), options, &spent, step)?,
            };
            let Some(found) = found else {
                return Ok(RunEnd::Stopped);
            };
            for (unit, found) in units.iter().zip(&found) {
                self.take(unit, found);
            }
            let around = units.iter().zip(&found).filter(|(unit, _)| matches!(unit, Work::Around));
            let around: Vec<u64> = around.map(|(_, found)| found.rays).collect();
            let lines = around.len() as u64 * u64::from(LINES);
            self.rays_around = around.iter().sum::<u64>().div_ceil(lines.max(1)).max(1);
            self.looks.iter_mut().for_each(Looks::end_round);
            self.rounds += 1;
        }
        Ok(if options.share.is_some() { RunEnd::Share } else { RunEnd::Whole })
    }

    fn known(&self) -> Known<'_> {
        Known {
            tree: self.tree,
            cells: self.cells,
            beside: &self.beside,
            near: &self.near,
            visible: &self.visible,
            open: &self.open,
        }
    }

    /// Runs some units of a round, on so many threads; `None` where it was stopped.
    fn run_units(
        &self,
        units: &[Work],
        numbers: &[usize],
        threads: usize,
        spent: &AtomicU64,
        step: &(impl Fn(f64) -> bool + Sync),
    ) -> Option<Vec<Findings>> {
        let known = self.known();
        let stopped = AtomicBool::new(false);
        let order = Ordering::Relaxed;
        let found = threads::run(
            threads.max(1),
            numbers.len(),
            Tracer::default,
            |tracer, k| {
                let number = numbers[k];
                let mut random = Random::new(self.settings.seed, [self.rounds, number as u32]);
                let found = known.run(&units[number], &mut random, tracer);
                let rays = spent.fetch_add(found.rays, order) + found.rays;
                if !step(self.share(rays)) {
                    stopped.store(true, order);
                }
                found
            },
            || !stopped.load(order),
        )?;
        (!stopped.load(order)).then_some(found)
    }

    /// Runs the units of a round of which no file lies in a folder, and leaves their files there.
    fn in_folder(
        &self,
        units: &[Work],
        (folder, key): (&UnitFolder, u64),
        options: &RunOptions<'_>,
        spent: &AtomicU64,
        step: &(impl Fn(f64) -> bool + Sync),
    ) -> std::io::Result<Option<Vec<Findings>>> {
        let files = UNITS.min(units.len());
        let [share, shares] = options.share.unwrap_or([0, 1]).map(|v| v as usize);
        let bound = |share: usize| files * share / shares.max(1);
        let own = bound(share)..bound(share + 1);
        // Others do theirs from the other end meanwhile.
        let others = (own.end..files).chain(0..own.start).rev();
        let mut found: Vec<Findings> = vec![Findings::default(); units.len()];
        for file in own.clone().chain(others) {
            let numbers: Vec<usize> = (file..units.len()).step_by(files).collect();
            let at = [self.rounds, file as u32];
            let limits = [self.cells.len(), self.tree.targets().count()];
            let read = folder.read(key, at);
            let read = read.and_then(|bytes| unit_file::read(&bytes, numbers.len(), limits));
            let parts = match read {
                Some(parts) => {
                    let rays = parts.iter().map(|p| p.rays).sum::<u64>();
                    let rays = spent.fetch_add(rays, Ordering::Relaxed) + rays;
                    if !step(self.share(rays)) {
                        return Ok(None);
                    }
                    parts
                }
                None => {
                    let parts = self.run_units(units, &numbers, options.threads, spent, step);
                    let Some(parts) = parts else { return Ok(None) };
                    folder.write(key, at, &unit_file::write(&parts))?;
                    parts
                }
            };
            numbers.iter().zip(parts).for_each(|(&number, part)| found[number] = part);
        }
        Ok(Some(found))
    }

    /// Takes in what a unit found. In the order of the units, so that it is the same for any number of threads.
    fn take(&mut self, unit: &Work, found: &Findings) {
        let mut weight = 0.0;
        for &(discovery, lines) in &found.seen {
            let Discovery { cell, target, .. } = discovery;
            self.looks[cell as usize].now[1] += u64::from(lines);
            if self.visible.has(cell, target) {
                continue;
            }
            self.visible.set(cell, target);
            let of_this = self.known().weight(cell, target);
            weight += of_this;
            self.waiting.push(discovery, of_this);
        }
        for &(cell, looks) in &found.looks {
            self.looks[cell as usize].now[0] += u64::from(looks);
        }
        found.open.iter().for_each(|&cell| self.open[cell as usize] = true);
        self.rays += found.rays;
        if let Work::Sweep(cell) = *unit {
            self.sweeps[cell as usize].end(found.rays, weight);
        }
    }

    /// Ends with what was found, and adds what the settings keep besides.
    #[must_use]
    pub fn finish(self) -> ScenePvs {
        let missing = self.looks.iter().map(Looks::missing).collect();
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
