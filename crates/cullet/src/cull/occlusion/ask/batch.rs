//! Asking for whole batches, and for the nodes above them.
//!
//! A box is asked about by the rectangle around it and its nearest corner. To ask about what is left of them
//! once more, by the pixels alone that the convex hull of the corners touches, was tried: in four views of a
//! city of 100,000 boxes it took 0.3 µs a box and found none of 1,476 to be hidden, so it is not done.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x8};

use super::super::buffer::{OcclusionBuffer, TILE};
use super::super::tile::{Held, Tiles};
use super::lens::{Lens, Rectangles};
use super::nearest::Nearest;
use super::{Footprint, Verdict};
use crate::bits;
use crate::bounds::{BoxBlock, Boxes, LANES};
use crate::hierarchy::Nodes;
use crate::transform::Transform;

/// How much more doubt a node is projected with than what is below it, so that all below a hidden node is
/// hidden by its own test too, and the answer depends on no node: see [`Lens::project`].
const NODE_SLACK: f32 = 4.0;

/// What has fewer pixels is hidden as a whole or not at all: asking about its parts costs more than drawing them.
const LEAST_PARTED: usize = 64;

/// A buffer that is done, made ready to be asked about many boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asker<'a> {
    buffer: &'a OcclusionBuffer,
    lens: Option<Lens>,
    level: Level,
    /// Where it is known how near the tiles come at most.
    nearest: Option<&'a Nearest>,
}

/// What boxes that were asked about were found to be: one bit a box.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    hidden: u64,
    outside: u64,
    /// Nothing within is hidden; see [`Asker::group`].
    whole: u64,
}

/// What a block is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Nodes,
    Boxes,
}

impl Found {
    /// What no pixel shows.
    fn unseen(self) -> u64 {
        self.hidden | self.outside
    }
}

impl OcclusionBuffer {
    /// Sorts those of a batch of boxes that are asked about: sets the bits of the hidden ones in `hidden`, of
    /// the visible ones in `visible`, and neither for those outside. Bit 0 of the first word of the three masks
    /// is box 64 · `first_word`; what is not asked about gets no bit.
    ///
    /// Boxes are relative to the buffer's origin. Those that are not finite or cross the near plane are
    /// visible, and so are all before [`begin`](Self::begin); empty ones are outside, and so are those beyond
    /// an edge of the screen. What is hidden is so by [`ask_box`](Self::ask_box) too, while a few that this
    /// finds hidden by less than f32 can tell are visible here. The same answer at every [`Level`]. Some 10 ns
    /// a box in the view; blocks of sixteen of which none is asked about cost next to nothing, so ask about
    /// what the frustum does not reject.
    ///
    /// Several threads may each fill a part of the masks.
    ///
    /// # Panics
    /// If the masks differ in length.
    pub fn ask_boxes(
        &self,
        level: Level,
        boxes: &Boxes,
        first_word: usize,
        asked: &[u64],
        visible: &mut [u64],
        hidden: &mut [u64],
    ) {
        let words = asked.len();
        assert!(
            visible.len() == words && hidden.len() == words,
            "{words} words asked about, {} and {} to be filled",
            visible.len(),
            hidden.len()
        );
        let asker = Asker::new(self, level);
        for (i, &asked) in asked.iter().enumerate() {
            let asked = asked & below(boxes.len(), first_word + i);
            let found = asker.word(boxes, first_word + i, asked);
            hidden[i] = found.hidden;
            visible[i] = asked & !found.unseen();
        }
    }

    /// The oracle of [`ask_boxes`](Self::ask_boxes): one box after the other, in f64.
    #[must_use]
    pub fn ask_boxes_ref(&self, boxes: &Boxes) -> Vec<Verdict> {
        (0..boxes.len()).map(|i| self.ask_box(&boxes.get(i))).collect()
    }

