//! Density of instances on the screen: where there is much to hide.
//!
//! The ground at one's feet fills half of the screen and hides nothing but what little stands
//! before it, while a trunk at eye level has all of a forest behind it. So the value of a shape is
//! not how many pixels it covers, but how many instances may be behind them, of those that are
//! [sampled](super::samples).

use alloc::vec::Vec;

use crate::array::Each;
use crate::cull::occlusion::{BoxTests, ScreenBounds};
use crate::scene::Scene;

/// Pixels along an edge of a cell: coarse, since a sample stands for hundreds of instances around
/// it.
const CELL: u64 = 32;

/// The most cells of which the densest is looked up.
const FEW_CELLS: usize = 16;

/// Instances behind pixels, in pixels of mean density.
#[derive(Clone, Debug, Default)]
pub(super) struct Density {
    /// Cells in a row, and rows.
    cells: [usize; 2],
    /// Sum of the weights of the cells left of and above each corner of the grid, row by row.
    sums: Vec<u64>,
    /// Weight of each cell.
    weights: Vec<u32>,
    scale: f32,
    densest: f32,
    thinnest: f32,
    all: f32,
}

impl Density {
    /// Measures the density of the sampled instances of `slots`, in a buffer of `size` pixels.
    pub(super) fn sample(
        &mut self,
        scene: &Scene,
        tests: &BoxTests<'_>,
        size: [u32; 2],
        slots: &[u32],
    ) {
        self.cells = size.each(|s| (s as usize).div_ceil(CELL as usize));
        let [columns, rows] = self.cells;
        let stride = columns + 1;
        self.sums.clear();
        self.sums.resize(stride * (rows + 1), 0);
        let mut count = 0;
        for &slot in slots {
            if let Ok(f) = tests.bounds(scene.boxes(), slot as usize) {
                let middle = |a: usize| (f.min[a] + f.max[a]) as usize / 2 / CELL as usize;
                self.sums[(middle(1) + 1) * stride + middle(0) + 1] += 1;
                count += 1;
            }
        }
        let cells = (columns * rows) as u64;
        // Weight of a cell: its share of the samples and its share of the pixels, for what is
        // hidden where nothing was sampled counts too. With seven times the weight on samples no
        // more is found, and more has to be considered.
        let weight_of = |samples: u64| samples * cells + count.max(1);
        let mut most = 0;
        self.weights.clear();
        for row in 1..=rows {
            let mut sum = 0;
            for column in 1..=columns {
                let weight = weight_of(self.sums[row * stride + column]);
                most = most.max(weight);
                self.weights.push(weight as u32);
                sum += weight;
                self.sums[row * stride + column] = self.sums[(row - 1) * stride + column] + sum;
            }
        }
        let pixels: f32 = size.each(|s| s as f32).iter().product();
        let total = self.at([0, 1].each(|a| u64::from(size[a])));
        self.scale = pixels / total as f32;
        // A pixel of a cell has its weight times CELL² over as many pixels.
        self.densest = most as f32 * self.scale;
        self.thinnest = count.max(1) as f32 * self.scale;
        self.all = self.of([0; 2], size.each(|s| s - 1));
    }

    /// Weight of pixels, the first and the last columns and rows inclusive. No part of them has
    /// more.
    pub(super) fn of(&self, min: [u32; 2], max: [u32; 2]) -> f32 {
        let [x0, y0] = min.each(u64::from);
        let [x1, y1] = max.each(|v| u64::from(v) + 1);
        // Whole numbers: exact, so that a part is never more than the whole.
        let weight = self.at([x1, y1]) + self.at([x0, y0]) - self.at([x0, y1]) - self.at([x1, y0]);
        weight as f32 * self.scale
    }

    /// Weight of screen bounds; where none are known, of all of the screen.
    pub(super) fn of_bounds(&self, bounds: Option<ScreenBounds>) -> f32 {
        bounds.map_or(self.all, |f| self.of(f.min, f.max))
    }

    /// Most weight of `pixels` pixels of some bounds.
    pub(super) fn most_of(&self, bounds: Option<ScreenBounds>, pixels: f32) -> f32 {
        let Some(f) = bounds else { return self.all };
        // Raised by more than its rounding.
        let most = pixels * self.densest_of(f.min, f.max) * (1.0 + 1e-5);
        // Where the bounds have more than that by the weight that all pixels have, it is the less.
        if f.pixels() * self.thinnest > most { most } else { self.of(f.min, f.max).min(most) }
    }

    /// Most weight of a pixel of some, or of all, where they lie in many cells.
    fn densest_of(&self, min: [u32; 2], max: [u32; 2]) -> f32 {
        let [x0, y0] = min.each(|v| v as usize / CELL as usize);
        let [x1, y1] = max.each(|v| v as usize / CELL as usize);
        if (x1 - x0 + 1) * (y1 - y0 + 1) > FEW_CELLS {
            return self.densest;
        }
        let rows =
            (y0..=y1).flat_map(|y| &self.weights[y * self.cells[0] + x0..=y * self.cells[0] + x1]);
        rows.fold(0, |most, &w| most.max(w)) as f32 * self.scale
    }

    /// Most weight of a pixel.
    pub(super) fn densest(&self) -> f32 {
        self.densest
    }

    /// Weight of the rectangle up to a corner of a pixel: between the corners of the cells as if
    /// each had its weight spread evenly.
    fn at(&self, [x, y]: [u64; 2]) -> u64 {
        let stride = self.cells[0] + 1;
        let ([i, j], [u, v]) = ([x / CELL, y / CELL].each(|c| c as usize), [x % CELL, y % CELL]);
        // Where a coordinate is that of a corner, what lies beyond has no weight in the sum.
        let (right, below) = ((i + 1).min(self.cells[0]), (j + 1).min(self.cells[1]));
        let sum = |i: usize, j: usize| self.sums[j * stride + i];
        (sum(i, j) * (CELL - u) + sum(right, j) * u) * (CELL - v)
            + (sum(i, below) * (CELL - u) + sum(right, below) * u) * v
    }
}
