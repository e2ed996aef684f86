//! The walk: level by level from the top, sixteen children at a time.
//!
//! Level by level and not down to the leaves at once, for then one block does not wait for the
//! branches of the one before: their loads overlap. What is found is written to masks, whose order
//! is given, so the order of the walk does not matter.

use alloc::vec::Vec;
use core::ops::Range;

use crate::simd::dispatch;
use fearless_simd::prelude::*;

use super::super::batch::planes::{BoxPlane, Planes};
use super::super::batch::words::load;
use crate::bits;
use crate::bounds::{BoxBlock, Boxes, LANES};
use crate::hierarchy::Nodes;

/// The blocks of one level that are still to be tested, with the planes that each of them
/// straddles.
#[derive(Clone, Debug, Default)]
pub(super) struct Front {
    blocks: Vec<u32>,
    open: Vec<u32>,
    len: usize,
}

impl Front {
    /// Room for `len` blocks, and a vector more.
    fn reserve(&mut self, len: usize) {
        if self.blocks.len() < len + LANES {
            self.blocks.resize(len + LANES, 0);
            self.open.resize(len + LANES, 0);
        }
    }

    /// The root over so many boxes, if there are any: it straddles all of so many planes as far as
    /// is known.
    fn set_root(&mut self, planes: usize, boxes: usize) {
        self.reserve(1);
        self.blocks[0] = 0;
        self.open[0] = if planes == 32 { u32::MAX } else { (1 << planes) - 1 };
        self.len = usize::from(boxes > 0);
    }

    fn iter(&self) -> impl Iterator<Item = (u32, u32)> {
        self.blocks[..self.len].iter().copied().zip(self.open[..self.len].iter().copied())
    }
}

/// The masks that a walk writes.
#[derive(Debug)]
pub(super) struct Target<'a> {
    pub(super) visible: &'a mut [u64],
    pub(super) inside: &'a mut [u64],
    pub(super) touched: &'a mut [u64],
    /// How many boxes lie under nodes.
    pub(super) covered: usize,
    pub(super) counts: Counts,
}

/// Cost of a walk.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub(super) nodes: u64,
    pub(super) leaves: u64,
    pub(super) planes: u64,
}

impl<'a> Target<'a> {
    /// Takes blocks of sixteen whole: those of them that there are.
    fn take_whole(&mut self, first: usize, count: usize) {
        let first = first * LANES;
        self.take_range(first..(first + count * LANES).min(self.covered));
    }

    /// Takes a range of boxes that is not empty.
    fn take_range(&mut self, range: Range<usize>) {
        for (word, bits) in bits::words_of(range.clone()) {
            self.visible[word] |= bits;
            self.inside[word] |= bits;
        }
        for (word, bits) in bits::words_of(range.start / 64..range.end.div_ceil(64)) {
            self.touched[word] |= bits;
        }
    }

    /// Takes those of one block of sixteen whose bits are set.
    #[inline(always)]
    fn take_block(&mut self, block: usize, visible: u32, inside: u32) {
        let (word, shift) = (block / 4, block % 4 * LANES);
        self.visible[word] |= u64::from(visible) << shift;
        self.inside[word] |= u64::from(inside) << shift;
        self.touched[word / 64] |= u64::from(visible != 0) << (word % 64);
    }
}

/// Nodes and boxes that are walked, and the planes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk<'a> {
    pub(super) simd: crate::Simd,
    pub(super) planes: &'a Planes,
    pub(super) nodes: &'a Nodes,
    pub(super) boxes: &'a Boxes,
}

/// A block that the walk tests takes about 3/2 as long as one that a sweep passes: so a walk that
/// has to test more than this share of the blocks costs more than the sweep.
const SWEEP: (usize, usize) = (5, 8);

impl Walk<'_> {
    /// Walks from the root to the boxes. Returns `false` if so many boxes are left to test that
    /// sweeping all of them is cheaper: then the masks are incomplete.
    pub(super) fn run(&self, fronts: &mut [Front; 2], target: &mut Target<'_>) -> bool {
        fronts[0].set_root(self.planes.box_planes().len(), self.nodes.len());
        self.down(fronts, target);
        if self.is_vain(&fronts[0]) {
            return false;
        }
        self.leaves(&fronts[0], target);
        true
    }

    /// Whether so many blocks of boxes are left to test that sweeping all of them is cheaper.
    fn is_vain(&self, front: &Front) -> bool {
        front.len * SWEEP.1 > self.nodes.len() / LANES * SWEEP.0 && front.len > 1
    }

    /// Walks from the front of the root down to the blocks of boxes.
    fn down(&self, fronts: &mut [Front; 2], target: &mut Target<'_>) {
        let [front, next] = fronts;
        let planes = self.planes.box_planes();
        for (at, below) in self.nodes.levels().iter().enumerate().rev() {
            let unit = LANES.pow(at as u32);
            next.reserve((front.len * LANES).min(below.len()));
            dispatch!(self.simd, simd => inner(simd, planes, below, unit, front, next, target));
            core::mem::swap(front, next);
        }
    }

    /// Tests the boxes of a front.
    fn leaves(&self, front: &Front, target: &mut Target<'_>) {
        let planes = self.planes.box_planes();
        dispatch!(self.simd, simd => leaves(simd, planes, self.boxes, front, target));
    }
}

