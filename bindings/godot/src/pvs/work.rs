//! A bake, with the bakers of the engine, on any thread.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};

use cullet::Scene;
use cullet_bake::pvs::{Bake, PvsSettings};
use cullet_bake::rooms::{FindOptions, RoomsError, find_cells};
use cullet_bake::sampled::{
    RayTree, RayTreeOptions, SampledBake, SampledError, SampledSettings, SolidVoxels, ViewCells,
};
use cullet_bake::work::{RunEnd, RunOptions};
use cullet_cells::Cells;
use cullet_cells::cell::CellError;
use cullet_cells::pvs::{Targets, VisibleSets};
use cullet_io::baked::Region;
use thiserror::Error;

use super::baked::{Baked, Method};
use super::gather::Gathered;

/// Settings of a bake.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    pub(crate) method: Method,
    /// The cells; none for a grid.
    pub(crate) boxes: Vec<Region>,
    /// Region of the grid; none for the bounds of all nodes.
    pub(crate) region: Option<Region>,
    pub(crate) cell_size: [f64; 3],
    /// Voxels along the longest side.
    pub(crate) voxels: u32,
    /// Side of a voxel of walls; none to find one.
    pub(crate) voxel: Option<f64>,
    /// Smaller nodes hide nothing.
    pub(crate) smallest: f64,
    pub(crate) rays: u64,
    pub(crate) threads: usize,
}

/// Progress of a bake, and the wish that it ends.
#[derive(Debug, Default)]
pub(crate) struct Progress {
    share: AtomicU32,
    is_cancelled: AtomicBool,
}

impl Progress {
    pub(crate) fn share(&self) -> f32 {
        f32::from_bits(self.share.load(Ordering::Relaxed))
    }

    pub(crate) fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    fn goes_on(&self) -> bool {
        !self.is_cancelled.load(Ordering::Relaxed)
    }

    /// Notes how much is done. Returns whether to go on.
    fn at(&self, share: f64) -> bool {
        // Bits of numbers from 0 on are in the order of the numbers.
        self.share.fetch_max((share.clamp(0.0, 1.0) as f32).to_bits(), Ordering::Relaxed);
        self.goes_on()
    }
}

