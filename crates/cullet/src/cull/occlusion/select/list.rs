//! Drawing lists of occluders, without those that are hidden by then.
//!
//! Sharing a list out over threads was tried. A buffer for each, merged pixel by pixel, was slower
//! than one thread: what one has hidden the other draws, and merging moves megabytes. Bands of one
//! buffer, cut by a model of what each row costs, drew the same bits, but no renderer called for
//! them. Boxes of a sorted list read from a plain slice, one or two cache lines each, took as long
//! to project as those of a batch, six.

use super::super::query::BoxProjector;
use super::super::raster::{OcclusionBuffer, Rectangles};
use crate::bits;
use crate::bounds::{BoxBlock, Boxes, LANES};

impl OcclusionBuffer {
    /// Goes through occluders, the nearest first for most effect, and has those drawn that are not
    /// hidden by then: `draw` is called with the numbers of `order`, in its order, but for those
    /// whose box, relative to the buffer's origin, lies behind what was drawn before or beyond an
    /// edge of the screen. Returns how many were drawn. The buffer proves the same as if all were
    /// drawn.
    ///
    /// `least_pixels` has for each box the pixels from which on it is drawn, such as
    /// [`Shape::worth_pixels`](super::super::Shape::worth_pixels); an empty slice is for none. What
    /// is smaller is passed over, and the buffer proves less: of a castle and a hall of boxes that
    /// are hidden 0.2 and 0.7 in a hundred, in 0.40 and 0.56 of the time.
    ///
    /// Boxes are projected sixteen at a time. Those that cross the near plane or are not finite are
    /// drawn; empty ones are not.
    ///
    /// # Panics
    /// If `order` has a number that is no box, or that `least_pixels`, which is not empty, lacks.
    pub fn draw_unless_hidden(
        &mut self,
        simd: crate::Simd,
        (boxes, least_pixels): (&Boxes, &[f32]),
        order: &[u32],
        mut draw: impl FnMut(&mut Self, u32),
    ) -> usize {
        let Some((screen, _)) = self.screen() else { return 0 };
        let projector = BoxProjector::new(screen);
        let mut drawn = 0;
        for some in order.chunks(LANES) {
            let r = rectangles(simd, projector.as_ref(), boxes, some);
            let wanted = u64::MAX >> (64 - some.len()) & !u64::from(r.outside);
            for lane in bits::ones(wanted) {
                if r.bounded >> lane & 1 == 1 {
                    let bounds = r.bounds(lane);
                    let is_small = !least_pixels.is_empty()
                        && bounds.pixels() < least_pixels[some[lane] as usize];
                    if is_small || self.covers(simd, &bounds) {
                        continue;
                    }
                }
                draw(self, some[lane]);
                drawn += 1;
            }
        }
        drawn
    }
}

/// Where up to sixteen boxes lie on the screen.
pub(super) fn rectangles(
    simd: crate::Simd,
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
    projector.map_or(Rectangles::NONE, |projector| projector.project(simd, &block, 1.0))
}
