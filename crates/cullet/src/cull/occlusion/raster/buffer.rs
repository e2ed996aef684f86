//! The buffer: blocks of pixels, each with the nearness of what is proved to cover all of it.

use alloc::vec;
use alloc::vec::Vec;

use super::super::OcclusionError;
use super::blocks::{BLOCK, Block, Blocks, BlocksMut, Pixels};
use super::canvas::{Canvas, Pen};
use super::screen::Screen;
use super::steps::Scale;
use crate::array::Each;
use crate::view::View;

/// Proof of what is hidden, pixel by pixel.
///
/// A pixel holds a *nearness*: all of the pixel, as a closed square of the image plane and not
/// merely its middle, is covered by occluders that are at least that near. 0 is a pixel of which
/// some point may be open. What is everywhere farther than the pixels that it can touch is hidden,
/// at every resolution and from every sample.
///
/// Nearness is kept in sixteen bits, rounded down: in perspective to 1/2048 of itself, in parallel
/// views to 1/65,536 of the depth range. Tiles of 8 × 4 pixels keep the least of their pixels, at
/// which most tests end. Clearing touches two bytes and a bit a tile.
#[derive(Clone, Debug)]
pub struct OcclusionBuffer {
    size: [u32; 2],
    /// Blocks in a row.
    columns: usize,
    blocks: Vec<Block>,
    /// Masks, one per block, of the tiles that have a number for each pixel.
    parted: Vec<u8>,
    pixels: Vec<Pixels>,
    screen: Option<Screen>,
    origin: [f64; 3],
    pen: Pen,
    /// Pens of the bands but the first.
    more: Vec<Pen>,
}

impl OcclusionBuffer {
    /// The longest edge that a buffer may have.
    pub const LIMIT: u32 = 4096;

    /// A buffer of `size` pixels, which need not be a multiple of anything, nor that of the view.
    /// It is empty: nothing is hidden. Half or a quarter of the view's resolution proves nearly as
    /// much.
    ///
    /// # Errors
    /// [`OcclusionError::Size`] where it has no pixel, or an edge beyond [`LIMIT`](Self::LIMIT).
    pub fn new(size: [u32; 2]) -> Result<Self, OcclusionError> {
        if size.iter().any(|&s| s == 0 || s > Self::LIMIT) {
            return Err(OcclusionError::Size(size[0], size[1], Self::LIMIT));
        }
        let [columns, rows] = [0, 1].each(|a| (size[a] as usize).div_ceil(BLOCK[a]));
        Ok(Self {
            size,
            columns,
            blocks: vec![Block::default(); columns * rows],
            parted: vec![0; columns * rows],
            pixels: vec![Pixels::BLANK; columns * rows * 8],
            screen: None,
            origin: [0.0; 3],
            pen: Pen::new(columns, rows),
            more: Vec::new(),
        })
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Empties the buffer and turns it to a view. What is tested later is given relative to
    /// `origin`.
    pub fn begin(&mut self, view: &View, origin: [f64; 3]) {
        self.blocks.fill(Block::default());
        self.parted.fill(0);
        let rows = self.block_rows();
        let ([width, height], [across, down]) = (self.size.each(|s| s as usize), BLOCK);
        // What is not there never counts as open.
        if width % across != 0 {
            (0..rows).for_each(|row| self.fill_beyond([self.columns - 1, row]));
        }
        if height % down != 0 {
            (0..self.columns).for_each(|column| self.fill_beyond([column, rows - 1]));
        }
        self.pen.begin();
        self.more.iter_mut().for_each(Pen::begin);
        self.screen = Some(Screen::new(view, origin, self.size));
        self.origin = origin;
    }

    /// Has the pixels of a block that lie beyond the buffer's edge be infinitely near.
    fn fill_beyond(&mut self, [column, row]: [usize; 2]) {
        let block = row * self.columns + column;
        let size = [0, 1].each(|a| self.size[a] as usize);
        let place = [column * BLOCK[0], row * BLOCK[1]];
        let left = [0, 1].each(|a| size[a].saturating_sub(place[a]).min(BLOCK[a]));
        self.parted[block] =
            self.blocks[block].fill_beyond(&mut self.pixels[block * 8..][..8], left);
    }

    /// The screen of the view that it was turned to last, and what its points are relative to.
    pub(crate) fn screen(&self) -> Option<(&Screen, [f64; 3])> {
        Some((self.screen.as_ref()?, self.origin))
    }

    /// Returns the scale of the view that the buffer was turned to last; that of a parallel view
    /// before any.
    fn scale(&self) -> Scale {
        self.screen.as_ref().map_or(Scale::parallel(), |screen| screen.scale)
    }

    /// All of its blocks.
    #[inline(always)]
    pub(crate) fn read(&self) -> Blocks<'_> {
        Blocks {
            scale: self.scale(),
            columns: self.columns,
            blocks: &self.blocks,
            parted: &self.parted,
            pixels: &self.pixels,
        }
    }

