//! Bounds of the sizes of sixteen boxes on the screen at once.
//!
//! With g = x − q w, where x and w are rows of the matrix and q = x/w at the middle of a box, a
//! corner at d from the middle is at g·d / w beside it, so that the picture is at most 2G/w wide, G
//! being the sum of |g| times half the box, and w the least of the box. For a box that is small for
//! its distance the bound is hardly wider than the picture. Tried: projecting the corners of boxes
//! just above the threshold changed no answer in some hundreds.
//!
//! A node decides all its boxes at once, sixteen nodes at a time: q is then known only as a range,
//! which widens |g|, and the box is taken as large as the largest below the node. None is small
//! where the smallest would not be, with |g| made less by that range and with the farthest w.

use crate::array::Each;
use crate::simd::dispatch_256;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

use super::{Detail, Measure};
use crate::bounds::{Aabb, Block, BoxBlock, LANES};
use crate::hierarchy::Span;
use crate::simd::Simd;

/// 2⁻¹⁹: more than stored boxes are [wider](crate::bounds::Boxes) than what they are of, and f32
/// rounds.
const STEP: f32 = 1.0 / (1 << 19) as f32;

/// Test of the sizes of boxes in one view against the threshold of detail culling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizeTest {
    /// Rows of x, y, depth beyond the near plane, and w.
    rows: [[f32; 4]; 4],
    /// Size of the viewport, in pixels.
    size: [f32; 2],
    measure: Measure,
    threshold: f32,
}

impl SizeTest {
    /// Creates the test from the [rows](crate::View::depth_rows) of a view and its viewport.
    pub(crate) fn new(rows: [[f64; 4]; 4], viewport: [u32; 2], detail: &Detail) -> Self {
        let threshold = match detail.measure {
            // Squares are compared.
            Measure::Diameter => detail.threshold_px * detail.threshold_px.abs(),
            _ => detail.threshold_px,
        };
        let rows = rows.each(|row| row.each(|v| v as f32));
        let size = viewport.each(|v| v as f32);
        Self { rows, size, measure: detail.measure, threshold: threshold as f32 }
    }

    /// Returns one bit for each box that is surely small, of up to four blocks; blocks whose bits
    /// in `wanted` are clear are left out. `weights` multiply sizes; a box with a weight that is
    /// negative, infinite or NaN is never small.
    ///
    /// Several at once, for most of the time is that of memory: no decision stands between the
    /// blocks that are read.
    pub(crate) fn small(
        &self,
        simd: Simd,
        blocks: &[BoxBlock],
        wanted: u8,
        weights: Option<&[[f32; LANES]; 4]>,
    ) -> u64 {
        dispatch_256!(simd, simd => self.small_blocks(simd, blocks, wanted, weights))
    }

    // Plain functions and loops all through: a closure that is not inlined has no vector
    // instructions, and made this six times as slow.
    #[inline(always)]
    fn small_blocks<S: fearless_simd::Simd>(
        &self,
        simd: S,
        blocks: &[BoxBlock],
        wanted: u8,
        weights: Option<&[[f32; LANES]; 4]>,
    ) -> u64 {
        let (mut small, mut rest) = (0, wanted);
        while rest != 0 {
            let part = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let Some(block) = blocks.get(part) else { break };
            let lanes = Lanes::new(simd, block);
            let bounds = self.bounds(&lanes, &lanes.reach, false);
            let own = weights.map(|weights| &weights[part]);
            small |= u64::from(self.below(&bounds, own)) << (part * LANES);
        }
        small
    }

