//! Drawing on a picture: what maps and legends need.

use super::Picture;
use super::font::{text_height, text_size, text_width};
use super::palette::{INK, PAPER, mix};
use crate::clip::{Window, line};

impl Picture {
    /// Lays `color` over a pixel, as opaque as `alpha`; outside nothing happens.
    pub fn blend(&mut self, x: i64, y: i64, color: [u8; 3], alpha: f64) {
        if x < 0 || y < 0 || x >= i64::from(self.width) || y >= i64::from(self.height) {
            return;
        }
        let at = (y as usize * self.width as usize + x as usize) * 3;
        let old = [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]];
        self.rgb[at..at + 3].copy_from_slice(&mix(old, color, alpha));
    }

    /// Fills a rectangle from its top left corner.
    pub fn fill(&mut self, [x, y]: [i64; 2], [w, h]: [i64; 2], color: [u8; 3], alpha: f64) {
        let x0 = x.max(0);
        let x1 = (x + w).min(i64::from(self.width));
        for row in y.max(0)..(y + h).min(i64::from(self.height)) {
            for column in x0..x1 {
                self.blend(column, row, color, alpha);
            }
        }
    }

    /// Fills a convex polygon: the pixels whose centres it holds.
    pub fn fill_convex(&mut self, polygon: &[[f64; 2]], color: [u8; 3], alpha: f64) {
        let bounds = |axis: usize| {
            let low = polygon.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
            (low, polygon.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max))
        };
        let (top, bottom) = bounds(1);
        let first = (top - 0.5).ceil().max(0.0) as i64;
        let last = ((bottom - 0.5).floor()).min(f64::from(self.height) - 1.0) as i64;
        for row in first..=last {
            let y = row as f64 + 0.5;
            let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..polygon.len() {
                let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                if (p[1] <= y) != (q[1] <= y) {
                    let x = p[0] + (q[0] - p[0]) * ((y - p[1]) / (q[1] - p[1]));
                    left = left.min(x);
                    right = right.max(x);
                }
            }
            let from = (left - 0.5).ceil().max(0.0) as i64;
            let to = (right - 0.5).floor().min(f64::from(self.width) - 1.0) as i64;
            for column in from..=to {
                self.blend(column, row, color, alpha);
            }
        }
    }

    /// Draws a line `width` pixels thick, with smooth edges.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], width: f64, color: [u8; 3], alpha: f64) {
        let Some((from, to)) = self.clipped(from, to) else { return };
        let d = [to[0] - from[0], to[1] - from[1]];
        let length = d[0].hypot(d[1]).max(1e-9);
        let reach = width * 0.5 + 1.0;
        // The axis along which the line runs: for each step, a few pixels across.
        let (along, across) = if d[0].abs() >= d[1].abs() { (0, 1) } else { (1, 0) };
        let (low, high) = (from[along].min(to[along]), from[along].max(to[along]));
        let slope = d[across] / if d[along] == 0.0 { 1.0 } else { d[along] };
        // At most 45 degrees off the axis.
        let spread = reach * 1.5;
        for step in (low - reach).floor() as i64..=(high + reach).ceil() as i64 {
            let middle = from[across] + (step as f64 + 0.5 - from[along]) * slope;
            for c in (middle - spread).floor() as i64..=(middle + spread).ceil() as i64 {
                let [x, y] = if along == 0 { [step, c] } else { [c, step] };
                let p = [x as f64 + 0.5 - from[0], y as f64 + 0.5 - from[1]];
                let t = ((p[0] * d[0] + p[1] * d[1]) / (length * length)).clamp(0.0, 1.0);
                let distance = (p[0] - d[0] * t).hypot(p[1] - d[1] * t);
                let cover = (width * 0.5 + 0.5 - distance).clamp(0.0, 1.0);
                if cover > 0.0 {
                    self.blend(x, y, color, alpha * cover);
                }
            }
        }
    }

    /// Draws an arrow from `a` to the tip at `b`; nothing if they are one point.
    pub fn arrow(&mut self, a: [f64; 2], b: [f64; 2], width: f64, color: [u8; 3]) {
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = d[0].hypot(d[1]);
        if length < 1e-6 {
            return;
        }
        let head = (4.0 * width + 6.0).min(length);
        let [u, v] = d.map(|v| v / length * head);
        let neck = [b[0] - u, b[1] - v];
        self.line(a, [b[0] - u * 0.7, b[1] - v * 0.7], width, color, 1.0);
        let side = |s: f64| [neck[0] - v * 0.42 * s, neck[1] + u * 0.42 * s];
        self.fill_convex(&[b, side(1.0), side(-1.0)], color, 1.0);
    }

    /// Draws the outline of a polygon.
    pub fn outline(&mut self, polygon: &[[f64; 2]], width: f64, color: [u8; 3], alpha: f64) {
        for i in 0..polygon.len() {
            self.line(polygon[i], polygon[(i + 1) % polygon.len()], width, color, alpha);
        }
    }

    /// The part of a line that lies near the picture: a line to far away is not walked to its end.
    /// `None` also for NaN.
    fn clipped(&self, from: [f64; 2], to: [f64; 2]) -> Option<([f64; 2], [f64; 2])> {
        const ROOM: f64 = 16.0;
        if !from.iter().chain(&to).all(|v| v.is_finite()) {
            return None;
        }
        let high = [self.width, self.height].map(|v| f64::from(v) + ROOM);
        let t = Window::new([-ROOM; 2], high).ok()?.liang_barsky(&from, &to)?;
        Some((line::at(&from, &to, t[0]), line::at(&from, &to, t[1])))
    }
}

