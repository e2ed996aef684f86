//! The cut-away: by what, where, and which part is shown.

use eframe::egui;

use super::words::{button, choices, switch};
use crate::numbers::grouped;
use crate::session::Session;
use crate::state::{CutAway, Part, REACH, Shape};

/// The section.
pub(super) fn section(ui: &mut egui::Ui, session: &mut Session) {
    let about = "Cuts the scene open by a plane or a box; what is left is a scene that is culled like any other (Z)";
    switch(ui, &mut session.state.cut.on, "cut", about);
    if !session.state.cut.on {
        return;
    }
    let cut = &mut session.state.cut;
    choices(
        ui,
        "cut by",
        &mut cut.shape,
        &[
            (Shape::Plane, "plane", "One plane through the scene"),
            (Shape::Box, "box", "Six upright planes"),
        ],
    );
    let parts = match cut.shape {
        Shape::Plane => [
            (Part::Inside, "behind it", "What the normal points away from is shown"),
            (Part::Outside, "before it", "What the normal points to is shown"),
        ],
        Shape::Box => [
            (Part::Inside, "inside", "What is in the box is shown"),
            (Part::Outside, "outside", "The box is taken out of the scene"),
        ],
    };
    choices(ui, "what is shown", &mut cut.part, &parts);
    ui.spacing_mut().slider_width = 96.0;
    match cut.shape {
        Shape::Plane => plane(ui, cut),
        Shape::Box => {
            for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                for (value, end) in [(&mut cut.low[axis], "from"), (&mut cut.high[axis], "to")] {
                    ui.horizontal(|ui| {
                        place(ui, value, &format!("{name} {end}"));
                    });
                }
            }
        }
    }
    switch(
        ui,
        &mut cut.caps,
        "caps",
        "Closes what is solid where it is cut, in the red of section drawings",
    );
    switch(ui, &mut cut.outlines, "outlines", "The outlines of the cut, as in a section drawing");
    if cut.shape == Shape::Plane
        && button(
            ui,
            "Face the cut",
            "Looks straight at the cut from afar, almost to scale (End); Home goes back",
        )
    {
        session.face_cut();
    }
    if session.cutting.is_working() {
        ui.horizontal(|ui| {
            ui.spinner();
            ui.weak("cutting …");
        });
        return;
    }
    let t = &session.cutting.report;
    ui.weak(format!(
        "{} instances cut, {} dropped, {:.0} ms",
        grouped(t.instances_cut),
        grouped(t.instances_dropped),
        session.cutting.milliseconds
    ));
    if session.state.cut.caps {
        let open = match t.open_edges {
            0 => String::new(),
            n => format!("; {} edges of open surfaces have none", grouped(n)),
        };
        ui.weak(format!(
            "caps: {} triangles, area {:.4}{open}",
            grouped(t.cap_triangles),
            t.cap_area
        ))
        .on_hover_text("The area of what is cut through, in squared units of the scene");
    }
}

fn plane(ui: &mut egui::Ui, cut: &mut CutAway) {
    ui.horizontal(|ui| {
        ui.label("across");
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let mut normal = [0.0; 3];
            normal[axis] = 1.0;
            ui.selectable_value(&mut cut.normal, normal, name)
                .on_hover_text("The plane stands across this axis")
                .accessible_name(format!("across {name}"));
        }
    });
    ui.horizontal(|ui| {
        ui.label("normal");
        let before = cut.normal;
        for (v, axis) in cut.normal.iter_mut().zip(["x", "y", "z"]) {
            ui.add(egui::DragValue::new(v).range(-1.0..=1.0).speed(0.01).max_decimals(2))
                .on_hover_text("The plane's normal, of any length: it points out of what is kept")
                .accessible_name(format!("normal {axis}"));
        }
        // All zeros have no direction.
        if cut.check().is_err() {
            cut.normal = before;
        }
    });
    ui.horizontal(|ui| place(ui, &mut cut.at, "at"));
}

/// Where a plane stands, to a hundredth, so that links stay short.
fn place(ui: &mut egui::Ui, value: &mut f64, name: &str) {
    let slider =
        egui::Slider::new(value, -REACH..=REACH).step_by(0.01).fixed_decimals(2).text(name);
    ui.add(slider).on_hover_text("0 is the middle of the scene, 1 its end along this axis");
}
