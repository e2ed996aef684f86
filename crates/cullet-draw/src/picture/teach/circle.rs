//! Normal masks in the plane, where directions are a circle.

use super::sheet::{Sheet, on_circle};
use super::{BACK, KEPT, LOST, SIGHT};
use crate::picture::Picture;
use crate::picture::palette::INK;

/// The angles at which the cells of a square with `n` cells along each side end, in degrees.
fn cells(n: u32) -> Vec<[f64; 2]> {
    let at = |side: u32, i: u32| {
        let t = 2.0 * f64::from(i) / f64::from(n) - 1.0;
        f64::from(side) * 90.0 + t.atan().to_degrees()
    };
    (0..4).flat_map(|side| (0..n).map(move |i| [at(side, i), at(side, i + 1)])).collect()
}

/// Whether a cell is back-facing for all lines of sight within `half_angle` of direction 0: both its
/// ends are within 90 degrees less that angle. All in degrees.
fn faces_away([from, to]: [f64; 2], half_angle: f64) -> bool {
    let off = |a: f64| ((a + 180.0).rem_euclid(360.0) - 180.0).abs();
    let limit = 90.0 - half_angle + 1e-9;
    off(from) <= limit && off(to) <= limit
}

fn pie(sheet: &mut Sheet, c: [f64; 2], r: f64, [from, to]: [f64; 2], color: [u8; 3]) {
    let steps = ((to - from).abs() / 2.0).ceil().max(1.0);
    let mut a = from;
    for i in 1..=steps as u32 {
        let b = from + (to - from) * f64::from(i) / steps;
        sheet.fill(&[c, on_circle(c, r, a), on_circle(c, r, b)], color, 1.0);
        a = b;
    }
}

fn ring(sheet: &mut Sheet, c: [f64; 2], r: f64, [from, to]: [f64; 2], width: f64, color: [u8; 3]) {
    let steps = ((to - from).abs() / 2.0).ceil().max(1.0) as u32;
    let at = |i: u32| on_circle(c, r, from + (to - from) * f64::from(i) / f64::from(steps));
    for i in 0..steps {
        sheet.line(at(i), at(i + 1), width, color);
    }
}

/// The circle of normals cut by the cells of a square, four along each side, and the cells that face
/// away in an orthographic view (left) and for lines of sight that spread by `half_angle` degrees
/// (right). `half_angle` is clamped to 0..80; NaN is 0. `size` is at least 640 × 360.
#[must_use]
pub fn normal_partition(half_angle: f64, size: [u32; 2]) -> Picture {
    let spread = if half_angle > 0.0 { half_angle.min(80.0) } else { 0.0 };
    let mut sheet = Sheet::new(size);
    let [w, h] = sheet.size();
    let r = (w * 0.25 - 60.0).min((h - 190.0) * 0.5);
    for (column, angle) in [(0.25, 0.0), (0.75, spread)] {
        let c = [w * column, h * 0.5 - 8.0];
        let mut count = 0;
        for cell in cells(4) {
            let culled = faces_away(cell, angle);
            count += u32::from(culled);
            pie(&mut sheet, c, r, cell, if culled { BACK } else { KEPT });
        }
        ring(&mut sheet, c, r, [0.0, 360.0], 2.0, INK);
        // The square whose sides the cells divide evenly.
        let corner = |i: i32| on_circle(c, r * 2f64.sqrt() * 0.5, 45.0 + 90.0 * f64::from(i));
        let square = [0, 1, 2, 3].map(corner);
        for [from, _] in cells(4) {
            sheet.line(c, on_circle(c, r + 7.0, from), 1.2, INK);
        }
        sheet.outline(&square, 1.2, INK);
        // The exact bounds: perpendicular to the outermost lines of sight.
        for side in [-1.0, 1.0] {
            let end = on_circle(c, r + 24.0, side * (90.0 - angle));
            sheet.line(c, end, 2.4, SIGHT);
        }
        let eye = [c[0] - r - 46.0, c[1]];
        for a in [-angle, 0.0, angle] {
            sheet.arrow(eye, on_circle(eye, 42.0, a), 2.0, SIGHT);
        }
        sheet.disc(eye, 4.0, SIGHT);
        let kind = if angle == 0.0 {
            "parallel sight".into()
        } else {
            format!("within {angle:.0} degrees")
        };
        sheet.centred([w * column, h - 66.0], format!("{kind}: {count} of 16"), INK);
    }
    sheet.centred([w * 0.5, 18.0], "The circle of normals in 16 classes", INK);
    let entries = [(BACK, "faces away"), (KEPT, "kept"), (SIGHT, "sight, exact limits")];
    sheet.legend([26.0, h - 32.0], &entries);
    sheet.finish()
}

