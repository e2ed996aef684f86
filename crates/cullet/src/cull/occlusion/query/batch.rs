//! Tests of whole batches, and of the nodes above them.
//!
//! A box is tested by the rectangle around it and its nearest corner. To test what is left of them
//! once more, by the pixels alone that the convex hull of the corners touches, was tried: in four
//! views of a city of 100,000 boxes it took twenty times as long a box and found none of 1,476 to
//! be hidden, so it is not done.

use crate::simd::dispatch;
use fearless_simd::prelude::*;

use super::super::raster::{OcclusionBuffer, Rectangles, ScreenBounds};
use super::nearest::Nearest;
use super::projector::BoxProjector;
use super::visibility::Visibility;
use crate::bits;
use crate::bounds::{BoxBlock, Boxes, LANES};
use crate::hierarchy::Nodes;
use crate::transform::Transform;

/// How much more doubt a node is projected with than what is below it, so that all below a hidden
/// node is hidden by its own test too, and the answer depends on no node: see
/// [`BoxProjector::project`].
const NODE_SLACK: f32 = 4.0;

/// The fewest pixels of an instance whose parts are tested: for a smaller one that costs more than
/// drawing them.
const LEAST_PARTED: f32 = 64.0;

/// Tests of many boxes against a buffer that is done.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxTests<'a> {
    buffer: &'a OcclusionBuffer,
    projector: Option<BoxProjector>,
    simd: crate::Simd,
    /// How near the tiles come at most, where that is known.
    nearest: Option<&'a Nearest>,
}

/// Results of boxes that were tested: one bit a box.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    hidden: u64,
    outside: u64,
    /// Nothing within is hidden; see [`BoxTests::group`].
    whole: u64,
}

/// Contents of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Nodes,
    Boxes,
}

impl Found {
    /// Boxes that no pixel shows.
    fn unseen(self) -> u64 {
        self.hidden | self.outside
    }
}

impl OcclusionBuffer {
    /// Tests the `wanted` boxes of a batch: sets the bits of the hidden ones in `hidden`, of the
    /// visible ones in `visible`, and neither for those outside. Bit 0 of the first word of the
    /// three masks is box 64 · `first_word`; what is not wanted gets no bit.
    ///
    /// Boxes are relative to the buffer's origin. Those that are not finite or cross the near plane
    /// are visible, and so are all before [`begin`](Self::begin); empty ones are outside, and so
    /// are those beyond an edge of the screen. What is hidden is so by [`test_box`](Self::test_box)
    /// too, while a few that it finds hidden by less than f32 can tell are visible here. The same
    /// answer at every [`Simd`](crate::Simd). Blocks of sixteen of which none is wanted cost next
    /// to nothing, so test what the frustum does not reject.
    ///
    /// Several threads may each fill a part of the masks.
    ///
    /// # Panics
    /// If the masks differ in length.
    pub fn test_boxes(
        &self,
        simd: crate::Simd,
        boxes: &Boxes,
        first_word: usize,
        wanted: &[u64],
        visible: &mut [u64],
        hidden: &mut [u64],
    ) {
        let words = wanted.len();
        assert!(
            visible.len() == words && hidden.len() == words,
            "{words} words wanted, {} and {} to be filled",
            visible.len(),
            hidden.len()
        );
        let tests = BoxTests::new(self, simd);
        for (i, &wanted) in wanted.iter().enumerate() {
            let wanted = wanted & below(boxes.len(), first_word + i);
            let found = tests.word(boxes, first_word + i, wanted);
            hidden[i] = found.hidden;
            visible[i] = wanted & !found.unseen();
        }
    }

