//! The part of space that a mesh seals off, in cells that none of its triangles touches.

use glam::DVec3;

use super::surface::{Shell, Surface, normal};

/// Cells along each axis, with a border of one that is always outside.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) low: DVec3,
    pub(super) cell: DVec3,
    pub(super) size: [usize; 3],
}

/// A block of cells: from the first of each axis to before the second.
pub(super) type Block = [[usize; 2]; 3];

impl Grid {
    /// Along its shortest side a mesh has at least this many cells, so that a slab is not thin.
    const LEAST: f64 = 12.0;

    /// Over a box, with `resolution` cells along its longest side. Cells are no cubes where the box
    /// is flat.
    pub(super) fn new(low: DVec3, high: DVec3, resolution: u32) -> Self {
        let extent = high - low;
        let most = f64::from(resolution);
        let longest = extent.max_element().max(f64::MIN_POSITIVE);
        let count = (extent / longest * most)
            .ceil()
            .clamp(DVec3::splat(Self::LEAST.min(most)), DVec3::splat(most));
        // A flat mesh has cells of some thickness, with nothing in them.
        let cell = (extent / count).max(DVec3::splat(longest / most * 1e-3));
        let size = count.to_array().map(|n| n as usize + 2);
        Self { low: low - cell, cell, size }
    }

    pub(super) fn cells(&self) -> usize {
        self.size.iter().product()
    }

    pub(super) fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.size[0] * (y + self.size[1] * z)
    }

    pub(super) fn whole(&self) -> Block {
        self.size.map(|n| [0, n])
    }

    /// The corners of a block.
    pub(super) fn bounds(&self, block: &Block) -> [DVec3; 2] {
        [0, 1].map(|k| self.low + self.cell * DVec3::from(block.map(|b| b[k] as f64)))
    }

    /// The block of cells that a box meets, and `border` more all around.
    pub(super) fn block(&self, low: DVec3, high: DVec3, border: usize) -> Block {
        let at = |p: DVec3| ((p - self.low) / self.cell).floor();
        let (first, last) = (at(low), at(high));
        std::array::from_fn(|a| {
            let first = (first[a].max(0.0) as usize).saturating_sub(border);
            let end = (last[a].max(0.0) as usize + 1 + border).min(self.size[a]);
            [first.min(end), end]
        })
    }
}

/// Cells of the grid, with the state of each.
#[derive(Debug)]
pub(super) struct Voxels {
    pub(super) grid: Grid,
    /// No triangle of a shell touches the cell, and the shell seals it.
    pub(super) solid: Vec<bool>,
    /// The cell may hold a place within a shell that made others solid.
    pub(super) within: Vec<bool>,
    /// Shells that were too many or too large to look at.
    pub(super) skipped: u32,
}

/// Cells of all shells' boxes together that are looked at, before the rest is skipped.
const MOST_WORK: usize = 400_000_000;

impl Voxels {
    pub(super) fn new(surface: &Surface, shells: &[Shell], resolution: u32) -> Self {
        let low = surface.points.iter().fold(DVec3::INFINITY, |m, &p| m.min(p));
        let high = surface.points.iter().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
        let grid = Grid::new(low, high, resolution);
        let mut voxels = Self {
            solid: vec![false; grid.cells()],
            within: vec![false; grid.cells()],
            skipped: 0,
            grid,
        };
        let mut order: Vec<_> = shells.iter().collect();
        order.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
        let mut work = 0;
        for shell in order {
            let block = voxels.grid.block(shell.low, shell.high, 1);
            let cells = block.iter().map(|[a, b]| b - a).product::<usize>();
            // Two of the cells along each axis are border, and one between two that are touched is
            // solid.
            if block.iter().any(|[a, b]| b - a < 5) {
                continue;
            }
            if work + cells > MOST_WORK {
                voxels.skipped += 1;
                continue;
            }
            work += cells;
            voxels.add(shell, &block, surface.margin());
        }
        voxels
    }

