//! Drawing lists of occluders: without those that are hidden by then, and shared out over threads.
//!
//! Jobs are [`Band`]s of the buffer. A buffer for each of them, the list dealt out in turn and the buffers
//! merged pixel by pixel, was slower than one thread: what one has hidden the other draws, and merging moves
//! megabytes. Buffers of one's own pay where lists are apart to begin with, as where each thread makes what it
//! draws.
//!
//! More bands than threads, taken by whoever is free, were slower than as many: of the city of the benchmark a
//! fourth of all work lies in one row of blocks, that of the horizon, so more bands even out little and set up
//! more twice. Boxes of a sorted list read from a plain slice, one or two cache lines each, took as long to
//! project as those of a batch, six.

use crate::array::Each;
use crate::simd::dispatch;
use fearless_simd::prelude::*;

use super::super::query::BoxProjector;
use super::super::raster::{BLOCK, Band, Blocks, OcclusionBuffer, Rectangles};
use crate::bits;
use crate::bounds::{BoxBlock, Boxes, LANES};

/// A part of the drawing of a list, to be run once on any thread; see
/// [`OcclusionBuffer::draw_in_jobs`].
#[derive(Debug)]
pub struct DrawJob<'a, F> {
    band: Band<'a>,
    level: crate::Simd,
    order: &'a [u32],
    rectangles: &'a [Rectangles],
    draw: &'a F,
}

