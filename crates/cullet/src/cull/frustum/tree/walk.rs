//! The walk: level by level from the top, sixteen children at a time.
//!
//! Level by level and not down to the leaves at once, for then one block does not wait for the branches
//! of the one before: their loads overlap. What is found is written to masks, whose order is given, so
//! the order of the walk does not matter.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

use super::super::batch::planes::{BoxPlane, Planes};
use super::Cut;
use crate::bits;
use crate::bounds::{BoxBlock, Boxes, LANES};
use crate::hierarchy::Nodes;

/// The blocks of one level that are still to be asked, with the planes that each of them straddles.
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
}

/// Walks the nodes over `boxes` and sets in `cut` what is visible, and what is inside. `cut` is empty.
pub(super) fn walk(
    level: Level,
    planes: &Planes,
    nodes: &Nodes,
    boxes: &Boxes,
    fronts: &mut [Front; 2],
    cut: &mut Cut,
) {
    let all = planes.box_planes();
    let open = if all.len() == 32 { u32::MAX } else { (1 << all.len()) - 1 };
    let [front, next] = fronts;
    front.reserve(1);
    (front.blocks[0], front.open[0], front.len) = (0, open, 1);
    let mut unit = LANES.pow(nodes.levels().len() as u32);
    for below in nodes.levels().iter().rev() {
        unit /= LANES;
        let children = below.len();
        next.reserve(children);
        dispatch!(level, simd => inner(simd, all, below, unit, front, next, cut));
        std::mem::swap(front, next);
    }
    dispatch!(level, simd => leaves(simd, all, boxes, nodes.len(), front, cut));
}

/// The bits of a block's lanes that a batch of `len` has.
#[inline(always)]
fn valid(len: usize, block: usize) -> u32 {
    let left = len - block * LANES;
    if left >= LANES { 0xffff } else { (1 << left) - 1 }
}

/// Asks sixteen children each, of which one covers `unit` blocks of leaves.
#[inline(always)]
fn inner<S: Simd>(
    simd: S,
    planes: &[BoxPlane],
    boxes: &Boxes,
    unit: usize,
    front: &Front,
    next: &mut Front,
    cut: &mut Cut,
) {
    let mut len = 0;
    let asked = front.blocks[..front.len].iter().zip(&front.open[..front.len]);
    for (&block, &open) in asked {
        let at = block as usize;
        let mut closed = [0; LANES];
        let (seen, straddling) = test::<S>(simd, planes, open, &boxes.blocks()[at], &mut closed);
        cut.plane_tests += u64::from(open.count_ones());
        let seen = seen & valid(boxes.len(), at);
        for run in bits::runs(u64::from(seen & !straddling)) {
            cut.take_whole((at * LANES + run.start) * unit, run.len() * unit);
        }
        let part = seen & straddling;
        compress::<S>(simd, block * LANES as u32, part, &closed, next, len);
        len += part.count_ones() as usize;
    }
    next.len = len;
    cut.nodes_asked += front.len as u64;
}

/// Asks the boxes themselves.
#[inline(always)]
fn leaves<S: Simd>(
    simd: S,
    planes: &[BoxPlane],
    boxes: &Boxes,
    len: usize,
    front: &Front,
    cut: &mut Cut,
) {
    let asked = front.blocks[..front.len].iter().zip(&front.open[..front.len]);
    for (&block, &open) in asked {
        let at = block as usize;
        let mut ignored = [0; LANES];
        let (seen, straddling) = test::<S>(simd, planes, open, &boxes.blocks()[at], &mut ignored);
        let seen = seen & valid(len, at);
        cut.plane_tests += u64::from(open.count_ones());
        cut.take_block(at, seen, seen & !straddling);
    }
    cut.leaves_asked += front.len as u64;
}

/// Of sixteen boxes: which no open plane rejects, which are not inside all of them, and, by box, the
/// planes that it is not inside of.
///
/// The same arithmetic as the flat sweep's. Rounding is monotone and all coefficients are positive, so
/// what holds for a node's larger box holds for each box in it: the answers are the same, to the last bit.
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
        let [p, q, r] = plane.rows;
        assert!(p < 6 && q < 6 && r < 6);
        let [u, v, w] = [(p + 3) % 6, (q + 3) % 6, (r + 3) % 6];
        let b = S::f32s::splat(simd, plane.b);
        let c = S::f32s::splat(simd, plane.c);
        let d = S::f32s::splat(simd, plane.d);
        let inside = S::f32s::splat(simd, plane.inside);
        let bit = S::i32s::splat(simd, (1u32 << number) as i32);
        for i in 0..vectors {
            let at = i * lanes;
            let row = |r: usize| S::f32s::from_slice(simd, &rows[r][at..at + lanes]);
            let near = row(p) + (row(q) * b + row(r) * c) + d;
            let far = inside - (row(u) + (row(v) * b + row(w) * c));
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
