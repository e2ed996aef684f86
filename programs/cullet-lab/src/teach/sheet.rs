//! A sheet of paper to draw on: shapes at twice the size first, then text.

use cullet_draw::Picture;
use cullet_draw::picture::canvas::{keys, keys_height};
use cullet_draw::picture::font::text_width;
use cullet_draw::picture::palette::{INK, PAPER};

/// The smallest sheet on which labels have room.
const LEAST: [u32; 2] = [640, 360];
/// A title is so many times the size of a label.
const TITLE: f64 = 1.25;
/// From the edge of the sheet to its legend.
const MARGIN: i64 = 26;

/// A drawing under way. Coordinates are pixels of the final picture.
pub(super) struct Sheet {
    /// Twice as wide and high: halved, its edges are smooth.
    large: Picture,
    labels: Vec<Label>,
    keys: Vec<([u8; 3], String)>,
}

/// Words at a place, in ems of so many pixels.
struct Label {
    at: [f64; 2],
    text: String,
    size: f64,
    color: [u8; 3],
}

impl Sheet {
    pub(super) fn new(size: [u32; 2]) -> Self {
        let [w, h] = [size[0].clamp(LEAST[0], 8192), size[1].clamp(LEAST[1], 8192)];
        let large = Picture::new(w * 2, h * 2, PAPER);
        Self { large, labels: Vec::new(), keys: Vec::new() }
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

    /// Pixels of an em of its labels.
    pub(super) fn text_size(&self) -> f64 {
        (self.size()[0] / 64.0).clamp(15.0, 20.0)
    }

    /// A label, `at` its left end and the top of its capitals.
    pub(super) fn text(&mut self, at: [f64; 2], text: impl Into<String>, color: [u8; 3]) {
        let size = self.text_size();
        self.labels.push(Label { at, text: text.into(), size, color });
    }

    /// A label centred at `at`.
    pub(super) fn centred(&mut self, at: [f64; 2], text: impl Into<String>, color: [u8; 3]) {
        self.centred_in(self.text_size(), at, text.into(), color);
    }

    /// The heading of the sheet.
    pub(super) fn title(&mut self, text: impl Into<String>) {
        let middle = self.size()[0] * 0.5;
        self.centred_in(self.text_size() * TITLE, [middle, 16.0], text.into(), INK);
    }

    fn centred_in(&mut self, size: f64, at: [f64; 2], text: String, color: [u8; 3]) {
        let left = at[0] - text_width(&text, size) as f64 * 0.5;
        self.labels.push(Label { at: [left, at[1]], text, size, color });
    }

    /// The legend along the lower edge: colours and what they mean.
    pub(super) fn legend(&mut self, entries: &[([u8; 3], &str)]) {
        self.keys = entries.iter().map(|(color, words)| (*color, (*words).to_owned())).collect();
    }

    /// From the title down to the legend: the height at which what is drawn begins and that at
    /// which it ends.
    pub(super) fn room(&self) -> [f64; 2] {
        [20.0 + self.text_size() * TITLE * 1.4, self.size()[1] - self.legend_height() - 4.0]
    }

    /// How high the legend is, with room above and below.
    fn legend_height(&self) -> f64 {
        let room = self.size()[0] as i64 - 2 * MARGIN;
        keys_height(room, self.text_size(), &self.keys) as f64 + 14.0
    }

    pub(super) fn finish(self) -> Picture {
        let (size, [w, h]) = (self.text_size(), self.size());
        let top = h - self.legend_height() + 4.0;
        let mut picture = self.large.halved();
        for Label { at: [x, y], text, size, color } in &self.labels {
            picture.text([x.round() as i64, y.round() as i64], text, *size, *color);
        }
        keys(&mut picture, [MARGIN, top as i64], w as i64 - MARGIN, size, INK, &self.keys);
        picture
    }
}

/// The point of a circle at an angle in degrees, counter-clockwise from the right.
pub(super) fn on_circle(c: [f64; 2], r: f64, degrees: f64) -> [f64; 2] {
    let (s, t) = degrees.to_radians().sin_cos();
    [c[0] + r * t, c[1] - r * s]
}

/// A flat camera for diagrams in space: parallel, so that equal lengths look equal.
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
