//! The bake: rounds of units, and what they found joined in their order.

use std::ops::Range;

use super::cells::ViewCells;
use super::edit::{Edit, EditCounts};
use super::line::Tracer;
use super::near::NearTargets;
use super::plan::{FOLLOWED, RAYS_AROUND, RAYS_SWEPT, Sweep, Waiting, plan};
use super::sets::ScenePvs;
use super::tree::RayTree;
use super::unit::{Discovery, Findings, Known, LINES, Work};
use super::unit_file;
use super::{SampledError, SampledSettings};
use crate::rows::BitRows;
use crate::threads;
use crate::work::{self, Rounds, RunEnd, RunOptions};
use cullet_draw::Random;
use cullet_io::baked::{SceneSets, hash, scene_hash};

/// Changed whenever results change, so that units of another version are not taken for this one's.
const VERSION: u32 = 2;

/// Bytes that rows may take.
const MOST_BYTES: u64 = 8 << 30;

/// Discoveries that are kept to be tried from the cells beside. They take three quarters of a GiB.
const WITNESSES: usize = 3 << 23;

/// A bake under way.
///
/// Each round is a list of items that is known when it begins; what an item finds is a pure
/// function of scene, cells, settings, what the rounds before found, and its number.
#[derive(Debug)]
pub struct SampledBake<'a> {
    tree: &'a RayTree<'a>,
    cells: &'a ViewCells,
    settings: SampledSettings,
    beside: Vec<Vec<u32>>,
    near: NearTargets,
    visible: BitRows,
    /// The discoveries of each cell, the first of them as far as there is room.
    witnesses: Vec<Vec<Discovery>>,
    witness_count: usize,
    looks: Vec<Looks>,
    open: Vec<bool>,
    sweeps: Vec<Sweep>,
    waiting: Waiting,
    rays: u64,
    /// Rays that a line around which is looked took in the last round.
    rays_around: u64,
    /// Rays that a sweep took in the last round that had some.
    rays_swept: u64,
    /// The items of the round that is next; none once the settings are met.
    planned: Vec<Work>,
    rounds: u32,
    /// Pairs to search, where the bake goes on from earlier sets.
    edit: Option<Edit>,
}

/// Looks of lines without an aim from a cell, and how many of them met what was not known when
/// their round began.
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

