//! Silhouette edges: those with a drawn facet on one side alone. What they touch is not proved to
//! be covered.

use fearless_simd::f32x8;
use fearless_simd::prelude::*;

use super::super::blocks::BLOCK;
use super::super::connected::{Connected, LANES, NUMBERS};
use super::super::screen::ObjectScreen;
use super::super::span::{ROWS, Span, blocks};
use super::{Projection, Surface, Window};
use crate::array::Each;
use crate::bits;

impl Surface {
    /// Lists them; `false` where clipping them takes more corners than there are numbers.
    #[inline(always)]
    pub(super) fn find_silhouettes(
        &mut self,
        (screen, projection): (&ObjectScreen, &Projection),
        patch: &Connected,
        window: &Window,
        back: bool,
    ) -> bool {
        let mut found = core::mem::take(&mut self.silhouettes);
        found.clear();
        for [f, g, a, b] in &patch.edges {
            let mut differ = 0;
            for lane in 0..LANES {
                let [f, g] = [usize::from(f[lane]) % NUMBERS, usize::from(g[lane]) % NUMBERS];
                differ |= (self.drawn[f] ^ self.drawn[g]) & (1 << lane);
            }
            for lane in bits::ones(u64::from(differ)) {
                found.push([a[lane % LANES], b[lane % LANES]]);
            }
        }
        let fits =
            !window.is_clipped || self.cut_silhouettes(screen, projection, patch, back, &mut found);
        self.silhouettes = found;
        fits
    }

    /// Removes what they touch.
    #[inline(always)]
    pub(super) fn draw_silhouettes<S: Simd>(&mut self, simd: S, window: &Window) {
        let all = core::mem::take(&mut self.silhouettes);
        for eight in all.chunks(LANES) {
            let mut ends = [eight[0]; LANES];
            ends[..eight.len()].copy_from_slice(eight);
            simd.vectorize(
                #[inline(always)]
                || self.remove_eight(simd, window, &ends, eight.len()),
            );
        }
        self.silhouettes = all;
    }

    #[inline(always)]
    fn remove_eight<S: Simd>(
        &mut self,
        simd: S,
        window: &Window,
        ends: &[[u16; 2]; LANES],
        count: usize,
    ) {
        let splat = |v: f32| f32x8::splat(simd, v);
        let margin = splat(3.0 * window.margin);
        let [ax, ay, _] = self.spots.gather(simd, &ends.each(|[a, _]| a));
        let [bx, by, _] = self.spots.gather(simd, &ends.each(|[_, b]| b));
        let upward = ay.simd_gt(by);
        let (top_x, end_x) = (upward.select(bx, ax), upward.select(ax, bx));
        let (top_y, end_y) = (ay.min(by), ay.max(by));
        let low = [
            (ax.min(bx) - margin).floor().max(splat(window.low[0])),
            (top_y - margin).floor().max(splat(window.low[1])),
        ];
        let high = [
            ((ax.max(bx) + margin).floor() + 1.0).min(splat(window.high[0])),
            (end_y + margin).floor().min(splat(window.high[1])),
        ];
        let mut lanes = (low[0].simd_lt(high[0]) & low[1].simd_le(high[1])).to_bitmask();
        lanes &= (1 << count) - 1;
        if lanes == 0 {
            return;
        }
        let dx = end_x - top_x;
        let slope = dx / (end_y - top_y).max(dx.abs() * (1.0 / 4_194_304.0) + 1e-20);
        let wide = slope.abs() * (margin + 0.5) + margin;
        let through = top_x - slope * (top_y - 0.5);
        let start: [f32; LANES] = (through - wide).into();
        let end: [f32; LANES] = (through + wide + 1.0).into();
        let slope: [f32; LANES] = slope.into();
        let columns: [[i32; LANES]; 2] = [blocks(low[0], 0), blocks(high[0] - 1.0, 0)];
        let rows: [[i32; LANES]; 2] = [blocks(low[1], 1), blocks(high[1], 1)];
        let low: [[f32; LANES]; 2] = [low[0].into(), low[1].into()];
        let high: [[f32; LANES]; 2] = [high[0].into(), high[1].into()];
        for lane in bits::ones(lanes) {
            let [x0, x1, y0, y1] = [low[0][lane], high[0][lane], low[1][lane], high[1][lane]];
            let [first, last] =
                [columns[0][lane] as u32 as usize, columns[1][lane] as u32 as usize];
            let all = window.run([first, last]);
            for row in rows[0][lane] as u32 as usize..rows[1][lane] as u32 as usize + 1 {
                if self.used[row - window.block[1]] & all == 0 {
                    continue;
                }
                let y = f32x8::simd_from(simd, ROWS) + (row * BLOCK[1]) as i32 as f32;
                let at = y * slope[lane];
                let left = (at + start[lane]).max(splat(x0)).min(splat(x1));
                let right = (at + end[lane]).min(splat(x1));
                let inside = y.simd_ge(splat(y0)) & y.simd_le(splat(y1));
                let span = Span::new(simd, left, right, inside);
                if let Some((from, to)) = span.blocks(simd, first, last) {
                    self.remove(simd, window, row, [from, to], &span);
                }
            }
        }
    }
}
