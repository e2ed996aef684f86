//! Pieces of the drawn chain: boxes, lines of text, and values on scales with a limit.

use std::fmt::Write;

use cullet_command::html::{escape, hex};
use cullet_draw::palette;

type Color = [u8; 3];

/// Pixels across.
pub(super) const WIDTH: f64 = 960.0;
/// From where to where boxes reach, and scales in them.
const BOX: [f64; 2] = [24.0, WIDTH - 24.0];
const SCALE: [f64; 2] = [400.0, WIDTH - 48.0];
/// Where words in a box begin, and behind the name of a value its number.
const LEFT: f64 = 54.0;
const NUMBER: f64 = 140.0;
/// From a line to the next.
const LINE: f64 = 22.0;
/// Width of the stripe that tells what came of it.
const STRIPE: f64 = 12.0;
/// How many letters fit into a line from `LEFT` on.
const LETTERS: usize = 116;

/// A value, or the range of one, on a scale with a limit.
#[derive(Clone, Debug)]
pub(super) struct Gauge {
    /// Name of the gauge, and its number in words.
    pub(super) label: String,
    pub(super) number: String,
    /// From where to where it reaches.
    pub(super) value: [f64; 2],
    /// Beyond it the stage drops.
    pub(super) limit: f64,
    /// Whether that is above the limit; else below.
    pub(super) drops_above: bool,
}

/// A scale that gauges share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Scale {
    /// One that has all values and limits of `gauges` on it.
    pub(super) fn of(gauges: &[Gauge], logarithmic: bool) -> Self {
        let all = gauges.iter().flat_map(|g| [g.value[0], g.value[1], g.limit]);
        let finite = all.filter(|v| v.is_finite()).map(|v| even(v, logarithmic));
        let (low, high) = finite
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low > high { (0.0, 0.0) } else { (low, high) };
        // Room on both sides, so that there is something beyond every limit.
        let room = (0.12 * (high - low)).max(1e-9);
        // Sizes begin at 0, so that twice as far is twice as large.
        let low = if low > 0.0 && !logarithmic { 0.0 } else { low - room };
        Self { low, high: high + room, logarithmic }
    }

    /// In pixels. What is not a number is at the far end.
    fn x(&self, value: f64) -> f64 {
        let share = (even(value, self.logarithmic) - self.low) / (self.high - self.low);
        let share = if share.is_nan() { 1.0 } else { share.clamp(0.0, 1.0) };
        SCALE[0] + share * (SCALE[1] - SCALE[0])
    }
}

/// A value of which equal steps are equally wide on a scale.
fn even(value: f64, logarithmic: bool) -> f64 {
    if logarithmic { value.asinh() } else { value }
}

/// A drawing that grows downwards.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    body: String,
    y: f64,
    /// Where the box began that is open, and its colour.
    open: Option<(f64, Color, usize)>,
}

impl Sheet {
    /// Room without anything.
    pub(super) fn skip(&mut self, height: f64) {
        self.y += height;
    }

    /// Begins a box whose stripe has the colour of what came of it.
    pub(super) fn begin(&mut self, color: Color) {
        self.open = Some((self.y, color, self.body.len()));
        self.skip(8.0);
    }

    /// Ends it.
    pub(super) fn end(&mut self) {
        let Some((top, color, place)) = self.open.take() else { return };
        self.skip(8.0);
        let (height, width) = (self.y - top, BOX[1] - BOX[0]);
        let ink = hex(palette::INK);
        // Beneath what was written since.
        let own = format!(
            "<rect x=\"{}\" y=\"{top:.1}\" width=\"{width}\" height=\"{height:.1}\" rx=\"5\" fill=\"#fff\" stroke=\"{ink}\"/>\n\
             <rect x=\"{}\" y=\"{:.1}\" width=\"{STRIPE}\" height=\"{:.1}\" rx=\"3\" fill=\"{}\" stroke=\"{ink}\" stroke-width=\"0.5\"/>\n",
            BOX[0],
            BOX[0] + 5.0,
            top + 5.0,
            height - 10.0,
            hex(color)
        );
        self.body.insert_str(place, &own);
    }

