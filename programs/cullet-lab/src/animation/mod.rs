//! Short films: pictures of one size in few colours, as animated PNG or WebP. The same pictures
//! give the same bytes.

mod apng;
mod bits;
mod colors;
mod matches;
mod prefix;
mod vp8l;
mod webp;

use thiserror::Error;

use colors::Colors;
use cullet_draw::Picture;

/// Pixels along a side of a film at the most: what WebP can say.
pub(crate) const MOST_SIDE: u32 = 16_384;

/// The index that stands for "as in the frame before"; it follows the last colour.
type Index = u8;

/// Why pictures are no film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub(crate) enum AnimationError {
    /// No picture.
    #[error("a film needs at least one frame")]
    Empty,
    /// A picture of another size than the first.
    #[error("frame {frame} is {size:?} pixels large, but the first is {first:?}")]
    Size {
        /// Number of the frame, from 0.
        frame: usize,
        /// Its width and height.
        size: [u32; 2],
        /// Size of the first frame.
        first: [u32; 2],
    },
    /// Pictures without pixels, or too large.
    #[error("a film of {0}x{1} pixels is not between 1x1 and {MOST_SIDE}x{MOST_SIDE}")]
    Side(u32, u32),
    /// Too few or too many colours.
    #[error("{0} colours; a film has 2 to 255")]
    Colors(u32),
    /// Too slow or too fast.
    #[error("{0} frames per second; a film has 1 to 1,000")]
    Rate(u32),
}

/// A film: frames in the colours of one palette, each as long in sight as the next, without end.
#[derive(Clone, Debug)]
pub(crate) struct Animation {
    size: [u32; 2],
    fps: u32,
    palette: Vec<[u8; 3]>,
    /// Palette index of each pixel of each frame, row by row from the top.
    frames: Vec<Vec<Index>>,
}

impl Animation {
    /// A film of these pictures, reduced to at most so many colours, 2 to 255: the fewer, the
    /// smaller its file. Nothing is dithered. Cost: some ten nanoseconds a pixel.
    ///
    /// # Errors
    /// If there is no picture, they are not of one size, or a number is beyond its limits.
    pub(crate) fn new(pictures: &[Picture], fps: u32, colors: u32) -> Result<Self, AnimationError> {
        let first = pictures.first().ok_or(AnimationError::Empty)?;
        let size = [first.width, first.height];
        if !size.iter().all(|side| (1..=MOST_SIDE).contains(side)) {
            return Err(AnimationError::Side(size[0], size[1]));
        }
        if !(2..=255).contains(&colors) {
            return Err(AnimationError::Colors(colors));
        }
        if !(1..=1000).contains(&fps) {
            return Err(AnimationError::Rate(fps));
        }
        let other = (0..).zip(pictures).find(|(_, p)| [p.width, p.height] != size);
        if let Some((frame, p)) = other {
            return Err(AnimationError::Size { frame, size: [p.width, p.height], first: size });
        }
        let colors = Colors::of(pictures, colors as usize);
        let frames = pictures.iter().map(|p| colors.indices(p)).collect();
        Ok(Self { size, fps, palette: colors.palette(), frames })
    }

    /// Width and height in pixels.
    #[must_use]
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// How many frames there are.
    #[must_use]
    pub(crate) fn frame_count(&self) -> usize {
        self.frames.len()
    }

    /// A frame as it is shown.
    ///
    /// # Panics
    /// If there is no such frame.
    #[must_use]
    pub(crate) fn frame(&self, number: usize) -> Picture {
        let rgb = self.frames[number].iter().flat_map(|&i| self.palette[usize::from(i)]).collect();
        Picture { width: self.size[0], height: self.size[1], rgb }
    }

    /// The bytes of an animated PNG, which programs that know no animation show the first frame of.
    #[must_use]
    pub(crate) fn to_apng(&self) -> Vec<u8> {
        apng::write(self)
    }

    /// The bytes of an animated WebP, lossless in its colours. Cost: some hundred nanoseconds a
    /// pixel.
    #[must_use]
    pub(crate) fn to_webp(&self) -> Vec<u8> {
        webp::write(self)
    }

    /// The index of what is left as it was.
    fn clear(&self) -> Index {
        self.palette.len() as Index
    }

    /// From when to when a frame is shown, in milliseconds: rounded so that the whole film keeps
    /// its time.
    fn shown_ms(&self, frame: usize) -> [u32; 2] {
        [frame, frame + 1].map(|n| (n as u64 * 1000 / u64::from(self.fps)) as u32)
    }

    /// The part of a frame that differs from the one before; all of the first. One pixel of a frame
    /// that is the same.
    fn changed(&self, frame: usize) -> Part {
        let [width, height] = self.size;
        let Some(before) = frame.checked_sub(1).map(|n| &self.frames[n]) else {
            return Part { at: [0; 2], size: self.size };
        };
        let now = &self.frames[frame];
        let (mut low, mut high) = ([width, height], [0; 2]);
        for y in 0..height {
            let row = (y * width) as usize..((y + 1) * width) as usize;
            let (old, new) = (&before[row.clone()], &now[row]);
            let Some(first) = old.iter().zip(new).position(|(a, b)| a != b) else { continue };
            let last = old.iter().zip(new).rposition(|(a, b)| a != b).unwrap_or(first);
            low = [low[0].min(first as u32), low[1].min(y)];
            high = [high[0].max(last as u32), y];
        }
        if low[0] > high[0] {
            return Part { at: [0; 2], size: [1; 2] };
        }
        // WebP places parts at even pixels alone.
        let at = low.map(|v| v & !1);
        Part { at, size: [high[0] + 1 - at[0], high[1] + 1 - at[1]] }
    }

