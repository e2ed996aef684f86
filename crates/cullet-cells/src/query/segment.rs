//! Segments against boxes, sixteen at a time, and the walk of nodes from near to far that follows
//! one.

use cullet::bounds::Boxes;
use cullet::hierarchy::Nodes;

/// Boxes of a block, and children of a node.
const LANES: usize = 16;

/// Numbers of a block: six of each box, as [`Boxes::as_floats`] has them.
const NUMBERS: usize = 6 * LANES;

/// The blocks of a batch.
fn blocks(boxes: &Boxes) -> &[[f32; NUMBERS]] {
    boxes.as_floats().as_chunks().0
}

/// Segment from a point along a vector, in f64, with the slack within which its coordinates and
/// those of what is in the boxes are known. Shares of the way run from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    start: [f64; 3],
    /// One over the vector: infinite along an axis that the segment does not move along.
    inverse: [f64; 3],
    slack: [f64; 3],
}

/// Shares of the way that are compared may be off by so much of themselves: some ten roundings.
const SHARE_ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Span {
    /// Boxes are met where they come within `slack` of the segment, along each axis. A slack of
    /// zero becomes the smallest number above it: a box that is merely touched is met.
    pub(super) fn new(start: [f64; 3], along: [f64; 3], slack: [f64; 3]) -> Self {
        let slack = slack.map(|s| s + f64::MIN_POSITIVE);
        Self { start, inverse: along.map(|v| 1.0 / v), slack }
    }

    /// The share of the way at which the segment enters each of sixteen boxes: 0 where it starts
    /// within, infinite where it misses the box or enters it beyond `limit`. Never later than it
    /// does.
    #[inline(always)]
    pub(super) fn enter(&self, block: &[f32; NUMBERS], limit: f64) -> [f64; LANES] {
        let (mut near, mut far) = ([0.0; LANES], [limit; LANES]);
        for axis in 0..3 {
            let inverse = self.inverse[axis];
            let (min, max) = (&block[axis * LANES..], &block[(axis + 3) * LANES..]);
            let (low, high) =
                (self.start[axis] + self.slack[axis], self.start[axis] - self.slack[axis]);
            for lane in 0..LANES {
                let first = (-f64::from(min[lane]) - low) * inverse;
                let last = (f64::from(max[lane]) - high) * inverse;
                let (enter, leave) = if inverse < 0.0 { (last, first) } else { (first, last) };
                // A NaN, of 0 · ∞ on the very face of a box, changes neither: the box is kept.
                near[lane] = if enter > near[lane] { enter } else { near[lane] };
                far[lane] = if leave < far[lane] { leave } else { far[lane] };
            }
        }
        core::array::from_fn(|lane| {
            let meets = near[lane] <= far[lane] * (1.0 + SHARE_ROUNDING);
            if meets { near[lane] } else { f64::INFINITY }
        })
    }
}

/// Visits the boxes that a segment meets up to the share `limit` of its way, those that it enters
/// early before others of the same node. `visit` is given the number of a box, and may lower the
/// limit; where it says `true` the walk ends, and so it returns `true`. Boxes that lie under no
/// node yet come last.
pub(super) fn walk(
    (nodes, boxes): (&Nodes, &Boxes),
    span: &Span,
    limit: &mut f64,
    visit: &mut impl FnMut(usize, &mut f64) -> bool,
) -> bool {
    let under = nodes.len().min(boxes.len());
    let tree = Tree { nodes, boxes, span, end: under };
    if under > 0 && tree.descend(nodes.levels().len(), 0, limit, visit) {
        return true;
    }
    let first = under / LANES;
    let after = if under < boxes.len() { &blocks(boxes)[first..] } else { &[] };
    after.iter().enumerate().any(|(at, block)| {
        let numbers =
            ((first + at) * LANES).max(under)..((first + at + 1) * LANES).min(boxes.len());
        visit_block(span.enter(block, *limit), limit, |lane, limit| {
            let number = (first + at) * LANES + lane;
            numbers.contains(&number) && visit(number, limit)
        })
    })
}

struct Tree<'a> {
    nodes: &'a Nodes,
    boxes: &'a Boxes,
    span: &'a Span,
    /// How many boxes are under nodes.
    end: usize,
}