    /// Decides sixteen nodes: one bit for each node of `block` below which all boxes are surely
    /// small, and one for each below which [`small`](Self::small) finds none, which is not known
    /// where there are weights. `spans` are those of the sizes of the boxes below each, and
    /// `weights` those of the heaviest.
    pub(crate) fn decide_nodes(
        &self,
        simd: Simd,
        block: &BoxBlock,
        spans: &[Span],
        weights: Option<&[f32; LANES]>,
    ) -> Decided {
        let (mut most, mut least) = ([[0.0; LANES]; 3], [[-1.0; LANES]; 3]);
        for (lane, own) in spans.iter().take(LANES).enumerate() {
            for a in 0..3 {
                most[a][lane] = own.most[a] * 0.5;
                least[a][lane] = own.least[a] * 0.5;
            }
        }
        dispatch_256!(simd, simd => {
            let lanes = Lanes::new(simd, block);
            let (mut largest, mut smallest) = (lanes.reach, lanes.reach);
            for a in 0..3 {
                largest[a] = f32x16::from_slice(simd, &most[a]);
                smallest[a] = f32x16::from_slice(simd, &least[a]);
            }
            let small = self.below(&self.bounds(&lanes, &largest, true), weights);
            let kept = match weights {
                None if small != u16::MAX => self.none_below(&lanes, &smallest),
                _ => 0,
            };
            Decided { small, kept }
        })
    }

    /// Returns the bounds of width and height in pixels of one box; `None` where there are none.
    pub(crate) fn bound(&self, simd: Simd, b: &Aabb) -> Option<[f64; 2]> {
        let mut block: BoxBlock = bytemuck::Zeroable::zeroed();
        block.set(0, b);
        let (mut known, mut sizes) = (0, [[0.0; LANES]; 2]);
        dispatch_256!(simd, simd => {
            let lanes = Lanes::new(simd, &block);
            let bounds = self.bounds(&lanes, &lanes.reach, false);
            known = bounds.known.to_bitmask();
            bounds.width.store_slice(&mut sizes[0]);
            bounds.height.store_slice(&mut sizes[1]);
        });
        (known & 1 == 1).then(|| sizes.each(|of| f64::from(of[0])))
    }

    /// Bounds sixteen lanes: boxes with these halves, which are the lanes or, where `within`, lie
    /// in them.
    #[inline(always)]
    fn bounds<S: fearless_simd::Simd>(
        &self,
        lanes: &Lanes<S>,
        halves: &[f32x16<S>; 3],
        within: bool,
    ) -> Bounds<S> {
        let [row_x, row_y, row_z, row_w] = &self.rows;
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        let (w, w_off, w_half) = (lanes.at(row_w), lanes.off(row_w), lanes.half(row_w));
        let nearest = w - w_half - w_off;
        let depth = lanes.at(row_z) - lanes.half(row_z) - lanes.off(row_z) - w_off;
        // What reciprocals are rounded by is far below the slack of what they are used for.
        let deep = Deep {
            row: row_w,
            per_w: one / w,
            spread: if within { w_half + w_off } else { w_off },
            per_nearest: one / nearest,
        };
        Bounds {
            simd: lanes.simd,
            known: nearest.simd_gt(zero) & depth.simd_ge(zero),
            width: lanes.side(row_x, &deep, halves, within, self.size[0]),
            height: lanes.side(row_y, &deep, halves, within, self.size[1]),
        }
    }

    /// The bits of lanes whose bounds are below the threshold.
    #[inline(always)]
    fn below<S: fearless_simd::Simd>(
        &self,
        bounds: &Bounds<S>,
        weights: Option<&[f32; LANES]>,
    ) -> u16 {
        let Bounds { simd, mut known, mut width, mut height } = *bounds;
        if let Some(weights) = weights {
            let weight = f32x16::from_slice(simd, weights);
            known = known
                & weight.simd_ge(f32x16::splat(simd, 0.0))
                & weight.simd_lt(f32x16::splat(simd, f32::INFINITY));
            (width, height) = (width * weight, height * weight);
        }
        let most = match self.measure {
            Measure::WidthAndHeight => width.max(height),
            Measure::Area => width * height,
            Measure::Diameter => width * width + height * height,
        };
        let margin = f32x16::splat(simd, self.threshold.abs() * (4.0 * STEP));
        let small = (most + margin).simd_lt(f32x16::splat(simd, self.threshold));
        (known & small).to_bitmask() as u16
    }

