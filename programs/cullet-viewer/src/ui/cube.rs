//! The cube of directions in a corner of the picture: the cells whose normals face away, as the eye
//! moves.

use cullet::Stage;
use cullet_draw::palette;
use eframe::egui::{self, Color32, Pos2, Stroke};
use glam::DVec3;

use super::words::colour;
use crate::session::Session;
use crate::study::{Cube, on_cube};

/// Shows the cube in the lower left corner of the picture, if it is wanted.
pub(super) fn show(ui: &egui::Ui, picture: egui::Rect, session: &Session) {
    if !session.state.study.cube || session.decision.is_none() {
        return;
    }
    let side = (picture.size().min_elem() * 0.42).clamp(120.0, 260.0);
    let corner = egui::pos2(picture.min.x + 8.0, picture.max.y - 8.0 - side);
    let rect = egui::Rect::from_min_size(corner, egui::vec2(side, side));
    let painter = ui.painter_at(picture);
    painter.rect_filled(rect, 3.0, ui.visuals().panel_fill.gamma_multiply(0.9));
    let font = egui::TextStyle::Small.resolve(ui.style());
    let ink = ui.visuals().strong_text_color();
    let put = |at: Pos2, align, words: String| painter.text(at, align, words, font.clone(), ink);
    let of = if session.inspected.is_some() { "of what is inspected" } else { "of the whole view" };
    put(
        rect.min + egui::vec2(6.0, 4.0),
        egui::Align2::LEFT_TOP,
        format!("normals that face away, {of}"),
    );
    let Some(cube) = session.cube() else {
        put(
            rect.center(),
            egui::Align2::CENTER_CENTER,
            "the eye is in its sphere: none".to_owned(),
        );
        return;
    };
    let words =
        format!("N = {}: {} of {} classes", cube.grid.cells(), cube.away, cube.grid.classes());
    put(egui::pos2(rect.min.x + 6.0, rect.max.y - 4.0), egui::Align2::LEFT_BOTTOM, words);
    paint(&painter, rect, &cube);
}

fn paint(painter: &egui::Painter, rect: egui::Rect, cube: &Cube) {
    let axis = DVec3::from(cube.cone.axis);
    // Along the line of sight lie the normals that face away, so that corner is shown; from aside,
    // or the arrow would be a point.
    let sign = axis.to_array().map(|v| if v < 0.0 { -1.0 } else { 1.0 });
    let [x, z] = if axis.x.abs() < axis.z.abs() { [1.5, 0.8] } else { [0.8, 1.5] };
    let toward = DVec3::new(sign[0] * x, sign[1] * 0.75, sign[2] * z).normalize();
    let across = DVec3::Y.cross(toward).try_normalize().unwrap_or(DVec3::X);
    let upright = toward.cross(across);
    let scale = f64::from(rect.width()) / 4.4;
    let place = |p: DVec3| {
        let (x, y) = (p.dot(across) * scale, p.dot(upright) * scale);
        rect.center() + egui::vec2(x as f32, -y as f32)
    };
    let n = cube.grid.cells();
    let along = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let away = colour(palette::reason_color(Some(Stage::Backface)));
    let kept = colour(palette::SEEN);
    let line = Stroke::new(if n > 10 { 0.5 } else { 1.0 }, Color32::from_gray(90));
    for major in 0..3 {
        let positive = toward[major] > 0.0;
        // Sides differ in lightness, so that the cube is one.
        let shade = [0.86, 1.0, 0.72][major];
        for [i, j] in (0..n * n).map(|k| [k % n, k / n]) {
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            let corners = corners.map(|c| place(on_cube(major, positive, c.map(along))));
            let fill = if cube.is_away(major, positive, [i, j]) { away } else { kept };
            let dim = |v: u8| (f32::from(v) * shade) as u8;
            let fill = Color32::from_rgb(dim(fill.r()), dim(fill.g()), dim(fill.b()));
            painter.add(egui::Shape::convex_polygon(corners.to_vec(), fill, line));
        }
    }
    let leaves = axis / axis.abs().max_element();
    let (from, to) = (place(leaves), place(leaves + axis * 0.8));
    painter.arrow(from, to - from, Stroke::new(2.5, colour(palette::UNSEEN)));
}