    /// An arrow down to what comes next.
    pub(super) fn arrow(&mut self) {
        let (x, top, tip) = (WIDTH * 0.5, self.y, self.y + 18.0);
        let ink = hex(palette::INK);
        let _ = writeln!(
            self.body,
            "<path d=\"M{x} {top:.1}V{:.1}M{:.1} {:.1}L{x} {tip:.1}L{:.1} {:.1}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"2\"/>",
            tip - 1.0,
            x - 6.0,
            tip - 7.0,
            x + 6.0,
            tip - 7.0
        );
        self.skip(18.0);
    }

    /// The head of a box: its name, what it is of, and what came of it.
    pub(super) fn head(&mut self, name: &str, of: &str, outcome: &str) {
        self.put(LEFT, name, "font-weight=\"700\"");
        self.put(LEFT + 110.0, of, "");
        self.put(SCALE[1], outcome, "font-weight=\"700\" text-anchor=\"end\"");
        self.skip(LINE);
    }

    /// Lines of words, cut where they are longer than the drawing is wide.
    pub(super) fn words(&mut self, text: &str) {
        for line in wrapped(text, LETTERS) {
            self.put(LEFT, &line, "");
            self.skip(LINE);
        }
    }

    /// A line that is larger.
    pub(super) fn title(&mut self, text: &str) {
        for line in wrapped(text, LETTERS * 2 / 3) {
            self.put(BOX[0], &line, "font-weight=\"700\" font-size=\"20\"");
            self.skip(LINE + 6.0);
        }
    }

    /// Lines of words beside the boxes.
    pub(super) fn plain(&mut self, text: &str) {
        for line in wrapped(text, LETTERS) {
            self.put(BOX[0], &line, "");
            self.skip(LINE);
        }
    }

    /// A line beneath a scale that says how to read it.
    pub(super) fn note(&mut self, text: &str) {
        let color = hex(palette::mix(palette::INK, palette::PAPER, 0.25));
        self.put(SCALE[1], text, &format!("fill=\"{color}\" font-size=\"12\" text-anchor=\"end\""));
        self.skip(LINE - 4.0);
    }

    /// A value on its scale: the track, tinted where the stage drops; the limit; and from where to
    /// where the value reaches.
    pub(super) fn gauge(&mut self, gauge: &Gauge, scale: &Scale, tint: Color) {
        self.put(LEFT, &gauge.label, "");
        self.put(NUMBER, &gauge.number, "");
        let middle = self.y + LINE * 0.5;
        let limit = scale.x(gauge.limit);
        let [from, to] = gauge.value.map(|v| scale.x(v));
        let (from, to) = (from.min(to), from.max(to));
        let drops = if gauge.drops_above { [limit, SCALE[1]] } else { [SCALE[0], limit] };
        let pale = palette::mix(palette::INK, [255; 3], 0.9);
        self.bar(SCALE, middle, 12.0, pale);
        self.bar(drops, middle, 12.0, palette::mix(tint, [255; 3], 0.45));
        // What is a point is seen all the same.
        let half = (3.0 - 0.5 * (to - from)).max(0.0);
        self.bar([from - half, to + half], middle, 8.0, palette::SUBJECT);
        self.bar([limit - 1.0, limit + 1.0], middle, 20.0, palette::INK);
        self.skip(LINE);
    }

