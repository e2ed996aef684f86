//! Choice of the tiles that matter.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::settings::{Settings, bytes_of};
use crate::source::{TileError, TileId, TileInfo, TileSource};
use crate::status::Want;

/// Tiles that together are the whole world: each place in one of them, and in those above it that
/// it adds to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cut {
    /// Ascending.
    pub tiles: Vec<TileId>,
    /// Bytes that it takes while it is in use and the next is built.
    pub bytes: u64,
    /// Whether the budget ended it before the error on the screen was small enough everywhere.
    pub is_cut_short: bool,
}

struct Candidate {
    want: Want,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        // A heap gives the greatest first.
        other.want.order(&self.want)
    }
}

/// Chooses a cut for an eye at any of some points: where the error on the screen is largest tiles
/// are replaced by finer ones, until it is small enough everywhere or the budget is used. Where the
/// source [knows](TileSource::is_seen) which tiles can be seen from the cells of the eyes, all of
/// those come before any other; the others get what they leave of the budget, so that with a budget
/// that is never used up the cut is the same. Tiles of `failed` are never chosen; what is coarser
/// stays. A function of its arguments alone; cost: a logarithm for each tile of the cut.
///
/// # Errors
/// If the coarsest tiles and what the source takes itself exceed the budget.
pub fn choose<S: TileSource + ?Sized>(
    source: &S,
    eyes: &[[f64; 3]],
    settings: &Settings,
    failed: &dyn Fn(TileId) -> bool,
) -> Result<Cut, TileError> {
    let cells = source.cells_of(eyes);
    let want = |tile: TileId| want(source, tile, eyes, &cells, settings);
    let mut heap: BinaryHeap<Candidate> =
        source.roots().into_iter().map(|tile| Candidate { want: want(tile) }).collect();
    let roots = heap.iter().map(|c| c.want.bytes);
    let mut cut = Cut { bytes: roots.fold(source.bytes(), u64::saturating_add), ..Cut::default() };
    if cut.bytes > settings.budget {
        return Err(TileError::Budget { bytes: cut.bytes, budget: settings.budget });
    }
    let mut children = Vec::new();
    while let Some(Candidate { want: of }) = heap.pop() {
        children.clear();
        // What is no number is not small enough.
        if of.pixels.is_nan() || of.pixels > settings.pixels {
            source.children(of.tile, &mut children);
        }
        if children.is_empty() || children.iter().any(|&child| failed(child)) {
            cut.tiles.push(of.tile);
            continue;
        }
        let finer: Vec<Want> = children.iter().map(|&child| want(child)).collect();
        let adds = source.info(of.tile).adds;
        let without = if adds { cut.bytes } else { cut.bytes - of.bytes };
        let bytes = finer.iter().fold(without, |sum, w| sum.saturating_add(w.bytes));
        if bytes > settings.budget {
            // What follows matters less, and must not take what this could not have.
            cut.is_cut_short = true;
            cut.tiles.push(of.tile);
            cut.tiles.extend(heap.drain().map(|c| c.want.tile));
            break;
        }
        cut.bytes = bytes;
        // What adds to a tile is shown beside it.
        cut.tiles.extend(adds.then_some(of.tile));
        heap.extend(finer.into_iter().map(|want| Candidate { want }));
    }
    cut.tiles.sort_unstable();
    Ok(cut)
}

/// A tile, and how much it matters. `cells` are those of the eyes.
pub(crate) fn want<S: TileSource + ?Sized>(
    source: &S,
    tile: TileId,
    eyes: &[[f64; 3]],
    cells: &[u32],
    settings: &Settings,
) -> Want {
    let info = source.info(tile);
    Want {
        tile,
        bytes: bytes_of(info.instances, info.meshes),
        pixels: pixels(&info, eyes, settings.scale),
        is_seen: cells.is_empty() || source.is_seen(tile, cells),
    }
}

/// The error of a tile on the screen, in pixels, from the nearest of some eyes; without end where
/// one is within its box.
fn pixels(info: &TileInfo, eyes: &[[f64; 3]], scale: f64) -> f64 {
    if info.error <= 0.0 {
        return 0.0;
    }
    let [low, high] = info.bounds;
    let distance = |eye: &[f64; 3]| {
        let beyond = |a: usize| (low[a] - eye[a]).max(eye[a] - high[a]).max(0.0);
        (0..3).map(|a| beyond(a) * beyond(a)).sum::<f64>().sqrt()
    };
    let nearest = eyes.iter().map(distance).fold(f64::INFINITY, f64::min);
    info.error * scale / nearest
}
