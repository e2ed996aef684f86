//! The cube of directions, its cells, and which of them face away.

use cullet::Level;
use cullet::cull::backface::{MaskGrid, ViewCone};
use glam::DVec3;

use super::sheet::{Flat, Sheet};
use super::{BACK, KEPT, SIGHT};
use crate::picture::Picture;
use crate::picture::palette::{INK, mix};

/// Two cubes side by side, with 6 and 16 cells along an edge (216 and 1536 classes of normals), the
/// classes that are back-facing for these lines of sight in green: Zhang & Hoff's normal masks.
///
/// The green cells are those of [`MaskGrid::mask`], from which the count in the picture is taken as
/// well. The cubes are seen from where most green is visible. `size` is at least 640 × 360.
#[must_use]
pub fn normal_mask(cone: &ViewCone, size: [u32; 2]) -> Picture {
    let mut sheet = Sheet::new(size);
    let [w, h] = sheet.size();
    let axis = DVec3::from(cone.axis);
    // Along the line of sight lie the normals that face away, so that corner is shown; from aside, or
    // the arrow would be a point.
    let sign = axis.to_array().map(|v| if v < 0.0 { -1.0 } else { 1.0 });
    let [x, z] = if axis.x.abs() < axis.z.abs() { [1.5, 0.8] } else { [0.8, 1.5] };
    let toward = DVec3::new(sign[0] * x, sign[1] * 0.75, sign[2] * z);
    let scale = (w * 0.5 - 40.0).min(h - 150.0) / 3.1;
    for (column, n) in [(0.25, 6), (0.75, 16)] {
        let Ok(grid) = MaskGrid::new(n) else { continue };
        let mask = grid.mask(Level::new(), Some(cone));
        let camera = Flat::new(toward, DVec3::ZERO, [w * column, h * 0.5 - 14.0], scale);
        let mut green = 0;
        for face in 0..6usize {
            let major = face / 2;
            let outward = if face % 2 == 0 { 1.0 } else { -1.0 };
            let shown = camera.toward[major] * outward > 0.0;
            // Sides differ in lightness, so that the cube is one.
            let shade = [0.10, 0.0, 0.2][major];
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
                green += u32::from(culled);
                if shown {
                    let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    let corners = corners.map(|(i, j)| camera.point(point(along(i), along(j))));
                    let color = if culled { BACK } else { KEPT };
                    sheet.fill(&corners, mix(color, INK, shade), 1.0);
                    let line = if n > 10 { 0.6 } else { 1.0 };
                    sheet.outline(&corners, line, mix(INK, KEPT, 0.35));
                }
            }
            if shown {
                let rim = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
                sheet.outline(&rim.map(|(u, v)| camera.point(point(u, v))), 2.0, INK);
            }
        }
        // Where the line of sight leaves the cube, and how far along it goes.
        let leaves = axis / axis.abs().max_element();
        sheet.arrow(camera.point(leaves), camera.point(leaves + axis * 0.9), 3.0, SIGHT);
        let classes = grid.classes();
        let words = format!("N = {n}: {green} of {classes} classes face away");
        sheet.centred([w * column, h - 72.0], words, INK);
    }
    let angle = cone.sine.clamp(0.0, 1.0).asin().to_degrees();
    sheet.centred(
        [w * 0.5, 18.0],
        format!("Normal masks: lines of sight within {angle:.0} degrees of the arrow"),
        INK,
    );
    let entries =
        [(BACK, "back-facing for all of them"), (KEPT, "kept"), (SIGHT, "direction of sight")];
    sheet.legend([26.0, h - 34.0], &entries);
    sheet.finish()
}