    /// A share of something that went on, and the rest that a stage dropped.
    pub(super) fn share(&mut self, label: &str, number: &str, share: f64, dropped: Color) {
        self.put(LEFT, label, "");
        self.put(NUMBER, number, "");
        let middle = self.y + LINE * 0.5;
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 };
        let [from, to] = [SCALE[0] + 0.5, SCALE[1] - 0.5];
        self.bar(SCALE, middle, 13.0, palette::INK);
        self.bar([from, to], middle, 12.0, dropped);
        self.bar([from, from + share * (to - from)], middle, 12.0, palette::SEEN);
        self.skip(LINE);
    }

    fn bar(&mut self, [from, to]: [f64; 2], middle: f64, height: f64, color: Color) {
        let _ = writeln!(
            self.body,
            "<rect x=\"{from:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{}\"/>",
            middle - 0.5 * height,
            (to - from).max(0.0),
            hex(color)
        );
    }

    fn put(&mut self, x: f64, text: &str, how: &str) {
        // The baseline of letters whose middle is that of the line.
        let y = self.y + LINE * 0.5 + 5.0;
        let space = if how.is_empty() { "" } else { " " };
        let _ = writeln!(
            self.body,
            "<text x=\"{x:.1}\" y=\"{y:.1}\"{space}{how}>{}</text>",
            escape(text)
        );
    }

    /// The drawing; `title` is for those who cannot see it.
    pub(super) fn finish(self, title: &str) -> String {
        let height = self.y.ceil();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" height=\"{height}\" \
             role=\"img\" aria-label=\"{}\" font-family=\"Open Sans, DejaVu Sans, sans-serif\" font-size=\"14\" \
             fill=\"{}\">\n<title>{}</title>\n\
             <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"{}\"/>\n{}</svg>\n",
            escape(title),
            hex(palette::INK),
            escape(title),
            hex(palette::PAPER),
            self.body
        )
    }
}

/// Lines of at most so many letters, between words where there are some.
fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    let mut length = 0;
    for word in text.split(' ') {
        let letters: Vec<char> = word.chars().collect();
        // A word longer than a line is cut.
        for part in letters.chunks(most.max(1)) {
            if length > 0 && length + 1 + part.len() > most {
                lines.push(String::new());
                length = 0;
            }
            let line = lines.len() - 1;
            if length > 0 {
                lines[line].push(' ');
                length += 1;
            }
            lines[line].extend(part);
            length += part.len();
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gauge(value: [f64; 2], limit: f64) -> Gauge {
        let (label, number) = (String::new(), String::new());
        Gauge { label, number, value, limit, drops_above: true }
    }

    #[test]
    fn a_scale_keeps_the_order_of_values_and_limits() {
        for logarithmic in [false, true] {
            let gauges = [gauge([-2400.0, -3.0], 0.0), gauge([-1.0, 50.0], 0.0)];
            let scale = Scale::of(&gauges, logarithmic);
            let x = [-2400.0, -3.0, -1.0, 0.0, 50.0].map(|v| scale.x(v));
            assert!(x.windows(2).all(|w| w[0] < w[1]), "{x:?}");
            assert!(x[0] > SCALE[0] && x[4] < SCALE[1], "there is room on both sides: {x:?}");
        }
        let scale = Scale::of(&[gauge([10.0, 10.0], 40.0)], false);
        let [zero, value, limit] = [0.0, 10.0, 40.0].map(|v| scale.x(v));
        assert_eq!(zero, SCALE[0]);
        assert!(((limit - zero) - 4.0 * (value - zero)).abs() < 1e-6);
    }

    #[test]
    fn what_is_not_a_number_stays_on_the_sheet() {
        let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        let gauges = [gauge([wild[0], wild[1]], 0.0), gauge([wild[2], 1.0], wild[0])];
        for logarithmic in [false, true] {
            let scale = Scale::of(&gauges, logarithmic);
            assert!(wild.iter().all(|v| (SCALE[0]..=SCALE[1]).contains(&scale.x(*v))));
            let mut sheet = Sheet::default();
            gauges.iter().for_each(|g| sheet.gauge(g, &scale, palette::LOST));
            assert!(!sheet.finish("").contains("NaN"));
        }
        assert!(Scale::of(&[], false).x(0.0).is_finite());
    }

    #[test]
    fn long_words_are_cut_and_lose_no_letter() {
        let text = format!("a {} b", "x".repeat(25));
        let lines = wrapped(&text, 10);
        assert!(lines.iter().all(|line| line.chars().count() <= 10), "{lines:?}");
        assert_eq!(lines.concat().matches('x').count(), 25);
        assert_eq!(wrapped("", 10), [""]);
    }
}