    /// Clears the bits of those boxes that are hidden or outside, as
    /// [`test_boxes`](Self::test_boxes) finds them, but tests the `nodes` above first, 256 boxes
    /// and then sixteen at a time, so that what is hidden together falls together. The answer is
    /// the same, whatever the nodes. Bit i of the words is box i; how many tests it took comes
    /// back.
    ///
    /// # Panics
    /// If the nodes are over more boxes than there are, or a bit is set beyond the last box.
    pub fn hide_boxes(
        &self,
        simd: crate::Simd,
        nodes: &Nodes,
        boxes: &Boxes,
        alive: &mut [u64],
    ) -> u64 {
        BoxTests::new(self, simd).hide(nodes, boxes, alive)
    }

    /// Whether every pixel of some screen bounds is covered by what is nearer.
    pub(crate) fn covers(&self, simd: crate::Simd, bounds: &ScreenBounds) -> bool {
        dispatch!(simd, simd => self.read().covers(simd, bounds))
    }
}

impl<'a> BoxTests<'a> {
    pub(crate) fn new(buffer: &'a OcclusionBuffer, simd: crate::Simd) -> Self {
        let projector = buffer.screen().and_then(|(screen, _)| BoxProjector::new(screen));
        Self { buffer, projector, simd, nearest: None }
    }

    pub(crate) fn simd(&self) -> crate::Simd {
        self.simd
    }

    /// For boxes in the space of an object.
    pub(crate) fn of_object(
        buffer: &'a OcclusionBuffer,
        simd: crate::Simd,
        transform: &Transform,
    ) -> Self {
        let projector = buffer.screen().and_then(|(screen, origin)| {
            BoxProjector::of_object(screen, &screen.of_object(transform, origin))
        });
        Self { buffer, projector, simd, nearest: None }
    }

    /// The same for boxes in the space of an object.
    pub(crate) fn for_object(&self, transform: &Transform) -> Self {
        Self::of_object(self.buffer, self.simd, transform)
    }

    /// Adds the nearest depths of the buffer. They let a node that lies in front of everything
    /// drawn over its pixels accept all boxes below it without testing them.
    pub(crate) fn with_nearest(self, nearest: &'a Nearest) -> Self {
        Self { nearest: Some(nearest), ..self }
    }

    /// Clears the bits in `alive` of the boxes that are hidden or outside, as
    /// [`hide_boxes`](OcclusionBuffer::hide_boxes) does. Returns the number of tests.
    pub(crate) fn hide(&self, nodes: &Nodes, boxes: &Boxes, alive: &mut [u64]) -> u64 {
        let mut tests = 0;
        for (group, words) in alive.chunks_mut(64).enumerate() {
            if words.iter().any(|&w| w != 0) {
                let (mut all, mut whole) = ([0; 64], [0; 64]);
                all[..words.len()].copy_from_slice(words);
                tests += self.group(nodes, boxes, group, &mut all, &mut whole);
                words.copy_from_slice(&all[..words.len()]);
            }
        }
        tests
    }

    /// The screen bounds of a box as the batch has them; or why there are none: it is outside, or
    /// visible since it crosses the near plane or is not finite.
    pub(crate) fn bounds(&self, boxes: &Boxes, index: usize) -> Result<ScreenBounds, Visibility> {
        let mut found = Err(Visibility::Outside);
        let (block, lane) = (&boxes.blocks()[index / LANES], index % LANES);
        self.bounds_of(block, 1 << lane, 0.0, |_, f| found = f.ok_or(Visibility::Visible));
        found
    }

    /// Calls back with the lane and the screen bounds of the boxes of a block that are wanted, but
    /// for those of less than `least` pixels and those outside. `None` is for one that crosses the
    /// near plane or is not finite.
    pub(crate) fn bounds_of(
        &self,
        block: &BoxBlock,
        wanted: u64,
        least: f32,
        each: impl FnMut(usize, Option<ScreenBounds>),
    ) {
        self.bounds_with(1.0, block, wanted, least, each);
    }

