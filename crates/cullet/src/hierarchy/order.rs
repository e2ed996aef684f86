//! An order of boxes in which neighbours in the list are neighbours in space.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::classes::{Classes, Counts};
use crate::array::{self, Each};
use crate::bounds::Aabb;
use crate::sort::sort;

/// Bits of a key.
const KEY_BITS: usize = 32;
/// The most of them that one axis may take: two tables of 256 entries.
const AXIS_BITS: u32 = 16;
/// Values that one pass of the sort tells apart: counters that stay in the first cache.
const DIGITS: usize = 1 << 11;
const PASSES: usize = KEY_BITS.div_ceil(DIGITS.ilog2() as usize);

/// The numbers of `boxes` in an order that keeps what is near together: along a Morton curve
/// through their centres, each bit of which halves what is then the longest side of a cell. Boxes
/// that are empty or not finite come last, so that they share their nodes with each other only;
/// equal keys keep their order. O(n).
///
/// Where many boxes are some times as large as many others, each kind is sorted by itself, so that
/// nodes are of like boxes: a node of grass alone is too small to be seen, or hidden, where one
/// that has a tree in it would have to be opened.
///
/// A curve with cells as cubic as they can be matters where worlds are flat: with ten bits for each
/// axis, a million trees on a plane share a thousand cells each way.
///
/// Of a million boxes, a walk for 1, 10 or 50 % of them tests 0.97 to 1.00 times the blocks that it
/// tests in the order of a binary tree built by surface area, and 1.06 to 1.08 times where they lie
/// in heaps (obvhs, medium, in `benches/peers`, program `trees`).
#[must_use]
pub fn spatial_order(boxes: &[Aabb]) -> Vec<u32> {
    let mut order = Vec::new();
    Orderer::default().order(boxes.len(), |i| boxes[i], &mut order);
    order
}

/// Memory that one sort after another uses, and the curve of the last.
#[derive(Clone, Debug, Default)]
pub(super) struct Orderer {
    keys: Vec<u64>,
    other: Vec<u64>,
    curve: Curve,
}

impl Orderer {
    /// Writes to `order` the numbers 0..`len` sorted by where their boxes are.
    pub(super) fn order(
        &mut self,
        len: usize,
        bounds: impl Fn(usize) -> Aabb,
        order: &mut Vec<u32>,
    ) {
        let mut extent = Extent::default();
        let mut counts = Counts::default();
        for i in 0..len {
            let bounds = bounds(i);
            extent.add(&bounds);
            counts.add(&bounds);
        }
        self.curve = Curve::new(&extent, Classes::of(&counts));
        self.order_again(len, bounds, order);
    }

    /// The same along the curve of the last time, whose ends take what lies beyond.
    pub(super) fn order_again(
        &mut self,
        len: usize,
        bounds: impl Fn(usize) -> Aabb,
        order: &mut Vec<u32>,
    ) {
        let curve = &self.curve;
        self.keys.clear();
        self.keys.extend((0..len).map(|i| u64::from(curve.key(&bounds(i))) << 32 | i as u64));
        if len < DIGITS {
            sort(&mut self.keys);
        } else {
            radix_sort(&mut self.keys, &mut self.other);
        }
        order.clear();
        order.extend(self.keys.iter().map(|&k| k as u32));
    }

    /// Frees the memory of the last sort, but for the curve: sixteen bytes a box.
    pub(super) fn forget_keys(&mut self) {
        (self.keys, self.other) = (Vec::new(), Vec::new());
    }

    /// Where on the curve of the last sort a box lies.
    pub(super) fn key(&self, b: &Aabb) -> u32 {
        self.curve.key(b)
    }
}

/// A stable sort by `PASSES` digits of `DIGITS` values each, from bit 32 on upwards.
fn radix_sort(keys: &mut Vec<u64>, other: &mut Vec<u64>) {
    other.resize(keys.len(), 0);
    let mut counts = [[0u32; DIGITS]; PASSES];
    let digit = |key: u64, pass: usize| {
        (key >> (32 + DIGITS.ilog2() as usize * pass)) as usize & (DIGITS - 1)
    };
    for &key in &*keys {
        for (pass, counts) in counts.iter_mut().enumerate() {
            counts[digit(key, pass)] += 1;
        }
    }
    for (pass, counts) in counts.iter_mut().enumerate() {
        if counts.iter().any(|&c| c as usize == keys.len()) {
            continue;
        }
        let mut start = 0;
        for count in counts.iter_mut() {
            start += core::mem::replace(count, start);
        }
        for &key in &*keys {
            let to = &mut counts[digit(key, pass)];
            other[*to as usize] = key;
            *to += 1;
        }
        core::mem::swap(keys, other);
    }
}

/// The span of all finite centres.
#[derive(Clone, Debug)]
struct Extent {
    low: [f32; 3],
    high: [f32; 3],
}

impl Default for Extent {
    fn default() -> Self {
        Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] }
    }
}

/// The centre, each half of it halved first where the sum would overflow, and whether the box is
/// anywhere in particular.
#[inline(always)]
fn centre(b: &Aabb) -> ([f32; 3], bool) {
    let c = array::from_fn(|a| b.min[a] * 0.5 + b.max[a] * 0.5);
    // Bits and not branches: there are six comparisons.
    let somewhere = (0..3).fold(true, |all, a| all & (b.min[a] <= b.max[a]) & is_finite(c[a]));
    (c, somewhere)
}

#[inline(always)]
fn is_finite(v: f32) -> bool {
    v.abs() < f32::INFINITY
}

