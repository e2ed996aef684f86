//! Cells where they are needed: small where much geometry is near, large in the open.

use std::collections::BinaryHeap;

use glam::DVec3;

use super::SampledError;
use super::cells::ViewCells;
use super::tree::RayTree;
use cullet_draw::Random;
use cullet_io::baked::Region;

/// Rays that look around in a cell before it is cut.
const LOOKS: u32 = 24;

/// Weight of an open cell, relative to one whose every ray ends nearby.
const OPEN: f64 = 0.02;

impl ViewCells {
    /// So many cells in some regions, cut where geometry is near: again and again the cell whose
    /// surface, times the share of rays in it that end within its own length, is largest, at the
    /// middle of its longest side. Deterministic by the seed. Some 24 rays a cell.
    ///
    /// Cells are cut without regard to walls, so that one may reach through a wall: its set then
    /// holds what both sides see. More cells make that rarer.
    ///
    /// # Errors
    /// If a region is no box, or there are too many cells or fewer than regions.
    pub fn adaptive(
        tree: &RayTree<'_>,
        regions: &[Region],
        cells: u32,
        seed: u64,
    ) -> Result<Self, SampledError> {
        let mut new = Self::of_regions(regions, u64::from(cells))?;
        let score = |new: &Self, cell: u32, cut: u32| {
            let b = new.boxes()[cell as usize];
            // Positive numbers compare as their bits do; of equals the older is cut first.
            (
                weight(tree, &b, &mut Random::new(seed, [cell, cut])).to_bits(),
                std::cmp::Reverse(cell),
            )
        };
        let mut heap: BinaryHeap<_> =
            (0..new.len()).map(|cell| (score(&new, cell, 0), cell)).collect();
        while new.len() < cells {
            let Some((_, cell)) = heap.pop() else { break };
            let [low, high] = new.boxes()[cell as usize];
            let size = high - low;
            let axis = (0..3).fold(0, |best, a| if size[a] > size[best] { a } else { best });
            let middle = low[axis] + size[axis] * 0.5;
            // No number lies between its ends.
            if !(low[axis] < middle && middle < high[axis]) {
                continue;
            }
            let cut = new.len();
            new.split(cell, axis, middle);
            heap.extend([cell, cut].map(|c| (score(&new, c, cut), c)));
        }
        Ok(new)
    }
}

/// How much a cell is worth cutting.
fn weight(tree: &RayTree<'_>, bounds: &[DVec3; 2], random: &mut Random) -> f64 {
    let size = bounds[1] - bounds[0];
    let length = size.length();
    let mut passed = Vec::new();
    let near = (0..LOOKS)
        .filter(|_| {
            let from = bounds[0] + size * DVec3::from(random.three());
            tree.cast(from, direction(random), &mut passed).end() < length
        })
        .count();
    let surface = size.x * size.y + size.y * size.z + size.z * size.x;
    surface * (OPEN + near as f64 / f64::from(LOOKS))
}

/// A direction, each as likely as any other.
pub(crate) fn direction(random: &mut Random) -> DVec3 {
    loop {
        let v = DVec3::from(random.three()) * 2.0 - 1.0;
        let square = v.length_squared();
        // No sines and cosines, whose last bits are not the same on every machine.
        if (1e-4..=1.0).contains(&square) {
            return v / square.sqrt();
        }
    }
}
