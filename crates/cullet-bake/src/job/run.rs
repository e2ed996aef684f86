//! A bake that is held open while its units are run here and elsewhere.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use crate::pvs::{Bake, Pvs};
use crate::sampled::{RayTree, RayTreeOptions, SampledBake, SampledError, ScenePvs};
use crate::work::{Rounds, taper, tile};

use super::error::WorkError;
use super::plan::{Plan, Product};
use super::settings::Settings;
use super::source::{CellSource, content_of, is_named_scene, scene};

/// The bytes of units, each with its items.
type Units = Vec<(Range<u32>, Vec<u8>)>;

/// A bake that is held open: scene, tree and what is known, on a thread of its own. A closed job's
/// thread ends with it.
#[derive(Debug)]
pub struct Job {
    asks: Sender<Ask>,
    state: State,
    thread: Option<JoinHandle<()>>,
}

/// Output of a job.
#[derive(Debug)]
pub struct Made {
    /// The sets, as `cullet pvs -o` writes them.
    pub sets: Vec<u8>,
    /// The map with the sets in it, where there is one.
    pub map: Option<Vec<u8>>,
    /// How many cells there are.
    pub cells: u32,
    /// How many things each may see: cells, instances or clusters.
    pub targets: u32,
    /// Pairs of a cell and what it sees; of cells, both ways and without themselves.
    pub visible_pairs: u64,
    /// Pairs of cells that are undecided, and kept.
    pub undecided: u64,
}

/// Where a work stands.
#[derive(Clone, Debug)]
struct State {
    product: Product,
    key: u64,
    round: u32,
    costs: Vec<f64>,
    /// Share of the work that is over before the round that is next, and after it.
    shares: [f64; 2],
}

#[derive(Debug)]
enum Ask {
    Run(Range<u32>, usize, Arc<AtomicBool>, Sender<Option<Vec<u8>>>),
    Whole(Range<u32>, Vec<u8>, Sender<bool>),
    Merge(Units, Sender<Result<State, WorkError>>),
    Finish(Sender<Result<Made, WorkError>>),
}

impl Job {
    /// Opens a planned bake, with the file of the plan at a place of this machine. Cost: loading
    /// the scene, and what is prepared of it.
    ///
    /// # Errors
    /// If the file is another, cannot be loaded or baked, or makes other work here than where it
    /// was planned.
    pub fn open(plan: &Plan, scene: &str, threads: usize) -> Result<Self, WorkError> {
        plan.check(scene)?;
        let job = Self::start(scene, &plan.settings, threads)?;
        if job.state.key != plan.key {
            let (found, expected) = (job.state.key, plan.key);
            return Err(WorkError::OtherWork { scene: scene.to_owned(), found, expected });
        }
        Ok(job)
    }

    fn start(scene: &str, settings: &Settings, threads: usize) -> Result<Self, WorkError> {
        let (asks, asked) = channel();
        let (ready, is_ready) = channel();
        let (name, settings) = (scene.to_owned(), settings.clone());
        let begin = move || {
            let end = serve_file(&name, &settings, threads.max(1), &ready, &asked);
            if let Err(error) = end {
                // Nobody waits for it once the job is open.
                let _ = ready.send(Err(error));
            }
        };
        // Chains of portals are deep.
        let thread = std::thread::Builder::new().stack_size(8 << 20).spawn(begin);
        let thread = thread.map_err(|_| WorkError::Gone)?;
        let state = is_ready.recv().map_err(|_| WorkError::Gone)??;
        Ok(Self { asks, state, thread: Some(thread) })
    }

    /// Returns the product of the bake.
    #[must_use]
    pub fn product(&self) -> Product {
        self.state.product
    }

    /// The key of its units.
    #[must_use]
    pub fn key(&self) -> u64 {
        self.state.key
    }

    /// The round that is next.
    #[must_use]
    pub fn round(&self) -> u32 {
        self.state.round
    }

    /// Items of that round; none once all is done.
    #[must_use]
    pub fn item_count(&self) -> u32 {
        self.state.costs.len() as u32
    }