impl<F: Fn(&mut Band<'_>, u32)> DrawJob<'_, F> {
    /// Does it.
    pub fn run(mut self) {
        let mut draw = self.draw;
        for (some, r) in self.order.chunks(LANES).zip(self.rectangles) {
            self.band.draw_open(self.level, r, some, &mut draw);
        }
    }
}

impl OcclusionBuffer {
    /// Goes through occluders, the nearest first for most effect, and has those drawn that are not hidden by
    /// then: `draw` is called with the numbers of `order`, in its order, but for those whose box, relative to
    /// the buffer's origin, lies behind what was drawn before or beyond an edge of the screen. Returns how many
    /// were drawn. The buffer proves the same as if all were drawn. The [`Band`] that `draw` is given is all of
    /// the buffer.
    ///
    /// Boxes are projected sixteen at a time. Those that cross the near plane or are not finite are drawn; empty ones are
    /// not.
    ///
    /// # Panics
    /// If `order` has a number that is no box.
    pub fn draw_unless_hidden(
        &mut self,
        level: crate::Simd,
        boxes: &Boxes,
        order: &[u32],
        mut draw: impl FnMut(&mut Band<'_>, u32),
    ) -> usize {
        let Some((screen, _)) = self.screen() else { return 0 };
        let projector = BoxProjector::new(screen);
        let mut band = self.band();
        let mut drawn = 0;
        for some in order.chunks(LANES) {
            let r = rectangles(level, projector.as_ref(), boxes, some);
            drawn += band.draw_open(level, &r, some, &mut draw);
        }
        drawn
    }

    /// Does the work of [`draw_unless_hidden`](Self::draw_unless_hidden) in `jobs` jobs. The buffer
    /// is the same to the last bit, for any number of them. `run` is given the jobs. Each must be
    /// run once, on any thread and in any order. A job has a [`Band`] of the buffer, which is some
    /// rows of blocks, and goes through the whole list. It draws each occluder that touches its
    /// band and is not hidden there by then. An occluder may therefore be drawn in several bands,
    /// or in none.
    ///
    /// To use rayon, pass `|jobs| jobs.into_par_iter().for_each(DrawJob::run)` as `run`. It is best
    /// to have as many jobs as threads: bands are cut so that each has about as much to do, and an
    /// occluder that crosses from one band into the next is set up in both. The boxes are projected
    /// before, by the caller's thread. A number of 0 counts as 1, and there are never more jobs
    /// than rows of blocks.
    ///
    /// # Panics
    /// If `order` has a number that is no box.
    pub fn draw_in_jobs<F: Fn(&mut Band<'_>, u32)>(
        &mut self,
        level: crate::Simd,
        boxes: &Boxes,
        order: &[u32],
        jobs: usize,
        draw: &F,
        run: impl FnOnce(Vec<DrawJob<'_, F>>),
    ) {
        let Some((screen, _)) = self.screen() else { return };
        let projector = BoxProjector::new(screen);
        let mut all = std::mem::take(&mut self.rectangles);
        all.clear();
        let some = order.chunks(LANES);
        all.extend(some.map(|some| rectangles(level, projector.as_ref(), boxes, some)));
        let ends = RowCosts::new(&all, order.len(), self.block_counts()).ends(jobs);
        let rectangles = &all;
        let job = |band| DrawJob { band, level, order, rectangles, draw };
        run(self.bands(&ends).into_iter().map(job).collect());
        self.rectangles = all;
    }
}

impl Band<'_> {
    /// Draws those of up to sixteen occluders that are not hidden by then; gives how many those are.
    fn draw_open(
        &mut self,
        level: crate::Simd,
        r: &Rectangles,
        some: &[u32],
        draw: &mut impl FnMut(&mut Band<'_>, u32),
    ) -> usize {
        let mut left = u64::MAX >> (64 - some.len()) & !u64::from(r.outside);
        let mut drawn = 0;
        while let Some(lane) = self.first_open(level, r, left) {
            draw(self, some[lane]);
            drawn += 1;
            left &= !1 << lane;
        }
        drawn
    }

    /// The first of some rectangles that is not hidden by now, or that has no bounds.
    fn first_open(&mut self, level: crate::Simd, r: &Rectangles, left: u64) -> Option<usize> {
        dispatch!(level, simd => first_open(simd, self.target.read(), r, left))
    }
}

#[inline(always)]
fn first_open<S: Simd>(simd: S, of: Blocks<'_>, r: &Rectangles, left: u64) -> Option<usize> {
    let [first, last] = of.pixel_rows().each(|v| v as i32);
    let mut touching = !r.bounded;
    for lane in 0..LANES {
        let touches = r.max[1][lane] >= first && r.min[1][lane] <= last;
        touching |= u32::from(touches) << lane;
    }
    for lane in bits::ones(left & u64::from(touching)) {
        if r.bounded >> lane & 1 == 0 {
            return Some(lane);
        }
        if !of.covers(simd, &r.bounds(lane)) {
            return Some(lane);
        }
    }
    None
}

/// Where up to sixteen boxes lie on the screen.
pub(super) fn rectangles(
    level: crate::Simd,
    projector: Option<&BoxProjector>,
    boxes: &Boxes,
    some: &[u32],
) -> Rectangles {
    let mut block = BoxBlock([[0.0; LANES]; 6]);
    for (lane, &i) in some.iter().enumerate() {
        assert!((i as usize) < boxes.len(), "box {i} of {}", boxes.len());
        let from = &boxes.blocks()[i as usize / LANES].0;
        for (row, from) in block.0.iter_mut().zip(from) {
            row[lane] = from[i as usize % LANES];
        }
    }
    projector.map_or(Rectangles::NONE, |projector| projector.project(level, &block, 1.0))
}

/// Cost of looking at an occluder, in units of what it costs to cover a block: fitted to the bands of 32 views of a city,
/// where a few of those looked at are drawn.
const LOOK: u64 = 12;

/// Cost of drawing one, beside the blocks that it covers whole.
const DRAW: u64 = 150;

/// So many of a list, the nearest, are taken to be drawn as far as they are beside those before.
const DRAWN: usize = 256;

/// Estimated cost of drawing a list, row by row of blocks.
#[derive(Debug)]
struct RowCosts {
    /// Up to each row, how many blocks are covered; how much begins above, and how much ends above.
    rows: Vec<[u64; 3]>,
}

impl RowCosts {
    /// Estimates the costs of `listed` occluders in a buffer of `columns` by `rows` blocks.
    fn new(rectangles: &[Rectangles], listed: usize, [columns, rows]: [usize; 2]) -> Self {
        let mut rows = vec![[0_u64; 3]; rows + 1];
        for (some, r) in rectangles.iter().enumerate() {
            let count = (listed - some * LANES).min(LANES);
            for lane in bits::ones(u64::from(r.bounded) & ((1 << count) - 1)) {
                let block = |v: i32, axis: usize| v as usize / BLOCK[axis];
                let [first, last] = [block(r.min[1][lane], 1), block(r.max[1][lane], 1)];
                let mut cost = LOOK;
                if some * LANES < DRAWN {
                    let [left, right] = [block(r.min[0][lane], 0), block(r.max[0][lane], 0)];
                    let width = (right - left + 1) as u64;
                    let mut covered = 0;
                    for row in &mut rows[first + 1..last + 2] {
                        let more = width.min(columns as u64 - row[0]);
                        row[0] += more;
                        covered += more;
                    }
                    cost += if covered > 0 { DRAW } else { 0 };
                }
                rows[first + 1][1] += cost;
                rows[last + 1][2] += cost;
            }
        }
        let mut sum = [0; 3];
        for row in &mut rows {
            // No row is free: each is cleared and tested.
            sum = [sum[0] + row[0] + 1, sum[1] + row[1], sum[2] + row[2]];
            *row = sum;
        }
        Self { rows }
    }

    /// Cost of some rows.
    fn cost(&self, first: usize, end: usize) -> u64 {
        let (above, below) = (self.rows[first], self.rows[end]);
        below[0] - above[0] + below[1] - above[2]
    }

    /// Ends of bands that cost as little as can be, the most expensive of so many.
    fn ends(&self, jobs: usize) -> Vec<usize> {
        let rows = self.rows.len() - 1;
        let jobs = jobs.clamp(1, rows);
        let (mut low, mut high) = (0, self.cost(0, rows));
        let mut best = vec![rows];
        while low < high {
            let limit = low.midpoint(high);
            let ends = self.within(limit, jobs);
            if ends.last() == Some(&rows) {
                (best, high) = (ends, limit);
            } else {
                low = limit + 1;
            }
        }
        best
    }

    /// Ends of bands that cost no more than a limit: not all rows, where so many bands do not reach.
    fn within(&self, limit: u64, jobs: usize) -> Vec<usize> {
        let rows = self.rows.len() - 1;
        let (mut ends, mut first) = (Vec::with_capacity(jobs), 0);
        while first < rows && ends.len() < jobs {
            let mut end = first;
            while end < rows && self.cost(first, end + 1) <= limit {
                end += 1;
            }
            if end == first {
                break;
            }
            ends.push(end);
            first = end;
        }
        ends
    }
}
