//! Who decides what is drawn, and what the graphics device says of it.

use eframe::egui;

use super::words::{choices, switch};
use crate::numbers::grouped;
use crate::session::Session;
use crate::state::{Layout, OnDevice};

/// The switch between CPU and device; without effect where the device cannot, which it then says.
pub(super) fn who(ui: &mut egui::Ui, session: &mut Session) {
    let refused = session.device.refused.as_deref();
    let on = &mut session.state.device.on;
    let row = ui.horizontal_wrapped(|ui| {
        ui.label("decided by").on_hover_text(
            "Who finds out what is drawn. Reasons, funnel and what is clicked are the CPU's in any case",
        );
        ui.add_enabled_ui(refused.is_none(), |ui| {
            choices(ui, "decided by", on, &[
                (false, "CPU", "All stages below, in a thread of its own"),
                (
                    true,
                    "device",
                    "The graphics device, in two phases: instances against the frustum, then their boxes against the depth of \
                     what was visible before. Frustum and occlusion alone: all else is drawn in full (')",
                ),
            ]);
        })
        .response
    });
    if let Some(why) = refused {
        row.inner.on_hover_text(why);
        if session.state.device.on {
            ui.weak(format!("The CPU decides: {why}."));
        }
    }
}

/// Shows the controls of the division of the picture.
pub(super) fn beside(ui: &mut egui::Ui, session: &mut Session) {
    if !session.by_device() {
        return;
    }
    let size = session.culling_size();
    let device = &mut session.state.device;
    match session.state.layout {
        Layout::Wipe => {
            let about =
                "To the right of the divider is what the CPU decides, rather than everything";
            switch(ui, &mut device.compare, "against the CPU", about);
        }
        Layout::Buffer => {
            ui.horizontal(|ui| {
                ui.label("level");
                ui.spacing_mut().slider_width = 100.0;
                let levels = OnDevice::levels(size);
                let level = ui.add(egui::Slider::new(&mut device.level, 0..=levels - 1));
                let level = level.accessible_name("level of the depth pyramid");
                level.on_hover_text(
                    "Of the depth pyramid: each texel is the farthest of four of the level below, so that one look says of \
                     many pixels that they are nearer",
                );
            });
        }
        _ => {}
    }
}

/// The figures of the newest picture that are known.
pub(super) fn figures(ui: &mut egui::Ui, session: &Session) {
    if !session.by_device() {
        return;
    }
    let f = &session.device.figures;
    if f.frame == 0 {
        ui.weak("The device has said nothing yet.");
        return;
    }
    ui.weak("by the device, instances in full");
    let row = |ui: &mut egui::Ui, name: &str, value: String, about: &str| {
        ui.label(name).on_hover_text(about);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| ui.label(value));
        ui.end_row();
    };
    egui::Grid::new("by the device").num_columns(2).show(ui, |ui| {
        let about = "Instances whose boxes are not beyond a plane of the frustum";
        row(ui, "in view", grouped(u64::from(f.in_view)), about);
        let about = "Of these the ones that the depth pyramid does not prove hidden";
        row(ui, "visible", grouped(u64::from(f.visible)), about);
        row(ui, "triangles", grouped(f.triangles), "Those of the visible instances");
        let about = "Those of instances that were visible in the picture before and are in view: their depth is what the rest is \
                     tested against";
        row(ui, "of depth", grouped(f.early_triangles), about);
        let draws = [f.draws_in_use, f.draws].map(|n| grouped(u64::from(n)));
        let about = "Draws with an instance, of those that are handed in: the CPU does not know which";
        row(ui, "draws", format!("{} of {}", draws[0], draws[1]), about);
        let Some(times) = &f.times else { return };
        for (name, took, about) in [
            ("planes", times.early, "All instances against the planes, and the list of those seen before"),
            ("depth", times.depth, "The depth of those seen before"),
            ("pyramid", times.pyramid, "Its pyramid, level by level (4 shows it)"),
            ("boxes", times.late, "Boxes against the pyramid, and the list of what is visible"),
        ] {
            row(ui, name, format!("{took:.2} ms"), about);
        }
    });
}