    /// The bits of nodes of which no box, with at least these halves, is [below](Self::below) the
    /// threshold: the bounds of each are at least these, rounded down.
    #[inline(always)]
    fn none_below<S: fearless_simd::Simd>(
        &self,
        lanes: &Lanes<S>,
        halves: &[f32x16<S>; 3],
    ) -> u16 {
        let [row_x, row_y, _, row_w] = &self.rows;
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        let (w, w_off, w_half) = (lanes.at(row_w), lanes.off(row_w), lanes.half(row_w));
        let nearest = w - w_half - w_off;
        let deep = Deep {
            row: row_w,
            per_w: one / w,
            spread: w_half + w_off,
            per_nearest: one / nearest,
        };
        let per_farthest = one / (w + w_half + w_off + w_off);
        let width = lanes.least_side(row_x, &deep, halves, per_farthest, self.size[0]);
        let height = lanes.least_side(row_y, &deep, halves, per_farthest, self.size[1]);
        let least = match self.measure {
            Measure::WidthAndHeight => width.max(height),
            Measure::Area => width * height,
            Measure::Diameter => width * width + height * height,
        };
        // A number that overflowed says nothing, nor does the size of an empty box.
        let known = nearest.simd_gt(zero)
            & least.simd_lt(lanes.splat(f32::MAX))
            & halves[0].simd_ge(zero)
            & halves[1].simd_ge(zero)
            & halves[2].simd_ge(zero);
        let large = least.simd_ge(lanes.splat(self.threshold));
        (known & large).to_bitmask() as u16
    }
}

/// What nodes decide, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Decided {
    /// All boxes below are small.
    pub(crate) small: u16,
    /// None is.
    pub(crate) kept: u16,
}

/// Widths and heights in pixels that the pictures of sixteen boxes do not exceed, where they are
/// known.
#[derive(Clone, Copy)]
struct Bounds<S: fearless_simd::Simd> {
    simd: S,
    known: mask32x16<S>,
    width: f32x16<S>,
    height: f32x16<S>,
}

/// Sixteen boxes: middles, halves, and the largest coordinates along each axis.
struct Lanes<S: fearless_simd::Simd> {
    simd: S,
    middle: [f32x16<S>; 3],
    reach: [f32x16<S>; 3],
    most: [f32x16<S>; 3],
}

/// Row of w, and what it is of sixteen boxes: one over that of their middles, by how much it may be
/// off of the middle of a box, and one over the least there is of it.
struct Deep<'a, S: fearless_simd::Simd> {
    row: &'a [f32; 4],
    per_w: f32x16<S>,
    spread: f32x16<S>,
    per_nearest: f32x16<S>,
}

impl<S: fearless_simd::Simd> Lanes<S> {
    #[inline(always)]
    fn new(simd: S, BoxBlock(rows): &BoxBlock) -> Self {
        let (x, p) = (f32x16::from_slice(simd, &rows[0]), f32x16::from_slice(simd, &rows[3]));
        let (y, q) = (f32x16::from_slice(simd, &rows[1]), f32x16::from_slice(simd, &rows[4]));
        let (z, r) = (f32x16::from_slice(simd, &rows[2]), f32x16::from_slice(simd, &rows[5]));
        let half = f32x16::splat(simd, 0.5);
        // The first three rows are of −min.
        Self {
            simd,
            middle: [(p - x) * half, (q - y) * half, (r - z) * half],
            reach: [(p + x) * half, (q + y) * half, (r + z) * half],
            most: [x.abs().max(p.abs()), y.abs().max(q.abs()), z.abs().max(r.abs())],
        }
    }

    #[inline(always)]
    fn splat(&self, v: f32) -> f32x16<S> {
        f32x16::splat(self.simd, v)
    }

    /// A row at the middles.
    #[inline(always)]
    fn at(&self, row: &[f32; 4]) -> f32x16<S> {
        let [x, y, z] = self.middle;
        ((self.splat(row[0]) * x + self.splat(row[1]) * y) + self.splat(row[2]) * z)
            + self.splat(row[3])
    }

    /// Returns the most by which `row` changes from the middle of each box to its sides.
    #[inline(always)]
    fn half(&self, row: &[f32; 4]) -> f32x16<S> {
        let [x, y, z] = self.reach;
        (self.splat(row[0].abs()) * x + self.splat(row[1].abs()) * y) + self.splat(row[2].abs()) * z
    }

