//! Clipping in the plane: outcodes, and a polygon cut side by side.

use cullet_draw::clip::{Clipper, Region, Window, line};

use super::sheet::Sheet;
use super::{KEPT, OUTSIDE};
use cullet_draw::Picture;
use cullet_draw::picture::font::{text_height, text_width};
use cullet_draw::picture::palette::{INK, PAPER, PROVED, SUBJECT, UNSEEN, mix};

/// The window of both diagrams.
const LOW: [f64; 2] = [-1.0, -1.0];
const HIGH: [f64; 2] = [1.0, 1.0];

fn window() -> Option<Window<f64, 2>> {
    Window::new(LOW, HIGH).ok()
}

/// The codes as they are written: top, bottom, right, left.
fn digits(code: u32) -> String {
    format!("{code:04b}")
}

/// Colour of a primitive by the result of its test: `left` says whether clipping leaves any of it.
fn result_color(codes: &[u32], left: bool) -> [u8; 3] {
    let (and, or) = codes.iter().fold((u32::MAX, 0), |(and, or), c| (and & c, or | c));
    match (or, and, left) {
        (0, _, _) => PROVED,
        (_, 1.., _) => OUTSIDE,
        (_, _, true) => SUBJECT,
        _ => UNSEEN,
    }
}

/// Lines for the outcodes: accepted, candidates, rejected and false positives.
const LINES: [[[f64; 2]; 2]; 7] = [
    [[-0.7, 0.35], [0.2, 0.6]],
    [[-1.7, 0.1], [-0.1, -0.75]],
    [[-0.1, 1.5], [0.8, -1.5]],
    [[-1.75, 1.1], [-0.75, 1.5]],
    [[1.12, -1.75], [1.45, -0.2]],
    [[-1.65, -0.4], [-0.75, -1.75]],
    [[0.7, 1.7], [1.65, 0.07]],
];
/// Triangles for them.
const TRIANGLES: [[[f64; 2]; 3]; 5] = [
    [[-0.65, -0.5], [0.1, -0.7], [-0.35, 0.25]],
    [[0.35, -0.35], [1.6, -0.6], [0.75, 0.45]],
    [[-1.5, -1.35], [-0.7, -1.6], [-1.25, -1.85]],
    [[-0.75, 1.2], [0.2, 1.6], [-0.35, 1.3]],
    [[0.6, 1.5], [1.25, 0.85], [1.5, 1.5]],
];

/// A panel of the outcodes: from the plane of the window to the sheet.
struct Panel {
    middle: [f64; 2],
    /// Pixels a unit.
    scale: f64,
    em: f64,
}

impl Panel {
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.middle[0] + x * self.scale, self.middle[1] - y * self.scale]
    }

    /// The top left corner of the code of a region, -1 to 1 to the right and up, and how wide and
    /// high it is: in the region's upper corner away from the window's middle, where no line and no
    /// triangle is drawn.
    fn code(&self, x: i32, y: i32) -> [[f64; 2]; 2] {
        let edge = |v: i32, ends: [f64; 3]| ends[(v + 1) as usize];
        let size = [text_width("0000", self.em) as f64, text_height(self.em) as f64];
        let [px, py] = self.at([edge(x, [-1.95, -1.0, 1.95]), edge(y, [-1.0, 1.0, 1.95])]);
        let left = if x == 1 { px - size[0] - 4.0 } else { px + 8.0 };
        [[left, py + 8.0], size]
    }
}

