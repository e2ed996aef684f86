//! From frame to frame: blocks of boxes that no plane can have crossed since they were last tested are
//! not read again.
//!
//! The idea is the translation and rotation coherency of Assarsson & Möller, *Optimized View Frustum
//! Culling Algorithms* (2000), made sharper. They keep a distance for each node and wear it down by how far
//! the view moved and turned. Here a block keeps the plane that it was tested with, and the bounds of its
//! boxes on the two axes that may matter: how far a plane that is like the old one can have moved against
//! any of its corners is then an interval, evaluated at once and not summed over frames. A view that goes
//! and comes back has not moved, and a long way off a turning view costs no more than what the block itself
//! sees of it: its own width, not its distance.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

use super::super::batch::planes::{BoxPlane, Planes};
use super::Cut;
use super::walk::{Counts, Front, Target, Walk, test, valid};
use crate::bounds::{BoxBlock, Boxes, LANES};
use crate::hierarchy::Nodes;

/// [`Cut`]s of one view from frame to frame: what the last frames proved is not asked again. The
/// answers are those of [`Cut::cull`] in every frame, bit for bit.
///
/// Keeps 64 bytes for each sixteen boxes, a sixth of what the boxes take.
#[derive(Clone, Debug, Default)]
pub struct Coherent {
    now: Cut,
    before: Cut,
    memory: Vec<Memory>,
    /// What is remembered under another number is forgotten; 0 is never in use.
    generation: u32,
    version: Option<u64>,
    last: Vec<BoxPlane>,
    len: usize,
    again: Vec<u32>,
    sampling: bool,
    found: Found,
    unchanged: bool,
}

/// What one frame found.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// Blocks whose answer was taken from memory.
    answered: usize,
    /// Blocks that had a memory.
    remembered: usize,
    /// All blocks that the walk reached.
    reached: usize,
}

impl Coherent {
    /// Nothing is known yet.
    #[must_use]
    pub fn new() -> Self {
        Self { generation: 1, ..Self::default() }
    }

    /// [`Cut::cull`], from what is remembered where that is enough. `version` tells whether boxes and nodes
    /// are still those of the last call: pass
    /// [`Hierarchy::change_version`](crate::hierarchy::Hierarchy::change_version), or whatever number the
    /// caller gives to a state of the boxes. At another number everything is forgotten; see also
    /// [`moved`](Self::moved).
    ///
    /// # Panics
    /// If the nodes are over more boxes than there are.
    pub fn cull(
        &mut self,
        level: Level,
        planes: &Planes,
        nodes: &Nodes,
        boxes: &Boxes,
        version: u64,
    ) {
        assert!(nodes.len() <= boxes.len(), "nodes over {} of {}", nodes.len(), boxes.len());
        let same = self.version == Some(version) && self.len == boxes.len();
        self.unchanged = same && self.last == planes.box_planes();
        if self.unchanged {
            self.found.answered = self.found.reached;
            (self.now.counts, self.now.swept) = (Counts::default(), 0);
            return;
        }
        if !same {
            self.forget();
        }
        self.version = Some(version);
        self.len = boxes.len();
        self.last.clear();
        self.last.extend_from_slice(planes.box_planes());
        self.memory.resize(nodes.len().div_ceil(LANES), Memory::NONE);
        std::mem::swap(&mut self.now, &mut self.before);
        self.now.begin(level, planes, nodes, boxes);
        let mut fronts = std::mem::take(&mut self.now.fronts);
        let mut target = self.now.target(nodes);
        let walk = Walk { level, planes, nodes, boxes };
        let worth = walk.inner(&mut fronts, &mut target);
        self.found = Found { reached: fronts[0].len(), ..Found::default() };
        if worth {
            let step = if self.sampling { SAMPLE } else { 1 };
            let mut asked = Asked {
                walk: &walk,
                memory: &mut self.memory,
                again: &mut self.again,
                generation: self.generation,
                step,
            };
            self.found = asked.run(&fronts[0], &mut target);
            self.now.counts = target.counts;
            self.now.fronts = fronts;
            self.now.finish(planes, nodes);
        } else {
            self.now.counts = target.counts;
            self.now.fronts = fronts;
            self.now.sweep(level, planes, boxes, 0);
        }
        // Too few to tell from: leave it as it is.
        if self.found.remembered >= 32 {
            self.sampling = self.found.answered * WORTH.1 < self.found.remembered * WORTH.0;
        }
    }

    /// Forgets what is known of the box in a slot, and of those beside it: where little moves, call it for
    /// each slot whose box was set, and give the next cull the version of the last.
    pub fn moved(&mut self, slot: u32) {
        self.last.clear();
        if let Some(memory) = self.memory.get_mut(slot as usize / LANES) {
            *memory = Memory::NONE;
        }
    }

    /// Forgets all. The next cull is a cold one.
    pub fn forget(&mut self) {
        self.version = None;
        self.last.clear();
        self.generation = self.generation.wrapping_add(1).max(1);
        // Numbers come round after years; what is older than that must not be taken for new.
        if self.generation == 1 {
            self.memory.fill(Memory::NONE);
        }
    }

