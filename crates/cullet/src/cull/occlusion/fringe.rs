//! The fringe: pixels that edges cross, where faces that meet cover a pixel together.
//!
//! A pixel that an edge crosses is covered by no face alone, and shrinking every face would leave a crack along each edge
//! inside a surface. But take some faces of a surface that all show the same side, and a pixel that no edge of
//! their common border touches: then either all of the pixel is covered by them or nothing is, since how often a point
//! is covered changes only at the border. So where an inner edge touches a pixel and no border does, the pixel is covered;
//! and the faces that cover it are those with an edge in it, so it is at least as near as the farthest of them.
//!
//! A sheet of pixels beside the buffer holds that: the least nearness of the faces along the edges that touch a pixel, 0 for
//! ever once a border does. When all edges of a patch are walked, what is left goes into the buffer.

use super::buffer::{OcclusionBuffer, TILE, Tile};
use super::plane::Plane;
use super::screen::Spot;

/// Pixels by which an edge is thickened: more than anything here is off by.
const SLACK: f64 = 1.0 / 256.0;

/// The sheet.
#[derive(Clone, Debug)]
pub(super) struct Fringe {
    size: [i32; 2],
    columns: usize,
    tiles: Vec<Tile>,
    /// The tiles that are not all infinite.
    touched: Vec<u32>,
    is_touched: Vec<bool>,
    nearest: f32,
    window: [[i32; 2]; 2],
}

/// What is along an edge.
#[derive(Clone, Copy, Debug)]
pub(super) enum Along<'a> {
    /// The border of the faces.
    Border,
    /// Two faces, each with its plane and the nearness of its farthest corner.
    Faces(&'a Plane, f32, &'a Plane, f32),
}

impl Fringe {
    pub(super) fn new(size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|s| (s as usize).div_ceil(TILE));
        Self {
            size: size.map(|s| s as i32),
            columns,
            tiles: vec![Tile::filled(f32::INFINITY); columns * rows],
            touched: Vec::new(),
            is_touched: vec![false; columns * rows],
            nearest: f32::INFINITY,
            window: [[0; 2], size.map(|s| s as i32 - 1)],
        }
    }

    /// Begins a side of a patch: nothing of it is nearer than `nearest`, and nothing beyond `window` (first
    /// column and row, last column and row) is wanted. Both hold for all edges alike, borders too.
    pub(super) fn begin(&mut self, nearest: f32, window: [[i32; 2]; 2]) {
        self.nearest = nearest;
        let limit = |v: i32, a: usize| v.clamp(-1, self.size[a]);
        let [min, max] = window;
        self.window = [
            [limit(min[0], 0).max(0), limit(min[1], 1).max(0)],
            [limit(max[0], 0).min(self.size[0] - 1), limit(max[1], 1).min(self.size[1] - 1)],
        ];
    }

    /// Walks every pixel that the edge touches, `doubt` pixels to either side included; but those of tiles which are
    /// covered already by what is nearer than all of the patch.
    pub(super) fn walk(&mut self, far: &[f32], p: Spot, q: Spot, doubt: f64, along: Along<'_>) {
        // Borders thicker, so that none is missed where an inner edge behind it is not.
        let wide = match along {
            Along::Border => doubt * 3.0 + SLACK * 2.0,
            Along::Faces(..) => doubt + SLACK,
        };
        let [min, max] = self.window;
        let (p, q) = if p.y <= q.y { (p, q) } else { (q, p) };
        let first = (p.y - wide).floor().max(f64::from(min[1])) as i32;
        let last = (q.y + wide).floor().min(f64::from(max[1])) as i32;
        let (low, high) = (p.x.min(q.x), p.x.max(q.x));
        if high + wide < f64::from(min[0]) || low - wide > f64::from(max[0] + 1) {
            return;
        }
        // Level edges have no slope that would be of use: every row spans all of them.
        let slope = if q.y - p.y > 1e-6 { (q.x - p.x) / (q.y - p.y) } else { f64::INFINITY };
        for row in first..=last {
            let (mut from, mut to) = (low, high);
            if slope.is_finite() {
                let at = |y: f64| p.x + (y.clamp(p.y, q.y) - p.y) * slope;
                let (a, b) = (at(f64::from(row) - wide), at(f64::from(row + 1) + wide));
                (from, to) = (a.min(b).max(low), a.max(b).min(high));
            }
            let from = (from - wide).floor().max(f64::from(min[0])) as i32;
            let to = (to + wide).floor().min(f64::from(max[0])) as i32;
            if from <= to {
                self.touch(far, [from as usize, to as usize], row as usize, along);
            }
        }
    }

    /// Touches some pixels of a row.
    #[inline(always)]
    fn touch(&mut self, far: &[f32], [from, to]: [usize; 2], row: usize, along: Along<'_>) {
        for column in from / TILE..=to / TILE {
            let t = row / TILE * self.columns + column;
            if far[t] >= self.nearest {
                continue;
            }
            if !self.is_touched[t] {
                self.is_touched[t] = true;
                self.touched.push(t as u32);
            }
            let pixels = &mut self.tiles[t].0[row % TILE * TILE..][..TILE];
            let x0 = column * TILE;
            for x in from.max(x0)..=to.min(x0 + TILE - 1) {
                let value = match along {
                    Along::Border => 0.0,
                    // A plane goes on beyond its face, so a face is at least as near as its farthest corner.
                    Along::Faces(a, far_a, b, far_b) => {
                        let (x, y) = (x as f32, row as f32);
                        // Nor is a pixel beside the faces nearer than all of them.
                        let near = a.at(x, y).max(far_a).min(b.at(x, y).max(far_b));
                        near.min(self.nearest)
                    }
                };
                let pixel = &mut pixels[x - x0];
                *pixel = pixel.min(value);
            }
        }
    }
}

impl OcclusionBuffer {
    /// Takes what the fringe proved into the buffer, and blanks the sheet.
    pub(super) fn take_fringe(&mut self) {
        let Self { size, columns, tiles, far, live, fringe, .. } = self;
        for t in fringe.touched.drain(..) {
            let t = t as usize;
            fringe.is_touched[t] = false;
            let proved = std::mem::replace(&mut fringe.tiles[t], Tile::filled(f32::INFINITY));
            Self::wake(*size, *columns, tiles, live, t);
            let mut least = f32::INFINITY;
            for (pixel, proved) in tiles[t].0.iter_mut().zip(&proved.0) {
                let value = if *proved == f32::INFINITY { 0.0 } else { *proved };
                *pixel = pixel.max(value);
                least = least.min(*pixel);
            }
            far[t] = least;
        }
    }
}
