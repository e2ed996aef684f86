//! A sheet of paper to draw on: shapes at twice the size first, then text.

use crate::picture::Picture;
use crate::picture::canvas::text_width;
use crate::picture::palette::{INK, PAPER};

/// The smallest sheet on which labels have room.
const LEAST: [u32; 2] = [640, 360];
/// Dots of a label.
const SCALE: u32 = 2;

/// A drawing under way. Coordinates are pixels of the final picture.
pub(super) struct Sheet {
    /// Twice as wide and high: halved, its edges are smooth.
    large: Picture,
    labels: Vec<([f64; 2], String, [u8; 3])>,
}

impl Sheet {
    pub(super) fn new(size: [u32; 2]) -> Self {
        let [w, h] = [size[0].clamp(LEAST[0], 8192), size[1].clamp(LEAST[1], 8192)];
        Self { large: Picture::new(w * 2, h * 2, PAPER), labels: Vec::new() }
    }

    /// Width and height.
    pub(super) fn size(&self) -> [f64; 2] {
        [f64::from(self.large.width / 2), f64::from(self.large.height / 2)]
    }

    /// Puts a picture of twice its size on the sheet, its top left corner at `at`.
    pub(super) fn paste(&mut self, at: [u32; 2], picture: &Picture) {
        for y in 0..picture.height {
            for x in 0..picture.width {
                let to = [i64::from(at[0] * 2 + x), i64::from(at[1] * 2 + y)];
                self.large.blend(to[0], to[1], picture.pixel(x, y), 1.0);
            }
        }
    }

    pub(super) fn fill(&mut self, polygon: &[[f64; 2]], color: [u8; 3], alpha: f64) {
        let large: Vec<_> = polygon.iter().map(|p| p.map(|v| v * 2.0)).collect();
        self.large.fill_convex(&large, color, alpha);
    }

    pub(super) fn line(&mut self, a: [f64; 2], b: [f64; 2], width: f64, color: [u8; 3]) {
        let [a, b] = [a, b].map(|p| p.map(|v| v * 2.0));
        self.large.line(a, b, width * 2.0, color, 1.0);
    }

    pub(super) fn outline(&mut self, polygon: &[[f64; 2]], width: f64, color: [u8; 3]) {
        for (i, &p) in polygon.iter().enumerate() {
            self.line(p, polygon[(i + 1) % polygon.len()], width, color);
        }
    }

    pub(super) fn arrow(&mut self, a: [f64; 2], b: [f64; 2], width: f64, color: [u8; 3]) {
        let [a, b] = [a, b].map(|p| p.map(|v| v * 2.0));
        self.large.arrow(a, b, width * 2.0, color);
    }

    pub(super) fn disc(&mut self, c: [f64; 2], r: f64, color: [u8; 3]) {
        let ring: Vec<_> = (0..40).map(|i| on_circle(c, r, f64::from(i) / 40.0 * 360.0)).collect();
        self.fill(&ring, color, 1.0);
    }

    /// A label with its top left corner at `at`.
    pub(super) fn text(&mut self, at: [f64; 2], text: impl Into<String>, color: [u8; 3]) {
        self.labels.push((at, text.into(), color));
    }

    /// A label centred at `at`.
    pub(super) fn centred(&mut self, at: [f64; 2], text: impl Into<String>, color: [u8; 3]) {
        let text = text.into();
        let width = text_width(&text, SCALE) as f64;
        self.labels.push(([at[0] - width * 0.5, at[1]], text, color));
    }

    /// A row of squares in colours and what they mean, from `at` to the right.
    pub(super) fn legend(&mut self, at: [f64; 2], entries: &[([u8; 3], &str)]) {
        let mut x = at[0];
        for (color, words) in entries {
            let square =
                [[x, at[1]], [x + 14.0, at[1]], [x + 14.0, at[1] + 14.0], [x, at[1] + 14.0]];
            self.fill(&square, *color, 1.0);
            self.outline(&square, 1.0, INK);
            self.text([x + 22.0, at[1]], *words, INK);
            x += 22.0 + text_width(words, SCALE) as f64 + 26.0;
        }
    }

    pub(super) fn finish(self) -> Picture {
        let mut picture = self.large.halved();
        for ([x, y], text, color) in &self.labels {
            picture.text([x.round() as i64, y.round() as i64], text, SCALE, *color);
        }
        picture
    }
}

/// The point of a circle at an angle in degrees, counter-clockwise from the right.
pub(super) fn on_circle(c: [f64; 2], r: f64, degrees: f64) -> [f64; 2] {
    let (s, t) = degrees.to_radians().sin_cos();
    [c[0] + r * t, c[1] - r * s]
}

/// A flat camera for diagrams in space: parallel, so that equal things look equal.
pub(super) struct Flat {
    pub(super) toward: glam::DVec3,
    right: glam::DVec3,
    up: glam::DVec3,
    middle: glam::DVec3,
    at: [f64; 2],
    scale: f64,
}

impl Flat {
    /// Looks against `toward`; `middle` is drawn at `at`, `scale` pixels a unit.
    pub(super) fn new(toward: glam::DVec3, middle: glam::DVec3, at: [f64; 2], scale: f64) -> Self {
        let toward = toward.normalize_or(glam::DVec3::Z);
        let pole = if toward.y.abs() > 0.99 { glam::DVec3::NEG_Z } else { glam::DVec3::Y };
        let right = pole.cross(toward).normalize();
        Self { toward, right, up: toward.cross(right), middle, at, scale }
    }

    pub(super) fn point(&self, p: glam::DVec3) -> [f64; 2] {
        let p = p - self.middle;
        [self.at[0] + p.dot(self.right) * self.scale, self.at[1] - p.dot(self.up) * self.scale]
    }
}
