//! Basins of free space: each about a place that is far from all walls, cut from others where the
//! way is narrow.
//!
//! Voxels are flooded from the farthest off a wall to the nearest. Where two basins meet, the
//! distance is half the width of the way between them: if that is nearly the half width of the
//! narrower of the two, they are one.

use super::options::{FindOptions, RoomsError};
use super::voxels::{FREE, Grid};

/// Label of a voxel in no basin.
pub(super) const NONE: u32 = u32::MAX;
/// Distances are kept in parts of a voxel.
const PARTS: f32 = 16.0;

/// Basins by voxel.
pub(super) struct Basins {
    /// Basin of each voxel; [`NONE`] for voxels that are not free, and for small pockets. The first
    /// basin surrounds the scene.
    pub(super) labels: Vec<u32>,
    pub(super) count: u32,
}

/// Basins as they grow: sets that are joined.
struct Sets {
    parents: Vec<u32>,
    /// Greatest distance, in parts.
    peaks: Vec<u16>,
}

impl Sets {
    fn root(&mut self, mut set: u32) -> u32 {
        while self.parents[set as usize] != set {
            let up = self.parents[self.parents[set as usize] as usize];
            self.parents[set as usize] = up;
            set = up;
        }
        set
    }

    fn add(&mut self, peak: u16) -> u32 {
        self.parents.push(self.parents.len() as u32);
        self.peaks.push(peak);
        self.parents.len() as u32 - 1
    }

    /// The older of two takes the other.
    fn join(&mut self, a: u32, b: u32) -> u32 {
        let (to, from) = (a.min(b), a.max(b));
        self.parents[from as usize] = to;
        self.peaks[to as usize] = self.peaks[to as usize].max(self.peaks[from as usize]);
        to
    }
}

impl Basins {
    pub(super) fn new(
        grid: &Grid,
        states: &[u8],
        options: &FindOptions,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, RoomsError> {
        let distances = distances(grid, states);
        if !go_on() {
            return Err(RoomsError::Stopped);
        }
        let order = order(states, &distances);
        let smallest = parts((options.smallest / grid.size) as f32);
        let mut labels = vec![NONE; grid.len()];
        let mut sets = Sets { parents: Vec::new(), peaks: Vec::new() };
        // What is around the scene is one basin from the beginning, and knows no narrow place.
        sets.add(u16::MAX);
        let last = grid.counts.map(|n| n - 1);
        for voxel in 0..grid.len() {
            let at = grid.place(voxel);
            if (0..3).any(|a| at[a] == 0 || at[a] == last[a]) {
                labels[voxel] = 0;
            }
        }
        let flood = Flood { strides: grid.strides(), distances: &distances, options, smallest };
        let (mut queue, mut done) = (Vec::new(), 0);
        for level in order.chunk_by(|&a, &b| distances[a as usize] == distances[b as usize]) {
            done += level.len();
            if done >> 20 != (done - level.len()) >> 20 && !go_on() {
                return Err(RoomsError::Stopped);
            }
            // What is as far off a wall goes to the basins that reach it, step by step from all at
            // once: voxel by voxel in their order, one would creep along all edges of the next
            // room.
            queue.clear();
            // Those at the border of the grid have a basin, and nothing beyond.
            let reached = |v: &&u32| {
                let is_new = labels[**v as usize] == NONE;
                is_new && flood.around(**v).any(|beside| labels[beside] != NONE)
            };
            queue.extend(level.iter().filter(reached));
            flood.fill(&mut queue, &mut labels, &mut sets);
            for &voxel in level {
                if labels[voxel as usize] == NONE {
                    labels[voxel as usize] = sets.add(distances[voxel as usize]);
                    queue.clear();
                    flood.push_level(voxel, &labels, &mut queue);
                    flood.fill(&mut queue, &mut labels, &mut sets);
                }
            }
        }
        Ok(Self::numbered(labels, &mut sets, smallest))
    }

    /// The basins that are large enough, by the first voxel of each.
    fn numbered(mut labels: Vec<u32>, sets: &mut Sets, smallest: u16) -> Self {
        let mut numbers = vec![NONE; sets.parents.len()];
        let mut count = 0;
        for label in labels.iter_mut().filter(|label| **label != NONE) {
            let root = sets.root(*label) as usize;
            if numbers[root] == NONE && sets.peaks[root] >= smallest {
                numbers[root] = count;
                count += 1;
            }
            *label = numbers[root];
        }
        Self { labels, count }
    }
}

/// Input of a flood.
struct Flood<'a> {
    strides: [usize; 3],
    distances: &'a [u16],
    options: &'a FindOptions,
    smallest: u16,
}

