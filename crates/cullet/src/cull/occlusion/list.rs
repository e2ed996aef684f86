//! Drawing lists of occluders: without those that are hidden by then, and shared out over threads.

use std::iter::StepBy;
use std::ops::Range;

use fearless_simd::{Level, dispatch};

use super::ask::{Lens, Rectangles, covered};
use super::buffer::{OcclusionBuffer, OcclusionError};
use crate::bounds::{BoxBlock, Boxes, LANES};

/// The items of a list that are a job's own: every so many, from its first on.
pub type Share = StepBy<Range<usize>>;

/// A part of the drawing of a list, to be run once on any thread; see
/// [`OcclusionBuffer::draw_in_jobs`].
#[derive(Debug)]
pub struct DrawJob<'a, F> {
    buffer: &'a mut OcclusionBuffer,
    draw: &'a F,
    share: Share,
}

impl<F: Fn(&mut OcclusionBuffer, Share)> DrawJob<'_, F> {
    /// Does it.
    pub fn run(self) {
        (self.draw)(self.buffer, self.share);
    }
}

impl OcclusionBuffer {
    /// Goes through occluders, the nearest first for most effect, and has those drawn that are not hidden by then: `draw` is
    /// called with the numbers of `order`, in its order, but for those whose box, relative to the buffer's origin, lies behind
    /// what was drawn before or beyond an edge of the screen. Returns how many were drawn. The buffer proves the same as if all
    /// were drawn.
    ///
    /// Boxes are projected sixteen at a time: some 10 ns for one that is hidden. Those that cross the near plane or are not
    /// finite are drawn; empty ones are not.
    ///
    /// # Panics
    /// If `order` has a number that is no box.
    pub fn draw_unless_hidden(
        &mut self,
        level: Level,
        boxes: &Boxes,
        order: &[u32],
        mut draw: impl FnMut(&mut Self, u32),
    ) -> usize {
        let Some(screen) = &self.screen else { return 0 };
        let lens = Lens::new(screen);
        let mut drawn = 0;
        for some in order.chunks(LANES) {
            let mut block = BoxBlock([[0.0; LANES]; 6]);
            for (lane, &i) in some.iter().enumerate() {
                assert!((i as usize) < boxes.len(), "box {i} of {}", boxes.len());
                let from = &boxes.blocks()[i as usize / LANES].0;
                for (row, from) in block.0.iter_mut().zip(from) {
                    row[lane] = from[i as usize % LANES];
                }
            }
            let mut r = Rectangles::NONE;
            if let Some(lens) = &lens {
                dispatch!(level, simd => lens.project(simd, &block, 1.0, &mut r));
            }
            for (lane, &i) in some.iter().enumerate() {
                let is_hidden = r.outside >> lane & 1 == 1
                    || r.bounded >> lane & 1 == 1 && {
                        let min = [0, 1].map(|a| r.min[a][lane] as usize);
                        let max = [0, 1].map(|a| r.max[a][lane] as usize);
                        dispatch!(level, simd => covered(simd, self, min, max, r.nearness[lane]))
                    };
                if !is_hidden {
                    draw(self, i);
                    drawn += 1;
                }
            }
        }
        drawn
    }

    /// Draws a list of `count` occluders as one job more than there are `others`, each into a buffer of its own, and takes in
    /// what the others proved. `run` is given the jobs, each to be run once, on any thread and in any order; each calls
    /// `draw` with its buffer and the numbers that are its share, which are spread over the list, so that one that is
    /// sorted front to back is so for every job. The same buffer in the end, for any number of jobs; but where what is drawn
    /// depends on the buffer, as in [`draw_unless_hidden`](Self::draw_unless_hidden), how much is drawn does differ.
    ///
    /// With rayon: `|jobs| jobs.into_par_iter().for_each(DrawJob::run)`. What the others held is lost; they are kept by
    /// the caller for their memory alone. Taking one in costs as much as copying it: a list that is drawn in less than a
    /// tenth of a millisecond is not worth sharing out.
    ///
    /// # Errors
    /// [`OcclusionError::Merge`] where another has another size; nothing is drawn.
    pub fn draw_in_jobs<F: Fn(&mut Self, Share)>(
        &mut self,
        others: &mut [Self],
        count: usize,
        draw: &F,
        run: impl FnOnce(Vec<DrawJob<'_, F>>),
    ) -> Result<(), OcclusionError> {
        if let Some(other) = others.iter().find(|o| o.size != self.size) {
            let ([a, b], [c, d]) = (self.size, other.size);
            return Err(OcclusionError::Merge(a, b, c, d));
        }
        let jobs = others.len() + 1;
        for other in &mut *others {
            other.empty();
            (other.screen, other.origin) = (self.screen.clone(), self.origin);
        }
        let buffers = std::iter::once(&mut *self).chain(&mut *others);
        let share = |first: usize| (first.min(count)..count).step_by(jobs);
        let all = buffers.enumerate().map(|(k, buffer)| DrawJob { buffer, draw, share: share(k) });
        run(all.collect());
        for other in others {
            self.merge(other)?;
        }
        Ok(())
    }
}