/// The nine regions around a window with their outcodes, and lines and triangles by what the codes
/// of their ends say: accepted, rejected, candidates; those candidates marked that miss the window.
/// Results, codes and what is left are the library's own. `size` is at least 640 × 360.
#[must_use]
pub fn outcodes(size: [u32; 2]) -> Picture {
    let mut sheet = Sheet::new(size);
    let [w, _] = sheet.size();
    let Some(window) = window() else { return sheet.finish() };
    let region = window.region();
    sheet.title("Outcodes: top, bottom, right, left");
    sheet.legend(&[
        (PROVED, "accepted: all codes 0"),
        (OUTSIDE, "rejected: a bit in common"),
        (SUBJECT, "candidate: clipped"),
        (UNSEEN, "candidate that misses"),
    ]);
    let [top, bottom] = sheet.room();
    let em = sheet.text_size();
    let words = em * 1.5;
    let scale = (w * 0.5 - 30.0).min(bottom - top - words) / 4.0;
    for (column, triangles) in [(0.25, false), (0.75, true)] {
        let c = [w * column, (top + bottom - words) * 0.5];
        let panel = Panel { middle: c, scale, em };
        let at = |p: [f64; 2]| panel.at(p);
        sheet.fill(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(at), KEPT, 1.0);
        for side in [-1.0, 1.0] {
            let thin = mix(INK, PAPER, 0.5);
            sheet.line(at([side, -1.95]), at([side, 1.95]), 1.0, thin);
            sheet.line(at([-1.95, side]), at([1.95, side]), 1.0, thin);
        }
        for (x, y) in (0..9).map(|i| (i % 3 - 1, i / 3 - 1)) {
            let middle = [x, y].map(|v| f64::from(v) * 1.5);
            sheet.text(panel.code(x, y)[0], digits(window.outcode(&middle)), INK);
        }
        let (mut misses, mut candidates) = (0, 0);
        let mut clipper = Clipper::new();
        if triangles {
            for t in TRIANGLES {
                let codes = t.map(|p| window.outcode(&p));
                let left = clipper.clip(&region, &t).to_vec();
                let color = result_color(&codes, !left.is_empty());
                sheet.fill(&t.map(at), mix(color, PAPER, 0.6), 1.0);
                if !left.is_empty() {
                    let left: Vec<_> = left.into_iter().map(at).collect();
                    sheet.fill(&left, color, 0.8);
                }
                sheet.outline(&t.map(at), 2.0, color);
                candidates += u32::from(color == SUBJECT || color == UNSEEN);
                misses += u32::from(color == UNSEEN);
            }
        } else {
            for [a, b] in LINES {
                let codes = [window.outcode(&a), window.outcode(&b)];
                let left = window.cohen_sutherland(&a, &b);
                let color = result_color(&codes, left.is_some());
                sheet.line(at(a), at(b), 2.0, mix(color, PAPER, 0.2));
                for t in left.into_iter() {
                    let ends = t.map(|t| at(line::at(&a, &b, t)));
                    sheet.line(ends[0], ends[1], 4.5, color);
                }
                for p in [a, b] {
                    sheet.disc(at(p), 4.0, color);
                }
                candidates += u32::from(color == SUBJECT || color == UNSEEN);
                misses += u32::from(color == UNSEEN);
            }
        }
        sheet.outline(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(at), 3.0, INK);
        let kind = if triangles { "triangles" } else { "lines" };
        let words = format!("{kind}: {misses} of {candidates} candidates miss");
        sheet.centred([c[0], bottom - em], words, INK);
    }
    sheet.finish()
}