impl Flood<'_> {
    /// The six voxels beside one that is not at the border of the grid.
    fn around(&self, voxel: u32) -> impl Iterator<Item = usize> + use<> {
        let voxel = voxel as usize;
        self.strides.into_iter().flat_map(move |s| [voxel - s, voxel + s])
    }

    /// Puts in the queue what is beside a voxel, as far off a wall, and of no basin.
    fn push_level(&self, voxel: u32, labels: &[u32], queue: &mut Vec<u32>) {
        let is_next = |beside: &usize| {
            labels[*beside] == NONE && self.distances[*beside] == self.distances[voxel as usize]
        };
        queue.extend(self.around(voxel).filter(is_next).map(|beside| beside as u32));
    }

    /// Gives all voxels of a queue, and those of their level that they lead to, to basins beside
    /// them.
    fn fill(&self, queue: &mut Vec<u32>, labels: &mut [u32], sets: &mut Sets) {
        let mut at = 0;
        while let Some(&voxel) = queue.get(at) {
            at += 1;
            if labels[voxel as usize] == NONE {
                self.give(voxel, labels, sets);
                self.push_level(voxel, labels, queue);
            }
        }
    }

    /// Gives a voxel to the basin beside it that is farthest off a wall there, and joins those that
    /// meet in it.
    fn give(&self, voxel: u32, labels: &mut [u32], sets: &mut Sets) {
        let pass = self.distances[voxel as usize];
        let mut best: Option<(u16, u32)> = None;
        let mut sets_around = [NONE; 6];
        for (k, beside) in self.around(voxel).enumerate().filter(|(_, b)| labels[*b] != NONE) {
            let set = sets.root(labels[beside]);
            sets_around[k] = set;
            if best.is_none_or(|(far, _)| self.distances[beside] > far) {
                best = Some((self.distances[beside], set));
            }
        }
        let Some((_, own)) = best else { return };
        labels[voxel as usize] = own;
        for (k, &a) in sets_around.iter().enumerate().filter(|(_, a)| **a != NONE) {
            for &b in sets_around[..k].iter().filter(|b| **b != NONE) {
                let (a, b) = (sets.root(a), sets.root(b));
                let lesser = sets.peaks[a as usize].min(sets.peaks[b as usize]);
                let is_wide = f64::from(pass) >= self.options.merge * f64::from(lesser);
                if a != b && (is_wide || lesser < self.smallest) {
                    sets.join(a, b);
                }
            }
        }
    }
}

fn parts(voxels: f32) -> u16 {
    (voxels * PARTS).round().clamp(0.0, f32::from(u16::MAX - 1)) as u16
}

/// Free voxels from the farthest off a wall to the nearest, of equals in their order.
fn order(states: &[u8], distances: &[u16]) -> Vec<u32> {
    let free = || (0..states.len()).filter(|&voxel| states[voxel] & 15 == FREE);
    let mut firsts = vec![0_u32; usize::from(u16::MAX) + 2];
    free().for_each(|voxel| firsts[usize::from(u16::MAX - distances[voxel]) + 1] += 1);
    for i in 1..firsts.len() {
        firsts[i] += firsts[i - 1];
    }
    let mut order = vec![0; firsts[firsts.len() - 1] as usize];
    for voxel in free() {
        let at = &mut firsts[usize::from(u16::MAX - distances[voxel])];
        order[*at as usize] = voxel as u32;
        *at += 1;
    }
    order
}

/// The distance of each voxel to the nearest that is not free, in parts: exact between their
/// middles (Felzenszwalb & Huttenlocher, *Distance transforms of sampled functions*, 2012).
fn distances(grid: &Grid, states: &[u8]) -> Vec<u16> {
    // Squares of whole numbers below 2²⁴ are exact; farther off, nothing is narrow.
    const FAR: f32 = 1e9;
    let mut squares: Vec<f32> =
        states.iter().map(|state| if state & 15 == FREE { FAR } else { 0.0 }).collect();
    let strides = grid.strides();
    let longest = grid.counts.into_iter().max().unwrap_or(0);
    let (mut row, mut hull, mut ends) =
        (vec![0.0_f32; longest], vec![0_usize; longest], vec![0.0_f32; longest + 1]);
    for axis in 0..3 {
        let (n, step) = (grid.counts[axis], strides[axis]);
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for j in 0..grid.counts[c] {
            for i in 0..grid.counts[b] {
                let first = i * strides[b] + j * strides[c];
                let mut is_far = true;
                for k in 0..n {
                    row[k] = squares[first + k * step];
                    is_far &= row[k] >= FAR;
                }
                if is_far {
                    continue;
                }
                lower_hull(&row[..n], &mut hull, &mut ends, |k, square| {
                    squares[first + k * step] = square.min(FAR);
                });
            }
        }
    }
    squares.into_iter().map(|square| parts(square.sqrt())).collect()
}

/// The lower hull of parabolas over the places of a row, at each place.
fn lower_hull(row: &[f32], hull: &mut [usize], ends: &mut [f32], mut each: impl FnMut(usize, f32)) {
    let mut top = 0;
    hull[0] = 0;
    (ends[0], ends[1]) = (f32::NEG_INFINITY, f32::INFINITY);
    let lift = |q: usize| f64::from(row[q]) + (q * q) as f64;
    for q in 1..row.len() {
        loop {
            let v = hull[top];
            let meet = ((lift(q) - lift(v)) / (2.0 * (q as f64 - v as f64))) as f32;
            if meet > ends[top] || top == 0 {
                let meet = if meet > ends[top] { meet } else { ends[top] };
                top += 1;
                hull[top] = q;
                (ends[top], ends[top + 1]) = (meet, f32::INFINITY);
                break;
            }
            top -= 1;
        }
    }
    let mut at = 0;
    for k in 0..row.len() {
        while ends[at + 1] < k as f32 {
            at += 1;
        }
        let from = k as f32 - hull[at] as f32;
        each(k, from * from + row[hull[at]]);
    }
}
