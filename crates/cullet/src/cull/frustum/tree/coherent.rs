//! From frame to frame: groups of 256 boxes that no plane can have crossed since they were last tested are
//! not read again.
//!
//! The idea is the translation and rotation coherency of Assarsson & Möller, *Optimized View Frustum
//! Culling Algorithms* (2000), made sharper. They keep a distance for each node and wear it down by how far
//! the view moved and turned. Here a group keeps the planes that it was tested with, how near to them its
//! boxes came, and its bounds: how far a plane like the old one can have moved against any of the group's
//! corners is then an interval, evaluated at once and not summed over frames. A view that goes and comes
//! back has not moved, and what a turn costs in precision is the group's own width times the turn, not its
//! distance from the eye.
//!
//! The gain depends on how many groups a step leaves alone, and that is soon known: a group that
//! straddles a plane holds boxes by the dozen on either side, and some change sides. Measured on a Zen 4
//! server, one thread, 1e6 boxes of 1 to 6 units in a cube of 2000 (`cargo test --release -p cullet-testkit --test cullet
//! hierarchy_coherent -- --ignored --nocapture`); *same* is the share of the straddling groups whose answer
//! is that of the frame before, which no memory of groups can exceed:
//!
//! | step | 1 % seen: same, gain | 10 % | 50 % |
//! |---|---|---|---|
//! | still | 100 %, 32 times | 100 %, 55 times | 100 %, 58 times |
//! | 0.1 units ahead | 95 %, 2.1 times | 88 %, 2.0 times | 78 %, 1.3 times |
//! | 1 unit ahead | 63 %, 0.94 times | 38 %, 0.96 times | 18 %, 0.96 times |
//! | turned by 0.03° | 71 %, 0.95 times | 64 %, 0.93 times | 56 %, 0.96 times |
//! | turned by 0.1° | 52 %, 0.93 times | 43 %, 0.95 times | 29 %, 0.95 times |
//! | turned by 1.2° | 25 %, 0.91 times | 15 %, 0.94 times | 9 %, 0.95 times |
//!
//! Clustered boxes come out alike (1.7, 1.7 and 1.1 times at 0.1 units). So memory serves views that stand,
//! or creep, or worlds with fewer boxes at the frustum's sides; a view that turns in a world of a million is
//! best walked cold, and where too little holds, a [`Coherent`] does so but for one group in
//! thirty-two, which costs it some 5 % (on the smallest views 10).
//!
//! Tried, and slower: a memory of 64 bytes for each block of sixteen boxes. It holds oftener (60 % against
//! 34 % at 0.1°, 10 % seen), but to look at it costs two thirds of the cold test of the block: nearly
//! everywhere slower than a cold walk.

use crate::array::Each;
use crate::simd::dispatch_256;
use fearless_simd::prelude::*;

use super::super::batch::planes::{BoxPlane, Planes};
use super::Cut;
use super::walk::{Counts, Front, Target, Walk};
use crate::bits;
use crate::bounds::{BoxBlock, Boxes, LANES};
use crate::hierarchy::Nodes;

/// [`Cut`]s of one view from frame to frame: what the last frames proved is not tested again. The
/// answers are those of [`Cut::cull`] in every frame, bit for bit.
///
/// Keeps 192 bytes for each 256 boxes, a thirty-second of what the boxes take.
#[derive(Clone, Debug, Default)]
pub struct Coherent {
    now: Cut,
    memory: Vec<Memory>,
    /// Groups to be tested now and remembered, with their open planes.
    again: Vec<(u32, u32)>,
    /// Number of the memories in use: those of another number are forgotten; 0 is never in use.
    generation: u32,
    version: Option<u64>,
    last: Vec<BoxPlane>,
    len: usize,
    sampling: bool,
    found: Found,
}