/// Why there is no result.
#[derive(Debug, Error)]
pub(crate) enum BakeError {
    #[error("cancelled")]
    Cancelled,
    #[error("nothing below the root stands still and has bounds; choose another root")]
    Nothing,
    #[error("no mesh that hides is closed and holds a voxel; take more voxels, or another method")]
    NoSolids,
    #[error(transparent)]
    Scene(#[from] cullet::SceneError),
    #[error(transparent)]
    Cells(#[from] CellError),
    #[error(transparent)]
    Rooms(#[from] RoomsError),
    #[error(transparent)]
    Sampled(#[from] SampledError),
    #[error("the bake broke off: {0}")]
    Units(#[from] std::io::Error),
}

/// Bakes. The same nodes and settings give the same sets, on any number of threads.
pub(crate) fn bake(
    mut gathered: Gathered,
    settings: &Settings,
    progress: &Progress,
) -> Result<Baked, BakeError> {
    if gathered.nodes.is_empty() {
        return Err(BakeError::Nothing);
    }
    let (mut scene, of_index) = gathered.scene()?;
    let mut rows = Rows::new(gathered.nodes.len(), of_index);
    let mut missing = [0.0; 2];
    let boxes = match settings.method {
        Method::Rooms => rooms(&mut scene, settings, progress, &mut rows)?,
        Method::Proved | Method::Sampled => {
            let tree = RayTree::new(&scene, &RayTreeOptions::default())?;
            let cells = cells(&tree, settings)?;
            match settings.method {
                Method::Proved => proved(&tree, &cells, settings, progress, &mut rows)?,
                _ => missing = sampled(&tree, &cells, settings, progress, &mut rows)?,
            }
            (0..cells.len()).map(|cell| (cell, cells.bounds(cell))).collect()
        }
    };
    let of_rows = rows.rows.iter().map(Vec::as_slice);
    let sets = VisibleSets::from_rows(Targets::Instances, gathered.nodes.len() as u32, of_rows);
    let nodes = gathered.nodes;
    if !progress.at(1.0) {
        return Err(BakeError::Cancelled);
    }
    Ok(Baked { method: settings.method, missing, boxes, sets, nodes })
}

/// Rows of nodes, one bit a node.
struct Rows {
    rows: Vec<Vec<u64>>,
    width: usize,
    of_index: Vec<u32>,
}

impl Rows {
    fn new(nodes: usize, of_index: Vec<u32>) -> Self {
        Self { rows: Vec::new(), width: nodes.div_ceil(64), of_index }
    }

    /// Returns a row of the nodes of some instances.
    fn row(&self, seen: impl Iterator<Item = u32>) -> Vec<u64> {
        let mut row = vec![0; self.width];
        for index in seen {
            if let Some(&node) = self.of_index.get(index as usize).filter(|&&n| n != u32::MAX) {
                row[node as usize / 64] |= 1 << (node % 64);
            }
        }
        row
    }

    fn indices(&self) -> std::ops::Range<u32> {
        0..self.of_index.len() as u32
    }
}

/// Returns the cells that the settings ask for.
fn cells(tree: &RayTree<'_>, settings: &Settings) -> Result<ViewCells, SampledError> {
    if !settings.boxes.is_empty() {
        return ViewCells::of_boxes(&settings.boxes);
    }
    let region = settings.region.unwrap_or_else(|| tree.bounds());
    let count = |a: usize| {
        let count = ((region[1][a] - region[0][a]) / settings.cell_size[a]).ceil();
        // Too many are refused with their number.
        if count >= 1.0 { count.min(1e6) as u32 } else { 1 }
    };
    ViewCells::grid(region, [count(0), count(1), count(2)])
}

/// Sets of rooms that are found in walls: an instance may be seen where one of its rooms may.
fn rooms(
    scene: &mut Scene,
    settings: &Settings,
    progress: &Progress,
    rows: &mut Rows,
) -> Result<Vec<(u32, Region)>, BakeError> {
    let mut options = FindOptions::default();
    options.voxel = settings.voxel;
    let step = |step: cullet_bake::rooms::FindStep| {
        progress.at(0.8 * f64::from(step.done) / f64::from(step.of))
    };
    let found = find_cells(scene, &options, settings.threads, step, || progress.goes_on());
    let found = found.map_err(|error| match error {
        RoomsError::Stopped => BakeError::Cancelled,
        error => error.into(),
    })?;
    let (graph, shapes) = found.build()?;
    let mut bake = Bake::new(&graph, &PvsSettings::default(), settings.threads);
    let run = RunOptions { threads: settings.threads, ..RunOptions::default() };
    if bake.run(&run, &|share| progress.at(0.8 + 0.2 * share))? == RunEnd::Stopped {
        return Err(BakeError::Cancelled);
    }
    let pvs = bake.finish();
    let cells = Cells::new(scene, graph, shapes);
    for cell in 0..pvs.cell_count() {
        let may_be_seen = |slot: &u32| {
            let of = cells.cells_of(*slot);
            // What is in no room was not found to be anywhere.
            of.is_empty() || of.iter().any(|&other| pvs.visible().has(cell, other))
        };
        let seen = scene.slots().filter(may_be_seen).filter_map(|slot| scene.handle(slot));
        let row = rows.row(seen.map(|handle| handle.index));
        rows.rows.push(row);
    }
    let pieces = (0..)
        .zip(&found.cells)
        .flat_map(|(cell, own)| own.pieces.iter().map(move |piece| (cell, *piece)));
    Ok(pieces.collect())
}

/// Sets of all that is not proved hidden.
fn proved(
    tree: &RayTree<'_>,
    cells: &ViewCells,
    settings: &Settings,
    progress: &Progress,
    rows: &mut Rows,
) -> Result<(), BakeError> {
    let voxels = SolidVoxels::new(tree, settings.voxels)?;
    if voxels.counts()[0] == 0 {
        return Err(BakeError::NoSolids);
    }
    let count = cells.len() as usize;
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let known = &*rows;
    let work = || -> Result<Vec<(usize, Vec<u64>)>, SampledError> {
        let mut own = Vec::new();
        while progress.goes_on() {
            let cell = next.fetch_add(1, Ordering::Relaxed);
            if cell >= count {
                break;
            }
            let one = ViewCells::of_boxes(&[cells.bounds(cell as u32)])?;
            let hidden = voxels.hidden(tree, &one);
            own.push((cell, known.row(known.indices().filter(|&i| !hidden.has(0, i)))));
            let share = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count as f64;
            progress.at(0.3 + 0.7 * share);
        }
        Ok(own)
    };
    let mut all = std::thread::scope(|scope| {
        let helpers: Vec<_> = (1..settings.threads).map(|_| scope.spawn(work)).collect();
        let mut all = work()?;
        for helper in helpers {
            all.extend(helper.join().map_err(|_| SampledError::Before)??);
        }
        Ok::<_, SampledError>(all)
    })?;
    if !progress.goes_on() {
        return Err(BakeError::Cancelled);
    }
    all.sort_unstable_by_key(|(cell, _)| *cell);
    rows.rows = all.into_iter().map(|(_, row)| row).collect();
    Ok(())
}

/// Sets of all that lines met. Returns what is estimated to be missing, the mean and the most.
fn sampled(
    tree: &RayTree<'_>,
    cells: &ViewCells,
    settings: &Settings,
    progress: &Progress,
    rows: &mut Rows,
) -> Result<[f64; 2], BakeError> {
    let of = SampledSettings::default().with_rays(settings.rays);
    let mut bake = SampledBake::new(tree, cells, &of)?;
    let run = RunOptions { threads: settings.threads, ..RunOptions::default() };
    if bake.run(&run, &|share| progress.at(share))? == RunEnd::Stopped {
        return Err(BakeError::Cancelled);
    }
    let sets = bake.finish();
    let all = (0..cells.len()).map(|cell| rows.row(sets.seen_from(cell)));
    rows.rows = all.collect();
    let shares = || sets.missing.iter().map(|&share| f64::from(share));
    Ok([shares().sum::<f64>() / f64::from(cells.len()), shares().fold(0.0, f64::max)])
}
