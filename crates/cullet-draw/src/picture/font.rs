//! Text in pictures: Open Sans, which lies in `fonts/` with its licence.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, Glyph, PxScale, point};

use super::Picture;

/// The height of a capital letter, in ems.
const CAPITALS: f64 = 0.714;
/// Places between two pixels at which letters may stand: their gaps are even, yet few forms of each
/// occur.
const PLACES: f32 = 4.0;

/// The font of all pictures.
fn font() -> &'static FontRef<'static> {
    static FONT: OnceLock<FontRef<'static>> = OnceLock::new();
    FONT.get_or_init(|| {
        let bytes = include_bytes!("../../fonts/OpenSans-Regular.ttf");
        FontRef::try_from_slice(bytes).expect("the font of the source tree is one")
    })
}

/// The letters of a line that begins at 0, in ems of `size` pixels, and how wide the line is.
fn lay_out(text: &str, size: f64) -> (Vec<Glyph>, f32) {
    let font = font();
    let per_em = font.units_per_em().unwrap_or(1000.0);
    let unit = size as f32 / per_em;
    // The library means the height of a line by a scale, not an em.
    let scale = PxScale::from(font.height_unscaled() * unit);
    let (mut x, mut last) = (0.0, None);
    let mut glyphs = Vec::with_capacity(text.len());
    for c in text.chars() {
        let id = font.glyph_id(c);
        if let Some(last) = last {
            x += font.kern_unscaled(last, id) * unit;
        }
        glyphs.push(id.with_scale_and_position(scale, point(x, 0.0)));
        x += font.h_advance_unscaled(id) * unit;
        last = Some(id);
    }
    (glyphs, x)
}

/// How many pixels wide a line of text is, in ems of `size` pixels; rounded up.
#[must_use]
pub fn text_width(text: &str, size: f64) -> i64 {
    lay_out(text, size).1.ceil() as i64
}

/// How many pixels high the capital letters of a text are; rounded.
pub fn text_height(size: f64) -> i64 {
    (size * CAPITALS).round() as i64
}

/// The size of text in a picture of that width, in pixels an em. On a page 1,000 pixels wide that
/// shows the picture shrunk to its own width, it is 13 at the least.
pub fn text_size(width: u32) -> f64 {
    (f64::from(width) / 68.0).clamp(13.0, 20.0)
}

impl Picture {
    /// Writes one line of text in ems of `size` pixels, `x` at its left end and `y` at the top of
    /// its capital letters; returns its width. Letters that the font has not (it has those of
    /// Latin-1, and some signs) are drawn as a box.
    pub fn text(&mut self, [x, y]: [i64; 2], text: &str, size: f64, color: [u8; 3]) -> i64 {
        let (glyphs, width) = lay_out(text, size);
        let baseline = y + text_height(size);
        for mut glyph in glyphs {
            let place = (glyph.position.x * PLACES).round() / PLACES;
            let whole = place.floor();
            glyph.position.x = place - whole;
            let Some(outline) = font().outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            let (left, top) = (x + (whole + corner.x) as i64, baseline + corner.y as i64);
            outline.draw(|column, row, cover| {
                let cover = f64::from(cover).clamp(0.0, 1.0);
                self.blend(left + i64::from(column), top + i64::from(row), color, cover);
            });
        }
        width.ceil() as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows and columns that a text darkens, as first and last of each.
    fn ink(text: &str, size: f64) -> [u32; 4] {
        let mut p = Picture::new(200, 80, [255; 3]);
        p.text([10, 20], text, size, [0; 3]);
        let dark = |x: u32, y: u32| p.pixel(x, y)[0] < 128;
        let rows: Vec<u32> = (0..80).filter(|&y| (0..200).any(|x| dark(x, y))).collect();
        let columns: Vec<u32> = (0..200).filter(|&x| (0..80).any(|y| dark(x, y))).collect();
        [rows[0], rows[rows.len() - 1], columns[0], columns[columns.len() - 1]]
    }

    #[test]
    fn letters_that_descend_go_below_the_line() {
        let size = 28.0;
        let line = 20 + text_height(size) as u32;
        let [top, bottom, ..] = ink("HE", size);
        assert_eq!((top, bottom), (20, line - 1));
        for text in ["p", "q", "g", "y", "j"] {
            assert!(ink(text, size)[1] > line + 3, "{text}");
        }
    }

    #[test]
    fn a_text_is_as_wide_as_it_says() {
        for (text, size) in [("proved, as near as it is", 14.0), ("90.0° × 2 ≤ 3 – ²", 18.0)]
        {
            let [.., left, right] = ink(text, size);
            let width = text_width(text, size);
            let inked = i64::from(right - left);
            assert!((width - 4..=width).contains(&inked), "{text}: {inked} of {width}");
        }
        assert_eq!((text_width("", 20.0), text_width("H", 0.0)), (0, 0));
    }

    #[test]
    fn pairs_are_kerned_and_figures_are_of_one_width() {
        let wide = |text: &str| lay_out(text, 100.0).1;
        assert!(wide("AV") < wide("A") + wide("V") - 1.0);
        assert!("123456789".chars().all(|c| wide(&c.to_string()) == wide("0")));
    }

    #[test]
    fn the_font_has_the_letters_of_the_captions() {
        for c in (' '..='~').chain("£×–—°²³≤≥−±·½…’“”éü".chars()) {
            assert_ne!(font().glyph_id(c).0, 0, "{c}");
        }
    }
}