/// Findings of some items of a round of a [`SampledBake`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampledPart(Vec<Findings>);

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
        let mut bake = Self {
            tree,
            cells,
            settings: *settings,
            beside,
            near: NearTargets::new(tree),
            visible: BitRows::new(count, targets),
            witnesses: vec![Vec::new(); count as usize],
            witness_count: 0,
            looks: vec![Looks::default(); count as usize],
            open: vec![false; count as usize],
            sweeps: vec![Sweep::default(); count as usize],
            waiting: Waiting::new(),
            rays: 0,
            rays_around: RAYS_AROUND,
            rays_swept: RAYS_SWEPT,
            planned: Vec::new(),
            rounds: 0,
            edit: None,
        };
        bake.plan();
        Ok(bake)
    }

    /// Begins from the sets that were baked before the scene was edited. `cells` must be
    /// [theirs](ViewCells::of_boxes). Only what changed is searched, and only from cells that see
    /// any of it; all others keep their sets. Of the rays as many are spent as the changed pairs
    /// are worth, at most those of the settings.
    ///
    /// Sets keep what a new instance hides: they are no smaller than those of before.
    ///
    /// # Errors
    /// Those of [`new`](Self::new), and sets without marks of their instances or of other cells.
    pub fn after(
        tree: &'a RayTree<'a>,
        cells: &'a ViewCells,
        settings: &SampledSettings,
        before: &SceneSets,
    ) -> Result<Self, SampledError> {
        let mut bake = Self::new(tree, cells, settings)?;
        if before.sets.cell_count() != cells.len() {
            return Err(SampledError::Before);
        }
        let edit = Edit::new(tree, &bake.near, before)?;
        bake.settings.rays = bake.settings.rays.min(edit.rays.max(1));
        bake.visible = edit.before.clone();
        bake.waiting = Waiting::new();
        bake.edit = Some(edit);
        bake.plan();
        Ok(bake)
    }

    /// Plans the round that is next.
    fn plan(&mut self) {
        self.planned = if self.is_done() {
            Vec::new()
        } else {
            plan(self.rays, self.rays_around, &mut self.waiting, &self.sweeps, self.edit.as_ref())
        };
    }

    /// Whether the settings are met: the budget of rays is spent; or so little is estimated to be
    /// missing, each cell was swept, and nothing of what was found waits to be followed up.
    #[must_use]
    pub fn is_done(&self) -> bool {
        let nothing_to_see = |edit: &Edit| edit.targets.is_empty() && edit.eyes().is_empty();
        let swept = |cell: u32| self.sweeps[cell as usize].times > 0;
        let all_swept = match &self.edit {
            Some(edit) => edit.eyes().iter().all(|&cell| swept(cell)),
            None => (0..self.cells.len()).all(swept),
        };
        self.edit.as_ref().is_some_and(nothing_to_see)
            || self.rays >= self.settings.rays
            || self.rounds > 0
                && self.settings.missing > 0.0
                && self.waiting.len() <= FOLLOWED
                && all_swept
                && self.missing() <= self.settings.missing
    }

    /// How much of the budget is spent, 0 to 1.
    #[must_use]
    pub fn spent(&self) -> f64 {
        self.share_of(self.rays)
    }

    fn share_of(&self, rays: u64) -> f64 {
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
        let sum = self.estimates().map(f64::from).sum::<f64>();
        sum / self.looks.len().max(1) as f64
    }

    /// Estimates of the cells; of those that saw nothing of an edit, that of before.
    fn estimates(&self) -> impl Iterator<Item = f32> {
        (0..).zip(&self.looks).map(|(cell, looks)| match &self.edit {
            Some(edit) if !edit.touches(cell) => edit.missing[cell as usize],
            _ => looks.missing(),
        })
    }

    /// Changes of an edit, where the bake [goes on](Self::after) after one.
    #[must_use]
    pub fn edited(&self) -> Option<EditCounts> {
        self.edit.as_ref().map(Edit::counts)
    }

    /// Cells that are known to see something that an edit changed, ascending.
    #[must_use]
    pub fn touched(&self) -> Vec<u32> {
        let mut cells = self.edit.as_ref().map_or(Vec::new(), |edit| edit.eyes().to_vec());
        cells.sort_unstable();
        cells
    }

    /// Runs what is left. `step` is called after each item with the share of the budget that is
    /// spent, and says whether to go on. After [`RunEnd::Stopped`] it holds the rounds that were
    /// ended; to go on within the next, begin anew with the same folder.
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

    fn known(&self) -> Known<'_> {
        Known {
            tree: self.tree,
            cells: self.cells,
            beside: &self.beside,
            near: &self.near,
            visible: &self.visible,
            witnesses: &self.witnesses,
            open: &self.open,
            edit: self.edit.as_ref(),
        }
    }

    /// Takes in what an item found. In the order of the items, so that it is the same for any
    /// number of threads.
    fn take(&mut self, unit: &Work, found: &Findings) {
        let mut weight = 0.0;
        for &(discovery, lines) in &found.seen {
            let Discovery { cell, target, .. } = discovery;
            self.looks[cell as usize].now[1] += u64::from(lines);
            if self.visible.has(cell, target) {
                continue;
            }
            if self.edit.as_mut().is_some_and(|edit| !edit.note(cell, target, &self.near)) {
                continue;
            }
            self.visible.set(cell, target);
            if self.witness_count < WITNESSES {
                self.witness_count += 1;
                self.witnesses[cell as usize].push(discovery);
            }
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
        let missing = self.estimates().collect();
        // After an edit only few cells were looked from.
        let looked = |cell: &u32| self.edit.as_ref().is_none_or(|edit| edit.touches(*cell));
        let buried = (0..self.cells.len()).filter(|&c| !self.open[c as usize]);
        let buried = buried.filter(looked).collect();
        let rays = self.rays + self.edit.as_ref().map_or(0, |edit| edit.rays_before);
        ScenePvs::new(
            self.tree,
            self.cells,
            &self.settings,
            (self.visible, self.edit.map(|edit| edit.before)),
            missing,
            buried,
            rays,
        )
    }
}