    /// Calls `each` like [`bounds_of`](Self::bounds_of), for nodes. The screen bounds of a node
    /// hold those of everything below it. Where a node is left out, because it has less than
    /// `least` pixels or is outside, so is everything below it.
    pub(crate) fn bounds_of_nodes(
        &self,
        block: &BoxBlock,
        wanted: u64,
        least: f32,
        each: impl FnMut(usize, Option<ScreenBounds>),
    ) {
        self.bounds_with(NODE_SLACK, block, wanted, least, each);
    }

    /// No box has more pixels that lies within a node of such screen bounds, and is no larger than
    /// `sizes` along each axis.
    pub(crate) fn most_pixels(&self, node: &ScreenBounds, sizes: [f32; 3]) -> f32 {
        self.projector
            .as_ref()
            .map_or(f32::INFINITY, |projector| projector.most_pixels(node, sizes))
    }

    /// Vector whose product with the area vector of a triangle around `p` is about its number of
    /// pixels, more than 0 where it faces the eye; see [`BoxProjector::pixels_of_area`].
    pub(crate) fn pixels_of_area(&self, p: [f32; 3]) -> Option<[f32; 3]> {
        self.projector.as_ref().map(|projector| projector.pixels_of_area(p))
    }

    fn bounds_with(
        &self,
        slack: f32,
        block: &BoxBlock,
        wanted: u64,
        least: f32,
        mut each: impl FnMut(usize, Option<ScreenBounds>),
    ) {
        let r = match &self.projector {
            Some(projector) => projector.project(self.simd, block, slack),
            None => Rectangles::NONE,
        };
        for lane in bits::ones(wanted & !u64::from(r.outside)) {
            if r.bounded >> lane & 1 == 0 {
                each(lane, None);
                continue;
            }
            let bounds = r.bounds(lane);
            if bounds.pixels() >= least {
                each(lane, Some(bounds));
            }
        }
    }

    /// Tests the wanted of sixty-four boxes.
    fn word(&self, boxes: &Boxes, word: usize, wanted: u64) -> Found {
        let mut found = Found::default();
        for part in 0..4 {
            let shift = part * LANES;
            let bits = wanted >> shift & 0xffff;
            if bits != 0 {
                let of = self.block(&boxes.blocks()[word * 4 + part], bits, Kind::Boxes);
                found.hidden |= of.hidden << shift;
                found.outside |= of.outside << shift;
                found.whole |= of.whole << shift;
            }
        }
        found
    }

    /// Tests the wanted of sixteen boxes.
    fn block(&self, block: &BoxBlock, wanted: u64, kind: Kind) -> Found {
        let (Some(projector), 1..) = (&self.projector, wanted) else { return Found::default() };
        let slack = if kind == Kind::Nodes { NODE_SLACK } else { 1.0 };
        let r = projector.project(self.simd, block, slack);
        dispatch!(self.simd, simd => {
            test_rectangles(simd, self.buffer, self.nearest, &r, wanted, kind)
        })
    }