impl Extent {
    #[inline(always)]
    fn add(&mut self, b: &Aabb) {
        let (c, somewhere) = centre(b);
        for a in 0..3 {
            self.low[a] = if somewhere & (c[a] < self.low[a]) { c[a] } else { self.low[a] };
            self.high[a] = if somewhere & (c[a] > self.high[a]) { c[a] } else { self.high[a] };
        }
    }
}

/// How centres become keys.
#[derive(Clone, Debug)]
struct Curve {
    low: [f32; 3],
    scale: [f32; 3],
    last: [f32; 3],
    classes: Classes,
    /// Spread bits of a coordinate: one table per axis, for its lower and then its upper byte, by
    /// the value of that byte.
    spread: Box<[[[u32; 256]; 2]; 3]>,
}

impl Default for Curve {
    fn default() -> Self {
        Self::new(&Extent::default(), Classes::default())
    }
}

impl Curve {
    fn new(extent: &Extent, classes: Classes) -> Self {
        let first = classes.bits();
        let mut side: [f64; 3] =
            array::from_fn(|a| (f64::from(extent.high[a]) - f64::from(extent.low[a])).max(0.0));
        let full = side;
        let mut bits = [0; 3];
        // From the top: which axis each bit of the key halves.
        let mut halved = [None; KEY_BITS];
        for at in &mut halved[first..] {
            let free = (0..3).filter(|&a| bits[a] < AXIS_BITS && side[a] > 0.0);
            let Some(axis) = free.max_by(|&a, &b| side[a].total_cmp(&side[b])) else { break };
            *at = Some(axis);
            side[axis] *= 0.5;
            bits[axis] += 1;
        }
        let mut spread = Box::new([[[0; 256]; 2]; 3]);
        let mut left = bits;
        for (i, axis) in halved.iter().enumerate().skip(first) {
            let Some(axis) = *axis else { break };
            left[axis] -= 1;
            let (byte, bit) = (left[axis] as usize / 8, left[axis] % 8);
            for (value, to) in spread[axis][byte].iter_mut().enumerate() {
                *to |= (value as u32 >> bit & 1) << (KEY_BITS - 1 - i);
            }
        }
        let cells = bits.each(|b| f64::from(1u32 << b));
        let scale = array::from_fn(|a| {
            if full[a] > 0.0 { (cells[a] / full[a]).min(f64::from(f32::MAX)) as f32 } else { 0.0 }
        });
        Self { low: extent.low, scale, last: cells.each(|c| c as f32 - 1.0), classes, spread }
    }

    #[inline(always)]
    fn key(&self, b: &Aabb) -> u32 {
        let (c, somewhere) = centre(b);
        if !somewhere {
            return u32::MAX;
        }
        let mut key = self.classes.key(b);
        for a in 0..3 {
            let cell = (c[a] - self.low[a]) * self.scale[a];
            // A NaN (infinity by zero, in spans beyond f32) becomes the last cell; any order is
            // right.
            let cell = cell.min(self.last[a]).max(0.0);
            // Added to 2²³, a number has its whole part in the last bits, rounded: a conversion
            // that saturates costs twice that.
            let cell = (cell + (1 << 23) as f32).to_bits() as usize;
            key |= self.spread[a][0][cell & 255] | self.spread[a][1][cell >> 8 & 255];
        }
        key
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(p: [f32; 3]) -> Aabb {
        Aabb::new(p, p)
    }

    #[test]
    fn neighbours_in_space_are_neighbours_in_the_list() {
        // A shuffled grid of 16³: blocks of eight must be cubes of 2³.
        let at = |i: usize| [i % 16, i / 16 % 16, i / 256].map(|v| v as f32);
        let boxes: Vec<_> = (0..4096).map(|i| point(at(i * 1365 % 4096))).collect();
        let order = spatial_order(&boxes);
        for eight in order.chunks(8) {
            let around = eight.iter().fold(Aabb::EMPTY, |a, &i| a.union(&boxes[i as usize]));
            assert_eq!(around.half_extent(), [0.5; 3]);
        }
    }

    #[test]
    fn a_flat_world_spends_no_bits_on_its_height() {
        let boxes: Vec<_> = (0..65536u64)
            .map(|i| point([(i * 40503 % 65536) as f32, 0.0, (i % 256) as f32]))
            .collect();
        let order = spatial_order(&boxes);
        let side = |c: &[u32]| {
            let b = c.iter().fold(Aabb::EMPTY, |a, &i| a.union(&boxes[i as usize]));
            b.half_extent()[0]
        };
        let mean = order.chunks(16).map(side).sum::<f64>() / 4096.0;
        assert!(mean < 200.0, "{mean}");
    }

    #[test]
    fn invalid_boxes_come_last_and_every_number_comes_once() {
        let mut boxes: Vec<_> = (0..100).map(|i| point([i as f32, 0.0, 0.0])).collect();
        boxes[3] = Aabb::EMPTY;
        boxes[50] = Aabb::EVERYTHING;
        boxes[51].max[1] = f32::NAN;
        boxes[0] = point([-f32::MAX; 3]);
        boxes[1] = point([f32::MAX; 3]);
        let order = spatial_order(&boxes);
        assert_eq!(order[97..], [3, 50, 51]);
        let mut all = order;
        all.sort_unstable();
        assert!(all.into_iter().eq(0..100));
        // Nothing, one, and all alike.
        assert!(spatial_order(&[]).is_empty());
        assert_eq!(spatial_order(&[Aabb::EMPTY]), [0]);
        assert!(spatial_order(&[point([1.0; 3]); 40]).into_iter().eq(0..40));
    }
}
