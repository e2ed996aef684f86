//! Pictures of frames, of what was culled, and of the cost of drawing.

pub mod canvas;
mod cells;
pub mod font;
mod frozen;
mod hierarchy;
mod highlight;
mod impostor;
mod kinds;
mod layers;
mod levels;
mod map;
mod occlusion;
mod opened;
mod outside;
pub mod palette;
mod scene_fates;
pub mod shaded;
pub mod space;
mod trace;

pub use canvas::{caption, key_strip};
pub use cells::{
    DoorInView, PairShown, PortalWalk, ShownPortal, cells, depth_color, matrix_order, portals,
    pvs_matrix, shown_portals, shut_doors, walk_order,
};
pub use font::text_width;
pub use frozen::FrozenView;
pub use hierarchy::hierarchy;
pub use highlight::Highlight;
pub use impostor::impostor_beside;
pub use kinds::{kinds, kinds_of};
pub use layers::depth_complexity;
pub use levels::{beside, difference, even_levels, levels};
pub use map::top_down;
pub use occlusion::{Culled, hidden, occluders, occlusion_buffer};
pub use opened::{Opening, before_cut, cut_away};
pub use outside::Outlook;
pub use shaded::{even, shaded, shaded_clear, shaded_levels};
pub use trace::Trace;

use std::io;
use std::path::Path;

/// A picture of red, green and blue bytes, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Three bytes a pixel, in sRGB.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// A picture of one colour.
    #[must_use]
    pub fn new(width: u32, height: u32, color: [u8; 3]) -> Self {
        let rgb = color.repeat(width as usize * height as usize);
        Self { width, height, rgb }
    }

    /// The colour of a pixel; black outside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        if x >= self.width || y >= self.height {
            return [0; 3];
        }
        let at = (y as usize * self.width as usize + x as usize) * 3;
        [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]]
    }

    /// The picture at half the size, each pixel the mean of four (in linear light): smooth edges
    /// for a frame rendered at scale 2. An odd last column or row is left out.
    #[must_use]
    pub fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        // A gamma of 2 is near enough to sRGB for a mean of like colours.
        let mean = |at: [usize; 4]| {
            let sum: f64 = at.iter().map(|&i| f64::from(self.rgb[i]).powi(2)).sum();
            (sum / 4.0).sqrt().round() as u8
        };
        let row = self.width as usize * 3;
        let mut rgb = Vec::with_capacity(width as usize * height as usize * 3);
        for y in 0..height as usize {
            for x in 0..width as usize {
                let at = y * 2 * row + x * 6;
                for c in at..at + 3 {
                    rgb.push(mean([c, c + 3, c + row, c + row + 3]));
                }
            }
        }
        Self { width, height, rgb }
    }

    /// The picture averaged down by a whole factor to at most `most` pixels of width.
    #[must_use]
    pub fn shrunk(&self, most: u32) -> Self {
        let factor = self.width.div_ceil(most.max(1)).max(1);
        if factor == 1 {
            return self.clone();
        }
        let (width, height) = ((self.width / factor).max(1), (self.height / factor).max(1));
        let high = factor.min(self.height);
        let n = factor * high;
        let mut rgb = Vec::with_capacity(width as usize * height as usize * 3);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [n / 2; 3];
                for dy in 0..high {
                    let at = ((y * factor + dy) * self.width + x * factor) as usize * 3;
                    for pixel in self.rgb[at..at + factor as usize * 3].as_chunks::<3>().0 {
                        (0..3).for_each(|c| sum[c] += u32::from(pixel[c]));
                    }
                }
                rgb.extend(sum.map(|v| (v / n) as u8));
            }
        }
        Self { width, height, rgb }
    }

    /// The bytes of a PNG file.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        // PNG has no picture without pixels; neither has memory an error to give.
        let written = self.write_png(&mut bytes);
        debug_assert!(written.is_ok() || self.rgb.is_empty(), "{written:?}");
        bytes
    }

    /// Writes a PNG file.
    ///
    /// # Errors
    /// If the file cannot be written, or the picture has no pixel.
    pub fn save_png(&self, path: impl AsRef<Path>) -> io::Result<()> {
        let mut file = io::BufWriter::new(std::fs::File::create(path)?);
        self.write_png(&mut file)?;
        io::Write::flush(&mut file)
    }

    fn write_png(&self, out: impl io::Write) -> io::Result<()> {
        let mut encoder = png::Encoder::new(out, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Balanced);
        let mut writer = encoder.write_header().map_err(io::Error::other)?;
        writer.write_image_data(&self.rgb).map_err(io::Error::other)?;
        writer.finish().map_err(io::Error::other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_leads_back_to_the_picture() {
        let mut p = Picture::new(7, 5, [1, 2, 3]);
        p.rgb[33] = 200;
        let mut reader = png::Decoder::new(io::Cursor::new(p.to_png())).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        assert_eq!((info.width, info.height, rgb), (7, 5, p.rgb));
    }

    #[test]
    fn shrinking_averages_and_keeps_small_pictures() {
        let rgb = vec![0, 0, 0, 100, 100, 100, 200, 200, 200, 100, 100, 100];
        let p = Picture { width: 2, height: 2, rgb };
        assert_eq!(p.shrunk(1), Picture::new(1, 1, [100; 3]));
        assert_eq!(p.shrunk(2), p);
        let flat = Picture { width: 5, height: 1, rgb: vec![7; 15] };
        assert_eq!(flat.shrunk(2), Picture::new(1, 1, [7; 3]));
        assert_eq!(flat.shrunk(3), Picture::new(2, 1, [7; 3]));
    }

    #[test]
    fn halving_takes_means() {
        let p = Picture { width: 3, height: 2, rgb: [vec![9; 9], vec![9; 9]].concat() };
        assert_eq!(p.halved(), Picture::new(1, 1, [9; 3]));
        assert_eq!(Picture::default().halved(), Picture::default());
    }
}
