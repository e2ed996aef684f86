//! The switches: what culls, from where, how it is drawn, what is shown of what was dropped.

use cullet::{Backface, Culler, Output, view::CullFace};
use cullet_scenes::paths::PathSpec;
use eframe::egui;

use super::lossy;
use super::words::{button, choices, colour, switch};
use crate::camera::{Chase, Mode};
use crate::cost::Measured;
use crate::journey::RATE;
use crate::numbers::grouped;
use crate::session::Session;
use crate::state::{Colour, GhostForm, Layout, Sides, Stages, Structure, WIDEST_BUFFER};
use crate::structure;

/// All of them.
pub(super) fn all(ui: &mut egui::Ui, session: &mut Session) {
    section(ui, "Culling", true, |ui| culling(ui, session));
    section(ui, "Cameras", true, |ui| cameras(ui, session));
    section(ui, "What was dropped", true, |ui| ghosts(ui, session));
    section(ui, "Picture", true, |ui| picture(ui, session));
    section(ui, "Cut-away", session.state.cut.on, |ui| super::cut::section(ui, session));
    section(ui, "Camera path", false, |ui| {
        journey(ui, session);
        report(ui, session);
    });
    if super::cells::are_there(session) {
        let s = &session.state;
        let shown = s.structure.cells || s.structure.portals || !s.doors.is_empty();
        section(ui, "Cells and portals", shown, |ui| super::cells::section(ui, session));
    }
    // Open where a link shows something of it.
    let s = &session.state;
    let of_cells = Structure {
        cells: s.structure.cells,
        portals: s.structure.portals,
        step: s.structure.step,
        ..Structure::default()
    };
    let shown = s.structure != of_cells || s.study != Default::default();
    section(ui, "Structures", shown, |ui| structures(ui, session));
}

/// A section that is open at first where `open` holds, and opens where that comes to hold, as by a
/// key.
fn section(ui: &mut egui::Ui, name: &str, open: bool, body: impl FnOnce(&mut egui::Ui)) {
    let id = ui.scope_id().with((name, "open"));
    let before = ui.data_mut(|data| std::mem::replace(data.get_temp_mut_or(id, open), open));
    let opens = (open && !before).then_some(true);
    egui::CollapsingHeader::new(name).default_open(open).open(opens).show_unindented(ui, body);
}

fn culling(ui: &mut egui::Ui, session: &mut Session) {
    let kept = session.kept_backs();
    let has_cells = super::cells::are_there(session);
    let found = lossy::Found::of(session);
    super::deciding::who(ui, session);
    let s = &mut session.state.stages;
    ui.horizontal_wrapped(|ui| {
        switch(ui, &mut s.on, "cull", "All culling at once; off draws everything (C)");
        ui.separator();
        for (name, about, preset) in [
            (
                "frustum only",
                "Frustum culling of whole instances, the first kind in most engines (6)",
                Stages::frustum_only(),
            ),
            (
                "+ back faces",
                "Also back-face culling, down to clusters; without occlusion culling (7)",
                Stages::without_occlusion(),
            ),
            ("default", "Also occlusion culling (8)", Stages::default()),
            (
                "exact",
                "As the default, with all that a wide buffer and any budget find",
                Stages::of(&Culler::exact()),
            ),
            (
                "fast",
                "What is found soonest: a narrow buffer, and few occluders",
                Stages::of(&Culler::fast()),
            ),
            (
                "all, lossy",
                "Down to triangles, with detail culling under two pixels (9)",
                Stages::all(),
            ),
        ] {
            let choice = ui.selectable_label(*s == preset, name).on_hover_text(about);
            if choice.accessible_name(format!("preset: {name}")).clicked() {
                *s = preset;
            }
        }
    });
    ui.add_enabled_ui(s.on, |ui| {
        switch(ui, &mut s.frustum, "frustum", "Drops what is beside, behind or too far: never wrong, some nanoseconds per instance");
        ui.add_enabled_ui(s.frustum, |ui| {
            let about = "Also drops big boxes near the frustum's corners, at some 50 ns for each that straddles";
            switch(ui, &mut s.frustum_exact, "exact at corners", about);
        });
        if has_cells {
            let about = "Drops what is in no cell that is seen through open portals, or beside those: some microseconds a view, and never wrong if the cells are true";
            switch(ui, &mut s.portal, "portals", about);
        }
        ui.horizontal(|ui| {
            ui.label("back faces");
            choices(ui, "back faces", &mut s.backface, &[
                (Backface::Off, "off", "Back faces of solids are kept"),
                (Backface::Fast, "fast", "Clusters that face away go whole, by a cone; then triangles by a plane of four bytes"),
                (Backface::Exact, "exact", "Each triangle from its corners: 15 ns each, where the output is triangles"),
            ]);
        });
        ui.horizontal_wrapped(|ui| {
            ui.label("sides").on_hover_text("Back faces are culled of one-sided triangles alone");
            choices(ui, "sides", &mut session.state.sides, &Sides::ALL);
        });
        if let Some(kept) = kept {
            ui.weak(kept);
        }
        switch(ui, &mut s.degenerate, "degenerate", "Culls triangles without area: they can own no pixel");
        lossy::all(ui, s, &found);
        occlusion(ui, s);
        ui.horizontal(|ui| {
            ui.label("depth");
            choices(ui, "depth", &mut s.depth, &[
                (Output::Instances, "instances", "Whole instances: the cheapest answer"),
                (Output::Clusters, "clusters", "Groups of up to 124 triangles of instances that straddle or face away in part"),
                (Output::Triangles, "triangles", "Single triangles: the tightest answer, and the most expensive"),
            ]);
        });
    });
}

