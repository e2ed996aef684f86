//! Whole nodes of boxes against the threshold of detail culling, and the boxes of those that do not
//! decide it.
//!
//! For a node, q = x/w is known as a range that holds for all its boxes, and so are |g| and w (see
//! [`batch`](super::batch)). What the picture of a box grows by along each of its sides thus has a
//! least and a most that hold in all of the node. With the smallest and largest sides below it
//! these decide the node. Else they decide its boxes by three products each, and only boxes that
//! are hardly larger or smaller than the threshold are bounded by themselves.

use crate::bits;
use crate::simd::dispatch_256;
use fearless_simd::f32x16;
use fearless_simd::prelude::*;

use super::batch::{Bounds, Lanes, STEP, SizeTest};
use crate::bounds::{BoxBlock, LANES};
use crate::hierarchy::Span;
use crate::simd::Simd;

/// Bounds of the sizes, in a view, of the boxes below sixteen nodes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NodeSizes {
    /// Nodes below which all boxes are small, one bit each.
    pub(crate) small: u16,
    /// Nodes below which none is.
    pub(crate) kept: u16,
    /// Nodes whose rates are known.
    known: u16,
    width: Rates,
    height: Rates,
}

/// Pixels that the picture of a box has along one axis of the screen for each unit of half its
/// sides, at most and at least, by node.
#[derive(Clone, Copy, Debug, Default)]
struct Rates {
    most: [[f32; LANES]; 3],
    least: [[f32; LANES]; 3],
    /// Share that is added to the upper bound, for rounding.
    slack: [f32; LANES],
}

impl NodeSizes {
    /// Returns what is known of the nodes of `nodes` alone.
    pub(crate) fn only(self, nodes: u16) -> Self {
        let Self { small, kept, known, .. } = self;
        Self { small: small & nodes, kept: kept & nodes, known: known & nodes, ..self }
    }
}

impl SizeTest {
    /// Decides sixteen nodes by the `spans` of the sizes of the boxes below each. `weights` are
    /// those of the heaviest; where there are any, nodes only say where all are small.
    pub(crate) fn of_nodes(
        &self,
        simd: Simd,
        block: &BoxBlock,
        spans: &[Span],
        weights: Option<&[f32; LANES]>,
    ) -> NodeSizes {
        // Nothing is known of the sizes of empty boxes.
        let (mut most, mut least) = ([[0.0; LANES]; 3], [[-1.0; LANES]; 3]);
        for (lane, own) in spans.iter().take(LANES).enumerate() {
            for a in 0..3 {
                most[a][lane] = own.most[a] * 0.5;
                least[a][lane] = own.least[a] * 0.5;
            }
        }
        let mut found = NodeSizes::default();
        dispatch_256!(simd, simd => {
            let lanes = Lanes::new(simd, block);
            self.rate(&lanes, &mut found);
            let known = lanes.mask(found.known);
            let width = found.width.most_of(&lanes, &most);
            let height = found.height.most_of(&lanes, &most);
            found.small = self.below(&Bounds { simd, known, width, height }, weights);
            if weights.is_none() {
                let width = found.width.least_of(&lanes, &least);
                let height = found.height.least_of(&lanes, &least);
                found.kept = self.none_below(&lanes, width, height) & found.known;
                for halves in &least {
                    let is_some = lanes.load(halves).simd_ge(lanes.splat(0.0));
                    found.kept &= is_some.to_bitmask() as u16;
                }
            }
        });
        if weights.is_some() {
            found.known = 0;
        }
        found
    }

    /// [`small`](Self::small) of the boxes `tested` of up to four blocks below node `node` of
    /// `nodes`; `None` where the node does not know.
    pub(crate) fn small_below(
        &self,
        simd: Simd,
        (nodes, node): (&NodeSizes, usize),
        blocks: &[BoxBlock],
        tested: u64,
    ) -> Option<u64> {
        if nodes.known >> node & 1 == 0 {
            return None;
        }
        Some(dispatch_256!(simd, simd => self.small_in(simd, (nodes, node), blocks, tested)))
    }

