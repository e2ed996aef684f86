//! The cube of directions, its cells, and which of them face away.

use cullet::Simd;
use glam::DVec3;

use super::sheet::{Flat, Sheet};
use super::{BACK, KEPT};
use cullet_draw::Picture;
use cullet_draw::picture::palette::{INK, PAPER, mix};
use cullet_mesh::{MaskGrid, ViewCone};

/// How far below the cube its lower side is drawn, in halves of an edge.
const FOLDED_OUT: f64 = 1.1;

/// Two cubes side by side, with 6 and 16 cells along an edge (216 and 1536 classes of normals), and
/// the classes that are back-facing for these lines of sight: Zhang & Hoff's normal masks.
///
/// The cells marked are those of [`MaskGrid::mask`], from which the count in the picture is taken
/// as well. The cubes are seen from above, and from where most of what is marked is visible; where
/// the lines of sight go down, the lower side is drawn below the cube. `size` is at least 640 ×
/// 360.
#[must_use]
pub fn normal_mask(cone: &ViewCone, size: [u32; 2]) -> Picture {
    let mut sheet = Sheet::new(size);
    let angle = cone.sine.clamp(0.0, 1.0).asin().to_degrees();
    sheet.title(format!("Normal masks: lines of sight within {angle:.0}° of the arrow"));
    sheet.legend(&[
        (BACK, "back-facing for all lines of sight"),
        (KEPT, "kept"),
        (INK, "direction of sight"),
    ]);
    let [w, _] = sheet.size();
    let [top, bottom] = sheet.room();
    let words = sheet.text_size() * 1.8;
    let axis = DVec3::from(cone.axis);
    let down = axis.y < 0.0;
    // Along the line of sight lie the normals that face away, so those sides are shown; from aside,
    // or the arrow would be a point.
    let sign = axis.to_array().map(|v| if v < 0.0 { -1.0 } else { 1.0 });
    let [x, z] = if axis.x.abs() < axis.z.abs() { [1.5, 0.8] } else { [0.8, 1.5] };
    let toward = DVec3::new(sign[0] * x, 1.0, sign[2] * z);
    let high = if down { 3.0 + FOLDED_OUT } else { 3.0 };
    let scale = ((w * 0.5 - 60.0) / 3.2).min((bottom - top - words) / high);
    for (column, n) in [(0.25, 6), (0.75, 16)] {
        let Some(grid) = MaskGrid::new(n) else { continue };
        let mask = grid.mask(Simd::best(), Some(cone));
        let lift = if down { FOLDED_OUT * 0.5 * scale * 0.86 } else { 0.0 };
        let middle = [w * column, (top + bottom - words) * 0.5 - lift];
        let camera = Flat::new(toward, DVec3::ZERO, middle, scale);
        let mut count = 0;
        for face in 0..6usize {
            let (major, outward) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
            let folded_out = face == 3 && down;
            let shown = camera.toward[major] * outward > 0.0 || folded_out;
            let shift = if folded_out { DVec3::Y * -FOLDED_OUT } else { DVec3::ZERO };
            // Sides differ in lightness, so that the cube is one.
            let shade = [0.12, 0.0, 0.22][major];
            let along = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
            let point = |u: f64, v: f64| {
                let mut p = [0.0; 3];
                p[major] = outward;
                p[(major + 1) % 3] = u;
                p[(major + 2) % 3] = v;
                DVec3::from(p)
            };
            for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
                let middle = point(along(i) + 1.0 / f64::from(n), along(j) + 1.0 / f64::from(n));
                let culled = mask.culls(grid.encode(middle.into()));
                count += u32::from(culled);
                if shown {
                    let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    let corners =
                        corners.map(|(i, j)| camera.point(point(along(i), along(j)) + shift));
                    let color = if culled { BACK } else { KEPT };
                    sheet.fill(&corners, mix(color, INK, shade), 1.0);
                    let line = if n > 10 { 0.6 } else { 1.0 };
                    sheet.outline(&corners, line, mix(INK, KEPT, 0.35));
                }
            }
            if shown {
                let rim = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
                let rim = rim.map(|(u, v)| point(u, v));
                sheet.outline(&rim.map(|p| camera.point(p + shift)), 2.0, INK);
                if folded_out {
                    // Those of the cube's corners that are not behind it.
                    for p in rim.into_iter().filter(|p| p.dot(camera.toward) > -1.0) {
                        let ends = [p, p + shift].map(|p| camera.point(p));
                        sheet.line(ends[0], ends[1], 0.8, mix(INK, PAPER, 0.5));
                    }
                }
            }
        }
        // Where the line of sight leaves the cube, and how far along it goes.
        let leaves = axis / axis.abs().max_element();
        sheet.arrow(camera.point(leaves), camera.point(leaves + axis * 0.9), 3.5, INK);
        axes(&mut sheet, toward, [middle[0] - scale * 1.75, top + scale * 0.45], scale);
        let classes = grid.classes();
        let words = format!("N = {n}: {count} of {classes} classes face away");
        sheet.centred([w * column, bottom - sheet.text_size()], words, INK);
    }
    sheet.finish()
}

/// The three axes of the cube, aside from it.
fn axes(sheet: &mut Sheet, toward: DVec3, at: [f64; 2], scale: f64) {
    let camera = Flat::new(toward, DVec3::ZERO, at, scale * 0.4);
    let em = sheet.text_size();
    for (axis, name) in [(DVec3::X, "x"), (DVec3::Y, "y"), (DVec3::Z, "z")] {
        let tip = camera.point(axis);
        sheet.arrow(camera.point(DVec3::ZERO), tip, 1.0, mix(INK, PAPER, 0.3));
        let d = [tip[0] - at[0], tip[1] - at[1]];
        let far = 1.0 + em * 0.75 / d[0].hypot(d[1]).max(1.0);
        let [x, y] = [at[0] + d[0] * far, at[1] + d[1] * far];
        sheet.centred([x, y - em * 0.36], name, INK);
    }
}
