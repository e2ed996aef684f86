//! The occlusion buffer on the picture.

use cullet::Stage;
use cullet_draw::palette;
use eframe::egui;
use glam::DVec3;

use super::words::colour;
use crate::compose::{Composition, Role};
use crate::nearness;
use crate::session::Session;
use crate::state::Layout;

/// A texture, and the inputs that it was made from.
#[derive(Clone)]
struct Made {
    key: (usize, u64, bool, bool),
    texture: egui::TextureHandle,
}

/// Paints the buffer where it is wanted: over the pane of the camera that it was made for, or in
/// the right half.
pub(super) fn show(ui: &egui::Ui, rect: egui::Rect, session: &Session, made: &Composition) {
    let state = &session.state;
    if !state.wants_buffer() || session.world.is_none() {
        return;
    }
    let beside = state.layout == Layout::Buffer;
    let ratio = ui.ctx().pixels_per_point();
    let painter = ui.painter_at(rect);
    // The device's pyramid is in the picture already.
    let is_pyramid = session.by_device() && state.stages.occlusion;
    if beside && !is_pyramid {
        let half = ((session.size[0] / 2).max(1)) as f32 / ratio;
        let right = egui::Rect::from_min_max(egui::pos2(rect.min.x + half, rect.min.y), rect.max);
        match texture(ui, session, false) {
            Some(texture) => {
                image(&painter, &texture, right);
                screen_bounds(&painter, session, right);
            }
            None => missing(ui, &painter, right, session),
        }
    }
    if !state.structure.buffer {
        return;
    }
    let Some(texture) = texture(ui, session, true) else { return };
    for panel in &made.panels {
        let own = match panel.role {
            Role::Culling | Role::Depth => true,
            // A part of a wipe shows a part of the view.
            Role::Flown => state.frozen.is_none() && state.layout == Layout::One,
            Role::Outside | Role::Bare => false,
        };
        if own {
            let [x, y, w, h] = panel.place.map(|v| v as f32 / ratio);
            let place = egui::Rect::from_min_size(rect.min + egui::vec2(x, y), egui::vec2(w, h));
            image(&painter, &texture, place);
            screen_bounds(&painter, session, place);
        }
    }
}

/// Draws the pixels that the inspected instance may touch: all of them must be covered for it to be
/// hidden.
fn screen_bounds(painter: &egui::Painter, session: &Session, place: egui::Rect) {
    let (Some(world), Some(inspected)) = (&session.world, &session.inspected) else { return };
    let Some(buffer) = session.decision.as_ref().and_then(|d| d.buffer.as_ref()) else { return };
    let Some(f) = buffer.screen_bounds(&world.model.scene.bounds(inspected.slot)) else { return };
    let size = buffer.size().map(|v| v as f32);
    let at = |x: u32, y: u32| {
        place.min + place.size() * egui::vec2(x as f32 / size[0], y as f32 / size[1])
    };
    let rect = egui::Rect::from_min_max(at(f.min[0], f.min[1]), at(f.max[0] + 1, f.max[1] + 1));
    let stroke = egui::Stroke::new(1.5, colour(palette::reason_color(Some(Stage::Occlusion))));
    painter.with_clip_rect(place).rect_stroke(rect, 0.0, stroke, egui::StrokeKind::Outside);
}

fn image(painter: &egui::Painter, texture: &egui::TextureHandle, place: egui::Rect) {
    let uv = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    painter.image(texture.id(), place, uv, egui::Color32::WHITE);
}

/// Says why there is no buffer.
fn missing(ui: &egui::Ui, painter: &egui::Painter, place: egui::Rect, session: &Session) {
    let stages = &session.state.stages;
    let words = if session.decision.is_none() {
        "Nothing is decided yet."
    } else if stages.on && stages.occlusion {
        "There is no buffer for this view."
    } else {
        "Occlusion culling is off: there is no buffer."
    };
    let font = egui::TextStyle::Body.resolve(ui.style());
    let ink = ui.visuals().weak_text_color();
    painter.text(place.center(), egui::Align2::CENTER_CENTER, words, font, ink);
}

/// The buffer's texture, made anew where the decision is another; `None` where there is no buffer.
fn texture(ui: &egui::Ui, session: &Session, over: bool) -> Option<egui::TextureHandle> {
    let (world, decision) = (session.world.as_ref()?, session.decision.as_ref()?);
    let buffer = decision.buffer.as_ref()?;
    let tiles = session.state.structure.tiles;
    let key = (std::sync::Arc::as_ptr(world) as usize, decision.number, tiles, over);
    let id = egui::Id::unique(if over { "buffer over" } else { "buffer" });
    if let Some(made) = ui.data(|d| d.get_temp::<Made>(id)).filter(|m| m.key == key) {
        return Some(made.texture);
    }
    let extent = DVec3::from(world.model.scene.extent().half_extent());
    let view = &decision.request.view;
    let picture = nearness::paint(buffer, view, extent.length(), tiles, over);
    let bytes = picture.pixels.as_flattened();
    let image = egui::ColorImage::from_rgba_unmultiplied(picture.size, bytes);
    // Nearest sampling, since the proof of a pixel says nothing of its neighbours.
    let texture = ui.ctx().load_texture("occlusion buffer", image, egui::TextureOptions::NEAREST);
    ui.data_mut(|d| d.insert_temp(id, Made { key, texture: texture.clone() }));
    Some(texture)
}
