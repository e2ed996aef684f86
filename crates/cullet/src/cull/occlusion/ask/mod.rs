//! Asking the buffer what is hidden: one thing in f64, which is the oracle, or a batch of boxes in f32.

mod batch;
mod lens;
mod nearest;

pub(crate) use batch::Asker;
pub(super) use batch::covered;
pub(super) use lens::{Lens, Rectangles};
pub(crate) use nearest::Nearest;

use super::buffer::{OcclusionBuffer, TILE};
use super::tile::Tiles;
use crate::bounds::Aabb;

/// What a buffer says of a thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It reaches no pixel of the buffer: it is out of the view.
    Outside,
    /// A pixel that it may touch is open to it, or nobody can tell: it crosses the near plane, or is not finite.
    Visible,
    /// Everything of it that is in the view lies behind what is proved to be covered.
    Hidden,
}

/// Pixels that a thing may touch, and how near it comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// First column and row, inclusive.
    pub min: [u32; 2],
    /// Last column and row, inclusive.
    pub max: [u32; 2],
    /// No point of it is nearer; see [`OcclusionBuffer::nearness`].
    pub nearness: f32,
}

impl Footprint {
    /// How many pixels it has.
    #[must_use]
    pub fn pixels(&self) -> f32 {
        (0..2).map(|a| (self.max[a] - self.min[a] + 1) as f32).product()
    }
}

impl OcclusionBuffer {
    /// Whether a box, given relative to the buffer's origin, is hidden. NaN and infinite boxes are visible, and
    /// so is everything before [`begin`](Self::begin); an empty box is outside.
    #[must_use]
    pub fn ask_box(&self, b: &Aabb) -> Verdict {
        if b.is_empty() {
            return Verdict::Outside;
        }
        self.ask_corners(&b.corners().map(|c| c.map(f64::from)))
    }

    /// As [`ask_box`](Self::ask_box), for the convex hull of any points.
    #[must_use]
    pub fn ask_corners(&self, corners: &[[f64; 3]]) -> Verdict {
        match self.footprint(corners) {
            Ok(Some(footprint)) => {
                if self.covers(&footprint) {
                    Verdict::Hidden
                } else {
                    Verdict::Visible
                }
            }
            Ok(None) => Verdict::Outside,
            Err(Unbounded) => Verdict::Visible,
        }
    }

    /// The pixels that a box may touch, given relative to the buffer's origin; `None` where it reaches none, crosses
    /// the near plane or is not finite.
    #[must_use]
    pub fn footprint_of(&self, b: &Aabb) -> Option<Footprint> {
        if b.is_empty() {
            return None;
        }
        self.footprint(&b.corners().map(|c| c.map(f64::from))).ok().flatten()
    }

    /// The pixels that the convex hull of points may touch; `None` where it reaches none.
    fn footprint(&self, corners: &[[f64; 3]]) -> Result<Option<Footprint>, Unbounded> {
        let Some(screen) = &self.screen else { return Err(Unbounded) };
        let rows = screen.rows();
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut nearest = f64::NEG_INFINITY;
        let (mut crosses, mut behind) = (false, true);
        for p in corners {
            let sum = |r: [f64; 4]| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3];
            let error = |r: [f64; 4]| {
                let size =
                    (r[0] * p[0]).abs() + (r[1] * p[1]).abs() + (r[2] * p[2]).abs() + r[3].abs();
                size * 32.0 * f64::EPSILON
            };
            let [x, y, nearness, near, w] = rows.map(sum);
            let [ex, ey, en, enear, ew] = rows.map(error);
            // A NaN fails both.
            if !(near >= -enear && w > 2.0 * ew) {
                crosses = true;
                behind &= near < -enear;
                continue;
            }
            behind = false;
            let low = w - ew;
            let off =
                |value: f64, error: f64| (error + value.abs() * ew) / low + value.abs() * 1e-15;
            for (axis, (value, error)) in [(x / w, ex), (y / w, ey)].into_iter().enumerate() {
                let off = off(value, error);
                min[axis] = min[axis].min(value - off);
                max[axis] = max[axis].max(value + off);
            }
            let value = nearness / w;
            nearest = nearest.max(value + off(value, en));
        }
        if crosses {
            return if behind { Ok(None) } else { Err(Unbounded) };
        }
        if !(min.iter().chain(&max).all(|v| v.is_finite()) && nearest.is_finite()) {
            return Err(Unbounded);
        }
        let size = self.size.map(f64::from);
        if (0..2).any(|a| max[a] < 0.0 || min[a] > size[a]) {
            return Ok(None);
        }
        let pixel = |v: f64, a: usize| v.floor().clamp(0.0, size[a] - 1.0) as u32;
        Ok(Some(Footprint {
            min: std::array::from_fn(|a| pixel(min[a], a)),
            max: std::array::from_fn(|a| pixel(max[a], a)),
            nearness: (nearest as f32).next_up(),
        }))
    }

    /// Whether every pixel of a footprint is covered by what is nearer.
    #[must_use]
    pub fn covers(&self, footprint: &Footprint) -> bool {
        self.first_open(footprint).is_none()
    }

    /// The first pixel that lets a footprint through, tile by tile; `None` where it is covered.
    #[must_use]
    pub fn first_open(&self, footprint: &Footprint) -> Option<[u32; 2]> {
        let max = [0, 1].map(|a| footprint.max[a].min(self.size[a] - 1));
        self.as_tiles().first_open(&Footprint { max, ..*footprint })
    }
}

impl Tiles<'_> {
    /// The first pixel of these tiles that lets a footprint through, which lies in the buffer.
    pub(super) fn first_open(&self, footprint: &Footprint) -> Option<[u32; 2]> {
        let Footprint { min, max, nearness } = *footprint;
        let tile = TILE as u32;
        let [first, end] = self.rows.map(|r| r as u32);
        for tile_row in (min[1] / tile).max(first)..=(max[1] / tile).min(end - 1) {
            for column in min[0] / tile..=max[0] / tile {
                let t = (tile_row - first) as usize * self.columns + column as usize;
                if self.far[t] > nearness {
                    continue;
                }
                let (x0, y0) = (column * tile, tile_row * tile);
                for y in min[1].max(y0)..=max[1].min(y0 + tile - 1) {
                    for x in min[0].max(x0)..=max[0].min(x0 + tile - 1) {
                        let at = [(x - x0) as usize, (y - y0) as usize];
                        let pixel = self.tiles[t].pixel(self.live[t], at[0], at[1]);
                        // A NaN nearness lets everything through.
                        let is_nearer = pixel > nearness;
                        if !is_nearer {
                            return Some([x, y]);
                        }
                    }
                }
            }
        }
        None
    }
}

/// A thing whose projection has no bounds.
#[derive(Clone, Copy, Debug)]
struct Unbounded;