/// Lines of a paragraph lie so many ems apart.
pub const LINE: f64 = 1.45;

/// Squares in colours and what they mean, from left to right and in as many rows as it takes
/// between `x` and `right`; `y` is the top of the first. Returns the top of the row after the last.
pub fn keys(
    picture: &mut Picture,
    [x, y]: [i64; 2],
    right: i64,
    size: f64,
    ink: [u8; 3],
    entries: &[([u8; 3], String)],
) -> i64 {
    let step = (size * LINE).round() as i64;
    let mut top = y;
    for row in key_rows(right - x, size, entries) {
        let mut left = x;
        for (color, words) in row {
            let side = text_height(size);
            picture.fill([left, top], [side; 2], mix(*color, INK, 0.45), 1.0);
            picture.fill([left + 1, top + 1], [side - 2; 2], *color, 1.0);
            left += key_indent(size);
            left += picture.text([left, top], words, size, ink) + size as i64;
        }
        top += step;
    }
    top
}

/// Lays a strip with squares in colours and what they mean over the lower edge of a picture, in as
/// many rows as it takes.
pub fn key_strip(picture: &mut Picture, entries: &[([u8; 3], String)]) {
    let size = text_size(picture.width);
    let [wide, high] = [picture.width, picture.height].map(i64::from);
    let room = wide - 2 * STRIP_MARGIN;
    let strip = keys_height(room, size, entries) + STRIP_MARGIN;
    picture.fill([0, high - strip], [wide, strip], PAPER, 0.9);
    let place = [STRIP_MARGIN, high - strip + STRIP_MARGIN / 2 + 1];
    keys(picture, place, wide - STRIP_MARGIN, size, INK, entries);
}

/// Space around the keys of a strip.
const STRIP_MARGIN: i64 = 10;

/// How high so many keys are: the rows, and what lies between them.
pub fn keys_height(room: i64, size: f64, entries: &[([u8; 3], String)]) -> i64 {
    key_rows(room, size, entries).len() as i64 * (size * LINE).round() as i64
}

/// From the left of a key's square to its words.
fn key_indent(size: f64) -> i64 {
    text_height(size) + (size * 0.45) as i64
}

fn key_rows(room: i64, size: f64, entries: &[([u8; 3], String)]) -> Vec<&[([u8; 3], String)]> {
    let (mut rows, mut first, mut wide) = (Vec::new(), 0, 0);
    for (i, (_, words)) in entries.iter().enumerate() {
        let own = key_indent(size) + text_width(words, size);
        if i > first && wide + own > room {
            rows.push(&entries[first..i]);
            (first, wide) = (i, 0);
        }
        wide += own + size as i64;
    }
    if first < entries.len() {
        rows.push(&entries[first..]);
    }
    rows
}

/// A number with a comma between thousands.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