/// Sutherland & Hodgman, step by step: a polygon, and what is left of it after each of the four
/// sides of a window. Vertices that stay and vertices that a cut makes are told apart. Each step is
/// what the library's clipper leaves. `size` is at least 640 × 360.
#[must_use]
pub fn clip_polygon(size: [u32; 2]) -> Picture {
    const POLYGON: [[f64; 2]; 6] =
        [[-1.55, 0.35], [-0.35, -1.5], [0.75, -1.3], [1.6, 0.3], [0.55, 0.6], [-0.15, 1.65]];
    let mut sheet = Sheet::new(size);
    let [w, _] = sheet.size();
    let Some(window) = window() else { return sheet.finish() };
    let region: Region<f64, 2> = window.region();
    let names = ["the polygon", "left", "right", "bottom", "top", "what is left"];
    sheet.title("Sutherland & Hodgman: one side after another");
    sheet.legend(&[
        (SUBJECT, "kept"),
        (OUTSIDE, "cut off by this side"),
        (INK, "side; vertex that stays"),
        (UNSEEN, "new vertex"),
    ]);
    let [top, bottom] = sheet.room();
    let em = sheet.text_size();
    let (wide, high) = (w / 3.0, (bottom - top) / 2.0);
    let scale = (wide - 20.0).min(high - 1.6 * em) / 3.5;
    let mut polygon = POLYGON.to_vec();
    let mut clipper = Clipper::new();
    for (step, name) in names.into_iter().enumerate() {
        let (column, row) = (step % 3, step / 3);
        let c = [wide * (column as f64 + 0.5), top + high * (row as f64 + 0.5) - 0.8 * em];
        let at = |p: [f64; 2]| [c[0] + p[0] * scale, c[1] - p[1] * scale];
        let before = polygon.clone();
        let cutting = (1..=4).contains(&step);
        if cutting {
            polygon = clipper.clip(&region.clone().only(1 << (step - 1)), &polygon).to_vec();
        }
        sheet.outline(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(at), 1.0, INK);
        if cutting {
            // The part that goes, and the side that cuts it off.
            let gone: Vec<_> = before.iter().map(|&p| at(p)).collect();
            fill_any(&mut sheet, &gone, mix(OUTSIDE, PAPER, 0.25));
            let (axis, sign) = ((step - 1) / 2, if step % 2 == 1 { -1.0 } else { 1.0 });
            let end = |along: f64| {
                let mut p = [along; 2];
                p[axis] = sign;
                at(p)
            };
            sheet.line(end(-1.7), end(1.7), 3.0, INK);
        }
        let points: Vec<_> = polygon.iter().map(|&p| at(p)).collect();
        fill_any(&mut sheet, &points, mix(SUBJECT, PAPER, 0.55));
        sheet.outline(&points, 2.0, SUBJECT);
        for &p in &polygon {
            let new = cutting && !before.contains(&p);
            sheet.disc(at(p), if new { 6.0 } else { 4.0 }, INK);
            if new {
                sheet.disc(at(p), 4.5, UNSEEN);
            }
        }
        let words = if cutting { format!("{step}. {name}") } else { name.to_owned() };
        let count = polygon.len();
        sheet.centred([c[0], c[1] + scale * 1.75 + 2.0], format!("{words}: {count} vertices"), INK);
    }
    sheet.finish()
}

/// Fills a polygon that is star-shaped around its mean.
fn fill_any(sheet: &mut Sheet, points: &[[f64; 2]], color: [u8; 3]) {
    let n = points.len().max(1) as f64;
    let sum = points.iter().fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
    for (i, &p) in points.iter().enumerate() {
        sheet.fill(&[sum.map(|v| v / n), p, points[(i + 1) % points.len()]], color, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_drawn_over_the_codes() {
        // On the smallest sheet, where letters are the largest beside the window.
        let sheet = Sheet::new([0; 2]);
        let [top, bottom] = sheet.room();
        let em = sheet.text_size();
        let scale = (sheet.size()[0] * 0.5 - 30.0).min(bottom - top - em * 1.5) / 4.0;
        let panel = Panel { middle: [0.0; 2], scale, em };
        let shapes: Vec<Vec<[f64; 2]>> =
            LINES.iter().map(|l| l.to_vec()).chain(TRIANGLES.iter().map(|t| t.to_vec())).collect();
        for (x, y) in (0..9).map(|i| (i % 3 - 1, i / 3 - 1)) {
            let [low, size] = panel.code(x, y);
            let label = Window::new(low, [low[0] + size[0], low[1] + size[1]]).unwrap();
            for shape in &shapes {
                let shape: Vec<_> = shape.iter().map(|&p| panel.at(p)).collect();
                let left = Clipper::new().clip(&label.region(), &shape).len();
                let crosses =
                    shape.len() == 2 && label.cohen_sutherland(&shape[0], &shape[1]).is_some();
                assert!(!crosses && (shape.len() == 2 || left == 0), "{x}, {y}: {shape:?}");
            }
        }
    }
}
