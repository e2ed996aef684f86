//! Graph 1: the share culled and the speed-up, against the number of classes.

use cullet_command::console::count;
use cullet_draw::palette;

use super::record::{TableRow, ZhangHoffRecord};
use crate::reproduce::chart::{Anchor, Chart, Plot};

/// Share culled: a blue and its paler self for the paper's.
const SHARE: [u8; 3] = [0x00, 0x72, 0xB2];
/// Speed-up: vermilion, told apart from the blue by anyone.
const SPEED: [u8; 3] = [0xD5, 0x5E, 0x00];
/// The share that an exact test culls.
const EXACT: [u8; 3] = [0x5C, 0x63, 0x6B];
/// The band of the speed-up that the paper claims.
const CLAIM: [u8; 3] = [0xF8, 0xE4, 0xD4];
const GRID: [u8; 3] = [0xDD, 0xDB, 0xD5];

/// The claims: a speed-up of 60 to 80 per cent in the paper, about 1.5 in lectures.
const CLAIMED: [f64; 2] = [1.6, 1.8];
const QUOTED: f64 = 1.5;

/// Draws the graph.
pub(super) fn chart(record: &ZhangHoffRecord) -> Chart {
    let mut c = Chart::new([1200, 820], "Graph 1: share culled and speed-up by number of classes");
    c.heading([80.0, 40.0], "Normal masks: share culled and speed-up");
    let m = &record.model;
    let line = format!(
        "{} x {}, {:.2} radii away, mean of {}",
        m.copies,
        m.name,
        record.distance_radii,
        count(u64::from(record.directions), "view", "views")
    );
    c.text([80.0, 76.0], line, Anchor::Start, palette::INK);
    let speeds = || record.rows.iter().filter_map(|r| r.speedup);
    let least = (speeds().fold(0.8, f64::min) * 5.0).floor() / 5.0;
    let most = (speeds().fold(2.0, f64::max) * 5.0).ceil() / 5.0;
    // By N, which spreads the nine sizes evenly; the classes are 6 N².
    let (corner, size) = ([80.0, 140.0], [1030.0, 490.0]);
    let share = Plot { corner, size, x: [1.0, 19.0], y: [0.0, 60.0] };
    let speed = Plot { corner, size, x: [1.0, 19.0], y: [least, most] };
    c.band(speed.at(1.0, CLAIMED[0]), speed.at(19.0, CLAIMED[1]), CLAIM);
    for percent in (0..=60).step_by(10) {
        let at = share.at(1.0, f64::from(percent));
        c.line(at, share.at(19.0, f64::from(percent)), 1.0, GRID);
        c.text([at[0] - 10.0, at[1]], format!("{percent}"), Anchor::End, SHARE);
    }
    for fifth in (least * 5.0).round() as u32..=(most * 5.0).round() as u32 {
        let value = f64::from(fifth) / 5.0;
        let at = speed.at(19.0, value);
        c.line(at, [at[0] + 6.0, at[1]], 1.0, SPEED);
        c.text([at[0] + 12.0, at[1]], format!("{value:.1}"), Anchor::Start, SPEED);
    }
    c.text([80.0, 116.0], "% culled", Anchor::Start, SHARE);
    c.text([1160.0, 116.0], "times as fast", Anchor::End, SPEED);
    for r in &record.rows {
        let at = share.at(f64::from(r.n), 0.0);
        c.line(at, [at[0], at[1] + 6.0], 1.0, palette::INK);
        c.text([at[0], at[1] + 20.0], r.n.to_string(), Anchor::Middle, palette::INK);
        c.text([at[0], at[1] + 42.0], r.classes.to_string(), Anchor::Middle, EXACT);
    }
    let below = corner[1] + size[1];
    c.text([70.0, below + 20.0], "N", Anchor::End, palette::INK);
    c.text([70.0, below + 42.0], "6NxN", Anchor::End, EXACT);

    c.dashed(speed.at(1.0, QUOTED), speed.at(19.0, QUOTED), 2.0, SPEED);
    if let Some(r) = record.rows.first() {
        c.line(share.at(1.0, r.exact_percent), share.at(19.0, r.exact_percent), 2.0, EXACT);
    }
    let points = |plot: &Plot, value: &dyn Fn(&TableRow) -> Option<f64>| {
        let at = |r: &TableRow| value(r).map(|v| plot.at(f64::from(r.n), v));
        record.rows.iter().filter_map(at).collect::<Vec<_>>()
    };
    c.curve(&points(&share, &|r| Some(r.culled_percent)), SHARE, false);
    let pale = palette::mix(SHARE, palette::PAPER, 0.45);
    c.curve(&points(&share, &|r| Some(r.paper_percent)), pale, true);
    let faint = palette::mix(SPEED, palette::PAPER, 0.45);
    c.curve(&points(&speed, &|r| Some(r.even_speedup)), faint, true);
    c.curve(&points(&speed, &|r| r.speedup), SPEED, false);

    // The legend, below: nothing hides a curve.
    let legend = [
        (SHARE, false, "culled by masks"),
        (pale, true, "culled, as the paper prints it"),
        (EXACT, false, "culled by the exact test"),
        (CLAIM, false, "speed-up the paper claims, 60-80 %"),
        (SPEED, false, "speed-up measured here"),
        (faint, true, "the same, if all triangles cost alike"),
        (SPEED, true, "speed-up quoted in lectures, 1.5"),
    ];
    for (i, (color, dashed, words)) in legend.into_iter().enumerate() {
        let [x, y] = [80.0 + 560.0 * (i / 4) as f64, below + 84.0 + 26.0 * (i % 4) as f64];
        if color == CLAIM {
            c.band([x, y - 9.0], [x + 44.0, y + 9.0], color);
        } else if dashed {
            c.dashed([x, y], [x + 44.0, y], 4.0, color);
        } else {
            c.line([x, y], [x + 44.0, y], 4.0, color);
        }
        c.text([x + 58.0, y], words, Anchor::Start, palette::INK);
    }
    c
}