impl Tree<'_> {
    /// Walks what is below block `at` of a level: 0 is that of the boxes, above stand the levels of
    /// the nodes.
    fn descend(
        &self,
        level: usize,
        at: usize,
        limit: &mut f64,
        visit: &mut impl FnMut(usize, &mut f64) -> bool,
    ) -> bool {
        let of_level = level.checked_sub(1).map_or(self.boxes, |l| &self.nodes.levels()[l]);
        let block = &blocks(of_level)[at];
        visit_block(self.span.enter(block, *limit), limit, |lane, limit| {
            let child = at * LANES + lane;
            match level {
                0 => child < self.end && visit(child, limit),
                _ => child < of_level.len() && self.descend(level - 1, child, limit, visit),
            }
        })
    }
}

/// Visits the lanes of a block that are met, in the order in which they are entered, as long as
/// that is within the limit.
fn visit_block(
    mut enter: [f64; LANES],
    limit: &mut f64,
    mut visit: impl FnMut(usize, &mut f64) -> bool,
) -> bool {
    loop {
        let (mut first, mut share) = (LANES, f64::INFINITY);
        for (lane, &at) in enter.iter().enumerate() {
            if at < share {
                (first, share) = (lane, at);
            }
        }
        if first == LANES || share > *limit {
            return false;
        }
        enter[first] = f64::INFINITY;
        if visit(first, limit) {
            return true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::Simd;
    use cullet::bounds::Aabb;
    use cullet_testkit::Rng;

    fn met(nodes: &Nodes, boxes: &Boxes, from: [f64; 3], along: [f64; 3]) -> Vec<usize> {
        let (mut found, mut limit) = (Vec::new(), 1.0);
        let span = Span::new(from, along, [0.0; 3]);
        walk((nodes, boxes), &span, &mut limit, &mut |i, _| {
            found.push(i);
            false
        });
        found.sort_unstable();
        found
    }

    /// Numbers of a grid, so that faces, edges and corners are met exactly; by clipping, one box
    /// after the other.
    #[test]
    fn a_walk_meets_every_box_that_the_segment_touches() {
        let mut rng = Rng(11);
        let mut misses = 0;
        for count in [0, 1, 15, 16, 17, 40, 300, 5000] {
            let mut coordinate = || rng.below(65) as f64 - 32.0;
            let boxes: Vec<Aabb> = (0..count)
                .map(|i| {
                    let min: [f32; 3] = core::array::from_fn(|_| coordinate() as f32);
                    let max = core::array::from_fn(|a| min[a] + ((i + a) % 3) as f32);
                    if i % 50 == 7 { Aabb::EMPTY } else { Aabb::new(min, max) }
                })
                .collect();
            // The last tenth was added later.
            let mut batch = Boxes::from_slice(&boxes[..count - count / 10]);
            let nodes = Nodes::over(Simd::best(), &batch);
            batch.extend_from_slice(&boxes[count - count / 10..]);
            for _ in 0..200 {
                let (from, to): ([f64; 3], [f64; 3]) =
                    ([(); 3].map(|()| coordinate()), [(); 3].map(|()| coordinate()));
                let along = core::array::from_fn(|a| to[a] - from[a]);
                let found = met(&nodes, &batch, from, along);
                for (i, b) in boxes.iter().enumerate() {
                    let touched = touches(b, from, along);
                    assert!(!touched || found.contains(&i), "{count}: {b:?} {from:?} {to:?}");
                    assert!(!(b.is_empty() && found.contains(&i)), "nothing is in {i}");
                    misses += usize::from(!found.contains(&i));
                }
                assert!(found.is_sorted_by(|a, b| a < b), "each once");
            }
        }
        assert!(misses > 900_000, "{misses}");
    }

    /// Whether a point of the segment is in the box: exact, by whole numbers.
    fn touches(b: &Aabb, from: [f64; 3], along: [f64; 3]) -> bool {
        if b.is_empty() {
            return false;
        }
        // Shares as fractions: the greatest of entering and the least of leaving, over positive
        // denominators.
        let (mut enter, mut leave) = ((0_i64, 1_i64), (1_i64, 1_i64));
        for a in 0..3 {
            let from_start = |v: f32| f64::from(v) as i64 - from[a] as i64;
            let (mut low, mut high) = (from_start(b.min[a]), from_start(b.max[a]));
            let mut d = along[a] as i64;
            if d < 0 {
                (low, high, d) = (-high, -low, -d);
            }
            if d == 0 {
                if low > 0 || high < 0 {
                    return false;
                }
                continue;
            }
            enter = if low * enter.1 > enter.0 * d { (low, d) } else { enter };
            leave = if high * leave.1 < leave.0 * d { (high, d) } else { leave };
        }
        enter.0 * leave.1 <= leave.0 * enter.1
    }
}