    /// Clears the bits of those boxes that are hidden or outside, as [`ask_boxes`](Self::ask_boxes) finds them,
    /// but asks first about the `nodes` above, 256 boxes and then sixteen at a time, so that what is hidden
    /// together falls together. The answer is the same, whatever the nodes. Bit i of the words is box i; how
    /// many tests it took comes back.
    ///
    /// # Panics
    /// If the nodes are over more boxes than there are, or a bit is set beyond the last box.
    pub fn hide_boxes(&self, level: Level, nodes: &Nodes, boxes: &Boxes, alive: &mut [u64]) -> u64 {
        Asker::new(self, level).hide(nodes, boxes, alive)
    }

    /// [`covers`](Self::covers), with SIMD.
    pub(crate) fn is_covering(&self, level: Level, f: &Footprint) -> bool {
        let (min, max) = (f.min.map(|v| v as usize), f.max.map(|v| v as usize));
        dispatch!(level, simd => covered(simd, self.as_tiles(), min, max, f.nearness))
    }
}

impl<'a> Asker<'a> {
    pub(crate) fn new(buffer: &'a OcclusionBuffer, level: Level) -> Self {
        let lens = buffer.screen.as_ref().and_then(Lens::new);
        Self { buffer, lens, level, nearest: None }
    }

    pub(crate) fn level(&self) -> Level {
        self.level
    }

    /// For boxes in the space of an object.
    pub(crate) fn of_object(
        buffer: &'a OcclusionBuffer,
        level: Level,
        transform: &Transform,
    ) -> Self {
        let screen = buffer.screen.as_ref();
        let lens = screen.and_then(|s| Lens::of_object(s, transform, buffer.origin));
        Self { buffer, lens, level, nearest: None }
    }

    /// The same for boxes in the space of an object.
    pub(crate) fn for_object(&self, transform: &Transform) -> Self {
        Self::of_object(self.buffer, self.level, transform)
    }

    /// With this, what is before everything that was drawn is found to be so by its node, and not asked about.
    pub(crate) fn with_nearest(self, nearest: &'a Nearest) -> Self {
        Self { nearest: Some(nearest), ..self }
    }

    /// What [`hide_boxes`](OcclusionBuffer::hide_boxes) does.
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

    /// The footprint of a box as the batch has it; or why there is none: it is outside, or visible since it
    /// crosses the near plane or is not finite.
    pub(crate) fn footprint(&self, boxes: &Boxes, index: usize) -> Result<Footprint, Verdict> {
        let mut found = Err(Verdict::Outside);
        let (block, lane) = (&boxes.blocks()[index / LANES], index % LANES);
        self.footprints(block, 1 << lane, 0.0, |_, f| found = f.ok_or(Verdict::Visible));
        found
    }

    /// Calls back with the lane and the footprint of the boxes of a block that are asked for, but for those of
    /// less than `least` pixels and those outside. `None` is for one that crosses the near plane or is not
    /// finite.
    pub(crate) fn footprints(
        &self,
        block: &BoxBlock,
        asked: u64,
        least: f32,
        each: impl FnMut(usize, Option<Footprint>),
    ) {
        self.footprints_with(1.0, block, asked, least, each);
    }

    /// As [`footprints`](Self::footprints), for nodes: what is below one has its footprint within, and where
    /// there is none for want of pixels or being outside, neither has what is below.
    pub(crate) fn footprints_of_nodes(
        &self,
        block: &BoxBlock,
        asked: u64,
        least: f32,
        each: impl FnMut(usize, Option<Footprint>),
    ) {
        self.footprints_with(NODE_SLACK, block, asked, least, each);
    }

    /// No box has more pixels that lies within a node of such a footprint, and is no larger than `sizes` along each
    /// axis.
    pub(crate) fn most_pixels(&self, node: &Footprint, sizes: [f32; 3]) -> f32 {
        self.lens.as_ref().map_or(f32::INFINITY, |lens| lens.most_pixels(node, sizes))
    }

