//! Bands: rows of tiles of a buffer, each drawn by itself.
//!
//! What covers a pixel depends on no other pixel, so a buffer can be drawn band by band, on as many threads,
//! with the same result to the last bit; and what is hidden in its band need not be drawn there, which threads
//! with a buffer each would not know of one another.

use super::body::Places;
use super::buffer::{OcclusionBuffer, TILE};
use super::fringe::Fringe;
use super::outline::Outline;
use super::screen::{Clip, ObjectScreen, Screen};
use super::surface::Surface;
use super::tile::{Held, Tile, Tiles};
use crate::transform::Transform;

/// Rows of tiles of an [`OcclusionBuffer`], all or some of them, into which occluders are drawn: of each only
/// the part that lies in these rows.
#[derive(Debug)]
pub struct Band<'a> {
    /// That of the whole buffer, in pixels.
    pub(super) size: [u32; 2],
    pub(super) columns: usize,
    /// The first of its rows of tiles, and the one beyond the last.
    pub(super) rows: [usize; 2],
    pub(super) tiles: &'a mut [Tile],
    pub(super) far: &'a mut [f32],
    pub(super) live: &'a mut [Held],
    pub(super) screen: Option<&'a Screen>,
    pub(super) origin: [f64; 3],
    pub(super) pen: &'a mut Pen,
}

/// What drawing keeps for its memory, and what it knows of the shape before.
#[derive(Clone, Debug)]
pub(super) struct Pen {
    /// A sheet for each side that faces show.
    pub(super) fringes: [Fringe; 2],
    pub(super) outline: Outline,
    pub(super) clips: Vec<Clip>,
    pub(super) surface: Surface,
    pub(super) places: Vec<Places>,
    /// The screen of the object that was drawn last: many shapes may stand as one object.
    pub(super) object: Option<(Transform, ObjectScreen)>,
}

impl Pen {
    /// One for a buffer of so many columns and rows of tiles.
    pub(super) fn new(columns: usize, rows: usize) -> Self {
        Self {
            fringes: [Fringe::new(columns, rows), Fringe::new(columns, rows)],
            outline: Outline::default(),
            clips: Vec::new(),
            surface: Surface::default(),
            places: Vec::new(),
            object: None,
        }
    }
}

impl Band<'_> {
    /// Its tiles, to be read.
    #[inline(always)]
    pub(super) fn as_tiles(&self) -> Tiles<'_> {
        Tiles {
            columns: self.columns,
            rows: self.rows,
            tiles: self.tiles,
            far: self.far,
            live: self.live,
        }
    }

    /// Its first and its last row of pixels.
    pub(super) fn pixel_rows(&self) -> [usize; 2] {
        [self.rows[0] * TILE, self.rows[1] * TILE - 1]
    }
}

impl OcclusionBuffer {
    /// All of it as one band.
    #[inline(always)]
    pub(super) fn band(&mut self) -> Band<'_> {
        Band {
            size: self.size,
            columns: self.columns,
            rows: [0, self.tiles.len() / self.columns],
            tiles: &mut self.tiles,
            far: &mut self.far,
            live: &mut self.live,
            screen: self.screen.as_ref(),
            origin: self.origin,
            pen: &mut self.pens[0],
        }
    }

    /// Its bands between rows of tiles; `ends` ascend from above 0 to the number of all rows.
    pub(super) fn bands(&mut self, ends: &[usize]) -> Vec<Band<'_>> {
        let rows = self.tiles.len() / self.columns;
        while self.pens.len() < ends.len() {
            self.pens.push(Pen::new(self.columns, rows));
        }
        let (mut tiles, mut far, mut live) =
            (&mut self.tiles[..], &mut self.far[..], &mut self.live[..]);
        let (mut first, mut bands) = (0, Vec::with_capacity(ends.len()));
        for (&end, pen) in ends.iter().zip(&mut self.pens) {
            let count = (end - first) * self.columns;
            bands.push(Band {
                size: self.size,
                columns: self.columns,
                rows: [first, end],
                tiles: tiles.split_off_mut(..count).unwrap_or_default(),
                far: far.split_off_mut(..count).unwrap_or_default(),
                live: live.split_off_mut(..count).unwrap_or_default(),
                screen: self.screen.as_ref(),
                origin: self.origin,
                pen,
            });
            first = end;
        }
        bands
    }
}
