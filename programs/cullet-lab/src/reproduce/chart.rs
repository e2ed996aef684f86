//! A chart as a list of marks, written as SVG and drawn as PNG: the same layout in both.

use std::fmt::Write;

use cullet_command::html::{escape, hex};
use cullet_draw::picture::text_width;
use cullet_draw::{Picture, palette};

type Color = [u8; 3];
type Point = [f64; 2];

/// Where a text stands from its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    /// To the right of it.
    Start,
    /// Around it.
    Middle,
    /// To the left of it.
    End,
}

#[derive(Clone, Debug)]
enum Mark {
    Band { from: Point, to: Point, color: Color },
    Line { from: Point, to: Point, width: f64, color: Color, dashed: bool },
    Dot { at: Point, radius: f64, color: Color },
    Text { at: Point, text: String, anchor: Anchor, large: bool, color: Color },
}

/// Marks on paper; points are pixels from the top left corner.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    size: [u32; 2],
    title: String,
    marks: Vec<Mark>,
}

/// A rectangle of a chart with a scale along each of its sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plot {
    /// Top left corner, in pixels.
    pub(crate) corner: Point,
    /// Width and height, in pixels.
    pub(crate) size: Point,
    /// The values at its left and right end.
    pub(crate) x: [f64; 2],
    /// The values at its bottom and top.
    pub(crate) y: [f64; 2],
}

impl Plot {
    /// Where a value lies, in pixels.
    pub(crate) fn at(&self, x: f64, y: f64) -> Point {
        let share = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
        [
            self.corner[0] + share(x, self.x) * self.size[0],
            self.corner[1] + (1.0 - share(y, self.y)) * self.size[1],
        ]
    }
}

/// Pixels of an em of text and of a heading, in both forms.
const EM: [f64; 2] = [17.0, 26.0];
/// How far above its baseline the middle of a line of text lies, in ems.
const MIDDLE: f64 = 0.357;

impl Chart {
    /// An empty chart of so many pixels; the title is for those who cannot see it.
    pub(crate) fn new(size: [u32; 2], title: impl Into<String>) -> Self {
        Self { size, title: title.into(), marks: Vec::new() }
    }

    /// A rectangle between two corners, filled.
    pub(crate) fn band(&mut self, from: Point, to: Point, color: Color) {
        self.marks.push(Mark::Band { from, to, color });
    }

    /// A straight line.
    pub(crate) fn line(&mut self, from: Point, to: Point, width: f64, color: Color) {
        self.marks.push(Mark::Line { from, to, width, color, dashed: false });
    }

    /// A dashed straight line.
    pub(crate) fn dashed(&mut self, from: Point, to: Point, width: f64, color: Color) {
        self.marks.push(Mark::Line { from, to, width, color, dashed: true });
    }

    /// A line through points, with a dot on each.
    pub(crate) fn curve(&mut self, points: &[Point], color: Color, dashed: bool) {
        for pair in points.windows(2) {
            self.marks.push(Mark::Line { from: pair[0], to: pair[1], width: 3.0, color, dashed });
        }
        let radius = if dashed { 4.0 } else { 6.0 };
        self.marks.extend(points.iter().map(|&at| Mark::Dot { at, radius, color }));
    }

    /// One line of text, centred on the height of its point.
    pub(crate) fn text(
        &mut self,
        at: Point,
        text: impl Into<String>,
        anchor: Anchor,
        color: Color,
    ) {
        self.marks.push(Mark::Text { at, text: text.into(), anchor, large: false, color });
    }

    /// One line of large text.
    pub(crate) fn heading(&mut self, at: Point, text: impl Into<String>) {
        let (text, color) = (text.into(), palette::INK);
        self.marks.push(Mark::Text { at, text, anchor: Anchor::Start, large: true, color });
    }

