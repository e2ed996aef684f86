//! The map: every thing as a dot from above, in the colour of what became of it, with the frustum. Painted on
//! the processor, so that it costs the graphics card nothing.

use cullet::View;
use cullet_draw::palette;
use eframe::egui;
use glam::DVec3;

use crate::session::Session;

/// Pixels along a side of the map's picture.
const SIDE: usize = 192;

/// What the map's picture was made of, and its texture.
#[derive(Clone)]
struct Made {
    key: (usize, u64, [u64; 3]),
    texture: egui::TextureHandle,
}

/// Shows the map in the lower right corner of the picture, if it is wanted and there is something to map.
pub(super) fn show(ui: &egui::Ui, picture: egui::Rect, session: &Session) {
    let (true, Some(world), Some(decision), Some(rig)) =
        (session.state.map, &session.world, &session.decision, session.culling_rig())
    else {
        return;
    };
    let side = (picture.size().min_elem() * 0.32).min(220.0);
    let corner = picture.max - egui::vec2(8.0, 8.0);
    let rect = egui::Rect::from_min_max(corner - egui::vec2(side, side), corner);
    let eye = DVec3::from(rig.eye());
    // The middle follows the eye in steps, so that the picture is not made anew for every step of it.
    let wide = world.reach * 1.7;
    let step = wide / 8.0;
    let middle = DVec3::from(world.centre).lerp(eye, 0.5);
    let middle = (middle / step).round() * step;
    let key = (
        std::sync::Arc::as_ptr(world) as usize,
        decision.number,
        middle.to_array().map(f64::to_bits),
    );
    let id = egui::Id::unique("map");
    let texture = match ui.data(|d| d.get_temp::<Made>(id)).filter(|m| m.key == key) {
        Some(made) => made.texture,
        None => {
            let image = paint(session, middle, wide);
            let texture = ui.ctx().load_texture("map", image, egui::TextureOptions::LINEAR);
            ui.data_mut(|d| d.insert_temp(id, Made { key, texture: texture.clone() }));
            texture
        }
    };
    let painter = ui.painter_at(picture);
    let uv = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    painter.image(texture.id(), rect, uv, egui::Color32::WHITE);
    let place = |p: DVec3| {
        let d = (p - middle) / wide;
        rect.center() + egui::vec2(d.x as f32, d.z as f32) * side
    };
    let inside = painter.with_clip_rect(rect);
    if let Some(costs) = session.measured.costs() {
        for cost in &costs.all {
            let [r, g, b] = costs.colour(cost);
            let ink = egui::Color32::from_rgb(r, g, b);
            inside.circle_filled(place(cost.eye.into()), 2.5, ink);
        }
    }
    outline(&inside, &decision.request.view, eye, wide, place);
    let rim = egui::Stroke::new(1.0, ui.visuals().weak_text_color());
    painter.rect_stroke(rect, 0.0, rim, egui::StrokeKind::Outside);
    let font = egui::TextStyle::Small.resolve(ui.style());
    let [r, g, b] = palette::CHALK;
    let ink = egui::Color32::from_rgb(r, g, b);
    let galley = painter.layout_no_wrap("from above".to_owned(), font, ink);
    let ground = egui::Rect::from_min_size(rect.min, galley.size() + egui::vec2(8.0, 4.0));
    let [r, g, b] = palette::NIGHT;
    painter.rect_filled(ground, 0.0, egui::Color32::from_rgb(r, g, b));
    painter.galley(rect.min + egui::vec2(4.0, 2.0), galley, ink);
}

/// The sides of the view, and where the eye is.
fn outline(
    painter: &egui::Painter,
    view: &View,
    eye: DVec3,
    wide: f64,
    place: impl Fn(DVec3) -> egui::Pos2,
) {
    let [w, h] = view.viewport().map(f64::from);
    let ink = egui::Stroke::new(1.5, egui::Color32::WHITE);
    for x in [0.0, w] {
        if let Some(ray) = view.ray([x, h * 0.5]) {
            let end = DVec3::from(ray.origin) + DVec3::from(ray.direction) * wide;
            painter.line_segment([place(ray.origin.into()), place(end)], ink);
        }
    }
    painter.circle_filled(place(eye), 3.0, egui::Color32::WHITE);
}

/// A dot for every thing: what is kept lies over what was dropped. O(slots).
fn paint(session: &Session, middle: DVec3, wide: f64) -> egui::ColorImage {
    let colour = |[r, g, b]: [u8; 3]| egui::Color32::from_rgb(r, g, b);
    let mut image = egui::ColorImage::filled([SIDE, SIDE], colour(palette::NIGHT));
    let (Some(world), Some(decision)) = (&session.world, &session.decision) else { return image };
    let scene = &world.model.scene;
    let origin = DVec3::from(scene.origin());
    let scale = SIDE as f64 / wide;
    for kept in [false, true] {
        for slot in scene.slots() {
            let reason = decision.visible.reasons.get(slot as usize).copied().flatten();
            if reason.is_none() != kept {
                continue;
            }
            let bounds = scene.bounds(slot);
            // A ground would cover all else.
            let size = DVec3::from(bounds.half_extent()).length() * scale;
            if !bounds.is_finite() || size > SIDE as f64 * 0.3 {
                continue;
            }
            let at = (DVec3::from(bounds.center()) + origin - middle) * scale + SIDE as f64 * 0.5;
            let rgb = colour(palette::reason_color(reason.map(|r| r.stage)));
            let half = bounds.half_extent().map(|v| v * scale);
            let range = |at: f64, half: f64| {
                let low = (at - half).floor().clamp(0.0, SIDE as f64) as usize;
                let high = (at + half).ceil().clamp(0.0, SIDE as f64) as usize;
                low..high
            };
            for y in range(at.z, half[2]) {
                for x in range(at.x, half[0]) {
                    image.pixels[y * SIDE + x] = rgb;
                }
            }
        }
    }
    image
}
