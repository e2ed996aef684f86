//! The buffer: tiles of pixels, each with the nearness of what is proved to cover all of it.

use thiserror::Error;

use super::band::Pen;
use super::list::Listed;
use super::screen::Screen;
use super::tile::{Held, Tile, Tiles};
use crate::view::View;

/// Pixels along an edge of a tile.
pub const TILE: usize = 8;

/// Why a buffer cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum OcclusionError {
    /// No pixels, or too many.
    #[error("an occlusion buffer of {0}x{1} pixels is not between 1x1 and {2}x{2}")]
    Size(u32, u32, u32),
    /// Buffers of different sizes, or of different views.
    #[error("a buffer of {0}x{1} pixels cannot take in one of {2}x{3}, or of another view")]
    Merge(u32, u32, u32, u32),
}

/// What is proved to be hidden, pixel by pixel.
///
/// A pixel holds a *nearness*: all of the pixel, as a closed square of the image plane and not merely its middle, is
/// covered by occluders that are at least that near. 0 is a pixel of which some point may be open. A thing that is
/// everywhere farther than the pixels that it can touch is hidden, at every resolution and from every sample.
///
/// Tiles of 8 × 8 pixels keep the least of their pixels, which most questions end at. Clearing touches one
/// number a tile.
#[derive(Clone, Debug)]
pub struct OcclusionBuffer {
    pub(super) size: [u32; 2],
    /// Tiles in a row.
    pub(super) columns: usize,
    pub(super) tiles: Vec<Tile>,
    /// The least of the pixels of each tile.
    pub(super) far: Vec<f32>,
    /// What each tile holds of this frame.
    pub(super) live: Vec<Held>,
    pub(super) screen: Option<Screen>,
    pub(super) origin: [f64; 3],
    /// One for each band that was drawn at a time, and at least one.
    pub(super) pens: Vec<Pen>,
    pub(super) listed: Listed,
}

impl OcclusionBuffer {
    /// The longest edge that a buffer may have.
    pub const LIMIT: u32 = 16384;

    /// A buffer of `size` pixels, which need not be a multiple of anything, nor that of the view. It
    /// is empty: nothing is hidden. Half or a quarter of the view's resolution proves nearly as much.
    ///
    /// # Errors
    /// [`OcclusionError::Size`] where it has no pixel, or an edge beyond [`LIMIT`](Self::LIMIT).
    pub fn new(size: [u32; 2]) -> Result<Self, OcclusionError> {
        if size.iter().any(|&s| s == 0 || s > Self::LIMIT) {
            return Err(OcclusionError::Size(size[0], size[1], Self::LIMIT));
        }
        let [columns, rows] = size.map(|s| (s as usize).div_ceil(TILE));
        Ok(Self {
            size,
            columns,
            tiles: vec![Tile::filled(0.0); columns * rows],
            far: vec![0.0; columns * rows],
            live: vec![Held::Nothing; columns * rows],
            screen: None,
            origin: [0.0; 3],
            pens: vec![Pen::new(columns, rows)],
            listed: Listed::default(),
        })
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Empties the buffer and turns it to a view. What is asked about later is given relative to `origin`.
    pub fn begin(&mut self, view: &View, origin: [f64; 3]) {
        self.empty();
        self.screen = Some(Screen::new(view, origin, self.size));
        self.origin = origin;
    }

    /// Nothing is covered.
    pub(super) fn empty(&mut self) {
        self.far.fill(0.0);
        self.live.fill(Held::Nothing);
        self.pens.iter_mut().for_each(|p| p.object = None);
    }

    /// All of its tiles.
    #[inline(always)]
    pub(super) fn as_tiles(&self) -> Tiles<'_> {
        Tiles {
            columns: self.columns,
            rows: [0, self.tiles.len() / self.columns],
            tiles: &self.tiles,
            far: &self.far,
            live: &self.live,
        }
    }

    /// The nearness that covers all of a pixel, counted from the top left; 0 where none is proved, and
    /// beyond the buffer. Larger is nearer: 1 / w in perspective.
    #[must_use]
    pub fn nearness(&self, x: u32, y: u32) -> f32 {
        if x >= self.size[0] || y >= self.size[1] {
            return 0.0;
        }
        let (x, y) = (x as usize, y as usize);
        let tile = y / TILE * self.columns + x / TILE;
        self.tiles[tile].pixel(self.live[tile], x % TILE, y % TILE)
    }

    /// The least nearness of each tile, row by row, and how many tiles there are in a row: the coarser
    /// level of the buffer.
    #[must_use]
    pub fn tiles(&self) -> (&[f32], usize) {
        (&self.far, self.columns)
    }

    /// Takes in what another buffer of the same view proved: of each pixel the nearer proof. Neither the order of
    /// merging nor how occluders were shared out changes the result.
    ///
    /// # Errors
    /// [`OcclusionError::Merge`] where sizes or views differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), OcclusionError> {
        if self.size != other.size || self.screen != other.screen || self.origin != other.origin {
            let ([a, b], [c, d]) = (self.size, other.size);
            return Err(OcclusionError::Merge(a, b, c, d));
        }
        for t in 0..self.tiles.len() {
            if other.live[t] == Held::Nothing {
                continue;
            }
            if self.live[t] != Held::Nothing {
                Self::wake(self.size, self.columns, &mut self.tiles, &mut self.live, t);
                let mut theirs = other.tiles[t];
                if other.live[t] == Held::Planes {
                    theirs.unfold();
                }
                let mut far = f32::INFINITY;
                for (mine, theirs) in self.tiles[t].0.iter_mut().zip(&theirs.0) {
                    // No pixel is NaN.
                    *mine = if *theirs > *mine { *theirs } else { *mine };
                    far = if *mine < far { *mine } else { far };
                }
                self.far[t] = far;
            } else {
                (self.tiles[t], self.far[t]) = (other.tiles[t], other.far[t]);
                self.live[t] = other.live[t];
            }
        }
        Ok(())
    }

    /// Has a tile hold its pixels. Where nothing was, they are 0, and infinitely near beyond the buffer's edge, so that
    /// what is not there never counts as open.
    #[inline(always)]
    pub(super) fn wake(
        size: [u32; 2],
        columns: usize,
        tiles: &mut [Tile],
        live: &mut [Held],
        t: usize,
    ) {
        match std::mem::replace(&mut live[t], Held::Pixels) {
            Held::Nothing => {}
            Held::Pixels => return,
            Held::Planes => return tiles[t].unfold(),
        }
        tiles[t] = Tile::filled(0.0);
        let (x, y) = (t % columns * TILE, t / columns * TILE);
        let [width, height] = size.map(|s| s as usize);
        if x + TILE > width || y + TILE > height {
            for (i, pixel) in tiles[t].0.iter_mut().enumerate() {
                if x + i % TILE >= width || y + i / TILE >= height {
                    *pixel = f32::INFINITY;
                }
            }
        }
    }
}