    /// Adds what one shell seals.
    fn add(&mut self, shell: &Shell, block: &Block, margin: f64) {
        let size = block.map(|[a, b]| b - a);
        let local = Grid { low: self.grid.bounds(block)[0], cell: self.grid.cell, size };
        let mut state = vec![FREE; local.cells()];
        for t in &shell.triangles {
            let low = t[0].min(t[1]).min(t[2]) - DVec3::splat(margin);
            let high = t[0].max(t[1]).max(t[2]) + DVec3::splat(margin);
            let reach = local.block(low, high, 0);
            touch(&local, t, margin, &reach, &mut state);
        }
        let mut region = Vec::new();
        flood(&local, &mut state, [0; 3], &mut region);
        let mut any = false;
        for z in 1..size[2] - 1 {
            for y in 1..size[1] - 1 {
                for x in 1..size[0] - 1 {
                    if state[local.index([x, y, z])] != FREE {
                        continue;
                    }
                    flood(&local, &mut state, [x, y, z], &mut region);
                    // All of a region is on one side of the shell; testing twice guards against a
                    // gap in that reasoning as well as in the arithmetic.
                    let tested = [region[0], region[region.len() / 2]];
                    let middle = |c: &[u16; 3]| {
                        local.low + local.cell * DVec3::from(c.map(|v| f64::from(v) + 0.5))
                    };
                    if tested.iter().all(|c| shell.seals(middle(c))) {
                        any = true;
                        for c in &region {
                            state[local.index(c.map(usize::from))] = SEALED;
                        }
                    }
                }
            }
        }
        if !any {
            return;
        }
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let s = state[local.index([x, y, z])];
                    let cell = self.grid.index([x + block[0][0], y + block[1][0], z + block[2][0]]);
                    self.solid[cell] |= s == SEALED;
                    self.within[cell] |= s == SEALED || s == TOUCHED;
                }
            }
        }
    }
}

const FREE: u8 = 0;
const TOUCHED: u8 = 1;
const SEEN: u8 = 2;
const SEALED: u8 = 3;

fn volume(shell: &Shell) -> f64 {
    (shell.high - shell.low).element_product()
}

/// Marks the cells of a block that a triangle touches: whole blocks are tested first.
fn touch(grid: &Grid, t: &[DVec3; 3], margin: f64, block: &Block, state: &mut [u8]) {
    let [low, high] = grid.bounds(block);
    if block.iter().any(|[a, b]| a >= b) || !touches(t, low, high, margin) {
        return;
    }
    let (axis, length) =
        (0..3).map(|a| (a, block[a][1] - block[a][0])).max_by_key(|x| x.1).unwrap_or((0, 1));
    if length == 1 {
        state[grid.index(block.map(|b| b[0]))] = TOUCHED;
        return;
    }
    let middle = block[axis][0] + length / 2;
    let (mut below, mut above) = (*block, *block);
    below[axis][1] = middle;
    above[axis][0] = middle;
    touch(grid, t, margin, &below, state);
    touch(grid, t, margin, &above, state);
}

/// Whether a triangle may be within `margin` of a box: false only if an axis separates them by more
/// (Akenine-Möller, *Fast 3D Triangle-Box Overlap Testing*, 2001).
pub(super) fn touches(t: &[DVec3; 3], low: DVec3, high: DVec3, margin: f64) -> bool {
    let middle = (low + high) * 0.5;
    let half = (high - low) * 0.5 + DVec3::splat(margin);
    let v = t.map(|p| p - middle);
    let apart = |axis: DVec3| {
        let d = v.map(|p| p.dot(axis));
        // The margin again, for the products of this axis; an axis of length 0 never separates.
        let reach = half.dot(axis.abs()) + margin * axis.abs().element_sum();
        d[0].min(d[1]).min(d[2]) > reach || d[0].max(d[1]).max(d[2]) < -reach
    };
    if [DVec3::X, DVec3::Y, DVec3::Z].into_iter().any(apart) {
        return false;
    }
    let edges = [v[1] - v[0], v[2] - v[1], v[0] - v[2]];
    // Of unit length, so that the margin means the same for every axis.
    !(apart(normal(&v).normalize_or_zero())
        || edges.iter().any(|e| {
            [DVec3::X, DVec3::Y, DVec3::Z]
                .into_iter()
                .any(|x| apart(x.cross(*e).normalize_or_zero()))
        }))
}

