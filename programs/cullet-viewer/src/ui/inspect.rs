//! Panel of the clicked instance: its chain of tests, with numbers.

use cullet::Stage;
use cullet_draw::palette;
use eframe::egui;

use super::words::swatch;
use crate::numbers::grouped;
use crate::session::Session;

/// The most names of occluders of an instance.
const MOST_BLOCKERS: usize = 12;

/// The panel.
pub(super) fn all(ui: &mut egui::Ui, session: &mut Session) {
    ui.strong("Inspect");
    let (Some(world), Some(decision), Some(inspected)) =
        (&session.world, &session.decision, &session.inspected)
    else {
        ui.weak("Click an instance: which tests it came to, and their numbers.");
        return;
    };
    let scene = &world.model.scene;
    ui.label(world.model.instance_name(inspected.handle));
    let reason = inspected.explanation.reason;
    ui.horizontal_wrapped(|ui| {
        swatch(ui, palette::reason_color(reason.map(|r| r.stage)));
        match reason {
            Some(reason) => {
                ui.strong(format!("dropped: {}", palette::reason_label(Some(reason.stage))))
            }
            None => ui.strong("drawn"),
        };
    });
    for step in &inspected.explanation.steps {
        let result = if step.left == 0 {
            "dropped"
        } else if step.left == step.entered {
            "passes"
        } else {
            "passes in part"
        };
        ui.label(format!("{} · {} · {result}", step.stage.name(), step.unit.name()));
        ui.indent(("step", step.stage.name(), step.unit.name()), |ui| {
            ui.weak(step.to_string());
        });
    }
    let view = &decision.request.view;
    let bounds = scene.bounds(inspected.slot);
    match view.project_box(&bounds, scene.origin()) {
        Some(r) => ui.weak(format!(
            "on the screen: {:.0}, {:.0} to {:.0}, {:.0} ({:.1} × {:.1} pixels)",
            r.min[0],
            r.min[1],
            r.max[0],
            r.max[1],
            r.width(),
            r.height()
        )),
        None => ui.weak("on the screen: its box crosses the near plane"),
    };
    let mesh = scene.mesh(inspected.slot);
    let name = world.model.mesh_names.get(scene.mesh_id(inspected.slot) as usize);
    ui.weak(format!(
        "mesh {}: {} triangles in {} clusters, {}",
        name.map_or("", String::as_str),
        grouped(u64::from(mesh.triangle_count())),
        mesh.clusters().len(),
        if mesh.is_two_sided() { "two-sided" } else { "one-sided" }
    ));
    super::structures::outcodes(ui, session);
    ui.weak(format!("slot {}, triangle {}", inspected.slot, inspected.triangle));
    let hidden_by = inspected.explanation.hidden_by.clone();
    let name = |slot: u32| scene.handle(slot).map(|h| world.model.instance_name(h).to_string());
    let mut chosen = None;
    if !hidden_by.is_empty() {
        ui.horizontal_wrapped(|ui| {
            swatch(ui, palette::reason_color(Some(Stage::Occlusion)));
            ui.label(format!("hidden by {}, the nearest first:", hidden_by.len()))
                .on_hover_text("Outlined in the picture in this colour. A click inspects it");
        });
        for &slot in hidden_by.iter().take(MOST_BLOCKERS) {
            let words = name(slot).unwrap_or_else(|| format!("slot {slot}"));
            if ui.link(words).clicked() {
                chosen = Some(slot);
            }
        }
        if hidden_by.len() > MOST_BLOCKERS {
            ui.weak(format!("and {} more", hidden_by.len() - MOST_BLOCKERS));
        }
    }
    if let Some(slot) = chosen {
        session.inspect_slot(slot);
    }
    if ui.small_button("Close").clicked() {
        session.inspected = None;
    }
}