    /// Returns the most by which rounding may put `row` off, for each box.
    #[inline(always)]
    fn off(&self, row: &[f32; 4]) -> f32x16<S> {
        let [x, y, z] = self.most;
        let sum = (self.splat(row[0].abs()) * x + self.splat(row[1].abs()) * y)
            + (self.splat(row[2].abs()) * z + self.splat(row[3].abs()));
        sum * self.splat(STEP)
    }

    /// Bounds how wide boxes with these halves look along one axis of a screen with so many pixels.
    #[inline(always)]
    fn side(
        &self,
        row: &[f32; 4],
        deep: &Deep<'_, S>,
        halves: &[f32x16<S>; 3],
        within: bool,
        pixels: f32,
    ) -> f32x16<S> {
        let (q, q_off) = self.quotient(row, deep, within);
        let mut most = self.splat(0.0);
        for a in 0..3 {
            let (g, g_off) = self.gradient(row[a], deep.row[a], q, q_off);
            most += (g + g_off) * (halves[a] + self.most[a] * self.splat(STEP));
        }
        // What x/w itself is rounded by where corners are projected is far below this. Twice half
        // the box, times half of the viewport.
        let slack = (q.abs() + self.splat(1.0)) * self.splat(1e-9 * pixels);
        most * deep.per_nearest * self.splat(pixels * (1.0 + 8.0 * STEP)) + slack
    }

    /// Returns what [`side`](Self::side) is at least for every box with at least these halves that
    /// lies in these lanes, of which none is farther than one over `per_farthest`.
    #[inline(always)]
    fn least_side(
        &self,
        row: &[f32; 4],
        deep: &Deep<'_, S>,
        halves: &[f32x16<S>; 3],
        per_farthest: f32x16<S>,
        pixels: f32,
    ) -> f32x16<S> {
        let zero = self.splat(0.0);
        let (q, q_off) = self.quotient(row, deep, true);
        let mut sum = zero;
        for a in 0..3 {
            let (g, g_off) = self.gradient(row[a], deep.row[a], q, q_off);
            sum += (g - g_off).max(zero) * halves[a];
        }
        sum * per_farthest * self.splat(pixels * (1.0 - 8.0 * STEP))
    }

    /// Returns `row` over w at the middle, and by how much that of a box may be off.
    #[inline(always)]
    fn quotient(
        &self,
        row: &[f32; 4],
        deep: &Deep<'_, S>,
        within: bool,
    ) -> (f32x16<S>, f32x16<S>) {
        let q = self.at(row) * deep.per_w;
        let steep = q.abs();
        let mut off = self.off(row);
        if within {
            off += self.half(row);
        }
        let rounded = (steep + self.splat(1.0)) * self.splat(STEP);
        (q, (off + steep * deep.spread) * deep.per_nearest + rounded)
    }

    /// Returns how much the picture moves along an axis whose numbers in the two rows are these,
    /// and by how much that may be off.
    #[inline(always)]
    fn gradient(
        &self,
        of_row: f32,
        of_w: f32,
        q: f32x16<S>,
        q_off: f32x16<S>,
    ) -> (f32x16<S>, f32x16<S>) {
        let (most_row, most_w) = (self.splat(of_row.abs()), self.splat(of_w.abs()));
        let g = (self.splat(of_row) - q * self.splat(of_w)).abs();
        let g_off = most_w * q_off + (most_row + q.abs() * most_w) * self.splat(STEP);
        (g, g_off)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Boxes;
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
                    (3, 77) => Aabb::EMPTY,
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
        let (mut decided, mut small_nodes, mut kept_nodes) = (0, 0, 0);
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
                let found = test.decide_nodes(
                    simd,
                    &nodes.levels()[1].blocks()[0],
                    nodes.spans_below(1),
                    weights.as_ref(),
                );
                for node in 0..LANES {
                    let blocks = &boxes.blocks()[node * LANES..(node + 1) * LANES];
                    let all: Vec<_> =
                        blocks.chunks(4).map(|b| test.small(simd, b, 0xf, own.as_ref())).collect();
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
        // Of the nodes whose boxes agree most are decided at once.
        assert!(small_nodes > 2000 && kept_nodes > 2000, "{small_nodes} {kept_nodes}");
        assert!((small_nodes + kept_nodes) * 3 > decided * 2, "{small_nodes} {kept_nodes} {decided}");
    }
}
