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
        }
    }

    /// Walks every pixel that the edge touches, `doubt` pixels to either side included.
    pub(super) fn walk(&mut self, p: Spot, q: Spot, doubt: f64, along: Along<'_>) {
        let wide = doubt + SLACK;
        let [width, height] = self.size;
        let (p, q) = if p.y <= q.y { (p, q) } else { (q, p) };
        let first = ((p.y - wide).floor().max(0.0)) as i32;
        let last = (q.y + wide).floor().min(f64::from(height - 1)) as i32;
        let (low, high) = (p.x.min(q.x), p.x.max(q.x));
        if !(low.is_finite() && high.is_finite())
            || high + wide < 0.0
            || low - wide > f64::from(width)
        {
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
            let from = (from - wide).floor().max(0.0) as i32;
            let to = (to + wide).floor().min(f64::from(width - 1)) as i32;
            for column in from..=to {
                self.touch(column, row, along);
            }
        }
    }

    #[inline(always)]
    fn touch(&mut self, column: i32, row: i32, along: Along<'_>) {
        let (x, y) = (column as usize, row as usize);
        let t = y / TILE * self.columns + x / TILE;
        if !self.is_touched[t] {
            self.is_touched[t] = true;
            self.touched.push(t as u32);
        }
        let value = match along {
            Along::Border => 0.0,
            // A plane goes on beyond its face, so a face is at least as near as its farthest corner.
            Along::Faces(a, far_a, b, far_b) => {
                let (x, y) = (column as f32, row as f32);
                a.at(x, y).max(far_a).min(b.at(x, y).max(far_b))
            }
        };
        let pixel = &mut self.tiles[t].0[y % TILE * TILE + x % TILE];
        *pixel = pixel.min(value);
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