    fn footprints_with(
        &self,
        slack: f32,
        block: &BoxBlock,
        asked: u64,
        least: f32,
        mut each: impl FnMut(usize, Option<Footprint>),
    ) {
        let mut r = Rectangles::NONE;
        if let Some(lens) = &self.lens {
            dispatch!(self.level, simd => lens.project(simd, block, slack, &mut r));
        }
        for lane in bits::ones(asked & !u64::from(r.outside)) {
            if r.bounded >> lane & 1 == 0 {
                each(lane, None);
                continue;
            }
            let footprint = Footprint {
                min: [0, 1].map(|a| r.min[a][lane] as u32),
                max: [0, 1].map(|a| r.max[a][lane] as u32),
                nearness: r.nearness[lane],
            };
            if footprint.pixels() >= least {
                each(lane, Some(footprint));
            }
        }
    }

    /// Those asked about of sixty-four boxes.
    fn word(&self, boxes: &Boxes, word: usize, asked: u64) -> Found {
        let mut found = Found::default();
        for part in 0..4 {
            let shift = part * LANES;
            let bits = asked >> shift & 0xffff;
            if bits != 0 {
                let of = self.block(&boxes.blocks()[word * 4 + part], bits, Kind::Boxes);
                found.hidden |= of.hidden << shift;
                found.outside |= of.outside << shift;
                found.whole |= of.whole << shift;
            }
        }
        found
    }

    /// Those asked about of sixteen boxes.
    fn block(&self, block: &BoxBlock, asked: u64, kind: Kind) -> Found {
        let (Some(lens), 1..) = (&self.lens, asked) else { return Found::default() };
        dispatch!(self.level, simd => {
            ask_block(simd, self.buffer, lens, self.nearest, block, asked, kind)
        })
    }