fn occlusion(ui: &mut egui::Ui, s: &mut Stages) {
    let about = "Drops what lies behind something, proved for every pixel of any resolution: never wrong; some \
                 tenths of a millisecond, which pay where much is hidden";
    switch(ui, &mut s.occlusion, "occlusion", about);
    if !s.occlusion {
        return;
    }
    ui.horizontal(|ui| {
        let width = egui::DragValue::new(&mut s.occlusion_width);
        let width = width.range(1..=WIDEST_BUFFER).speed(4.0).suffix(" px wide");
        let shown = ui.add(width).on_hover_text(
            "Pixels across the buffer that occluders are drawn into, at most those of the picture: fewer find \
             less and cost less. See it with 4",
        );
        shown.accessible_name("width of the occlusion buffer in pixels");
        let budget = egui::DragValue::new(&mut s.occlusion_budget);
        let budget = budget.range(0.0..=1e6).speed(20.0).suffix(" µs");
        let shown = ui.add(budget).on_hover_text(
            "Budget for drawing occluders, by a cost model and not by a clock, so that the result is the same on \
             every machine; occluders with the highest score, what they may hide for their cost, are drawn first",
        );
        shown.accessible_name("budget of occlusion in microseconds");
    });
}

fn cameras(ui: &mut egui::Ui, session: &mut Session) {
    let frozen = session.state.frozen.is_some();
    ui.horizontal(|ui| {
        let about = "What is drawn stays as it is decided now, and you fly on (F)";
        if ui.selectable_label(frozen, "Freeze").on_hover_text(about).clicked() {
            session.toggle_freeze();
        }
        let name = if frozen { "Back in" } else { "Fly out" };
        let about = "Freezes, and looks at it from outside; once more goes back (O)";
        if button(ui, name, about) {
            session.toggle_outside();
        }
    });
    choices(
        ui,
        "division of the picture",
        &mut session.state.layout,
        &[
            (Layout::One, "one", "One picture (1)"),
            (Layout::Split, "split", "The culling camera beside a view from outside (2)"),
            (
                Layout::Wipe,
                "wipe",
                "With culling to the left of a divider, without to the right: drag it (3)",
            ),
            (
                Layout::Buffer,
                "buffer",
                "What the culling camera sees as depth, beside the occlusion buffer that was made for it (4)",
            ),
        ],
    );
    super::deciding::beside(ui, session);
    switch(
        ui,
        &mut session.state.map,
        "map",
        "From above, in the corner: white is drawn, the rest in the colour of its reason (M)",
    );
    if let Some(rig) = &mut session.state.camera {
        let before = rig.mode;
        choices(
            ui,
            "camera",
            &mut rig.mode,
            &[
                (Mode::Orbit, "orbit", "Drag turns around what is in the middle"),
                (Mode::Fly, "fly", "Drag looks about; W A S D and Q E move (G)"),
                (Mode::Top, "top", "Straight down, without perspective"),
            ],
        );
        if before != rig.mode && rig.mode == Mode::Top {
            session.fit();
        }
    }
    switch(
        ui,
        &mut session.state.hover_turns,
        "turn on hover",
        "The camera turns by mere movement of the pointer over the picture",
    );
    ui.weak(format!("scale {:.2} ×", session.scale()))
        .on_hover_text("1 shows the whole scene; the wheel changes it");
    let turned =
        session.state.layout == Layout::Split && !frozen && session.chase != Chase::default();
    let about = "Puts the camera outside back behind the one that culls";
    if turned && button(ui, "Follow from behind", about) {
        session.chase = Chase::default();
    }
}

