//! The buffer: tiles of pixels, each with the nearness of what is proved to cover all of it.

use super::super::OcclusionError;
use super::band::{Band, Pen};
use super::bounds::Rectangles;
use super::screen::Screen;
use super::tile::{Held, TILE, Tile};
use super::tiles::{Tiles, TilesMut};
use crate::view::View;

/// Proof of what is hidden, pixel by pixel.
///
/// A pixel holds a *nearness*: all of the pixel, as a closed square of the image plane and not merely its middle, is
/// covered by occluders that are at least that near. 0 is a pixel of which some point may be open. What is
/// everywhere farther than the pixels that it can touch is hidden, at every resolution and from every sample.
///
/// Tiles of 8 × 8 pixels keep the least of their pixels, at which most tests end. Clearing touches one
/// number a tile.
#[derive(Clone, Debug)]
pub struct OcclusionBuffer {
    size: [u32; 2],
    /// Tiles in a row.
    columns: usize,
    tiles: Vec<Tile>,
    /// The least of the pixels of each tile.
    far: Vec<f32>,
    /// Contents of each tile, of this frame.
    held: Vec<Held>,
    screen: Option<Screen>,
    origin: [f64; 3],
    /// One for each band that was drawn at a time, and at least one.
    pens: Vec<Pen>,
    /// Memory of drawing lists of occluders.
    pub(crate) rectangles: Vec<Rectangles>,
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
            held: vec![Held::Nothing; columns * rows],
            screen: None,
            origin: [0.0; 3],
            pens: vec![Pen::new(columns, rows)],
            rectangles: Vec::new(),
        })
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Empties the buffer and turns it to a view. What is tested later is given relative to `origin`.
    pub fn begin(&mut self, view: &View, origin: [f64; 3]) {
        self.far.fill(0.0);
        self.held.fill(Held::Nothing);
        self.pens.iter_mut().for_each(|p| p.object = None);
        self.screen = Some(Screen::new(view, origin, self.size));
        self.origin = origin;
    }

    /// The screen of the view that it was turned to last, and what its points are relative to.
    pub(crate) fn screen(&self) -> Option<(&Screen, [f64; 3])> {
        Some((self.screen.as_ref()?, self.origin))
    }

    /// Tiles in a row, and rows of them.
    pub(crate) fn tile_counts(&self) -> [usize; 2] {
        [self.columns, self.tiles.len() / self.columns]
    }

    /// All of its tiles.
    #[inline(always)]
    pub(crate) fn read(&self) -> Tiles<'_> {
        Tiles {
            columns: self.columns,
            rows: [0, self.tiles.len() / self.columns],
            tiles: &self.tiles,
            far: &self.far,
            held: &self.held,
        }
    }

    /// All of it as one band, to draw into.
    #[inline(always)]
    pub fn band(&mut self) -> Band<'_> {
        Band {
            target: TilesMut {
                size: self.size,
                columns: self.columns,
                rows: [0, self.tiles.len() / self.columns],
                tiles: &mut self.tiles,
                far: &mut self.far,
                held: &mut self.held,
            },
            screen: self.screen.as_ref(),
            origin: self.origin,
            pen: &mut self.pens[0],
        }
    }

    /// Its bands between rows of tiles; `ends` ascend from above 0 to the number of all rows.
    pub(crate) fn bands(&mut self, ends: &[usize]) -> Vec<Band<'_>> {
        let rows = self.tiles.len() / self.columns;
        while self.pens.len() < ends.len() {
            self.pens.push(Pen::new(self.columns, rows));
        }
        let (mut tiles, mut far, mut held) =
            (&mut self.tiles[..], &mut self.far[..], &mut self.held[..]);
        let (mut first, mut bands) = (0, Vec::with_capacity(ends.len()));
        for (&end, pen) in ends.iter().zip(&mut self.pens) {
            let count = (end - first) * self.columns;
            let target = TilesMut {
                size: self.size,
                columns: self.columns,
                rows: [first, end],
                tiles: tiles.split_off_mut(..count).unwrap_or_default(),
                far: far.split_off_mut(..count).unwrap_or_default(),
                held: held.split_off_mut(..count).unwrap_or_default(),
            };
            bands.push(Band { target, screen: self.screen.as_ref(), origin: self.origin, pen });
            first = end;
        }
        bands
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
        self.tiles[tile].pixel(self.held[tile], x % TILE, y % TILE)
    }

    /// The least nearness of each tile, row by row, and how many tiles there are in a row: the coarser
    /// level of the buffer.
    #[must_use]
    pub fn tiles(&self) -> (&[f32], usize) {
        (&self.far, self.columns)
    }
}