    /// Clears the bits of what is hidden or outside of 64 words, by the nodes above them first; how many tests
    /// it took. Of what is left, sets the bits in `whole` of those of which no part is hidden: nothing that was
    /// drawn over the pixels that they may touch is nearer than their farthest point, or they are small.
    /// (Without [`with_nearest`](Self::with_nearest) only small ones are found.)
    ///
    /// Nodes still higher were not worth asking: one of 256 costs as much as one of sixteen boxes.
    pub(crate) fn group(
        &self,
        nodes: &Nodes,
        boxes: &Boxes,
        group: usize,
        alive: &mut [u64; 64],
        whole: &mut [u64; 64],
    ) -> u64 {
        let mut tests = 0;
        // What is under a node: the boxes that were there when the nodes were made.
        let under = |word: usize| below(nodes.len(), group * 64 + word);
        let is_alive = |n: &usize| alive[n * 4..n * 4 + 4] != [0; 4];
        let asked = (0..LANES).filter(is_alive).fold(0_u64, |a, n| a | 1 << n);
        if let Some(block) = nodes.levels().get(1).and_then(|l| l.blocks().get(group)) {
            tests += u64::from(asked.count_ones());
            let found = self.block(block, asked, Kind::Nodes);
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
        }
        for n in bits::ones(asked) {
            let words = n * 4..n * 4 + 4;
            let first = group * LANES + n;
            if let Some(block) = nodes.levels().first().and_then(|l| l.blocks().get(first)) {
                let mut asked = 0_u64;
                for (i, word) in words.clone().enumerate() {
                    let left = alive[word] & under(word) & !whole[word];
                    for part in (0..4).filter(|part| left >> (part * LANES) & 0xffff != 0) {
                        asked |= 1 << (i * 4 + part);
                    }
                }
                tests += u64::from(asked.count_ones());
                let found = self.block(block, asked, Kind::Nodes);
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
                let asked = alive[word] & !whole[word];
                tests += u64::from(asked.count_ones());
                let found = self.word(boxes, group * 64 + word, asked);
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
fn ask_block<S: Simd>(
    simd: S,
    buffer: &OcclusionBuffer,
    lens: &Lens,
    nearest: Option<&Nearest>,
    block: &BoxBlock,
    asked: u64,
    kind: Kind,
) -> Found {
    let mut r = Rectangles::NONE;
    let slack = if kind == Kind::Nodes { NODE_SLACK } else { 1.0 };
    lens.project(simd, block, slack, &mut r);
    let (mut hidden, mut whole) = (0, 0);
    for lane in bits::ones(asked & u64::from(r.bounded)) {
        let min = [0, 1].map(|a| r.min[a][lane] as usize);
        let max = [0, 1].map(|a| r.max[a][lane] as usize);
        if covered(simd, buffer.as_tiles(), min, max, r.nearness[lane]) {
            hidden |= 1 << lane;
        } else if nearest.is_some_and(|n| n.is_before(simd, buffer, min, max, r.farthest[lane])) {
            whole |= 1 << lane;
        } else if kind == Kind::Boxes {
            let pixels = (max[0] - min[0] + 1) * (max[1] - min[1] + 1);
            whole |= u64::from(pixels < LEAST_PARTED) << lane;
        }
    }
    Found { hidden, outside: asked & u64::from(r.outside), whole }
}

/// Whether all pixels of a rectangle that lie in some tiles are nearer: whole tiles first, a vector of them at
/// a time. The rectangle lies within the buffer.
#[inline(always)]
pub(in super::super) fn covered<S: Simd>(
    simd: S,
    of: Tiles<'_>,
    min: [usize; 2],
    max: [usize; 2],
    nearness: f32,
) -> bool {
    let limit = S::f32s::splat(simd, nearness);
    let (first, last) = (min.map(|v| v / TILE), max.map(|v| v / TILE));
    for row in first[1].max(of.rows[0])..=last[1].min(of.rows[1] - 1) {
        let mut column = first[0];
        while column <= last[0] {
            let count = (last[0] - column + 1).min(S::f32s::LEN);
            let t = (row - of.rows[0]) * of.columns + column;
            let wanted = u64::MAX >> (64 - count);
            let open = match of.far.get(t..t + S::f32s::LEN) {
                Some(far) => wanted & !S::f32s::from_slice(simd, far).simd_gt(limit).to_bitmask(),
                // The last tiles of the buffer: there is no whole vector of them.
                None => {
                    let nearer = |i: &usize| of.far[t + i] > nearness;
                    wanted & !(0..count).filter(nearer).fold(0, |near, i| near | 1 << i)
                }
            };
            for i in bits::ones(open) {
                let tile = [column + i, row];
                if !tile_covered(simd, of, tile, min, max, nearness) {
                    return false;
                }
            }
            column += count;
        }
    }
    true
}

/// Whether the pixels of a tile that are in a rectangle are nearer.
#[inline(always)]
fn tile_covered<S: Simd>(
    simd: S,
    of: Tiles<'_>,
    tile: [usize; 2],
    min: [usize; 2],
    max: [usize; 2],
    nearness: f32,
) -> bool {
    let t = (tile[1] - of.rows[0]) * of.columns + tile[0];
    let held = of.live[t];
    if held == Held::Nothing {
        return 0.0 > nearness;
    }
    let from = [0, 1].map(|a| min[a].max(tile[a] * TILE) % TILE);
    let to = [0, 1].map(|a| max[a].min(tile[a] * TILE + TILE - 1) % TILE);
    let wanted = 0xff_u64 >> (TILE - 1 - to[0]) & 0xff << from[0];
    if held == Held::Planes {
        return of.tiles[t].least_of_planes(from, to) > nearness;
    }
    let limit = f32x8::splat(simd, nearness);
    for row in from[1]..=to[1] {
        let nearer = of.tiles[t].row(simd, row).simd_gt(limit).to_bitmask();
        if nearer & wanted != wanted {
            return false;
        }
    }
    true
}