fn ghosts(ui: &mut egui::Ui, session: &mut Session) {
    let mut form = session.state.ghosts.form;
    let chosen = choices(
        ui,
        "what was dropped",
        &mut form,
        &[
            (GhostForm::Off, "hidden", "What was dropped is not there"),
            (
                GhostForm::Boxes,
                "boxes",
                "Its boxes, in the colour of the reason: fly out to see them",
            ),
            (
                GhostForm::Solid,
                "solid",
                "As it is, in the colour of the reason; the legend has a switch for each",
            ),
        ],
    );
    if chosen {
        session.show_ghosts(form);
    }
}

fn picture(ui: &mut egui::Ui, session: &mut Session) {
    let look = &mut session.state.look;
    ui.horizontal(|ui| {
        ui.label("colours");
        let name = Colour::ALL.iter().find(|c| c.0 == look.colour).map_or("", |c| c.1);
        let colours = egui::ComboBox::from_id_salt("colours").selected_text(name).width(100.0);
        let shown = colours.show_ui(ui, |ui| {
            for (value, name, about) in Colour::ALL {
                ui.selectable_value(&mut look.colour, value, name).on_hover_text(about);
            }
        });
        shown.response.accessible_name("colours");
    });
    ui.horizontal_wrapped(|ui| {
        switch(ui, &mut look.fill, "fill", "Triangles are filled");
        switch(ui, &mut look.wireframe, "wireframe", "Edges of triangles (X)");
    });
    ui.horizontal(|ui| {
        ui.label("cull");
        choices(
            ui,
            "faces culled in the picture",
            &mut look.cull,
            &[
                (CullFace::None, "none", "Faces from behind are kept"),
                (CullFace::Back, "back", "Faces of solids seen from behind are dropped"),
                (
                    CullFace::Front,
                    "front",
                    "Faces seen from the front are dropped, as shadow passes do",
                ),
            ],
        );
    });
    switch(
        ui,
        &mut look.hardware,
        "by the hardware too",
        "The graphics card culls those faces of every mesh, two-sided ones too: work that the culler saves it",
    );
    switch(
        ui,
        &mut look.clockwise,
        "clockwise is front",
        "The other winding: solids turn inside out",
    );
    switch(ui, &mut look.face_normals, "face normals", "A line from the middle of each face");
    switch(ui, &mut look.vertex_normals, "vertex normals", "A line from each vertex");
    switch(
        ui,
        &mut look.fine,
        "high quality",
        "Four samples a pixel: smoother edges for more drawing time",
    );
    ui.horizontal(|ui| {
        switch(
            ui,
            &mut session.state.always,
            "draw always",
            "Draws without end, for measuring; else only when something changes",
        );
        if button(ui, "Refresh", "Draws once more (R)") {
            session.refresh = true;
        }
    });
}

fn journey(ui: &mut egui::Ui, session: &mut Session) {
    ui.horizontal_wrapped(|ui| {
        for (path, about) in [
            (PathSpec::Orbit, "Around the scene"),
            (PathSpec::Walk, "Through it at eye height"),
            (PathSpec::Fly, "Over and through it"),
        ] {
            if button(ui, &path.to_string(), about) {
                session.travel(path);
            }
        }
        let (name, about) = if session.journey.recording {
            ("Stop", "Ends the recording (U)")
        } else {
            ("Record", "Records the camera twelve times a second (U)")
        };
        if button(ui, name, about) {
            session.journey.toggle_recording();
        }
    });
    if session.journey.is_making() {
        ui.spinner();
    }
    let j = &mut session.journey;
    if j.rigs.is_empty() {
        ui.weak("Take one of the scene's paths, or record your own.");
        return;
    }
    ui.weak(format!("{}: {} cameras, {:.1} s", j.name, j.rigs.len(), j.rigs.len() as f64 / RATE));
    let mut moved = false;
    ui.horizontal(|ui| {
        let name = if j.playing { "Pause" } else { "Play" };
        if !j.recording && button(ui, name, "Moves the camera along the path (Space)") {
            j.playing = !j.playing;
        }
        ui.spacing_mut().slider_width = 70.0;
        let end = j.seconds();
        let slider = egui::Slider::new(&mut j.at, 0.0..=end).suffix(" s").fixed_decimals(1);
        let slider = ui.add_enabled(!j.recording, slider);
        moved = slider.accessible_name("time along the path in seconds").changed();
    });
    if moved && let Some(rig) = j.rig() {
        session.state.camera = Some(rig);
    }
    costs(ui, session);
    if button(ui, "Copy as JSON", "The file that cullet report --path file:… reads") {
        session.copy_path();
    }
}