/// Counts of one frame.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// Groups whose answer was taken from memory.
    answered: usize,
    /// Groups that had a memory.
    remembered: usize,
    /// All groups that the walk reached.
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
        level: crate::Simd,
        planes: &Planes,
        nodes: &Nodes,
        boxes: &Boxes,
        version: u64,
    ) {
        assert!(nodes.len() <= boxes.len(), "nodes over {} of {}", nodes.len(), boxes.len());
        let same = self.version == Some(version) && self.len == boxes.len();
        if same && self.last == planes.box_planes() {
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
        self.memory.resize(nodes.len() / GROUP, Memory::NONE);
        self.now.begin(level, planes, nodes, boxes);
        let mut fronts = std::mem::take(&mut self.now.fronts);
        let mut target = self.now.target(nodes.len());
        let walk = Walk { level, planes, nodes, boxes };
        let reached = walk.down_to_groups(&mut fronts, &mut target);
        self.found = Found { reached, ..Found::default() };
        if reached * 2 < self.memory.len() {
            self.found = Recall {
                memory: &mut self.memory,
                again: &mut self.again,
                generation: self.generation,
                step: if self.sampling { SAMPLE } else { 1 },
            }
            .run(&walk, &mut fronts[0], &mut target);
        }
        let walked = walk.below_groups(&mut fronts, &mut target);
        self.now.counts = target.counts;
        self.now.fronts = fronts;
        if walked {
            self.now.finish(planes, nodes.holes());
        } else {
            self.found.answered = 0;
            self.now.sweep(level, planes, boxes, 0);
        }
        // Too few to tell from: leave it as it is.
        if self.found.remembered >= 4 {
            let share = self.found.answered as f64 / self.found.remembered as f64;
            self.sampling = share < LOOK_FOR[usize::from(self.sampling)];
        }
    }

    /// Forgets what is known of the box in a slot, and of the 255 beside it: where little moves, call it for
    /// each slot whose box was set, and give the next cull the version of the last.
    pub fn moved(&mut self, slot: u32) {
        self.last.clear();
        if let Some(memory) = self.memory.get_mut(slot as usize / GROUP) {
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

    /// Result of the last cull.
    #[must_use]
    pub fn cut(&self) -> &Cut {
        &self.now
    }

    /// The share of the groups of 256 boxes that the walk reached whose answer was taken from memory, 0 to 1;
    /// 0 if it reached none.
    #[must_use]
    pub fn share_answered(&self) -> f64 {
        self.found.answered as f64 / self.found.reached.max(1) as f64
    }

    /// How many groups of 256 boxes were answered from memory.
    #[must_use]
    pub fn answered(&self) -> u64 {
        self.found.answered as u64
    }
}

/// Boxes of a block of nodes: four words of the masks.
const GROUP: usize = LANES * LANES;

/// Most planes that a group with a memory may straddle. Three meet at corners alone.
const PLANES: usize = 2;

/// Where memory does not serve, one group in so many is still given one, to see when it will again.
const SAMPLE: u32 = 32;

/// Memory serves as long as this share of what is remembered holds, and again from the second share on: to
/// renew it costs, to use it saves.
const LOOK_FOR: [f64; 2] = [0.6, 0.75];

/// Visible boxes of a group, and how far each plane may move until they change.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Memory {
    generation: u32,
    /// The planes that it straddled.
    open: u32,
    margins: [Margin; PLANES],
    visible: [u64; 4],
    inside: [u64; 4],
}

/// How far a plane may go from where it was.
#[derive(Clone, Copy, Debug)]
struct Margin {
    /// Rows of the plane that was tested. A plane with another first row sums other numbers, so the
    /// margin never holds for it.
    rows: [u8; 3],
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
        open: 0,
        margins: [Margin::NONE; PLANES],
        visible: [0; 4],
        inside: [0; 4],
    };

    /// Whether all planes that it straddled are where the answer must be the same.
    fn holds(&self, planes: &[BoxPlane]) -> bool {
        let open = bits::ones(u64::from(self.open));
        open.zip(&self.margins).all(|(number, margin)| margin.holds(&planes[number]))
    }
}

