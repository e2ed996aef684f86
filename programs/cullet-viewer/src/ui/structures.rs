//! Switches for the study of the inspected instance, of back faces and of bounds.

use cullet_mesh::MaskGrid;
use eframe::egui;

use super::words::{button, switch};
use crate::numbers::{grouped, percent};
use crate::outcodes::names;
use crate::session::Session;
use crate::state::{By, MOST_GROUPS};
use crate::study::MOST_TRIANGLES;

/// Controls below those of the hierarchy and the cones.
pub(super) fn more(ui: &mut egui::Ui, session: &mut Session) {
    let s = &mut session.state;
    switch(
        ui,
        &mut s.structure.volume,
        "culling volume",
        "Of the cluster that was clicked: from where all of it is seen from behind",
    );
    switch(
        ui,
        &mut s.structure.outcodes,
        "outcodes and clip planes",
        "Of the triangle that was clicked: beyond which planes its corners lie, and what clipping leaves (green)",
    );
    ui.separator();
    switch(
        ui,
        &mut s.study.cube,
        "direction cube",
        "The classes of normals that face away, live as the eye moves: of what is inspected, or of the whole view",
    );
    ui.add_enabled_ui(s.study.cube || s.study.by == By::Masks, |ui| {
        ui.horizontal(|ui| {
            ui.label("cells N");
            let cells = egui::DragValue::new(&mut s.study.cells);
            let about = "Cells along an edge of the cube: 6 N² classes of normals, of one bit each";
            ui.add(cells.range(1..=MaskGrid::MAX_CELLS).speed(0.1))
                .on_hover_text(about)
                .accessible_name("cells N along an edge of the direction cube");
        });
    });
    ui.horizontal(|ui| {
        ui.label("back faces by");
        let name = By::ALL.iter().find(|b| b.0 == s.study.by).map_or("", |b| b.1);
        let by = egui::ComboBox::from_id_salt("bound").selected_text(name).width(92.0);
        let shown = by.show_ui(ui, |ui| {
            for (value, name, about) in By::ALL {
                ui.selectable_value(&mut s.study.by, value, name).on_hover_text(about);
            }
        });
        shown.response.accessible_name("back faces by");
    });
    if s.study.by == By::Masks {
        ui.horizontal(|ui| {
            ui.label("groups");
            ui.add(egui::DragValue::new(&mut s.study.groups).range(1..=MOST_GROUPS).speed(0.3))
                .on_hover_text("Groups of triangles, each with a mask of its own: more cull more, and cost a mask each")
                .accessible_name("groups of triangles");
        });
    }
    figures(ui, session);
    ui.separator();
    audit(ui, session);
    if button(ui, "Clipping playground", "A polygon cut by a window, one plane after another (T)") {
        session.state.clipping.open = !session.state.clipping.open;
    }
}

fn figures(ui: &mut egui::Ui, session: &Session) {
    if session.state.study.by == By::None {
        return;
    }
    let (Some(f), Some(world), Some(inspected)) =
        (&session.figures, &session.world, &session.inspected)
    else {
        ui.weak("Click an instance to study its back faces.");
        return;
    };
    if f.too_large {
        let most = grouped(u64::from(MOST_TRIANGLES));
        let has = grouped(u64::from(f.triangles));
        ui.weak(format!("This mesh has {has} triangles; up to {most} are studied while you look."));
        return;
    }
    let (proved, away, all) = (f.proved.len() as u64, u64::from(f.away), u64::from(f.triangles));
    ui.label(format!("{} of {} triangles are proved back-facing", grouped(proved), grouped(all)));
    ui.weak(format!("{} face away: {} of them found", grouped(away), percent(proved, away)))
        .on_hover_text("What is found is violet: fly out to see it from behind");
    if world.model.scene.mesh(inspected.slot).is_two_sided() {
        ui.weak("Its mesh is two-sided, so the culler keeps them all the same.");
    }
}

fn audit(ui: &mut egui::Ui, session: &mut Session) {
    switch(
        ui,
        &mut session.state.structure.audit,
        "bounds audit",
        "Tests every vertex against the box that its instance is culled by: an instance with a vertex outside it may vanish while it is visible",
    );
    if !session.state.structure.audit {
        return;
    }
    let Some(found) = session.audit.found() else {
        ui.spinner();
        return;
    };
    if found.is_empty() {
        ui.weak("Every vertex is within its instance's bounds.");
        return;
    }
    let text = format!("bounds violations: {}", grouped(found.len() as u64));
    ui.colored_label(ui.visuals().error_fg_color, text);
    let mut chosen = None;
    let worst = found.iter().take(8);
    for violation in worst {
        let name =
            session.world.as_ref().map(|w| w.model.instance_name(violation.handle).into_owned());
        let text = format!("{}: {:.3}", name.unwrap_or_default(), violation.excess);
        let about = format!(
            "{} vertices are outside, by up to {:.4} units",
            violation.outside, violation.excess
        );
        if button(ui, &text, &about) {
            chosen = Some(violation.handle);
        }
    }
    if let Some(handle) = chosen {
        session.inspect_handle(handle, 0);
    }
}

/// The outcodes of the triangle that was clicked, in the panel of what is inspected.
pub(super) fn outcodes(ui: &mut egui::Ui, session: &Session) {
    let Some(coded) = session.coded().filter(|_| session.state.structure.outcodes) else { return };
    ui.separator();
    ui.label("Outcodes of the triangle")
        .on_hover_text("The planes that each corner is proved outside of");
    for (i, (_, code)) in coded.corners.iter().enumerate() {
        let corner = char::from(b'A' + i as u8);
        ui.weak(format!("{corner}  {:06b}  {}", code.outside & 0b11_1111, names(code.outside)));
    }
    ui.weak(coded.words());
    let planes = coded.planes.iter().fold(0, |bits, (i, _)| bits | 1 << i);
    ui.weak(match planes {
        0 => "its box is inside of every plane".to_owned(),
        _ => format!("planes that its box is not inside of: {}", names(planes)),
    });
}
