//! Normal masks in the plane, where directions are a circle.

use super::sheet::{Sheet, on_circle};
use super::{BACK, KEPT};
use cullet_draw::Picture;
use cullet_draw::picture::palette::{INK, PAPER, UNSEEN, mix};

/// The angles at which the cells of a square with `n` cells along each side end, in degrees.
fn cells(n: u32) -> Vec<[f64; 2]> {
    let at = |side: u32, i: u32| {
        let t = 2.0 * f64::from(i) / f64::from(n) - 1.0;
        f64::from(side) * 90.0 + t.atan().to_degrees()
    };
    (0..4).flat_map(|side| (0..n).map(move |i| [at(side, i), at(side, i + 1)])).collect()
}

/// Whether a cell is back-facing for all lines of sight within `half_angle` of direction 0: both
/// its ends are within 90 degrees less that angle. All in degrees.
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

/// The circle of normals and the square around it, whose sides four cells each divide evenly: the
/// lines from the middle to their ends cut the circle into classes. Those that face away are
/// marked, in an orthographic view (left) and for lines of sight that spread by `half_angle`
/// degrees (right). `half_angle` is clamped to 0..80; NaN is 0. `size` is at least 640 × 360.
#[must_use]
pub fn normal_partition(half_angle: f64, size: [u32; 2]) -> Picture {
    let spread = if half_angle > 0.0 { half_angle.min(80.0) } else { 0.0 };
    let mut sheet = Sheet::new(size);
    sheet.title("The circle of normals in 16 classes");
    sheet.legend(&[
        (BACK, "faces away for all lines of sight"),
        (KEPT, "kept"),
        (INK, "lines of sight, and the exact limits they set"),
    ]);
    let [w, _] = sheet.size();
    let [top, bottom] = sheet.room();
    let words = sheet.text_size() * 1.6;
    // Beside the square are the eye, and room for the ends of the limits.
    let r = (w * 0.25 - 76.0).min((bottom - top - words) * 0.5 - 26.0);
    for (column, angle) in [(0.25, 0.0), (0.75, spread)] {
        let c = [w * column + 22.0, (top + bottom - words) * 0.5];
        let mut count = 0;
        for cell in cells(4) {
            let culled = faces_away(cell, angle);
            count += u32::from(culled);
            pie(&mut sheet, c, r, cell, if culled { BACK } else { KEPT });
        }
        let thin = mix(INK, PAPER, 0.35);
        ring(&mut sheet, c, r, [0.0, 360.0], 1.6, thin);
        sheet.outline(&[45.0, 135.0, 225.0, 315.0].map(|a| on_square(c, r, a)), 1.6, thin);
        for [from, _] in cells(4) {
            let end = on_square(c, r, from);
            sheet.line(c, end, 1.0, thin);
            sheet.disc(end, 3.0, thin);
        }
        // Perpendicular to the outermost lines of sight.
        for side in [-1.0, 1.0] {
            let end = on_circle(c, r + 22.0, side * (90.0 - angle));
            sheet.line(c, end, 3.0, INK);
        }
        let eye = [c[0] - r - 62.0, c[1]];
        for a in [-angle, 0.0, angle] {
            sheet.arrow(eye, on_circle(eye, 46.0, a), 2.0, INK);
        }
        sheet.disc(eye, 5.0, INK);
        let kind = if angle == 0.0 {
            "parallel lines of sight".into()
        } else {
            format!("lines of sight within {angle:.0}°")
        };
        let at = [c[0], bottom - sheet.text_size()];
        sheet.centred(at, format!("{kind}: {count} of 16"), INK);
    }
    sheet.finish()
}

/// The point at an angle in degrees of the square around a circle.
fn on_square(c: [f64; 2], r: f64, degrees: f64) -> [f64; 2] {
    let (s, t) = degrees.to_radians().sin_cos();
    on_circle(c, r / s.abs().max(t.abs()), degrees)
}

/// The normals that are back-facing for all lines of sight of a view `field_of_view` degrees wide:
/// an arc of 180 degrees less the field of view, and how it grows as the view is cut into 1, 2, 4
/// and 8 sectors, each with a mask of its own. The field of view is clamped to 10..150; NaN is 90.
/// `size` is at least 640 × 360.
#[must_use]
pub fn conservative_set(field_of_view: f64, size: [u32; 2]) -> Picture {
    let wide = if field_of_view.is_nan() { 90.0 } else { field_of_view.clamp(10.0, 150.0) };
    let mut sheet = Sheet::new(size);
    sheet.title(format!("A view {wide:.0}° wide, in sectors"));
    sheet.legend(&[
        (INK, "the lines of sight of one sector"),
        (BACK, "normals that face away for all of them"),
        (UNSEEN, "only for its middle one: kept"),
    ]);
    let [w, _] = sheet.size();
    let [top, bottom] = sheet.room();
    let em = sheet.text_size();
    // Four in a row with words below, or two in each of two rows with words beside: which leaves
    // less of the sheet empty.
    let in_a_row = (w * 0.125 - 16.0).min((bottom - top - 4.0 * em) * 0.5 - 6.0);
    let in_two = ((w * 0.5 - 12.0 * em) * 0.5).min((bottom - top) * 0.25 - 12.0);
    let row = in_a_row * 0.8 > in_two;
    let r = if row { in_a_row } else { in_two };
    for (i, sectors) in [1u32, 2, 4, 8].into_iter().enumerate() {
        let (c, words_at) = if row {
            let c = [w * (0.125 + 0.25 * i as f64), (top + bottom - 4.0 * em) * 0.5];
            (c, [c[0], c[1] + r + 1.2 * em])
        } else {
            let (column, row) = ((i % 2) as f64, (i / 2) as f64);
            let middle = w * (0.25 + 0.5 * column);
            let high = (bottom - top) * 0.5;
            let c = [middle - 4.5 * em, top + high * (row + 0.5)];
            (c, [middle + r + 1.0 * em, c[1] - 1.2 * em])
        };
        let half = wide * 0.5 / f64::from(sectors);
        // The sector in the middle, or next to it.
        let middle = if sectors == 1 { 0.0 } else { half };
        ring(&mut sheet, c, r, [0.0, 360.0], 1.4, INK);
        let [from, to] = [middle - half, middle + half];
        pie(&mut sheet, c, r * 0.62, [from, to], mix(INK, PAPER, 0.25));
        for s in 0..=sectors {
            let a = 180.0 - wide * 0.5 + wide * f64::from(s) / f64::from(sectors);
            sheet.line(c, on_circle(c, r, a + 180.0), 1.0, mix(INK, PAPER, 0.35));
        }
        ring(&mut sheet, c, r, [middle - 90.0, middle + 90.0], 10.0, UNSEEN);
        let limit = 90.0 - half;
        ring(&mut sheet, c, r, [middle - limit, middle + limit], 10.0, BACK);
        sheet.disc(c, 4.0, INK);
        let [x, y] = words_at;
        let words = if sectors == 1 { "1 sector".into() } else { format!("{sectors} sectors") };
        sheet.centred([x, y], words, INK);
        let words = format!("{:.1}° of 180°", 2.0 * limit);
        sheet.centred([x, y + 1.45 * em], words, mix(INK, PAPER, 0.3));
    }
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