impl Rounds for SampledBake<'_> {
    type Part = SampledPart;

    /// Hashes scene, granularity, cells, seed and version. The budget is left out: a bake with a
    /// larger one continues from the units that are there.
    fn key(&self) -> u64 {
        let mut bytes = VERSION.to_le_bytes().to_vec();
        bytes.extend(scene_hash(self.tree.scene).to_le_bytes());
        bytes.push(self.tree.targets().granularity() as u8);
        self.tree.kept().iter().for_each(|t| bytes.extend(t.to_le_bytes()));
        let ends = self.cells.boxes().iter().flatten();
        ends.for_each(|v| v.to_array().iter().for_each(|n| bytes.extend(n.to_le_bytes())));
        // Neither when it ends nor what is kept besides: finished units serve a larger budget and
        // other choices of that.
        bytes.extend(self.settings.seed.to_le_bytes());
        bytes.extend(self.edit.iter().flat_map(|edit| edit.key.to_le_bytes()));
        hash(&bytes)
    }

    fn round(&self) -> u32 {
        self.rounds
    }

    /// Nobody knows: it depends on what is found.
    fn is_last(&self) -> bool {
        false
    }

    /// Times, in such a measure that their sum is that of the rays.
    fn costs(&self) -> Vec<f64> {
        let rays = |work: &Work| work.rays(&self.sweeps, self.rays_around);
        let time = |work: &Work| work.time(&self.sweeps, self.rays_around, self.rays_swept);
        let all: u64 = self.planned.iter().map(rays).sum();
        let times: Vec<f64> = self.planned.iter().map(time).collect();
        let of_a_ray = times.iter().sum::<f64>() / all.max(1) as f64;
        times.into_iter().map(|time| time / of_a_ray.max(f64::MIN_POSITIVE)).collect()
    }

    fn share(&self, cost: f64) -> f64 {
        self.share_of(self.rays + cost as u64)
    }

    fn run_items(
        &self,
        items: Range<u32>,
        threads: usize,
        step: &(dyn Fn(u32) -> bool + Sync),
    ) -> Option<SampledPart> {
        let known = self.known();
        let begin = items.start;
        threads::run_while(
            threads,
            items.len(),
            Tracer::default,
            |tracer, k| {
                let number = begin + k as u32;
                let mut random = Random::new(self.settings.seed, [self.rounds, number]);
                known.run(&self.planned[number as usize], &mut random, tracer)
            },
            |k| step(begin + k as u32),
        )
        .map(SampledPart)
    }

    fn bytes_of(part: &SampledPart) -> Vec<u8> {
        unit_file::write(&part.0)
    }

    fn read(&self, items: Range<u32>, bytes: &[u8]) -> Option<SampledPart> {
        let limits = [self.cells.len(), self.tree.targets().count()];
        unit_file::read(bytes, items.len(), limits).map(SampledPart)
    }

    fn merge(&mut self, parts: Vec<SampledPart>) {
        let units = std::mem::take(&mut self.planned);
        let (mut around, mut lines) = (0, 0);
        let (mut swept, mut sweeps) = (0, 0_u64);
        for (unit, found) in units.iter().zip(parts.iter().flat_map(|part| &part.0)) {
            self.take(unit, found);
            match unit {
                Work::Around => {
                    around += found.rays;
                    lines += u64::from(LINES);
                }
                Work::Sweep(_) => {
                    swept += found.rays;
                    sweeps += 1;
                }
                _ => {}
            }
        }
        if sweeps > 0 {
            self.rays_swept = swept.div_ceil(sweeps).max(1);
        }
        self.rays_around = around.div_ceil(lines.max(1)).max(1);
        self.looks.iter_mut().for_each(Looks::end_round);
        self.rounds += 1;
        self.plan();
    }
}