impl Margin {
    const NONE: Self = Self {
        rows: [0; 3],
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

    /// Returns the margin of `plane`. `low` is the least of its sums that is not negative, and
    /// `high` is how far the nearest negative one is from zero. `around` is a box around the group,
    /// as the six rows of a block.
    fn new(plane: &BoxPlane, [low, high]: [f32; 2], around: &[f32; 6]) -> Self {
        // The term of row q lies in −(row q + 3) ..= row q: at the near corners it is −min or max of
        // a box, at the far ones the other of the two, with its sign turned.
        let [p, q, r] = plane.rows.each(|row| (-around[(row + 3) % 6], around[row]));
        Self {
            rows: plane.rows.each(|row| row as u8),
            low,
            high,
            b: plane.b,
            c: plane.c,
            d: plane.d,
            inside: plane.inside,
            reach: larger(p.0.abs(), p.1.abs()),
            middle: [(q.0 + q.1) * 0.5, (r.0 + r.1) * 0.5],
            half: [(q.1 - q.0) * 0.5, (r.1 - r.0) * 0.5],
        }
    }

    /// Whether the same sums with the numbers of `plane` must have the signs that were found.
    ///
    /// From corner to corner a sum changes by Δb·u + Δc·v + Δd, with u and v within the group. Numbers that
    /// are too large or not numbers fail the comparisons. An empty box lies at −LIMIT, outside of its node:
    /// so far out as to be rejected always, unless the plane is as far away.
    fn holds(&self, plane: &BoxPlane) -> bool {
        let (dd, di) = (plane.d - self.d, plane.inside - self.inside);
        let [m, n] = self.middle;
        let [reach_b, reach_c] = [0, 1].each(|i: usize| self.middle[i].abs() + self.half[i]);
        let mut shifts = [(plane.b - self.b) * m, (plane.c - self.c) * n];
        let mut around =
            [(plane.b - self.b).abs() * self.half[0], (plane.c - self.c).abs() * self.half[1]];
        let rows = plane.rows.each(|row| row as u8);
        if self.rows != rows {
            if self.rows[0] != rows[0] {
                return false;
            }
            // A coefficient that passed nought takes the other corner. Mostly it is next to nothing, as in the
            // sides of a view that turns about an upright axis.
            if self.rows[1] != rows[1] {
                (shifts[0], around[0]) = (0.0, (plane.b + self.b) * reach_b);
            }
            if self.rows[2] != rows[2] {
                (shifts[1], around[1]) = (0.0, (plane.c + self.c) * reach_c);
            }
        }
        let (middle, around) = (shifts[0] + shifts[1], around[0] + around[1]);
        let size = (self.reach + plane.d.abs() + self.d.abs())
            + (larger(plane.b, self.b) * reach_b + larger(plane.c, self.c) * reach_c);
        let slack = size * SLACK + f32::MIN_POSITIVE;
        let falls = middle - around + smaller(dd, di);
        let rises = middle + around + larger(dd, di);
        let near = plane.d.abs() < Boxes::LIMIT / 4.0 && self.d.abs() < Boxes::LIMIT / 4.0;
        near & (self.low + falls > slack) & (self.high - rises > slack)
    }
}

fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The part of a cull that memory has to do with.
struct Recall<'a> {
    memory: &'a mut [Memory],
    again: &'a mut Vec<(u32, u32)>,
    generation: u32,
    /// One group in so many has a memory.
    step: u32,
}