/// The convex hull of some points, counter-clockwise (Andrew, *Another Efficient Algorithm for
/// Convex Hulls in Two Dimensions*, 1979). Points that are not finite are left out.
pub fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut out = Vec::new();
    add_hull(points, &mut Vec::new(), &mut out);
    out
}

/// Appends the [`hull`] of a few points. `sorted` is room for them.
pub(super) fn add_hull(points: &[[f64; 2]], sorted: &mut Vec<[f64; 2]>, out: &mut Vec<[f64; 2]>) {
    sorted.clear();
    for &p in points.iter().filter(|p| p[0].is_finite() && p[1].is_finite()) {
        let is_after = |q: &[f64; 2]| q[0].total_cmp(&p[0]).then(q[1].total_cmp(&p[1])).is_gt();
        let mut at = sorted.len();
        while at > 0 && is_after(&sorted[at - 1]) {
            at -= 1;
        }
        sorted.insert(at, p);
    }
    sorted.dedup();
    if sorted.len() < 3 {
        return out.extend_from_slice(sorted);
    }
    let turn = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let count = sorted.len();
    for pass in 0..2 {
        let start = out.len();
        for i in 0..count {
            let p = sorted[if pass == 0 { i } else { count - 1 - i }];
            while out.len() >= start + 2 && turn(out[out.len() - 2], out[out.len() - 1], p) <= 0.0 {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
    }
}

/// Writes words on a light ground into the top left corner of a picture.
pub fn caption(picture: &mut Picture, words: &str) {
    let size = text_size(picture.width);
    // In a tiny picture, as large as there is room for.
    let room = f64::from(picture.width) - 44.0;
    let size = size.min((size * room / text_width(words, size).max(1) as f64).max(4.0));
    let (wide, high) = (text_width(words, size), text_height(size));
    picture.fill([12, 12], [wide + 20, high + 18], PAPER, 0.9);
    picture.text([22, 21], words, size, INK);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_by_three() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
    }

    #[test]
    fn keys_that_find_no_room_go_into_the_next_row() {
        let entries: Vec<_> = ["one", "two", "three"].map(|w| ([9; 3], w.to_owned())).into();
        assert_eq!(key_rows(1000, 16.0, &entries).len(), 1);
        assert_eq!(key_rows(1, 16.0, &entries).len(), 3);
        assert!(key_rows(1, 16.0, &[]).is_empty());
        let mut p = Picture::new(60, 100, [255; 3]);
        let below = keys(&mut p, [4, 4], 56, 16.0, INK, &entries);
        assert_eq!(below, 4 + keys_height(52, 16.0, &entries));
        let filled = (0..100).filter(|&y| p.pixel(8, y) == [9; 3]).count();
        assert_eq!(filled as i64, 3 * (text_height(16.0) - 2));
    }

    #[test]
    fn hulls_of_squares_and_of_lines() {
        let square = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.5, 0.5], [0.0, 1.0], [0.0, 0.5]];
        assert_eq!(hull(&square), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(hull(&[[2.0, 2.0], [0.0, 0.0], [1.0, 1.0]]), [[0.0, 0.0], [2.0, 2.0]]);
        assert!(hull(&[[f64::NAN, 0.0]]).is_empty());
    }

    #[test]
    fn polygons_fill_the_pixels_whose_centres_they_hold() {
        let mut p = Picture::new(8, 8, [0; 3]);
        p.fill_convex(&[[1.0, 2.0], [5.0, 2.0], [5.0, 6.0], [1.0, 6.0]], [255; 3], 1.0);
        let lit = p.rgb.iter().filter(|v| **v == 255).count() / 3;
        assert_eq!((lit, p.pixel(1, 2), p.pixel(5, 2)), (16, [255; 3], [0; 3]));
    }

    #[test]
    fn lines_from_beyond_the_picture_end_soon() {
        let mut p = Picture::new(20, 20, [0; 3]);
        p.line([-1e12, 10.5], [1e12, 10.5], 1.0, [255; 3], 1.0);
        assert_eq!((p.pixel(3, 10), p.pixel(3, 13)), ([255; 3], [0; 3]));
        p.line([f64::NAN, 0.0], [1.0, 1.0], 1.0, [255; 3], 1.0);
        p.line([50.0, 50.0], [90.0, 60.0], 3.0, [255; 3], 1.0);
    }
}