    /// The indices of a part of a frame; and the same with all that is as before left clear, where
    /// there is a frame before.
    fn cut(&self, frame: usize, part: &Part) -> (Vec<Index>, Option<Vec<Index>>) {
        let width = self.size[0] as usize;
        let places = || {
            let [x, y] = part.at.map(|v| v as usize);
            let [w, h] = part.size.map(|v| v as usize);
            (y..y + h).flat_map(move |row| row * width + x..row * width + x + w)
        };
        let now = &self.frames[frame];
        let whole = places().map(|at| now[at]).collect();
        let before = frame.checked_sub(1).map(|n| &self.frames[n]);
        let sparse = before.map(|before| {
            places().map(|at| if before[at] == now[at] { self.clear() } else { now[at] }).collect()
        });
        (whole, sparse)
    }
}

/// A rectangle of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Part {
    /// The top left corner.
    at: [u32; 2],
    size: [u32; 2],
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use cullet_draw::picture::palette::{INK, PAPER, SEEN};

    /// A square that goes over paper, on a ground that changes once.
    fn film() -> Vec<Picture> {
        (0..9)
            .map(|n| {
                let mut p = Picture::new(67, 41, if n < 6 { PAPER } else { SEEN });
                p.fill([5 * n, 3 * n], [20, 11], INK, 1.0);
                p.fill([5 * n + 3, 3 * n + 3], [9, 2], [9 * n as u8, 80, 200], 1.0);
                p
            })
            .chain([Picture::new(67, 41, SEEN), Picture::new(67, 41, SEEN)])
            .collect()
    }

    fn shown(a: &Animation) -> Vec<Picture> {
        (0..a.frame_count()).map(|n| a.frame(n)).collect()
    }

    #[test]
    fn few_colours_are_kept_as_they_are() {
        let film = film();
        let a = Animation::new(&film, 12, 64).unwrap();
        assert_eq!(shown(&a), film);
        let reduced = Animation::new(&film, 12, 4).unwrap();
        assert!(reduced.palette.len() <= 4);
        assert_ne!(shown(&reduced), film);
    }

    #[test]
    fn an_animated_webp_is_decoded_to_its_frames() {
        for colors in [4, 17, 64, 255] {
            let a = Animation::new(&film(), 12, colors).unwrap();
            let bytes = a.to_webp();
            assert_eq!(bytes, a.to_webp());
            let mut decoder = image_webp::WebPDecoder::new(Cursor::new(&bytes)).unwrap();
            assert!(decoder.is_animated() && decoder.num_frames() == 11);
            assert_eq!(decoder.dimensions(), (67, 41));
            let has_alpha = decoder.has_alpha();
            let (mut total, mut buffer) = (0, vec![0; decoder.output_buffer_size().unwrap()]);
            for (n, frame) in shown(&a).iter().enumerate() {
                total += decoder.read_frame(&mut buffer).unwrap();
                let rgb: Vec<u8> = match has_alpha {
                    true => buffer.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect(),
                    false => buffer.clone(),
                };
                assert!(rgb == frame.rgb, "frame {n} of {colors} colours");
            }
            assert_eq!(total, 11 * 1000 / 12);
        }
    }

    #[test]
    fn an_animated_png_is_decoded_to_its_frames() {
        let a = Animation::new(&film(), 12, 64).unwrap();
        let bytes = a.to_apng();
        assert_eq!(bytes, a.to_apng());
        let mut decoder = png::Decoder::new(Cursor::new(&bytes));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 11);
        let mut canvas = Picture::new(67, 41, [0; 3]);
        for (n, frame) in shown(&a).iter().enumerate() {
            let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut buffer).unwrap();
            let at = reader.info().frame_control().unwrap();
            let channels = if info.color_type == png::ColorType::Rgba { 4 } else { 3 };
            for y in 0..info.height {
                for x in 0..info.width {
                    let from = y as usize * info.line_size + x as usize * channels;
                    if channels == 4 && buffer[from + 3] == 0 {
                        continue;
                    }
                    let to = ((y + at.y_offset) * 67 + x + at.x_offset) as usize * 3;
                    canvas.rgb[to..to + 3].copy_from_slice(&buffer[from..from + 3]);
                }
            }
            assert!(canvas == *frame, "frame {n}");
        }
    }

    #[test]
    fn what_is_no_film_is_refused() {
        let p = Picture::new(4, 4, PAPER);
        let error = |p: &[Picture], fps, colors| Animation::new(p, fps, colors).unwrap_err();
        assert_eq!(error(&[], 12, 64), AnimationError::Empty);
        assert_eq!(error(&[Picture::default()], 12, 64), AnimationError::Side(0, 0));
        assert_eq!(error(std::slice::from_ref(&p), 0, 64), AnimationError::Rate(0));
        assert_eq!(error(std::slice::from_ref(&p), 12, 256), AnimationError::Colors(256));
        let other = Picture::new(4, 5, PAPER);
        let size = AnimationError::Size { frame: 1, size: [4, 5], first: [4, 4] };
        assert_eq!(error(&[p, other], 12, 64), size);
    }

    #[test]
    fn a_film_keeps_its_time() {
        let a = Animation::new(&film(), 12, 8).unwrap();
        let lengths: Vec<u32> = (0..11).map(|n| a.shown_ms(n)).map(|[a, b]| b - a).collect();
        assert!(lengths.iter().all(|ms| (83..=84).contains(ms)), "{lengths:?}");
        assert_eq!(lengths.iter().sum::<u32>(), 11 * 1000 / 12);
    }
}