    /// The chart as SVG.
    pub(crate) fn to_svg(&self) -> String {
        let [w, h] = self.size;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" \
             height=\"{h}\" role=\"img\" aria-label=\"{}\" font-family=\"Open Sans, sans-serif\">\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
            escape(&self.title),
            hex(palette::PAPER)
        );
        for mark in &self.marks {
            // Writing to a string cannot fail.
            let _ = match mark {
                Mark::Band { from, to, color } => writeln!(
                    svg,
                    "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"/>",
                    from[0].min(to[0]),
                    from[1].min(to[1]),
                    (to[0] - from[0]).abs(),
                    (to[1] - from[1]).abs(),
                    hex(*color)
                ),
                Mark::Line { from, to, width, color, dashed } => writeln!(
                    svg,
                    "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{}\" \
                     stroke-width=\"{width}\"{}/>",
                    from[0],
                    from[1],
                    to[0],
                    to[1],
                    hex(*color),
                    if *dashed { " stroke-dasharray=\"8 6\"" } else { "" }
                ),
                Mark::Dot { at, radius, color } => writeln!(
                    svg,
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\" fill=\"{}\"/>",
                    at[0],
                    at[1],
                    hex(*color)
                ),
                Mark::Text { at, text, anchor, large, color } => writeln!(
                    svg,
                    "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{}\" text-anchor=\"{}\" \
                     dominant-baseline=\"central\" fill=\"{}\">{}</text>",
                    at[0],
                    at[1],
                    EM[usize::from(*large)],
                    match anchor {
                        Anchor::Start => "start",
                        Anchor::Middle => "middle",
                        Anchor::End => "end",
                    },
                    hex(*color),
                    escape(text)
                ),
            };
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// The chart as a picture.
    pub(crate) fn to_picture(&self) -> Picture {
        // Drawn at twice the size and halved, for smooth edges.
        const TWICE: f64 = 2.0;
        let [w, h] = self.size.map(|v| v * 2);
        let mut picture = Picture::new(w, h, palette::PAPER);
        let up = |p: &Point| p.map(|v| v * TWICE);
        for mark in &self.marks {
            match mark {
                Mark::Band { from, to, color } => {
                    let (a, b) = (up(from), up(to));
                    let corner = [a[0].min(b[0]), a[1].min(b[1])].map(|v| v.round() as i64);
                    let size = [(b[0] - a[0]).abs(), (b[1] - a[1]).abs()].map(|v| v.round() as i64);
                    picture.fill(corner, size, *color, 1.0);
                }
                Mark::Line { from, to, width, color, dashed } => {
                    for [a, b] in dashes(up(from), up(to), *dashed) {
                        picture.line(a, b, width * TWICE, *color, 1.0);
                    }
                }
                Mark::Dot { at, radius, color } => {
                    let c = up(at);
                    let round: Vec<Point> = (0..24)
                        .map(|i| (f64::from(i) / 24.0 * std::f64::consts::TAU).sin_cos())
                        .map(|(s, t)| [c[0] + s * radius * TWICE, c[1] + t * radius * TWICE])
                        .collect();
                    picture.fill_convex(&round, *color, 1.0);
                }
                Mark::Text { at, text, anchor, large, color } => {
                    let em = EM[usize::from(*large)] * TWICE;
                    let wide = text_width(text, em) as f64;
                    let left = match anchor {
                        Anchor::Start => 0.0,
                        Anchor::Middle => wide * 0.5,
                        Anchor::End => wide,
                    };
                    let c = up(at);
                    let corner = [c[0] - left, c[1] - em * MIDDLE].map(|v| v.round() as i64);
                    picture.text(corner, text, em, *color);
                }
            }
        }
        picture.halved()
    }
}

/// The segments of a line: itself, or dashes as the SVG has them.
fn dashes(from: Point, to: Point, dashed: bool) -> Vec<[Point; 2]> {
    const ON: f64 = 16.0;
    const STEP: f64 = 28.0;
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    if !dashed || length < STEP {
        return vec![[from, to]];
    }
    let at = |d: f64| {
        let t = (d / length).min(1.0);
        [from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t]
    };
    let steps = (length / STEP).ceil() as u32;
    (0..steps).map(|i| f64::from(i) * STEP).map(|d| [at(d), at(d + ON)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_show_the_same_marks() {
        let mut chart = Chart::new([200, 100], "a \"title\" & <more>");
        let plot = Plot { corner: [20.0, 10.0], size: [160.0, 80.0], x: [0.0, 4.0], y: [0.0, 2.0] };
        assert_eq!((plot.at(0.0, 0.0), plot.at(4.0, 2.0)), ([20.0, 90.0], [180.0, 10.0]));
        chart.band(plot.at(0.0, 0.0), plot.at(4.0, 1.0), [10, 20, 30]);
        chart.curve(&[plot.at(1.0, 1.5), plot.at(3.0, 1.5)], [200, 0, 0], false);
        chart.text([100.0, 20.0], "<b>", Anchor::Middle, [0; 3]);
        let svg = chart.to_svg();
        assert!(svg.contains("&lt;b&gt;") && !svg.contains("<b>") && svg.contains("&amp;"));
        assert_eq!((svg.matches("<circle").count(), svg.matches("<line").count()), (2, 1));
        let picture = chart.to_picture();
        assert_eq!([picture.width, picture.height], [200, 100]);
        assert_eq!(picture.pixel(100, 70), [10, 20, 30]);
        assert_eq!(picture.pixel(100, 30), [200, 0, 0]);
        assert_eq!(picture.pixel(5, 5), palette::PAPER);
        // Letters are drawn smoothly: thin strokes are grey.
        let is_ink = |x, y| picture.pixel(x, y).iter().all(|&v| v < 150);
        let dark = (90..110).filter(|&x| (8..32).any(|y| is_ink(x, y)));
        assert!(dark.count() > 5, "the text is there");
    }

    #[test]
    fn dashes_stay_on_their_line() {
        let segments = dashes([0.0, 0.0], [100.0, 0.0], true);
        assert_eq!(segments.len(), 4);
        assert!(segments.iter().flatten().all(|p| (0.0..=100.0).contains(&p[0]) && p[1] == 0.0));
        assert_eq!(dashes([1.0, 2.0], [100.0, 0.0], false), [[[1.0, 2.0], [100.0, 0.0]]]);
    }
}
