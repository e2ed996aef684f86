//! Overlapping maximal blocks of solid cells, those first that hide the most.

use std::collections::{BinaryHeap, HashSet};

use super::voxels::{Block, Grid};

/// Cells from which blocks are grown, at most; spread evenly.
const SEEDS: usize = 1536;

/// Blocks of solid cells, and the share of the area that each adds.
///
/// Looking along an axis, every unbroken run of solid cells hides what is behind it; a block hides
/// the runs that pass through it, once. The area of all runs along the axes of weight is what there
/// is to gain. Blocks are taken greedily: the gain of a block only falls as others are taken, so a
/// heap with gains brought up to date at its top finds the best.
pub(super) fn choose(
    grid: &Grid,
    solid: &[bool],
    weight: [f64; 3],
    most: usize,
    min_gain: f64,
) -> Vec<(Block, f64)> {
    let runs = Runs::new(grid, solid, weight);
    let total: f64 = (0..3).map(|a| f64::from(runs.count[a]) * weight[a]).sum();
    if total <= 0.0 {
        return Vec::new();
    }
    let mut covered: [Vec<bool>; 3] = runs.count.map(|n| vec![false; n as usize]);
    let mut heap: BinaryHeap<(u64, Block)> = candidates(grid, solid)
        .into_iter()
        .map(|block| (runs.gain(grid, &block, &covered).to_bits(), block))
        .collect();
    let mut chosen = Vec::new();
    while chosen.len() < most {
        let Some((_, block)) = heap.pop() else { break };
        // Gains are positive, so their bits are ordered as they are.
        let gain = runs.gain(grid, &block, &covered);
        if heap.peek().is_some_and(|next| gain.to_bits() < next.0) {
            heap.push((gain.to_bits(), block));
            continue;
        }
        if gain <= 0.0 || gain < min_gain * total {
            break;
        }
        runs.cover(grid, &block, &mut covered);
        chosen.push((block, gain / total));
    }
    chosen
}

/// The runs of solid cells along each axis.
#[derive(Debug)]
struct Runs {
    of_cell: [Vec<u32>; 3],
    count: [u32; 3],
    weight: [f64; 3],
}

impl Runs {
    fn new(grid: &Grid, solid: &[bool], weight: [f64; 3]) -> Self {
        let mut runs = Self { of_cell: Default::default(), count: [0; 3], weight };
        for axis in 0..3 {
            if weight[axis] <= 0.0 {
                continue;
            }
            let of_cell = &mut runs.of_cell[axis];
            of_cell.resize(solid.len(), u32::MAX);
            let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
            for j in 0..grid.size[c] {
                for i in 0..grid.size[b] {
                    let mut before = false;
                    for k in 0..grid.size[axis] {
                        let mut at = [0; 3];
                        (at[axis], at[b], at[c]) = (k, i, j);
                        let cell = grid.index(at);
                        runs.count[axis] += u32::from(solid[cell] && !before);
                        before = solid[cell];
                        if before {
                            of_cell[cell] = runs.count[axis] - 1;
                        }
                    }
                }
            }
        }
        runs
    }

    fn gain(&self, grid: &Grid, block: &Block, covered: &[Vec<bool>; 3]) -> f64 {
        let mut new = [0u32; 3];
        self.each(grid, block, |axis, run| new[axis] += u32::from(!covered[axis][run]));
        (0..3).map(|a| f64::from(new[a]) * self.weight[a]).sum()
    }

    fn cover(&self, grid: &Grid, block: &Block, covered: &mut [Vec<bool>; 3]) {
        self.each(grid, block, |axis, run| covered[axis][run] = true);
    }