/// The bits of a block's lanes that a batch of `len` has.
#[inline(always)]
fn valid(len: usize, block: usize) -> u32 {
    let left = len - block * LANES;
    if left >= LANES { 0xffff } else { (1 << left) - 1 }
}

/// Tests sixteen children each, of which one covers `unit` blocks of leaves.
#[inline(always)]
fn inner<S: Simd>(
    simd: S,
    planes: &[BoxPlane],
    boxes: &Boxes,
    unit: usize,
    front: &Front,
    next: &mut Front,
    target: &mut Target<'_>,
) {
    let mut len = 0;
    for (block, open) in front.iter() {
        let at = block as usize;
        let mut closed = [0; LANES];
        let (seen, straddling) = test::<S>(simd, planes, open, &boxes.blocks()[at], &mut closed);
        target.counts.planes += u64::from(open.count_ones());
        let seen = seen & valid(boxes.len(), at);
        for run in bits::runs(u64::from(seen & !straddling)) {
            target.take_whole((at * LANES + run.start) * unit, run.len() * unit);
        }
        let part = seen & straddling;
        compress::<S>(simd, block * LANES as u32, part, &closed, next, len);
        len += part.count_ones() as usize;
    }
    next.len = len;
    target.counts.nodes += front.len as u64;
}

/// Tests the boxes themselves.
#[inline(always)]
fn leaves<S: Simd>(
    simd: S,
    planes: &[BoxPlane],
    boxes: &Boxes,
    front: &Front,
    target: &mut Target<'_>,
) {
    for (block, open) in front.iter() {
        let at = block as usize;
        let mut ignored = [0; LANES];
        let (seen, straddling) = test::<S>(simd, planes, open, &boxes.blocks()[at], &mut ignored);
        let seen = seen & valid(target.covered, at);
        target.counts.planes += u64::from(open.count_ones());
        target.take_block(at, seen, seen & !straddling);
    }
    target.counts.leaves += front.len as u64;
}

/// Tests sixteen boxes against the planes of `open`. Returns the boxes that no open plane rejects,
/// and the boxes that are not inside all open planes. Fills `still_open`, by box, with the planes
/// that the box is not inside of.
///
/// The arithmetic is the same as the flat sweep's. Rounding is monotone and all coefficients are
/// positive, so what holds for a node's larger box holds for each box in it: the answers are the
/// same, to the last bit.
#[inline(always)]
fn test<S: Simd>(
    simd: S,
    planes: &[BoxPlane],
    open: u32,
    block: &BoxBlock,
    still_open: &mut [u32; LANES],
) -> (u32, u32) {
    let lanes = S::f32s::LEN;
    let vectors = LANES / lanes;
    let rows = &block.0;
    let zero = S::i32s::splat(simd, 0);
    let mut negative = [zero; 4];
    let mut straddled = [zero; 4];
    let mut left = open;
    while left != 0 {
        let number = left.trailing_zeros() as usize;
        left &= left - 1;
        let plane = &planes[number];
        let [p, q, r] = plane.near_rows();
        let [u, v, w] = plane.far_rows();
        let b = S::f32s::splat(simd, plane.b);
        let c = S::f32s::splat(simd, plane.c);
        let d = S::f32s::splat(simd, plane.d);
        let inside = S::f32s::splat(simd, plane.inside);
        let bit = S::i32s::splat(simd, (1u32 << number) as i32);
        for i in 0..vectors {
            let at = i * lanes;
            let near = load::<S>(simd, &rows[p], at)
                + (load::<S>(simd, &rows[q], at) * b + load::<S>(simd, &rows[r], at) * c)
                + d;
            let far = inside
                - (load::<S>(simd, &rows[u], at)
                    + (load::<S>(simd, &rows[v], at) * b + load::<S>(simd, &rows[w], at) * c));
            let near: S::i32s = near.bitcast();
            let far: S::i32s = far.bitcast();
            negative[i] |= near;
            straddled[i] |= (far >> 31) & bit;
        }
    }
    let (mut rejected, mut straddling) = (0u64, 0u64);
    for i in 0..vectors {
        let outside = negative[i].simd_lt(zero).to_bitmask();
        let across = (!straddled[i].simd_eq(zero)).to_bitmask();
        rejected |= outside << (i * lanes);
        straddling |= across << (i * lanes);
        let bits: S::u32s = straddled[i].bitcast();
        bits.store_slice(&mut still_open[i * lanes..(i + 1) * lanes]);
    }
    (!rejected as u32 & 0xffff, straddling as u32)
}

/// Appends at `len` of `next` the children whose bits are set, with their open planes.
#[inline(always)]
fn compress<S: Simd>(
    simd: S,
    first: u32,
    children: u32,
    open: &[u32; LANES],
    next: &mut Front,
    len: usize,
) {
    if S::u32s::LEN == LANES {
        const IOTA: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
        let mask = S::mask32s::from_bitmask(simd, u64::from(children));
        let numbers = S::u32s::from_slice(simd, &IOTA) + first;
        let open = S::u32s::from_slice(simd, open);
        numbers.compress(mask).store_slice(&mut next.blocks[len..len + LANES]);
        open.compress(mask).store_slice(&mut next.open[len..len + LANES]);
    } else {
        for (at, child) in (len..).zip(bits::ones(u64::from(children))) {
            next.blocks[at] = first + child as u32;
            next.open[at] = open[child];
        }
    }
}
