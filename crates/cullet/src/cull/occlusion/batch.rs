//! The footprints of many boxes, sixteen at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

use super::ask::Footprint;
use super::buffer::OcclusionBuffer;
use crate::bits;
use crate::bounds::{BoxBlock, Boxes};

/// What a sum of three products and a constant in f32 may be off by, of the sum of their sizes: coefficients that
/// were rounded from f64, three products and three sums lose 7 units of 2⁻²⁴ at most.
const ROUNDING: f32 = 8.0 / (1 << 24) as f32;

const LANES: usize = 16;

/// A row of the screen in f32.
#[derive(Clone, Copy)]
struct Row {
    axes: [f32; 3],
    constant: f32,
}

struct Rows {
    x: Row,
    y: Row,
    nearness: Row,
    near: Row,
    w: Row,
    size: [f32; 2],
}

/// The footprints of a block, a box a lane.
struct Found {
    min: [[f32; LANES]; 2],
    max: [[f32; LANES]; 2],
    nearness: [f32; LANES],
    /// The boxes that have one.
    bounded: u64,
}

impl OcclusionBuffer {
    /// Appends the footprint of every box whose bit is set in `alive` (a bit a box, sixty-four a word) in one of the `words`
    /// named: that of [`footprint_of`](Self::footprint_of), or somewhat larger and nearer, for it is computed in f32.
    /// A box that crosses the near plane, may do so, is not finite or reaches no pixel is left out.
    ///
    /// The answer is the same at every SIMD level.
    ///
    /// # Panics
    /// If a word named is beyond `alive`.
    pub fn footprints(
        &self,
        level: Level,
        boxes: &Boxes,
        words: &[u32],
        alive: &[u64],
        out: &mut Vec<(u32, Footprint)>,
    ) {
        let Some(screen) = &self.screen else { return };
        let row = |r: [f64; 4]| Row {
            axes: [r[0] as f32, r[1] as f32, r[2] as f32],
            constant: r[3] as f32,
        };
        let [x, y, nearness, near, w] = screen.rows().map(row);
        let rows = Rows { x, y, nearness, near, w, size: self.size.map(|s| s as f32) };
        dispatch!(level, simd => all(simd, &rows, boxes, words, alive, out));
    }
}

#[inline(always)]
fn all<S: Simd>(
    simd: S,
    rows: &Rows,
    boxes: &Boxes,
    words: &[u32],
    alive: &[u64],
    out: &mut Vec<(u32, Footprint)>,
) {
    let [width, height] = rows.size;
    for &word in words {
        let there = match boxes.len().saturating_sub(word as usize * 64) {
            left if left >= 64 => u64::MAX,
            left => (1 << left) - 1,
        };
        let asked = alive[word as usize] & there;
        for quarter in 0..64 / LANES {
            let bits = asked >> (quarter * LANES) & 0xFFFF;
            let Some(block) = boxes.blocks().get(word as usize * (64 / LANES) + quarter) else {
                break;
            };
            if bits == 0 {
                continue;
            }
            let found = footprints(simd, rows, block);
            for lane in bits::ones(bits & found.bounded) {
                let pixel = |v: f32, size: f32| v.clamp(0.0, size - 1.0) as u32;
                let footprint = Footprint {
                    min: [pixel(found.min[0][lane], width), pixel(found.min[1][lane], height)],
                    max: [pixel(found.max[0][lane], width), pixel(found.max[1][lane], height)],
                    nearness: found.nearness[lane],
                };
                out.push((word * 64 + (quarter * LANES + lane) as u32, footprint));
            }
        }
    }
}