/// Culling costs of the path's cameras, as a strip: a click moves to that camera.
fn costs(ui: &mut egui::Ui, session: &mut Session) {
    if session.journey.recording {
        return;
    }
    let about = "Culls for every camera of the path: dark ones are left with few faces, light ones with most. The line \
                 through the scene and the map have the same colours";
    if matches!(session.measured, Measured::Working(_)) {
        ui.spinner();
    } else if button(ui, "Measure its cost", about) {
        session.measure();
    }
    let Some(costs) = session.measured.costs().cloned() else { return };
    let size = egui::vec2(ui.available_width(), 22.0);
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click_and_drag());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
    let wide = rect.width() / costs.all.len().max(1) as f32;
    for (i, cost) in costs.all.iter().enumerate() {
        let share = cost.triangles as f32 / costs.most.max(1) as f32;
        let x = rect.min.x + wide * i as f32;
        let top = rect.max.y - rect.height() * share.max(0.06);
        let bar =
            egui::Rect::from_min_max(egui::pos2(x, top), egui::pos2(x + wide + 0.5, rect.max.y));
        painter.rect_filled(bar, 0.0, colour(costs.colour(cost)));
    }
    let share = session.journey.at / session.journey.seconds().max(1e-9);
    let at = rect.min.x + rect.width() * share as f32;
    painter.vline(at, rect.y_range(), egui::Stroke::new(1.0, ui.visuals().strong_text_color()));
    let slowest = costs.all.iter().map(|c| c.milliseconds).fold(0.0, f32::max);
    ui.weak(format!(
        "{} to {} triangles, culling {slowest:.2} ms at most",
        grouped(costs.least),
        grouped(costs.most)
    ));
    if costs.stages != session.state.stages {
        ui.weak("Measured with other settings.");
    }
    if let Some(p) = response.interact_pointer_pos() {
        let share = f64::from(((p.x - rect.min.x) / rect.width()).clamp(0.0, 1.0));
        session.journey.at = share * session.journey.seconds();
        session.journey.playing = false;
        if let Some(rig) = session.journey.rig() {
            session.state.camera = Some(rig);
        }
    }
}

/// `cullet report` of the scene with the path, or with this camera.
fn report(ui: &mut egui::Ui, session: &mut Session) {
    if session.world.is_none() {
        return;
    }
    let about = "Runs cullet report on this scene with these settings and the path's cameras, or with this camera where \
                 there is no path: a page of figures and pictures, in the folder cullet-report";
    #[cfg(not(target_arch = "wasm32"))]
    ui.horizontal(|ui| {
        if session.is_reporting() {
            ui.spinner();
            ui.weak("making a report");
        } else if button(ui, "Make report", about) {
            session.make_report();
        }
    });
    // A page starts no programs: it says what to type.
    #[cfg(target_arch = "wasm32")]
    if button(ui, "How to report", about)
        && let Some(order) = session.order()
    {
        let [cameras, out] = ["cameras.json", "cullet-report"].map(std::path::Path::new);
        ui.ctx().copy_text(order.cameras.clone());
        let command = order.command(cameras, out);
        session.tell(
            format!("The cameras are copied: save them as cameras.json, then type: {command}"),
            false,
        );
    }
}

fn structures(ui: &mut egui::Ui, session: &mut Session) {
    let levels = session.world.as_ref().map_or(0, |w| structure::level_count(&w.model.scene));
    let level = &mut session.state.structure.level;
    ui.horizontal(|ui| {
        ui.label("hierarchy");
        let text = if *level == 0 { "off".to_owned() } else { format!("level {level}") };
        let level_box = egui::ComboBox::from_id_salt("level").selected_text(text).width(76.0);
        let shown = level_box.show_ui(ui, |ui| {
            ui.selectable_value(level, 0, "off");
            for l in 1..=levels {
                ui.selectable_value(level, l, format!("level {l}")).on_hover_text(
                    "Boxes that the walk tested: blue outside, green inside, yellow tested further",
                );
            }
        });
        shown.response.accessible_name("hierarchy");
    });
    let s = &mut session.state.structure;
    switch(
        ui,
        &mut s.buffer,
        "occlusion buffer",
        "Over the picture of the camera that it was made for: light is near, clear is open (5)",
    );
    switch(
        ui,
        &mut s.tiles,
        "its coarser level",
        "The farthest of each tile of 8 × 4 pixels, which most questions end at",
    );
    switch(
        ui,
        &mut s.occluders,
        "occluders only",
        "Draws the instances of which something was drawn into the buffer, and nothing else (0)",
    );
    switch(
        ui,
        &mut session.state.structure.cones,
        "cones of clusters",
        "Of what is inspected: the cone of each cluster's normals; violet ones face away and are dropped",
    );
    super::structures::more(ui, session);
}