    #[inline(always)]
    fn small_in<S: fearless_simd::Simd>(
        &self,
        simd: S,
        (nodes, node): (&NodeSizes, usize),
        blocks: &[BoxBlock],
        tested: u64,
    ) -> u64 {
        let (mut small, mut open) = (0, 0);
        for (part, block) in blocks.iter().enumerate().take(4) {
            let shift = part * LANES;
            let own = (tested >> shift) as u16;
            if own == 0 {
                continue;
            }
            let lanes = Lanes::new(simd, block);
            let known = lanes.mask(u16::MAX);
            let (width, height) =
                (nodes.width.most_at(&lanes, node), nodes.height.most_at(&lanes, node));
            // Empty boxes have sides below 0, of which this says nothing.
            let some = lanes.not_empty();
            let below = self.below(&Bounds { simd, known, width, height }, None) & some;
            let (width, height) =
                (nodes.width.least_at(&lanes, node), nodes.height.least_at(&lanes, node));
            let kept = self.none_below(&lanes, width, height) & some;
            small |= u64::from(below & own) << shift;
            open |= u64::from(own & !below & !kept) << shift;
        }
        if open == 0 {
            return small;
        }
        if open.count_ones() as usize > LANES {
            let wanted = (0..4).fold(0, |wanted, part| {
                wanted | u8::from(open >> (part * LANES) & 0xffff != 0) << part
            });
            return small | self.small_blocks(simd, blocks, wanted, None) & open;
        }
        // They are few: gathered in one block.
        let mut gathered = BoxBlock([[0.0; LANES]; 6]);
        for (lane, bit) in bits::ones(open).enumerate() {
            let from = &blocks[bit / LANES].0;
            for (to, from) in gathered.0.iter_mut().zip(from) {
                to[lane] = from[bit % LANES];
            }
        }
        let found = self.below(&self.bounds(&Lanes::new(simd, &gathered)), None);
        for (lane, bit) in bits::ones(open).enumerate() {
            small |= u64::from(found >> lane & 1) << bit;
        }
        small
    }

    /// Notes by how much the pictures of boxes in sixteen nodes grow with their sides.
    #[inline(always)]
    fn rate<S: fearless_simd::Simd>(&self, lanes: &Lanes<S>, found: &mut NodeSizes) {
        let (deep, known) = self.deep(lanes, true);
        found.known = known.to_bitmask() as u16;
        let [row_x, row_y, ..] = &self.rows;
        let per_farthest = lanes.splat(1.0) / deep.farthest;
        let sides =
            [(row_x, self.size[0], &mut found.width), (row_y, self.size[1], &mut found.height)];
        for (row, pixels, rates) in sides {
            let (q, q_off) = lanes.quotient(row, &deep, true);
            let mut slack = (q.abs() + lanes.splat(1.0)) * lanes.splat(1e-9 * pixels);
            // Twice the slack of a box, for what is rounded here is not what is rounded there.
            let up = deep.per_nearest * lanes.splat(pixels * (1.0 + 16.0 * STEP));
            let down = per_farthest * lanes.splat(pixels * (1.0 - 16.0 * STEP));
            for a in 0..3 {
                let (g, g_off) = lanes.gradient(row[a], deep.row[a], q, q_off);
                let most = (g + g_off) * up;
                slack += most * (lanes.most[a] * lanes.splat(STEP));
                most.store_slice(&mut rates.most[a]);
                ((g - g_off).max(lanes.splat(0.0)) * down).store_slice(&mut rates.least[a]);
            }
            slack.store_slice(&mut rates.slack);
        }
    }

    /// The bits of lanes that are at least so wide and high and thus not
    /// [below](Self::below) the threshold.
    #[inline(always)]
    fn none_below<S: fearless_simd::Simd>(
        &self,
        lanes: &Lanes<S>,
        width: f32x16<S>,
        height: f32x16<S>,
    ) -> u16 {
        let least = self.measured(width, height);
        // A number that overflowed says nothing.
        let large = least.simd_ge(lanes.splat(self.threshold));
        (large & least.simd_lt(lanes.splat(f32::MAX))).to_bitmask() as u16
    }
}

impl Rates {
    /// Bounds what boxes with these halves are at most, by node.
    #[inline(always)]
    fn most_of<S: fearless_simd::Simd>(
        &self,
        lanes: &Lanes<S>,
        halves: &[[f32; LANES]; 3],
    ) -> f32x16<S> {
        let mut sum = lanes.load(&self.slack);
        for a in 0..3 {
            sum += lanes.load(&self.most[a]) * lanes.load(&halves[a]);
        }
        sum
    }

    /// The same of what they are at least.
    #[inline(always)]
    fn least_of<S: fearless_simd::Simd>(
        &self,
        lanes: &Lanes<S>,
        halves: &[[f32; LANES]; 3],
    ) -> f32x16<S> {
        let mut sum = lanes.splat(0.0);
        for a in 0..3 {
            sum += lanes.load(&self.least[a]) * lanes.load(&halves[a]);
        }
        sum
    }

    /// Bounds what sixteen boxes below one node are at most.
    #[inline(always)]
    fn most_at<S: fearless_simd::Simd>(&self, lanes: &Lanes<S>, node: usize) -> f32x16<S> {
        let mut sum = lanes.splat(self.slack[node]);
        for a in 0..3 {
            sum += lanes.splat(self.most[a][node]) * lanes.reach[a];
        }
        sum
    }

