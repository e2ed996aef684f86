//! Panel of the scene: the title with its counts, the list, the path, what is being loaded, and
//! messages.
use eframe::egui;

use super::words::{FINGER, button};
use crate::numbers::grouped;
use crate::session::Session;
#[cfg(not(target_arch = "wasm32"))]
use crate::tiles::TileFigures;
use crate::world::Source;

/// The title: what is open and how much there is of it.
pub(super) fn title(ui: &mut egui::Ui, session: &mut Session) {
    // Where there are fingers, there is little room, and the buttons have a line of their own.
    let fingers = ui.spacing().interact_size.y >= FINGER;
    let line = |ui: &mut egui::Ui| {
        ui.strong("cullet");
        match &session.world {
            Some(world) => {
                ui.label(short(&world.name));
                let c = world.counts;
                let text = format!(
                    "{} vertices · {} triangles · {} instances",
                    grouped(c.vertices),
                    grouped(c.triangles),
                    grouped(c.instances)
                );
                ui.weak(text).on_hover_text(format!(
                    "{} meshes in {} clusters of all instances",
                    grouped(c.meshes),
                    grouped(c.clusters)
                ));
            }
            None => {
                ui.weak("what need not be drawn, and why");
            }
        }
        if let Some(name) = session.loading() {
            ui.spinner();
            ui.label(format!("loading {}", short(name)));
        }
        if !fingers {
            let right = egui::Layout::right_to_left(egui::Align::Center);
            ui.with_layout(right, |ui| buttons(ui, session));
        }
    };
    if fingers {
        ui.horizontal_wrapped(line);
    } else {
        ui.horizontal(line);
    }
    notices(ui, session);
}

/// Buttons for the whole scene.
pub(super) fn buttons(ui: &mut egui::Ui, session: &mut Session) {
    if button(ui, "Help", "Keys, mouse and words (H)") {
        session.help = !session.help;
    }
    if button(ui, "Tour", "Every kind of culling, step by step, with a question about each (Enter)")
    {
        session.tour_on();
    }
    let (name, about) = if session.state.dark {
        ("Light", "A light ground, for projectors")
    } else {
        ("Dark", "A dark ground")
    };
    if button(ui, name, about) {
        session.state.dark = !session.state.dark;
    }
    let about =
        "Copies scene, camera and switches as a text that --state and the page's address take (Y)";
    if button(ui, "Copy link", about) {
        session.copy_link();
    }
    if button(ui, "Picture", "Saves a picture of the window as PNG (I)") {
        session.shoot = true;
    }
    let about = "Clears the scene: none is open until another is chosen, or a file is dropped (\\)";
    if session.world.is_some() && button(ui, "Clear", about) {
        session.clear();
    }
}

/// Messages, until they are closed.
fn notices(ui: &mut egui::Ui, session: &mut Session) {
    let mut closed = None;
    for (i, notice) in session.notices.iter().enumerate() {
        ui.horizontal_wrapped(|ui| {
            let close = ui.small_button("×").on_hover_text("Close this message");
            if close.accessible_name("Close this message").clicked() {
                closed = Some(i);
            }
            if notice.bad {
                ui.colored_label(ui.visuals().error_fg_color, &notice.text);
            } else {
                ui.label(&notice.text);
            }
        });
    }
    if let Some(i) = closed {
        session.notices.remove(i);
    }
}

/// The list of scenes, and the path of a file.
pub(super) fn choose(ui: &mut egui::Ui, session: &mut Session) {
    ui.add_space(4.0);
    let open = session.world.as_ref().map_or(String::new(), |w| w.name.clone());
    let mut chosen = None;
    ui.horizontal(|ui| {
        let label = if open.is_empty() { "scene".to_owned() } else { short(&open) };
        let scenes = egui::ComboBox::from_id_salt("scenes").selected_text(label).width(110.0);
        let shown = scenes.show_ui(ui, |ui| {
            for info in cullet_scenes::list() {
                let here = open.split(':').next() == Some(info.name);
                if ui.selectable_label(here, info.name).on_hover_text(info.about).clicked() {
                    chosen = Some(Source::Builtin(info.name.to_owned()));
                }
            }
        });
        shown.response.accessible_name("scene");
        if button(ui, "Fit", "Shows the whole scene (Home)") {
            session.fit();
        }
        if button(ui, "File…", "Opens a file; what is open stays until it is loaded (L)") {
            session.choose_file();
        }
    });
    if cfg!(target_arch = "wasm32") {
        ui.weak("or drop a file here: GLB, glTF with its .bin, OBJ, PLY, STL, OFF");
    } else {
        ui.horizontal(|ui| {
            let hint = "file, or city:seed=3";
            let field = egui::TextEdit::singleline(&mut session.to_open).hint_text(hint);
            let room = (ui.available_width() - 60.0).clamp(60.0, 180.0);
            let typed = ui.add(field.desired_width(room)).on_hover_text(
                "A path, or a built-in scene with settings. Or drop a file on the window.",
            );
            let entered = typed.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let pressed = button(ui, "Open", "Opens it; what is open stays until it is loaded");
            if (pressed || entered) && !session.to_open.trim().is_empty() {
                chosen = Some(Source::of_text(&session.to_open));
            }
        });
    }
    if let Some(source) = chosen {
        session.open(source);
    }
    #[cfg(not(target_arch = "wasm32"))]
    if let Some(figures) = session.tile_figures() {
        tiles(ui, &figures);
    }
}

/// Shows what is loaded of a world in tiles, and what will be.
#[cfg(not(target_arch = "wasm32"))]
fn tiles(ui: &mut egui::Ui, f: &TileFigures) {
    let mebibytes = |bytes: u64| grouped(bytes.div_ceil(1 << 20));
    let (taken, budget) = (mebibytes(f.bytes), mebibytes(f.budget));
    ui.label(format!("{} tiles · {taken} of {budget} MiB", grouped(f.tiles as u64))).on_hover_text(
        "Tiles in the scene, and what they take of their budget at the most, also while the next scene is made",
    );
    if f.wanted > 0 {
        let (wanted, bytes) = (grouped(f.wanted as u64), mebibytes(f.wanted_bytes));
        ui.weak(format!("{wanted} more wanted, {bytes} MiB"));
    }
    if f.is_cut_short {
        ui.weak("the budget is used up").on_hover_text(
            "Some of what is far away is coarser than it should be: the budget ended before the error was small enough everywhere",
        );
    }
    if let Some(failure) = &f.failure {
        let text = format!("{} cannot be loaded", grouped(f.failed as u64));
        ui.colored_label(ui.visuals().error_fg_color, text).on_hover_text(failure);
    }
}

/// The end of a long name.
fn short(name: &str) -> String {
    const MOST: usize = 26;
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let count = file.chars().count();
    if count <= MOST {
        return file.to_owned();
    }
    let tail: String = file.chars().skip(count - MOST).collect();
    format!("…{tail}")
}
