//! The map: every instance as a dot from above, in the colour of the stage that culled it, with the
//! frustum. Painted on the processor, so that it costs the graphics card nothing.

use std::sync::Arc;

use cullet::{Reason, Scene, View};
use cullet_draw::palette;
use eframe::egui::{self, mutex::Mutex};
use glam::DVec3;

use super::tour;
use crate::levels_alone::is_dropped;
use crate::session::Session;
use crate::task::{clock, until};

/// Pixels along a side of the map's picture.
const SIDE: usize = 192;

/// Inputs of a picture of the map: the scene, the decision about it, the point in the middle.
type Key = (usize, u64, [u64; 3]);

/// The picture that is shown, and the next one while it is painted.
#[derive(Default)]
struct Map {
    shown: Option<(Key, DVec3, egui::TextureHandle)>,
    next: Option<Painting>,
}

/// Shows the map in the lower right corner of the picture, if it is wanted and there is something
/// to map; where the tour's card needs that corner, it has it.
pub(super) fn show(ui: &egui::Ui, picture: egui::Rect, session: &Session) {
    let (true, Some(world), Some(decision), Some(rig)) =
        (session.state.map, &session.world, &session.decision, session.culling_rig())
    else {
        return;
    };
    let side = (picture.size().min_elem() * 0.32).min(220.0);
    let corner = picture.max - egui::vec2(8.0, 8.0);
    let rect = egui::Rect::from_min_max(corner - egui::vec2(side, side), corner);
    if session.tour.is_some() && tour::card_right(picture) > rect.left() {
        return;
    }
    let eye = DVec3::from(rig.eye());
    // The middle follows the eye in steps, so that the picture is not made anew for every step of
    // it.
    let wide = world.reach * 1.7;
    let step = wide / 8.0;
    let middle = DVec3::from(world.centre).lerp(eye, 0.5);
    let middle = (middle / step).round() * step;
    let key = (Arc::as_ptr(world) as usize, decision.number, middle.to_array().map(f64::to_bits));
    let id = egui::Id::unique("map");
    let map = ui.data_mut(|d| d.get_temp_mut_or_default::<Arc<Mutex<Map>>>(id).clone());
    let Some((middle, texture)) = map.lock().follow(ui.ctx(), session, key, wide) else { return };
    let painter = ui.painter_at(picture);
    let uv = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    painter.image(texture, rect, uv, egui::Color32::WHITE);
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

impl Map {
    /// Goes on with what is to be shown: the middle and the texture of the newest that is finished.
    fn follow(
        &mut self,
        ctx: &egui::Context,
        session: &Session,
        wanted: Key,
        wide: f64,
    ) -> Option<(DVec3, egui::TextureId)> {
        let (world, decision) = (session.world.as_ref()?, session.decision.as_ref()?);
        // Slots of another scene are other instances.
        self.shown.take_if(|(key, ..)| key.0 != wanted.0);
        self.next.take_if(|next| next.key.0 != wanted.0);
        if self.shown.as_ref().is_none_or(|(key, ..)| *key != wanted) {
            // One that is begun is finished, or a camera that moves on would never see any.
            let next = self.next.get_or_insert_with(|| Painting::new(wanted, wide));
            if next.go_on(&world.model.scene, &decision.visible.reasons, until(clock())) {
                let image = std::mem::take(&mut next.image);
                let texture = ctx.load_texture("map", image, egui::TextureOptions::LINEAR);
                self.shown = Some((next.key, next.middle(), texture));
                self.next = None;
            }
            ctx.request_repaint();
        }
        self.shown.as_ref().map(|(_, middle, texture)| (*middle, texture.id()))
    }
}

/// A picture that is painted a little at a time.
struct Painting {
    key: Key,
    wide: f64,
    image: egui::ColorImage,
    /// Whether each pixel shows what is kept, which lies over what was dropped.
    kept: Vec<bool>,
    /// The first slot that is not painted yet.
    slot: u32,
}

/// Slots between two looks at the clock.
const BATCH: u32 = 1024;

impl Painting {
    fn new(key: Key, wide: f64) -> Self {
        let [r, g, b] = palette::NIGHT;
        let image = egui::ColorImage::filled([SIDE, SIDE], egui::Color32::from_rgb(r, g, b));
        Self { key, wide, image, kept: vec![false; SIDE * SIDE], slot: 0 }
    }

    fn middle(&self) -> DVec3 {
        DVec3::from(self.key.2.map(f64::from_bits))
    }

    /// Paints a dot for every instance until some moment, or to the end: then true. O(slots).
    fn go_on(&mut self, scene: &Scene, reasons: &[Option<Reason>], until: u64) -> bool {
        let count = scene.slot_count();
        while self.slot < count && clock() < until {
            let end = (self.slot + BATCH).min(count);
            for slot in (self.slot..end).filter(|&s| !scene.is_removed(s) && !scene.is_stand_in(s))
            {
                let reason = reasons.get(slot as usize).copied().flatten();
                // What others stand for is drawn in them.
                self.dot(scene, slot, reason.filter(|r| is_dropped(scene, slot, *r)));
            }
            self.slot = end;
        }
        self.slot == count
    }

    fn dot(&mut self, scene: &Scene, slot: u32, reason: Option<Reason>) {
        let bounds = scene.bounds(slot);
        let scale = SIDE as f64 / self.wide;
        // A ground would cover all else.
        let size = DVec3::from(bounds.half_extent()).length() * scale;
        if !bounds.is_finite() || size > SIDE as f64 * 0.3 {
            return;
        }
        let origin = DVec3::from(scene.origin());
        let at =
            (DVec3::from(bounds.center()) + origin - self.middle()) * scale + SIDE as f64 * 0.5;
        let [r, g, b] = palette::reason_color(reason.map(|r| r.stage));
        let half = bounds.half_extent().map(|v| v * scale);
        let range = |at: f64, half: f64| {
            let low = (at - half).floor().clamp(0.0, SIDE as f64) as usize;
            let high = (at + half).ceil().clamp(0.0, SIDE as f64) as usize;
            low..high
        };
        for y in range(at.z, half[2]) {
            for pixel in range(at.x, half[0]).map(|x| y * SIDE + x) {
                if reason.is_none() || !self.kept[pixel] {
                    self.image.pixels[pixel] = egui::Color32::from_rgb(r, g, b);
                    self.kept[pixel] = reason.is_none();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_lies_over_what_was_dropped_however_often_painting_stops() {
        let scene = cullet_scenes::build("city:cells=6,objects=3000").unwrap().scene;
        assert!(scene.slot_count() > 2 * BATCH);
        let middle = DVec3::from(scene.extent().center()) + DVec3::from(scene.origin());
        let key = (0, 0, middle.to_array().map(f64::to_bits));
        let wide = DVec3::from(scene.extent().half_extent()).length() * 2.0;
        let dropped = Some(Reason { stage: cullet::Stage::Frustum, detail: 0 });
        let reasons: Vec<_> =
            scene.slots().map(|s| if s % 3 == 0 { None } else { dropped }).collect();
        let mut whole = Painting::new(key, wide);
        assert!(whole.go_on(&scene, &reasons, u64::MAX));
        // The slow way: all of one kind, then all of the other.
        let mut layers = Painting::new(key, wide);
        for kept in [false, true] {
            for slot in scene.slots() {
                let reason = reasons[slot as usize];
                if reason.is_none() == kept {
                    layers.dot(&scene, slot, reason);
                }
            }
        }
        assert!(whole.image == layers.image);
        assert!(whole.kept.iter().any(|k| *k) && !whole.kept.iter().all(|k| *k));
        let mut slow = Painting::new(key, wide);
        assert!(!slow.go_on(&scene, &reasons, 0), "no time, no dots");
        assert_eq!(slow.slot, 0);
    }
}