    fn each(&self, grid: &Grid, block: &Block, mut with: impl FnMut(usize, usize)) {
        for axis in 0..3 {
            if self.weight[axis] <= 0.0 {
                continue;
            }
            let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
            for j in block[c][0]..block[c][1] {
                for i in block[b][0]..block[b][1] {
                    let mut at = [0; 3];
                    (at[axis], at[b], at[c]) = (block[axis][0], i, j);
                    with(axis, self.of_cell[axis][grid.index(at)] as usize);
                }
            }
        }
    }
}

/// Maximal blocks, grown in several ways from cells spread over the solid.
fn candidates(grid: &Grid, solid: &[bool]) -> Vec<Block> {
    let sums = Sums::new(grid, solid);
    let cells: Vec<usize> = (0..solid.len()).filter(|&i| solid[i]).collect();
    let step = cells.len().div_ceil(SEEDS).max(1);
    let mut found = HashSet::new();
    let mut blocks = Vec::new();
    for &cell in cells.iter().skip(step / 2).step_by(step) {
        let at = [
            cell % grid.size[0],
            cell / grid.size[0] % grid.size[1],
            cell / (grid.size[0] * grid.size[1]),
        ];
        let seed: Block = at.map(|v| [v, v + 1]);
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut block = seed;
            for axis in order {
                while sums.extend(&mut block, axis, true) {}
                while sums.extend(&mut block, axis, false) {}
            }
            if found.insert(block) {
                blocks.push(block);
            }
        }
        // All sides in turn, for what is neither long nor flat.
        let mut block = seed;
        loop {
            let mut grew = false;
            for axis in 0..3 {
                grew |= sums.extend(&mut block, axis, true);
                grew |= sums.extend(&mut block, axis, false);
            }
            if !grew {
                break;
            }
        }
        if found.insert(block) {
            blocks.push(block);
        }
    }
    blocks
}

/// How many cells are solid before each corner of the grid: whether a block is all solid costs 8
/// look-ups.
#[derive(Debug)]
struct Sums {
    size: [usize; 3],
    sums: Vec<u32>,
}

impl Sums {
    fn new(grid: &Grid, solid: &[bool]) -> Self {
        let size = grid.size.map(|n| n + 1);
        let mut sums = vec![0u32; size.iter().product()];
        let at = |x: usize, y: usize, z: usize| x + size[0] * (y + size[1] * z);
        for z in 1..size[2] {
            for y in 1..size[1] {
                let mut row = 0;
                for x in 1..size[0] {
                    row += u32::from(solid[grid.index([x - 1, y - 1, z - 1])]);
                    // Added before what is taken away, so that no step is below zero.
                    sums[at(x, y, z)] = row + sums[at(x, y - 1, z)] + sums[at(x, y, z - 1)]
                        - sums[at(x, y - 1, z - 1)];
                }
            }
        }
        Self { size, sums }
    }

    fn is_full(&self, b: &Block) -> bool {
        let at =
            |x: usize, y: usize, z: usize| self.sums[x + self.size[0] * (y + self.size[1] * z)];
        let layer = |z: usize| {
            at(b[0][1], b[1][1], z) + at(b[0][0], b[1][0], z)
                - at(b[0][0], b[1][1], z)
                - at(b[0][1], b[1][0], z)
        };
        let cells: usize = b.iter().map(|[a, b]| b - a).product();
        (layer(b[2][1]) - layer(b[2][0])) as usize == cells
    }

    /// Adds a layer of cells at one side, if all of them are solid.
    fn extend(&self, block: &mut Block, axis: usize, up: bool) -> bool {
        let mut layer = *block;
        if up {
            if block[axis][1] + 1 >= self.size[axis] {
                return false;
            }
            layer[axis] = [block[axis][1], block[axis][1] + 1];
        } else {
            if block[axis][0] == 0 {
                return false;
            }
            layer[axis] = [block[axis][0] - 1, block[axis][0]];
        }
        let full = self.is_full(&layer);
        if full {
            block[axis] = [block[axis][0].min(layer[axis][0]), block[axis][1].max(layer[axis][1])];
        }
        full
    }
}