    /// The same of what they are at least.
    #[inline(always)]
    fn least_at<S: fearless_simd::Simd>(&self, lanes: &Lanes<S>, node: usize) -> f32x16<S> {
        let mut sum = lanes.splat(0.0);
        for a in 0..3 {
            sum += lanes.splat(self.least[a][node]) * lanes.reach[a];
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Detail, Measure};
    use super::*;
    use crate::bounds::{Aabb, Boxes};
    use crate::hierarchy::Nodes;
    use crate::{Camera, Depth, Projection, Transform, View};

    /// Numbers in 0..1 (Marsaglia, *Xorshift RNGs*, 2003).
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f32 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 40) as f32 / (1 << 24) as f32
        }

        fn range(&mut self, low: f32, high: f32) -> f32 {
            low + self.next() * (high - low)
        }
    }

    /// The box of node 3 that is empty. The frustum drops those, so they have no size.
    const EMPTY: usize = 77;

    /// Sixteen nodes of 256 boxes of like sizes, some of them empty or without end.
    fn boxes(rng: &mut Random) -> Boxes {
        let mut boxes = Boxes::new();
        for node in 0..LANES {
            let middle = [0; 3].map(|_| rng.range(-200.0, 200.0));
            let (reach, size) = (rng.range(0.0, 30.0), 10.0_f32.powf(rng.range(-2.0, 1.5)));
            let wide = rng.range(1.0, 3.0);
            for i in 0..256 {
                let min = middle.map(|m| m + rng.range(-reach, reach));
                let max = min.map(|v| v + size * rng.range(1.0, wide));
                boxes.push(&match (node, i) {
                    (3, EMPTY) => Aabb::EMPTY,
                    (4, 200) => Aabb::EVERYTHING,
                    _ => Aabb { min, max },
                });
            }
        }
        boxes
    }

    fn rows(rng: &mut Random, projection: Projection) -> [[f64; 4]; 4] {
        let eye = [0; 3].map(|_| f64::from(rng.range(-400.0, 400.0)));
        let camera = Camera::look_at(eye, [1.0, 2.0, 3.0], projection);
        let view = View::new(&camera, Depth::Reversed, [1280, 720]).expect("a plain camera");
        view.depth_rows(&Transform::IDENTITY.to_matrix())
    }

    #[test]
    fn nodes_decide_as_their_boxes_do() {
        let mut rng = Random(0x1234_5678_9abc_def1);
        let (mut decided, mut small_nodes, mut kept_nodes, mut by_node) = (0, 0, 0, 0);
        for round in 0..400 {
            let boxes = boxes(&mut rng);
            let simd = Simd::best();
            let nodes = Nodes::over(simd, &boxes);
            let projection = match round % 4 {
                0 => Projection::Orthographic {
                    left: -260.0,
                    right: 270.0,
                    bottom: -150.0,
                    top: 150.0,
                    near: 1.0,
                    far: 2000.0,
                },
                _ => Projection::Perspective {
                    fov_y_radians: 1.0,
                    aspect: 16.0 / 9.0,
                    near: 0.5,
                    far: 2000.0,
                },
            };
            let rows = rows(&mut rng, projection);
            let measures = [Measure::WidthAndHeight, Measure::Area, Measure::Diameter];
            let detail = Detail::default()
                .with_measure(measures[round % 3])
                .with_threshold_px(f64::from(rng.range(0.0, 40.0)));
            let test = SizeTest::new(rows, [1280, 720], &detail);
            let weights = (round % 5 == 0).then_some([1.5; LANES]);
            let own = weights.map(|w| [w; 4]);
            for simd in Simd::all() {
                let found = test.of_nodes(
                    simd,
                    &nodes.levels()[1].blocks()[0],
                    nodes.spans_below(1),
                    weights.as_ref(),
                );
                for node in 0..LANES {
                    let blocks = &boxes.blocks()[node * LANES..(node + 1) * LANES];
                    let mut all: Vec<_> =
                        blocks.chunks(4).map(|b| test.small(simd, b, 0xf, own.as_ref())).collect();
                    for (blocks, all) in blocks.chunks(4).zip(&all) {
                        // Whatever is asked for at once.
                        let tested = match rng.next() {
                            v if v < 0.3 => u64::MAX,
                            v => ((f64::from(v) * 1e19) as u64).rotate_left(node as u32),
                        };
                        let below = test.small_below(simd, (&found, node), blocks, tested);
                        assert!(below.is_none_or(|b| b == *all & tested), "{round} {node}");
                        by_node += u32::from(below.is_some());
                    }
                    if node == 3 {
                        let other = all[EMPTY / 64] >> ((EMPTY + 1) % 64) & 1 == 1;
                        bits::set(&mut all, EMPTY, other);
                    }
                    let (small, kept) = (found.small >> node & 1, found.kept >> node & 1);
                    assert!(small == 0 || all.iter().all(|w| *w == u64::MAX), "{round} {node}");
                    assert!(kept == 0 || all.iter().all(|w| *w == 0), "{round} {node}");
                    let alike = all.iter().all(|w| *w == all[0]) && matches!(all[0], 0 | u64::MAX);
                    decided += u32::from(alike);
                    small_nodes += u32::from(small);
                    kept_nodes += u32::from(kept);
                }
            }
        }
        assert!(by_node > 20_000, "{by_node}");
        // Of the nodes whose boxes agree most are decided at once.
        assert!(small_nodes > 2000 && kept_nodes > 2000, "{small_nodes} {kept_nodes}");
        assert!(
            (small_nodes + kept_nodes) * 3 > decided * 2,
            "{small_nodes} {kept_nodes} {decided}"
        );
    }
}