impl Recall<'_> {
    /// Answers what it can of the groups of a front from memory, tests and remembers some, and leaves the
    /// others in the front.
    fn run(self, walk: &Walk<'_>, front: &mut Front, target: &mut Target<'_>) -> Found {
        let mut found = Found { reached: front.len(), ..Found::default() };
        let planes = walk.planes.box_planes();
        self.again.clear();
        let mut left = 0;
        for at in 0..front.len() {
            let (group, open) = front.get(at);
            let memory =
                self.memory.get(group as usize).filter(|_| group.is_multiple_of(self.step));
            match memory {
                Some(memory) if open.count_ones() as usize <= PLANES => {
                    let known = memory.generation == self.generation && memory.open == open;
                    found.remembered += usize::from(known);
                    if known && memory.holds(planes) {
                        found.answered += 1;
                        target.take_group(group as usize, &memory.visible, &memory.inside);
                    } else {
                        self.again.push((group, open));
                    }
                }
                _ => {
                    front.put(left, (group, open));
                    left += 1;
                }
            }
        }
        front.truncate(left);
        let Self { memory, again, generation, .. } = self;
        dispatch_256!(walk.level, simd => test_groups(simd, walk, again, memory, generation, target));
        found
    }
}

/// Tests groups, each down to its boxes at once, and remembers what is found.
#[inline(always)]
fn test_groups<S: Simd>(
    simd: S,
    walk: &Walk<'_>,
    groups: &[(u32, u32)],
    memory: &mut [Memory],
    generation: u32,
    target: &mut Target<'_>,
) {
    let planes = walk.planes.box_planes();
    let Some(nodes) = walk.nodes.levels().first() else { return };
    for &(group, open) in groups {
        let at = group as usize;
        let block = &nodes.blocks()[at];
        let mut nearest = [[S::f32s::splat(simd, f32::INFINITY); 2]; PLANES];
        // By node, which of the open planes it straddles.
        let mut straddled = [0; PLANES];
        let mut seen = 0xffff;
        for (i, number) in bits::ones(u64::from(open)).enumerate().take(PLANES) {
            let (kept, across) = test_one(simd, &planes[number], block, &mut nearest[i]);
            straddled[i] = across;
            seen &= kept;
        }
        let straddling = straddled.iter().fold(0, |all, s| all | s);
        for run in bits::runs(u64::from(seen & !straddling)) {
            target.take_whole(at * LANES + run.start, run.len());
        }
        let part = seen & straddling;
        for child in bits::ones(u64::from(part)) {
            let boxes = &walk.boxes.blocks()[at * LANES + child];
            let (mut seen, mut straddling) = (0xffff, 0);
            for (i, number) in bits::ones(u64::from(open)).enumerate().take(PLANES) {
                if straddled[i] >> child & 1 == 1 {
                    let (kept, across) = test_one(simd, &planes[number], boxes, &mut nearest[i]);
                    seen &= kept;
                    straddling |= across;
                    target.counts.planes += 1;
                }
            }
            target.take_block(at * LANES + child, seen, seen & !straddling);
        }
        target.counts.planes += u64::from(open.count_ones());
        target.counts.leaves += u64::from(part.count_ones());
        let around = match walk.nodes.levels().get(1) {
            Some(above) => above.blocks()[at / LANES].0.each(|row| row[at % LANES]),
            None => block.0.each(|row| row.into_iter().fold(f32::NEG_INFINITY, larger)),
        };
        let memory = &mut memory[at];
        for (i, number) in bits::ones(u64::from(open)).enumerate().take(PLANES) {
            let least = nearest[i].each(S::f32s::reduce_min);
            memory.margins[i] = Margin::new(&planes[number], least, &around);
        }
        (memory.visible, memory.inside) = target.group(at);
        (memory.generation, memory.open) = (generation, open);
    }
    target.counts.nodes += groups.len() as u64;
}

/// Sixteen boxes against one plane, by the arithmetic of the walk: those that it keeps, and those that it
/// straddles or rejects. Notes how near to zero sums came, from above and from below.
#[inline(always)]
fn test_one<S: Simd>(
    simd: S,
    plane: &BoxPlane,
    block: &BoxBlock,
    nearest: &mut [S::f32s; 2],
) -> (u32, u32) {
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
    let [low, high] = nearest;
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
        *low = low.min(rejected.select(none, near)).min(straddling.select(none, far));
        *high = high.min(rejected.select(-near, none)).min(straddling.select(-far, none));
    }
    (!outside as u32 & 0xffff, across as u32)
}
