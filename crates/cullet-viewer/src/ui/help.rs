//! The help sheet.

use eframe::egui;

use super::keys::KEYS;
use crate::session::Session;

/// The sheet, where it is open.
pub(super) fn sheet(ctx: &egui::Context, session: &mut Session) {
    if !session.help {
        return;
    }
    let mut open = true;
    let room = ctx.content_rect().size();
    egui::Window::new("Help")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .max_height(room.y - 80.0)
        .vscroll(true)
        .default_width(430.0)
        .show(ctx, |ui| {
            ui.label(
                "A renderer is handed everything and throws most of it away. This shows which of it need not \
                 be handed over at all. Start with Fly out (O): the white frustum is what the camera sees, and \
                 all that lies outside is not drawn. Then show what was dropped as solid, and click on it.",
            );
            ui.separator();
            egui::Grid::new("mouse").num_columns(2).show(ui, |ui| {
                for (how, what) in [
                    ("drag", "turn around the middle; in flight, look about"),
                    ("right drag, Shift drag", "move sideways"),
                    ("wheel, pinch", "nearer, farther"),
                    ("click", "inspect what is there"),
                    ("W A S D, Q E", "move; with Shift faster"),
                    ("arrows, + −", "turn, nearer, farther"),
                ] {
                    ui.strong(how);
                    ui.label(what);
                    ui.end_row();
                }
                for (key, what) in KEYS {
                    ui.strong(key.symbol_or_name());
                    ui.label(what);
                    ui.end_row();
                }
                ui.strong("R, Esc");
                ui.label("draw again; close");
                ui.end_row();
            });
            ui.separator();
            ui.label(
                "A thing is one placement of a mesh. A cluster is a group of up to 124 of its triangles. Never \
                 wrong means that nothing which owns a pixel is ever dropped: Verify this view proves it.",
            );
        });
    session.help = open;
}
