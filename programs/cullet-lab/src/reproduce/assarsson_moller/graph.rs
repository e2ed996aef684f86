//! The chart: how much faster than plain each variant is, on a scale of powers.

use cullet_draw::palette;

use super::record::AssarssonMollerRecord;
use crate::reproduce::chart::{Anchor, Chart, Plot};

/// One box at a time, and sixteen: told apart by anyone.
const SCALAR: [u8; 3] = [0x00, 0x72, 0xB2];
const WIDE: [u8; 3] = [0xD5, 0x5E, 0x00];
/// Plane tests.
const TESTS: [u8; 3] = [0x9A, 0xA1, 0xA9];
const GRID: [u8; 3] = [0xDD, 0xDB, 0xD5];

/// Pixels from bar to bar.
const STEP: f64 = 56.0;

/// Draws the chart.
pub(super) fn chart(record: &AssarssonMollerRecord) -> Chart {
    let bars = record.rows.len() + record.wide.len();
    let height = 200.0 + STEP * bars as f64;
    let title = "Assarsson & Moller: times as fast as plain view frustum culling";
    let mut c = Chart::new([1200, (height + 90.0) as u32], title);
    c.heading([60.0, 40.0], "View frustum culling: what each trick gains");
    let line = format!(
        "{}, {} boxes, {:.1} % seen; {} degrees and {:.3} units a frame",
        record.model, record.boxes, record.visible_percent, record.degrees, record.stride
    );
    c.text([60.0, 78.0], line, Anchor::Start, palette::INK);
    let scalar = record.rows.iter().map(|r| (r.variant, Some(r.fewer_tests), r.speedup, SCALAR));
    let wide = record.wide.iter().map(|r| (r.variant, None, r.speedup, WIDE));
    let rows: Vec<_> = scalar.chain(wide).collect();
    let gains = || rows.iter().flat_map(|r| [r.1.unwrap_or(r.2), r.2]);
    let most = gains().fold(2.0, f64::max) * 1.3;
    let least = gains().fold(1.0, f64::min) / 1.15;
    let plot = Plot {
        corner: [330.0, 130.0],
        size: [760.0, STEP * bars as f64],
        x: [least.log10(), most.log10()],
        y: [bars as f64, 0.0],
    };
    let below = plot.corner[1] + plot.size[1];
    for exponent in -1..=4 {
        for digit in [1.0, 2.0, 5.0] {
            let value = digit * 10f64.powi(exponent);
            if (least..most).contains(&value) {
                let x = plot.at(value.log10(), 0.0)[0];
                let color = if value == 1.0 { palette::INK } else { GRID };
                c.line([x, plot.corner[1]], [x, below], 1.0, color);
                c.text([x, below + 20.0], format!("{value}"), Anchor::Middle, palette::INK);
            }
        }
    }
    c.text([330.0, 110.0], "times as fast, or fewer tests", Anchor::Start, palette::INK);
    for (i, (variant, tests, speedup, color)) in rows.into_iter().enumerate() {
        let middle = plot.corner[1] + STEP * (i as f64 + 0.5);
        c.text([315.0, middle], variant, Anchor::End, palette::INK);
        let one = plot.at(0.0, 0.0)[0];
        if let Some(tests) = tests {
            let x = plot.at(tests.log10(), 0.0)[0];
            c.band([one, middle + 4.0], [x, middle + 20.0], TESTS);
        }
        let x = plot.at(speedup.log10(), 0.0)[0];
        let (lower, beside) = if tests.is_some() { (2.0, -9.0) } else { (20.0, 0.0) };
        c.band([one, middle - 20.0], [x, middle + lower], color);
        let text = format!("{speedup:.2}");
        c.text([one.max(x) + 10.0, middle + beside], text, Anchor::Start, color);
    }
    let legend = [
        (SCALAR, "speed, one box at a time"),
        (TESTS, "plane tests saved"),
        (WIDE, "speed, sixteen at once"),
    ];
    for (i, (color, words)) in legend.into_iter().enumerate() {
        let x = 60.0 + 380.0 * i as f64;
        c.band([x, below + 66.0], [x + 36.0, below + 84.0], color);
        c.text([x + 46.0, below + 75.0], words, Anchor::Start, palette::INK);
    }
    c
}