    /// What the last cull found.
    #[must_use]
    pub fn cut(&self) -> &Cut {
        &self.now
    }

    /// Lists what the last cull sees and the one before did not, and the reverse, ascending: see
    /// [`Cut::changes_since`]. If slots were permuted in between, they are the slots of different things.
    pub fn changes(&self, added: &mut Vec<u32>, removed: &mut Vec<u32>) {
        if self.unchanged {
            added.clear();
            removed.clear();
        } else {
            self.now.changes_since(&self.before, added, removed);
        }
    }

    /// The share of the blocks of sixteen boxes that the walk reached whose answer was taken from memory,
    /// 0 to 1; 0 if it reached none.
    #[must_use]
    pub fn share_answered(&self) -> f64 {
        self.found.answered as f64 / self.found.reached.max(1) as f64
    }

    /// How many blocks of sixteen boxes were answered from memory.
    #[must_use]
    pub fn answered(&self) -> u64 {
        self.found.answered as u64
    }
}

/// Where memory does not serve, one block in so many is still given one, to see when it will again.
const SAMPLE: u32 = 8;

/// A block with a memory costs half of one without; renewing it costs half as much again.
const WORTH: (usize, usize) = (1, 2);

/// What a block that straddles one plane alone was found to be, and how far the plane may go until that
/// changes. One cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Memory {
    generation: u32,
    /// Rows of the plane: with others, it is another sum.
    rows: u32,
    /// Visible in the lower half, inside in the upper.
    answer: u32,
    /// The least sum that is not negative, and how far the nearest negative one is from zero.
    low: f32,
    high: f32,
    b: f32,
    c: f32,
    d: f32,
    inside: f32,
    /// Largest size of what is summed from the first row.
    reach: f32,
    /// Middle and half extent of what is multiplied by b and by c.
    middle: [f32; 2],
    half: [f32; 2],
}

/// 64 units of rounding: each of two sums is off by at most four of the sizes summed, and the interval by
/// some ten.
const SLACK: f32 = 1.0 / (1 << 18) as f32;

impl Memory {
    const NONE: Self = Self {
        generation: 0,
        rows: 0,
        answer: 0,
        low: 0.0,
        high: 0.0,
        b: 0.0,
        c: 0.0,
        d: 0.0,
        inside: 0.0,
        reach: 0.0,
        middle: [0.0; 2],
        half: [0.0; 2],
    };

    /// Whether the same sums with the numbers of `plane` must have the signs that were found.
    ///
    /// From corner to corner a sum changes by Δb·u + Δc·v + Δd, with u and v within the block. Numbers that
    /// are too large or not numbers fail the comparisons.
    #[inline(always)]
    fn holds(&self, plane: &Ready) -> bool {
        let (db, dc) = (plane.b - self.b, plane.c - self.c);
        let (dd, di) = (plane.d - self.d, plane.inside - self.inside);
        let [m, n] = self.middle;
        let [h, k] = self.half;
        let middle = db * m + dc * n;
        let around = db.abs() * h + dc.abs() * k;
        let size = (self.reach + plane.d.abs() + self.d.abs())
            + (larger(plane.b, self.b) * (m.abs() + h) + larger(plane.c, self.c) * (n.abs() + k));
        let slack = size * SLACK + f32::MIN_POSITIVE;
        let falls = middle - around + smaller(dd, di);
        let rises = middle + around + larger(dd, di);
        (self.rows == plane.rows) & (self.low + falls > slack) & (self.high - rises > slack)
    }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// A plane as memory is compared with it.
#[derive(Clone, Copy, Debug)]
struct Ready {
    rows: u32,
    b: f32,
    c: f32,
    d: f32,
    inside: f32,
}

impl Ready {
    fn new(plane: &BoxPlane) -> Self {
        let [p, q, r] = plane.rows.map(|r| r as u32);
        // An empty box lies at −LIMIT, outside of its node; so far out as to be rejected always.
        let near = plane.d.abs() < Boxes::LIMIT / 4.0;
        let rows = if near { p | q << 8 | r << 16 } else { u32::MAX };
        Self { rows, b: plane.b, c: plane.c, d: plane.d, inside: plane.inside }
    }
}

/// The last step of a walk, with memory.
struct Asked<'a, 'w> {
    walk: &'a Walk<'w>,
    memory: &'a mut [Memory],
    again: &'a mut Vec<u32>,
    generation: u32,
    step: u32,
}

impl Asked<'_, '_> {
    fn run(&mut self, front: &Front, target: &mut Target<'_>) -> Found {
        dispatch!(self.walk.level, simd => self.blocks(simd, front, target))
    }