/// All eight corners of sixteen boxes, a box a lane. Products and sums are never fused, so that every level rounds
/// alike.
#[inline(always)]
fn footprints<S: Simd>(simd: S, rows: &Rows, block: &BoxBlock) -> Found {
    let lanes = S::f32s::LEN;
    let splat = |v: f32| S::f32s::splat(simd, v);
    let mut found = Found {
        min: [[0.0; LANES]; 2],
        max: [[0.0; LANES]; 2],
        nearness: [0.0; LANES],
        bounded: 0,
    };
    let mut at = 0;
    while at < LANES {
        let load = |row: usize| S::f32s::from_slice(simd, &block.0[row][at..at + lanes]);
        let low: [S::f32s; 3] = [-load(0), -load(1), -load(2)];
        let high: [S::f32s; 3] = [load(3), load(4), load(5)];
        let reach: [S::f32s; 3] = std::array::from_fn(|a| low[a].abs().max(high[a].abs()));
        let error = |row: &Row| {
            let sizes = reach[0] * row.axes[0].abs() + reach[1] * row.axes[1].abs();
            (sizes + reach[2] * row.axes[2].abs() + row.constant.abs()) * ROUNDING
        };
        // The least and the most of a row over a box.
        let least = |row: &Row, sign: f32| {
            (0..3).fold(splat(row.constant), |sum, a| {
                let end = if row.axes[a] * sign >= 0.0 { low[a] } else { high[a] };
                sum + end * row.axes[a]
            })
        };
        let (error_w, error_near) = (error(&rows.w), error(&rows.near));
        let nearest_w = least(&rows.w, 1.0) - error_w;
        // Any NaN fails these, and so does all that f32 overflows for.
        let mut bounded = (least(&rows.near, 1.0) - error_near).simd_ge(splat(0.0))
            & nearest_w.simd_gt(error_w + error_w);
        let inverse = splat(1.0) / nearest_w;
        let nearness = (least(&rows.nearness, -1.0) + error(&rows.nearness)) * inverse;
        let nearness = nearness * (1.0 + 1e-6);
        bounded &= nearness.simd_lt(splat(f32::MAX));
        nearness.store_slice(&mut found.nearness[at..at + lanes]);

        // x and y over w at the corners; terms of two axes are shared by two corners.
        let mut w = [splat(0.0); 8];
        corners(simd, &rows.w, &low, &high, &mut w);
        for v in &mut w {
            *v = splat(1.0) / *v;
        }
        for (axis, row) in [&rows.x, &rows.y].into_iter().enumerate() {
            let mut v = [splat(0.0); 8];
            corners(simd, row, &low, &high, &mut v);
            let first = v[0] * w[0];
            let (mut min, mut max) = (first, first);
            for k in 1..8 {
                let value = v[k] * w[k];
                min = min.min(value);
                max = max.max(value);
            }
            // |(v + e) / (w + f) − v / w| ≤ (|e| + |v / w||f|) / (w − |f|), and the two roundings of the quotient.
            let size = min.abs().max(max.abs());
            let off = (error(row) + size * error_w) * inverse + size * (4.0 * ROUNDING);
            let (min, max) = (min - off, max + off);
            let extent = splat(rows.size[axis]);
            bounded &= max.simd_ge(splat(0.0)) & min.simd_le(extent);
            min.store_slice(&mut found.min[axis][at..at + lanes]);
            max.store_slice(&mut found.max[axis][at..at + lanes]);
        }
        found.bounded |= bounded.to_bitmask() << at;
        at += lanes;
    }
    found
}

/// A row at the eight corners.
#[inline(always)]
fn corners<S: Simd>(
    simd: S,
    row: &Row,
    low: &[S::f32s; 3],
    high: &[S::f32s; 3],
    out: &mut [S::f32s; 8],
) {
    let terms: [[S::f32s; 2]; 3] =
        std::array::from_fn(|a| [low[a] * row.axes[a], high[a] * row.axes[a]]);
    let constant = S::f32s::splat(simd, row.constant);
    for y in 0..2 {
        for z in 0..2 {
            let sum = terms[1][y] + terms[2][z] + constant;
            out[y * 2 + z] = terms[0][0] + sum;
            out[4 + y * 2 + z] = terms[0][1] + sum;
        }
    }
}