    /// All that drawing needs of it.
    #[inline(always)]
    pub(crate) fn canvas(&mut self) -> Canvas<'_> {
        Canvas {
            target: BlocksMut {
                size: self.size,
                scale: self.scale(),
                columns: self.columns,
                rows: 0..self.blocks.len() / self.columns,
                blocks: &mut self.blocks,
                parted: &mut self.parted,
                pixels: &mut self.pixels,
            },
            screen: self.screen.as_ref(),
            origin: self.origin,
            nearest: f32::INFINITY,
            pen: &mut self.pen,
        }
    }

    /// Rows of blocks.
    pub(crate) fn block_rows(&self) -> usize {
        self.blocks.len() / self.columns
    }

    /// Canvases of bands, one below the other, that end at these rows of blocks: they ascend, and
    /// the last is the number of rows. Drawing onto each draws what drawing onto the whole does.
    pub(crate) fn bands(&mut self, ends: &[usize]) -> impl Iterator<Item = Canvas<'_>> {
        let (columns, size, scale) = (self.columns, self.size, self.scale());
        while self.more.len() + 1 < ends.len() {
            self.more.push(Pen::new(columns, self.blocks.len() / columns));
        }
        let (screen, origin) = (self.screen.as_ref(), self.origin);
        let mut rest = (&mut self.blocks[..], &mut self.parted[..], &mut self.pixels[..]);
        let pens = core::iter::once(&mut self.pen).chain(&mut self.more);
        let mut first = 0;
        ends.iter().zip(pens).map(move |(&end, pen)| {
            let count = (end - first) * columns;
            let (blocks, parted, pixels) = core::mem::take(&mut rest);
            let (blocks, parted, pixels) = (
                blocks.split_at_mut(count),
                parted.split_at_mut(count),
                pixels.split_at_mut(count * 8),
            );
            rest = (blocks.1, parted.1, pixels.1);
            let rows = first..end;
            first = end;
            let target = BlocksMut {
                size,
                scale,
                columns,
                rows,
                blocks: blocks.0,
                parted: parted.0,
                pixels: pixels.0,
            };
            Canvas { target, screen, origin, nearest: f32::INFINITY, pen }
        })
    }

    /// The nearness that covers all of a pixel, counted from the top left; 0 where none is proved,
    /// and beyond the buffer. Larger is nearer: 1 / w in perspective.
    #[must_use]
    pub fn nearness(&self, x: u32, y: u32) -> f32 {
        if x >= self.size[0] || y >= self.size[1] {
            return 0.0;
        }
        let all = self.read();
        all.scale.nearness(all.pixel(x as usize, y as usize))
    }

    /// The least nearness of the tile of 8 × 4 pixels around one: the coarser level of the buffer.
    #[must_use]
    pub fn tile_nearness(&self, x: u32, y: u32) -> f32 {
        if x >= self.size[0] || y >= self.size[1] {
            return 0.0;
        }
        let all = self.read();
        all.scale.nearness(all.least_around(x as usize, y as usize))
    }

    /// Whether a pixel lets through what is as near as given.
    pub(crate) fn lets_through(&self, x: u32, y: u32, nearness: f32) -> bool {
        let all = self.read();
        all.pixel(x as usize, y as usize) <= all.scale.of_tested(nearness)
    }
}