    #[inline(always)]
    fn blocks<S: Simd>(&mut self, simd: S, front: &Front, target: &mut Target<'_>) -> Found {
        let planes = self.walk.planes.box_planes();
        let mut ready = [Ready { rows: 0, b: 0.0, c: 0.0, d: 0.0, inside: 0.0 }; 32];
        ready.iter_mut().zip(planes).for_each(|(r, p)| *r = Ready::new(p));
        // Two passes and not one, for in the first there is nothing to mispredict.
        self.again.resize(front.len() + 1, 0);
        let mut left = 0;
        let mut found = Found { reached: front.len(), ..Found::default() };
        for (at, (block, open)) in (0..).zip(front.iter()) {
            let memory = &self.memory[block as usize];
            let plane = &ready[open.trailing_zeros() as usize & 31];
            let known = (memory.generation == self.generation)
                & (open & (open - 1) == 0)
                & block.is_multiple_of(self.step);
            let holds = known & memory.holds(plane);
            let answer = if holds { memory.answer } else { 0 };
            target.take_block(block as usize, answer & 0xffff, answer >> 16);
            found.remembered += usize::from(known);
            self.again[left] = at;
            left += usize::from(!holds);
        }
        found.answered = front.len() - left;
        let boxes = self.walk.boxes;
        let holders = self.walk.nodes.levels().first();
        for &at in &self.again[..left] {
            let (block, open) = front.get(at as usize);
            let at = block as usize;
            let lanes = valid(target.covered, at);
            let held = &boxes.blocks()[at];
            target.counts.planes += u64::from(open.count_ones());
            let keep = open & (open - 1) == 0 && block.is_multiple_of(self.step);
            if let Some(holders) = holders
                && keep
            {
                let number = open.trailing_zeros() as usize;
                let tested = test_one::<S>(simd, &planes[number], held);
                let seen = tested.seen & lanes;
                let inside = seen & !tested.straddling;
                target.take_block(at, seen, inside);
                let node = &holders.blocks()[at / LANES];
                let memory = &mut self.memory[at];
                *memory = remember(&planes[number], &ready[number], node, at % LANES, &tested);
                memory.answer = seen | inside << 16;
                memory.generation = self.generation;
                continue;
            }
            let mut ignored = [0; LANES];
            let (seen, straddling) = test::<S>(simd, planes, open, held, &mut ignored);
            let seen = seen & lanes;
            target.take_block(at, seen, seen & !straddling);
        }
        target.counts.leaves += left as u64;
        found
    }
}

/// A block against one plane.
struct Tested {
    seen: u32,
    straddling: u32,
    low: f32,
    high: f32,
}

/// [`test`] against one plane alone, with how near to zero its sums are.
#[inline(always)]
fn test_one<S: Simd>(simd: S, plane: &BoxPlane, block: &BoxBlock) -> Tested {
    let lanes = S::f32s::LEN;
    let rows = &block.0;
    let [p, q, r] = plane.rows;
    assert!(p < 6 && q < 6 && r < 6);
    let [u, v, w] = [(p + 3) % 6, (q + 3) % 6, (r + 3) % 6];
    let b = S::f32s::splat(simd, plane.b);
    let c = S::f32s::splat(simd, plane.c);
    let d = S::f32s::splat(simd, plane.d);
    let inside = S::f32s::splat(simd, plane.inside);
    let none = S::f32s::splat(simd, f32::INFINITY);
    let zero = S::i32s::splat(simd, 0);
    let (mut low, mut high) = (none, none);
    let (mut outside, mut across) = (0, 0);
    for i in 0..LANES / lanes {
        let at = i * lanes;
        let row = |r: usize| S::f32s::from_slice(simd, &rows[r][at..at + lanes]);
        let near = row(p) + (row(q) * b + row(r) * c) + d;
        let far = inside - (row(u) + (row(v) * b + row(w) * c));
        let sign = |sum: S::f32s| {
            let bits: S::i32s = sum.bitcast();
            bits.simd_lt(zero)
        };
        let (rejected, straddling) = (sign(near), sign(far));
        outside |= rejected.to_bitmask() << at;
        across |= straddling.to_bitmask() << at;
        low = low.min(rejected.select(none, near)).min(straddling.select(none, far));
        high = high.min(rejected.select(-near, none)).min(straddling.select(-far, none));
    }
    Tested {
        seen: !outside as u32 & 0xffff,
        straddling: across as u32,
        low: low.reduce_min(),
        high: high.reduce_min(),
    }
}

/// What to keep of a test of the boxes of a node, which is in a lane of a block.
#[inline(always)]
fn remember(
    plane: &BoxPlane,
    ready: &Ready,
    node: &BoxBlock,
    lane: usize,
    tested: &Tested,
) -> Memory {
    // What is summed from row q lies in −(row q + 3) ..= row q: at the near corners it is −min or max of a
    // box, at the far ones the other of the two, with its sign turned.
    let span = |row: usize| (-node.0[(row + 3) % 6][lane], node.0[row][lane]);
    let [p, q, r] = plane.rows.map(span);
    Memory {
        generation: 0,
        rows: ready.rows,
        answer: 0,
        low: tested.low,
        high: tested.high,
        b: plane.b,
        c: plane.c,
        d: plane.d,
        inside: plane.inside,
        reach: larger(p.0.abs(), p.1.abs()),
        middle: [(q.0 + q.1) * 0.5, (r.0 + r.1) * 0.5],
        half: [(q.1 - q.0) * 0.5, (r.1 - r.0) * 0.5],
    }
}
