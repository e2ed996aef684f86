//! The chart: what each bound culls, beside what clusters and triangles would give at best.

use cullet_draw::palette;

use super::record::JohannsenCarterRecord;
use crate::reproduce::chart::{Anchor, Chart, Plot};

const BAR: [u8; 3] = [0x00, 0x72, 0xB2];
const IDEAL: [u8; 3] = [0xD5, 0x5E, 0x00];
const GRID: [u8; 3] = [0xDD, 0xDB, 0xD5];

/// Pixels from bar to bar.
const STEP: f64 = 46.0;
/// Half the height of a bar.
const HALF: f64 = 15.0;

/// Draws the chart.
pub(super) fn chart(record: &JohannsenCarterRecord) -> Chart {
    let bars = record.bounds.len() as f64;
    let title = "Johannsen & Carter: triangles that each bound of a cluster culls";
    let mut c = Chart::new([1200, (STEP * bars + 290.0) as u32], title);
    c.heading([60.0, 40.0], "Clustered back-face culling: what each bound finds");
    let line = format!(
        "{}, {} triangles in {} clusters; means over {} views from {} radii",
        record.model.name,
        record.model.triangles,
        record.clusters,
        record.directions,
        record.distance_radii
    );
    c.text([60.0, 78.0], line, Anchor::Start, palette::INK);
    // In steps of ten, so that the best possible has room.
    let most = (record.exact_percent.max(record.ideal_percent) / 10.0).floor() * 10.0 + 10.0;
    let plot =
        Plot { corner: [400.0, 140.0], size: [700.0, STEP * bars], x: [0.0, most], y: [bars, 0.0] };
    let below = plot.corner[1] + plot.size[1];
    for percent in (0..=most as u32).step_by(10) {
        let x = plot.at(f64::from(percent), 0.0)[0];
        c.line([x, plot.corner[1]], [x, below], 1.0, GRID);
        c.text([x, below + 20.0], format!("{percent} %"), Anchor::Middle, palette::INK);
    }
    c.text([400.0, 118.0], "triangles culled", Anchor::Start, palette::INK);
    for (i, row) in record.bounds.iter().enumerate() {
        let middle = plot.corner[1] + STEP * (i as f64 + 0.5);
        c.text([385.0, middle], row.name, Anchor::End, palette::INK);
        let [zero, end] = [0.0, row.culled_percent].map(|v| plot.at(v, 0.0)[0]);
        c.band([zero, middle - HALF], [end, middle + HALF], BAR);
        let text = format!("{:.1}", row.culled_percent);
        // In the bar where it has room.
        if end - zero > 60.0 {
            c.text([end - 8.0, middle], text, Anchor::End, palette::PAPER);
        } else {
            c.text([end + 8.0, middle], text, Anchor::Start, BAR);
        }
    }
    let limits = [
        (record.ideal_percent, IDEAL, "clusters that face away wholly: no bound finds more"),
        (record.exact_percent, palette::INK, "triangles that face away"),
    ];
    for (i, (percent, color, words)) in limits.into_iter().enumerate() {
        let x = plot.at(percent, 0.0)[0];
        c.line([x, plot.corner[1]], [x, below], 3.0, color);
        let y = below + 66.0 + 32.0 * i as f64;
        c.line([60.0, y], [96.0, y], 3.0, color);
        c.text([106.0, y], format!("{percent:.1} %: {words}"), Anchor::Start, palette::INK);
    }
    c
}
