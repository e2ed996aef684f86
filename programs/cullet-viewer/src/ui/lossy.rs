//! The switches of what may change the picture: small instances, and levels of detail.

use cullet::cull::detail::Measure;
use cullet::draw::DrawRange;
use cullet_mesh::Impostor;
use eframe::egui;

use super::words::{choices, switch};
use crate::numbers::grouped;
use crate::session::Session;
use crate::state::{Colour, Stages};

/// Facts of the session that these switches show.
pub(super) struct Found {
    has_levels: bool,
    /// How many impostors are drawn, where the scene has any.
    impostors: Option<usize>,
    /// How many instances fade from one level to the next.
    fading: usize,
    /// Pixels by which what is drawn may be off.
    decided: Option<f64>,
    pops: Option<String>,
}

impl Found {
    pub(super) fn of(session: &Session) -> Self {
        let scene = session.world.as_ref().map(|world| &world.model.scene);
        let levels = || {
            let meshes = scene.map_or(0, |scene| scene.meshes().len() as u32);
            (0..meshes).flat_map(|mesh| scene.map_or(&[][..], |scene| scene.levels(mesh)))
        };
        let drawn = session.decision.as_ref().map_or(&[][..], |d| &d.visible.partial);
        let is_impostor =
            |r: &&DrawRange| scene.is_some_and(|s| Impostor::at(s, r.slot, r.level).is_some());
        let has_impostors = levels().any(|l| l.impostor.is_some());
        let shows_pops = session.state.look.colour == Colour::Pops;
        Self {
            has_levels: levels().next().is_some(),
            impostors: has_impostors.then(|| drawn.iter().filter(is_impostor).count()),
            fading: session.fades.len(),
            decided: session.decision.as_ref().and_then(|d| d.visible.lod_pixels),
            pops: shows_pops.then(|| session.pops.text()),
        }
    }
}

/// All of them.
pub(super) fn all(ui: &mut egui::Ui, s: &mut Stages, found: &Found) {
    detail(ui, s);
    levels(ui, s, found);
    if let Some(pops) = &found.pops {
        ui.weak(pops);
    }
}

/// Small instances.
fn detail(ui: &mut egui::Ui, s: &mut Stages) {
    ui.horizontal(|ui| {
        let mut on = s.detail_px > 0.0;
        if switch(ui, &mut on, "small", "Drops what stays under this many pixels: the one switch here that may change the picture") {
            s.detail_px = if on { 2.0 } else { 0.0 };
        }
        let pixels = egui::DragValue::new(&mut s.detail_px).range(0.0..=64.0).speed(0.1).suffix(" px");
        ui.add_enabled(on, pixels).accessible_name("small: threshold in pixels");
    });
    if s.detail_px > 0.0 {
        choices(
            ui,
            "small by",
            &mut s.detail_by,
            &[
                (Measure::WidthAndHeight, "box", "Width and height are both under it"),
                (Measure::Area, "area", "The area is under it, in square pixels"),
                (Measure::Diameter, "diagonal", "The diagonal is under it"),
            ],
        );
        ui.horizontal(|ui| {
            let about = "What comes near that size is drawn by fewer and fewer pixels, so that nothing pops: the colours “pops” show what does";
            let mut on = s.detail_fade > 0.0;
            if switch(ui, &mut on, "fade", about) {
                s.detail_fade = if on { 0.5 } else { 0.0 };
            }
            let share = egui::DragValue::new(&mut s.detail_fade).range(0.0..=4.0).speed(0.01);
            let about = "From how much above that size, as a share of it";
            let share = ui.add_enabled(on, share).on_hover_text(about);
            share.accessible_name("fade of small instances: from how much above, as a share");
        });
    }
}

/// Levels of detail, if the scene has any.
fn levels(ui: &mut egui::Ui, s: &mut Stages, found: &Found) {
    if !found.has_levels {
        let about = if cfg!(target_arch = "wasm32") {
            "A page reads none: cullet view baked.glb shows those of a file that cullet bake wrote"
        } else {
            "cullet bake model.glb -o baked.glb writes a file that has them; open that"
        };
        ui.weak("no levels of detail").on_hover_text(about);
        return;
    }
    ui.horizontal(|ui| {
        let mut on = s.lod_px > 0.0;
        let about = "Draws fewer triangles, off by no more than this many pixels: the colours “levels” show which";
        if switch(ui, &mut on, "levels", about) {
            s.lod_px = if on { 1.0 } else { 0.0 };
        }
        let slider = egui::Slider::new(&mut s.lod_px, 0.0..=64.0).logarithmic(true).suffix(" px");
        let pixels = ui.add_enabled(on, slider.smallest_positive(0.1));
        pixels.accessible_name("levels: error in pixels");
    });
    if s.lod_px > 0.0 {
        ui.horizontal(|ui| {
            let about = "Also in the corners of the picture, where a pixel is a smaller angle";
            switch(ui, &mut s.lod_corners, "in corners", about);
            let about = "Chosen for a ball of eyes: nothing changes until the eye has left it";
            switch(ui, &mut s.lod_steady, "steady", about);
            if s.lod_steady {
                let ball = egui::DragValue::new(&mut s.lod_ball).range(0.0..=1.0).speed(0.005);
                let about = "The radius of the ball, as a share of the distance";
                ui.add(ball).on_hover_text(about).accessible_name("radius of the ball of eyes");
            }
        });
        ui.horizontal(|ui| {
            let about = "The least error at which no more triangles than this are chosen, counted before clusters are culled";
            let mut on = s.lod_triangles > 0;
            if switch(ui, &mut on, "at most", about) {
                s.lod_triangles = if on { 100_000 } else { 0 };
            }
            let most = egui::DragValue::new(&mut s.lod_triangles).range(0..=u64::MAX).speed(1000.0);
            let most = ui.add_enabled(on, most.suffix(" triangles"));
            most.accessible_name("at most so many triangles");
        });
        ui.horizontal(|ui| {
            let about = "Levels fade into those that follow: for a while both are drawn, each in the pixels that the other leaves";
            let mut on = s.lod_fade > 0.0;
            if switch(ui, &mut on, "fade", about) {
                s.lod_fade = if on { 0.3 } else { 0.0 };
            }
            let time = egui::DragValue::new(&mut s.lod_fade).range(0.0..=60.0).speed(0.01);
            let time = ui.add_enabled(on, time.suffix(" s"));
            time.accessible_name("fade of levels in seconds");
            if found.fading > 0 {
                ui.weak(format!("{} now", grouped(found.fading as u64)));
            }
        });
        if let Some(drawn) = found.impostors {
            ui.horizontal(|ui| {
                let about = "Pictures of a mesh from all around in its place, where it is small enough. Off: its other levels. The wipe (3) has the originals beside";
                switch(ui, &mut s.lod_impostors, "impostors", about);
                ui.weak(format!("{} drawn", grouped(drawn as u64)));
            });
        }
        if let Some(pixels) = found.decided {
            ui.weak(format!("drawn within {pixels:.2} px of the original"));
        }
    }
}