/// The normals that are back-facing for all lines of sight of a view `field_of_view` degrees wide: an
/// arc of 180 degrees less the field of view, and how it grows as the view is cut into 1, 2, 4 and 8
/// sectors, each with a mask of its own. The field of view is clamped to 10..150; NaN is 90. `size`
/// is at least 640 × 360.
#[must_use]
pub fn conservative_set(field_of_view: f64, size: [u32; 2]) -> Picture {
    let wide = if field_of_view.is_nan() { 90.0 } else { field_of_view.clamp(10.0, 150.0) };
    let mut sheet = Sheet::new(size);
    let [w, h] = sheet.size();
    let r = (w * 0.125 - 26.0).min((h - 190.0) * 0.5);
    for (i, sectors) in [1u32, 2, 4, 8].into_iter().enumerate() {
        let c = [w * (0.125 + 0.25 * i as f64), h * 0.5 - 14.0];
        let half = wide * 0.5 / f64::from(sectors);
        // The sector in the middle, or next to it.
        let middle = if sectors == 1 { 0.0 } else { half };
        ring(&mut sheet, c, r, [0.0, 360.0], 1.4, INK);
        for s in 0..=sectors {
            let a = 180.0 - wide * 0.5 + wide * f64::from(s) / f64::from(sectors);
            sheet.line(c, on_circle(c, r, a + 180.0), 1.0, INK);
        }
        let [from, to] = [middle - half, middle + half];
        pie(&mut sheet, c, r * 0.62, [from, to], SIGHT);
        ring(&mut sheet, c, r, [middle - 90.0, middle + 90.0], 9.0, LOST);
        let limit = 90.0 - half;
        ring(&mut sheet, c, r, [middle - limit, middle + limit], 9.0, BACK);
        sheet.disc(c, 4.0, INK);
        let x = c[0];
        let words = if sectors == 1 { "1 sector".into() } else { format!("{sectors} sectors") };
        sheet.centred([x, h - 96.0], words, INK);
        sheet.centred([x, h - 74.0], format!("{:.1} degrees", 2.0 * limit), INK);
    }
    sheet.centred([w * 0.5, 18.0], format!("A view {wide:.0} degrees wide, in sectors"), INK);
    let entries = [
        (SIGHT, "a sector's sight"),
        (BACK, "faces away for all of it"),
        (LOST, "for its middle alone"),
    ];
    sheet.legend([26.0, h - 32.0], &entries);
    sheet.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_tile_the_circle_and_none_is_culled_wrongly() {
        for n in 1..9 {
            let cells = cells(n);
            assert_eq!(cells.len() as u32, 4 * n);
            let sum: f64 = cells.iter().map(|[a, b]| b - a).sum();
            assert!((sum - 360.0).abs() < 1e-9);
        }
        for half in [0.0, 10.0, 30.0] {
            for cell in cells(6).into_iter().filter(|c| faces_away(*c, half)) {
                for (normal, sight) in [(cell[0], half), (cell[1], -half), (cell[0], -half)] {
                    assert!((normal - sight).to_radians().cos() > -1e-9, "{cell:?} {half}");
                }
            }
        }
    }
}