    /// Whether all rounds are merged.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.state.costs.is_empty()
    }

    /// The share of the work that is expected to be over before the round that is next, and once
    /// that has ended: 0 to 1.
    #[must_use]
    pub fn shares(&self) -> [f64; 2] {
        self.state.shares
    }

    /// The units that the round lacks beside those that there are, cut into at most so many, and
    /// where others lie between. The first are the largest (see [`taper`]). Of a round of which
    /// there are none, the same for whoever holds the job.
    #[must_use]
    pub fn missing(&self, have: &[Range<u32>], units: u32) -> Vec<Range<u32>> {
        let (_, gaps) = tile(have.to_vec(), self.item_count());
        let planned = taper(&self.state.costs, units);
        let cut =
            |gap: &Range<u32>, unit: &Range<u32>| gap.start.max(unit.start)..gap.end.min(unit.end);
        let all = gaps.iter().flat_map(|gap| planned.iter().map(move |unit| cut(gap, unit)));
        all.filter(|items| !items.is_empty()).collect()
    }

    /// Selects from the units that lie there those that are to be merged: end to end, without
    /// overlap.
    #[must_use]
    pub fn tiles(&self, have: &[Range<u32>]) -> Vec<Range<u32>> {
        tile(have.to_vec(), self.item_count()).0
    }

    /// Runs some items of the round that is next, on so many threads; `None` once `stop` is true.
    ///
    /// # Errors
    /// If the round has no such items.
    pub fn run(
        &self,
        items: Range<u32>,
        threads: usize,
        stop: &Arc<AtomicBool>,
    ) -> Result<Option<Vec<u8>>, WorkError> {
        let Range { start, end } = items;
        let count = self.item_count();
        if start >= end || end > count {
            return Err(WorkError::Items { start, end, count });
        }
        let (reply, answer) = channel();
        self.ask(Ask::Run(items, threads.max(1), Arc::clone(stop), reply))?;
        answer.recv().map_err(|_| WorkError::Gone)
    }

    /// Whether bytes are a whole unit of these items of the round that is next.
    ///
    /// # Errors
    /// If the job is gone.
    pub fn is_whole(&self, items: Range<u32>, bytes: Vec<u8>) -> Result<bool, WorkError> {
        let (reply, answer) = channel();
        self.ask(Ask::Whole(items, bytes, reply))?;
        answer.recv().map_err(|_| WorkError::Gone)
    }

    /// Ends the round with its units, in any order.
    ///
    /// # Errors
    /// If one is damaged, or they do not make up the round; then nothing is changed.
    pub fn merge(&mut self, mut units: Units) -> Result<(), WorkError> {
        units.sort_by_key(|(items, _)| items.start);
        let (round, count) = (self.round(), self.item_count());
        let (tiles, gaps) = tile(units.iter().map(|(items, _)| items.clone()).collect(), count);
        let missing = gaps.iter().map(|gap| gap.end - gap.start).sum();
        if missing > 0 || tiles.len() != units.len() {
            return Err(WorkError::Incomplete { round, missing, count });
        }
        let (reply, answer) = channel();
        self.ask(Ask::Merge(units, reply))?;
        self.state = answer.recv().map_err(|_| WorkError::Gone)??;
        Ok(())
    }

    /// Ends with what was made.
    ///
    /// # Errors
    /// If rounds are left, or the map cannot hold the sets.
    pub fn finish(self) -> Result<Made, WorkError> {
        if !self.is_done() {
            return Err(WorkError::Unfinished { round: self.round() });
        }
        let (reply, answer) = channel();
        self.ask(Ask::Finish(reply))?;
        answer.recv().map_err(|_| WorkError::Gone)?
    }

    fn ask(&self, ask: Ask) -> Result<(), WorkError> {
        self.asks.send(ask).map_err(|_| WorkError::Gone)
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        // The thread ends once nobody can ask it any more.
        let (none, _) = channel();
        self.asks = none;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Plan {
    /// Plans the sets of a file: of its cells, if it is a portal graph, a map or a scene with cells
    /// and no view cells are asked for; else of view cells. Loads it, to know.
    ///
    /// # Errors
    /// If it cannot be loaded or baked.
    pub fn new(scene: &str, settings: &Settings) -> Result<Self, WorkError> {
        let content = content_of(scene)?;
        let job = Job::start(scene, settings, 1)?;
        Ok(Self::of(scene, content, job.state.product, settings, job.state.key))
    }
}

type Ready = Sender<Result<State, WorkError>>;

/// Loads a file and answers until nobody asks.
fn serve_file(
    name: &str,
    settings: &Settings,
    threads: usize,
    ready: &Ready,
    asked: &Receiver<Ask>,
) -> Result<(), WorkError> {
    let path = Path::new(name);
    let source = if settings.scene.wants_view_cells() || is_named_scene(path) {
        let model = scene(name)?;
        let graph = model.in_cells().graph().filter(|_| !settings.scene.wants_view_cells());
        match graph {
            Some(graph) => CellSource::of_cells(graph.clone()),
            None => {
                let fail = |error| WorkError::Sampled { scene: name.to_owned(), error };
                return serve_scene(&model.scene, settings, ready, asked).map_err(fail);
            }
        }
    } else {
        CellSource::open(path)?
    };
    let bake = Bake::new(&source.graph, &settings.of_cells(), threads);
    serve(bake, Product::Cells, ready, asked, |bake| made_of_cells(&source, path, &bake.finish()));
    Ok(())
}

fn serve_scene(
    scene: &cullet::Scene,
    settings: &Settings,
    ready: &Ready,
    asked: &Receiver<Ask>,
) -> Result<(), SampledError> {
    let granularity = settings.scene.granularity();
    let options = RayTreeOptions { granularity, ..RayTreeOptions::default() };
    let tree = RayTree::new(scene, &options)?;
    let cells = settings.view_cells(&tree)?;
    let bake = SampledBake::new(&tree, &cells, &settings.sampled())?;
    let targets = tree.targets().count();
    let made = |bake: SampledBake<'_>| Ok(made_of_scene(&bake.finish(), cells.len(), targets));
    serve(bake, Product::ViewCells, ready, asked, made);
    Ok(())
}

fn made_of_cells(source: &CellSource, path: &Path, pvs: &Pvs) -> Result<Made, WorkError> {
    let map = source.has_map().then(|| source.map_with(path, pvs)).transpose()?;
    let cells = pvs.cell_count();
    Ok(Made {
        sets: pvs.to_bytes(),
        map,
        cells,
        targets: cells,
        visible_pairs: pvs.visible_pairs(),
        undecided: pvs.undecided(),
    })
}

fn made_of_scene(pvs: &ScenePvs, cells: u32, targets: u32) -> Made {
    let visible_pairs = pvs.visible_pairs();
    Made { sets: pvs.to_bytes(), map: None, cells, targets, visible_pairs, undecided: 0 }
}

/// Answers until nobody asks, or it is finished.
fn serve<R: Rounds>(
    mut work: R,
    product: Product,
    ready: &Ready,
    asked: &Receiver<Ask>,
    finish: impl FnOnce(R) -> Result<Made, WorkError>,
) {
    let key = work.key();
    let state = |work: &R| {
        let costs = work.costs();
        let all = costs.iter().sum();
        let shares = if costs.is_empty() { [1.0; 2] } else { [0.0, all].map(|c| work.share(c)) };
        State { product, key, round: work.round(), costs, shares }
    };
    // Where nobody waits for an answer any more, it goes nowhere.
    let _ = ready.send(Ok(state(&work)));
    while let Ok(ask) = asked.recv() {
        match ask {
            Ask::Run(items, threads, stop, reply) => {
                let part = work.run_items(items, threads, &|_| !stop.load(Ordering::Relaxed));
                let _ = reply.send(part.map(|part| R::bytes_of(&part)));
            }
            Ask::Whole(items, bytes, reply) => {
                let _ = reply.send(work.read(items, &bytes).is_some());
            }
            Ask::Merge(units, reply) => {
                let parts = units.iter().map(|(items, bytes)| {
                    let (start, end, round) = (items.start, items.end, work.round());
                    let damaged = WorkError::Damaged { round, start, end };
                    work.read(items.clone(), bytes).ok_or(damaged)
                });
                let merged = parts.collect::<Result<Vec<_>, _>>().map(|parts| {
                    work.merge(parts);
                    state(&work)
                });
                let _ = reply.send(merged);
            }
            Ask::Finish(reply) => {
                let _ = reply.send(finish(work));
                return;
            }
        }
    }
}