/// Collects the free cells that are joined to one by faces, and marks them.
fn flood(grid: &Grid, state: &mut [u8], from: [usize; 3], region: &mut Vec<[u16; 3]>) {
    region.clear();
    region.push(from.map(|v| v as u16));
    state[grid.index(from)] = SEEN;
    let mut next = 0;
    while let Some(&cell) = region.get(next) {
        next += 1;
        for axis in 0..3 {
            for up in [false, true] {
                let mut other = cell.map(usize::from);
                if if up { other[axis] + 1 == grid.size[axis] } else { other[axis] == 0 } {
                    continue;
                }
                other[axis] = if up { other[axis] + 1 } else { other[axis] - 1 };
                let at = grid.index(other);
                if state[at] == FREE {
                    state[at] = SEEN;
                    region.push(other.map(|v| v as u16));
                }
            }
        }
    }
}

/// At most `most` boxes that together hold all marked cells: the box around them, split where that
/// saves the most space.
pub(super) fn cover(grid: &Grid, marked: &[bool], most: usize) -> Vec<Block> {
    let Some(all) = shrunk(grid, marked, &grid.whole()) else { return Vec::new() };
    let mut blocks = vec![all];
    let mut splits = vec![best_split(grid, marked, &all)];
    while blocks.len() < most {
        let best = (0..blocks.len()).max_by_key(|&i| splits[i].map_or(0, |s| s.0));
        let Some((i, Some((_, [a, b])))) = best.map(|i| (i, splits[i])) else { break };
        (blocks[i], splits[i]) = (a, best_split(grid, marked, &a));
        blocks.push(b);
        splits.push(best_split(grid, marked, &b));
    }
    blocks
}

fn cells(block: &Block) -> usize {
    block.iter().map(|[a, b]| b - a).product()
}

/// The least block around the marked cells of a block.
fn shrunk(grid: &Grid, marked: &[bool], block: &Block) -> Option<Block> {
    let mut found: Block = block.map(|[a, b]| [b, a]);
    for z in block[2][0]..block[2][1] {
        for y in block[1][0]..block[1][1] {
            for x in block[0][0]..block[0][1] {
                if marked[grid.index([x, y, z])] {
                    for (f, v) in found.iter_mut().zip([x, y, z]) {
                        *f = [f[0].min(v), f[1].max(v + 1)];
                    }
                }
            }
        }
    }
    found.iter().all(|[a, b]| a < b).then_some(found)
}

/// How many cells are saved, and the two halves; of a few places along each axis.
fn best_split(grid: &Grid, marked: &[bool], block: &Block) -> Option<(usize, [Block; 2])> {
    let mut best = None;
    for axis in 0..3 {
        let [first, end] = block[axis];
        for k in 1..8 {
            let at = first + (end - first) * k / 8;
            if at == first {
                continue;
            }
            let (mut below, mut above) = (*block, *block);
            below[axis][1] = at;
            above[axis][0] = at;
            let (Some(a), Some(b)) = (shrunk(grid, marked, &below), shrunk(grid, marked, &above))
            else {
                continue;
            };
            let saved = cells(block).saturating_sub(cells(&a) + cells(&b));
            if saved > best.map_or(0, |(s, _)| s) {
                best = Some((saved, [a, b]));
            }
        }
    }
    best
}