    /// Clears the bits of what is hidden or outside of 64 words, by the nodes above them first; how
    /// many tests it took. Of what is left, sets the bits in `whole` of those of which no part is
    /// hidden: nothing that was drawn over the pixels that they may touch is nearer than their
    /// farthest point, or they are small. (Without [`with_nearest`](Self::with_nearest) only small
    /// ones are found.)
    ///
    /// A node of all 4,096 boxes is tested where most of those of 256 are wanted: in a scene of ten
    /// million most of what is in the frustum goes by such nodes, while of a hundred thousand none
    /// is hidden that would not have gone as soon.
    pub(crate) fn group(
        &self,
        nodes: &Nodes,
        boxes: &Boxes,
        group: usize,
        alive: &mut [u64; 64],
        whole: &mut [u64; 64],
    ) -> u64 {
        let mut tests = 0;
        // Boxes under a node: those that were there when the nodes were made.
        let under = |word: usize| below(nodes.len(), group * 64 + word);
        let wanted_of = |alive: &[u64; 64], whole: &[u64; 64]| {
            let is_wanted = |n: &usize| (n * 4..n * 4 + 4).any(|w| alive[w] & !whole[w] != 0);
            (0..LANES).filter(is_wanted).fold(0_u64, |wanted, n| wanted | 1 << n)
        };
        let mut wanted = wanted_of(alive, whole);
        // Of few, a node around all says too little.
        if wanted.count_ones() as usize * 2 > LANES
            && let Some(block) = nodes.levels().get(2).and_then(|l| l.blocks().get(group / LANES))
        {
            tests += 1;
            let found = self.block(block, 1 << (group % LANES), Kind::Nodes);
            if found.unseen() | found.whole != 0 {
                for word in 0..64 {
                    match found.whole {
                        0 => alive[word] &= !under(word),
                        _ => whole[word] |= alive[word] & under(word),
                    }
                }
            }
            wanted = wanted_of(alive, whole);
        }
        if let Some(block) = nodes.levels().get(1).and_then(|l| l.blocks().get(group))
            && wanted != 0
        {
            tests += u64::from(wanted.count_ones());
            let found = self.block(block, wanted, Kind::Nodes);
            for n in bits::ones(found.unseen()) {
                for word in n * 4..n * 4 + 4 {
                    alive[word] &= !under(word);
                }
            }
            for n in bits::ones(found.whole) {
                for word in n * 4..n * 4 + 4 {
                    whole[word] |= alive[word] & under(word);
                }
            }
            wanted = wanted_of(alive, whole);
        }
        for n in bits::ones(wanted) {
            let words = n * 4..n * 4 + 4;
            let first = group * LANES + n;
            if let Some(block) = nodes.levels().first().and_then(|l| l.blocks().get(first)) {
                let mut wanted = 0_u64;
                for (i, word) in words.clone().enumerate() {
                    let left = alive[word] & under(word) & !whole[word];
                    for part in (0..4).filter(|part| left >> (part * LANES) & 0xffff != 0) {
                        wanted |= 1 << (i * 4 + part);
                    }
                }
                tests += u64::from(wanted.count_ones());
                let found = self.block(block, wanted, Kind::Nodes);
                for node in bits::ones(found.unseen()) {
                    let word = n * 4 + node / 4;
                    alive[word] &= !(under(word) & 0xffff << (node % 4 * LANES));
                }
                for node in bits::ones(found.whole) {
                    let word = n * 4 + node / 4;
                    whole[word] |= alive[word] & under(word) & 0xffff << (node % 4 * LANES);
                }
            }
            for word in words {
                let wanted = alive[word] & !whole[word];
                tests += u64::from(wanted.count_ones());
                let found = self.word(boxes, group * 64 + word, wanted);
                alive[word] &= !found.unseen();
                whole[word] |= found.whole;
            }
        }
        tests
    }
}

/// The bits of a word that are those of the first `len`.
fn below(len: usize, word: usize) -> u64 {
    match len.saturating_sub(word * 64) {
        0 => 0,
        left if left >= 64 => u64::MAX,
        left => (1 << left) - 1,
    }
}

#[inline(always)]
fn test_rectangles<S: Simd>(
    simd: S,
    buffer: &OcclusionBuffer,
    nearest: Option<&Nearest>,
    r: &Rectangles,
    wanted: u64,
    kind: Kind,
) -> Found {
    let (mut hidden, mut whole) = (0, 0);
    for lane in bits::ones(wanted & u64::from(r.bounded)) {
        let bounds = r.bounds(lane);
        if buffer.read().covers(simd, &bounds) {
            hidden |= 1 << lane;
            continue;
        }
        // Counting pixels is the cheaper of the two.
        let is_small = kind == Kind::Boxes && bounds.pixels() < LEAST_PARTED;
        let is_whole = is_small
            || nearest.is_some_and(|n| n.is_before(simd, buffer, &bounds, r.farthest[lane]));
        whole |= u64::from(is_whole) << lane;
    }
    Found { hidden, outside: wanted & u64::from(r.outside), whole }
}
