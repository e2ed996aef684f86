//! Drawing a batch of occluders, in bands of the buffer: a job for each.
//!
//! Every job goes over all shapes, front to back, but draws only into its own rows of blocks. What
//! is drawn of a shape in a row depends on nothing but what was drawn there before, so bands leave
//! the buffer as drawing into the whole does. A shape is hidden where every band finds it hidden;
//! where only some do, drawing it changes nothing in those. So neither the buffer nor the list of
//! what was drawn depends on the bands.

use alloc::vec::Vec;
use core::array;

use super::super::frame::Frame;
use crate::cull::occlusion::{BLOCK, Candidate, Canvas, OcclusionBuffer};
use crate::jobs::{self, MOST};
use crate::scene::Scene;
use crate::{Simd, simd::dispatch};

/// The least cost of shapes, in microseconds of the cost model, that is worth a job. Each band has
/// to place all shapes that reach into it.
const LEAST_DRAWN: f32 = 10.0;

/// A band that is drawn into.
struct Band<'a> {
    canvas: Canvas<'a>,
    /// Whether each shape is hidden within the band.
    hidden: &'a mut [bool],
}

/// Draws shapes in their order. Fills `hidden` with whether each was hidden by then, which adds
/// nothing.
pub(super) fn draw(
    frame: &Frame<'_>,
    shapes: &[Candidate],
    buffer: &mut OcclusionBuffer,
    hidden: &mut Vec<bool>,
) {
    let cost = shapes.iter().map(|shape| shape.cost).sum();
    let count = jobs::split(frame.jobs, cost, LEAST_DRAWN, 1).min(buffer.block_rows());
    hidden.clear();
    hidden.resize(shapes.len() * count, false);
    let (scene, simd) = (frame.scene, frame.culler.simd);
    if count > 1 {
        let ends = ends(shapes, buffer.block_rows(), count);
        let mut bands = buffer.bands(&ends[..count]).zip(hidden.chunks_mut(shapes.len().max(1)));
        let mut bands: [_; MOST] =
            array::from_fn(|_| bands.next().map(|(canvas, hidden)| Band { canvas, hidden }));
        jobs::each(frame.jobs, &mut bands[..count], |band| {
            if let Some(band) = band {
                band.draw(scene, simd, shapes);
            }
        });
    } else {
        Band { canvas: buffer.canvas(), hidden }.draw(scene, simd, shapes);
    }
    let (all, others) = hidden.split_at_mut(shapes.len());
    for band in others.chunks(shapes.len().max(1)) {
        all.iter_mut().zip(band).for_each(|(all, hidden)| *all &= hidden);
    }
}

impl Band<'_> {
    fn draw(&mut self, scene: &Scene, simd: Simd, shapes: &[Candidate]) {
        for (of, hidden) in shapes.iter().zip(&mut *self.hidden) {
            self.canvas.nearest = f32::INFINITY;
            if let Some(bounds) = of.bounds {
                let target = &self.canvas.target;
                if dispatch!(simd, simd => target.covers(simd, &bounds)) {
                    *hidden = true;
                    continue;
                }
                self.canvas.nearest = bounds.nearness;
            }
            let shape = &scene.prepared_of(of.slot).shapes()[of.shape as usize];
            shape.draw_on(simd, &mut self.canvas, scene.transform(of.slot));
        }
    }
}

/// Returns where bands end that cost about the same, by the rows of blocks that the shapes reach.
fn ends(shapes: &[Candidate], rows: usize, count: usize) -> [usize; MOST] {
    const ROWS: usize = OcclusionBuffer::LIMIT as usize / BLOCK[1];
    let mut slopes = [0.0_f32; ROWS + 1];
    let mut sum = 0.0;
    for shape in shapes {
        let [first, last] = shape.bounds.map_or([0, rows - 1], |b| {
            [b.min[1], b.max[1]].map(|y| (y as usize / BLOCK[1]).min(rows - 1))
        });
        let each = shape.cost / (last + 1 - first) as f32;
        slopes[first] += each;
        slopes[last + 1] -= each;
        sum += shape.cost;
    }
    let mut ends = [rows; MOST];
    let (mut of_row, mut above, mut band) = (0.0, 0.0, 0);
    for (row, slope) in slopes[..rows].iter().enumerate() {
        of_row += slope;
        above += of_row;
        if band + 1 < count && above * count as f32 >= sum * (band + 1) as f32 {
            ends[band] = row + 1;
            band += 1;
        }
    }
    // Those that no row was left for are empty.
    ends
}
