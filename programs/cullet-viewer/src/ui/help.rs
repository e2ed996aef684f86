//! The help sheet.

use eframe::egui;

use super::shortcuts::{Section, TABLE};
use crate::session::Session;

/// The sheet, where it is open.
pub(super) fn sheet(ctx: &egui::Context, session: &mut Session) {
    if !session.help {
        return;
    }
    let mut open = true;
    let room = ctx.content_rect().size();
    let wide = room.x > 860.0;
    egui::Window::new("Help")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .max_height(room.y - 80.0)
        .default_height(room.y - 80.0)
        .vscroll(true)
        .default_width(if wide { 800.0 } else { (room.x - 24.0).min(430.0) })
        .max_width(room.x - 24.0)
        .show(ctx, |ui| {
            ui.label(
                "A renderer is handed everything and throws most of it away. This shows which of it need not \
                 be handed over at all. Start with the Tour (Enter). Or Fly out (O): the white lines bound what the \
                 camera sees, and what lies outside is not drawn. Then show what was dropped as solid, and click \
                 on it.",
            );
            ui.separator();
            // Side by side where there is room.
            let (left, right) = TABLE.split_at(TABLE.len() / 2);
            if wide {
                ui.columns(2, |columns| {
                    lines(&mut columns[0], left);
                    lines(&mut columns[1], right);
                });
            } else {
                lines(ui, &TABLE);
            }
            ui.separator();
            ui.label(
                "An instance is one placement of a mesh. A cluster is a group of up to 124 of its triangles. Never \
                 wrong means that nothing which owns a pixel is ever dropped: Verify this view proves it.",
            );
        });
    session.help = open;
}

fn lines(ui: &mut egui::Ui, sections: &[Section]) {
    for (heading, lines) in sections {
        ui.add_space(3.0);
        ui.weak(*heading);
        if ui.available_width() < 380.0 {
            // A line of a table is as long as it is.
            for line in *lines {
                ui.horizontal_wrapped(|ui| {
                    ui.strong(line.name);
                    ui.label(line.what);
                });
            }
            continue;
        }
        egui::Grid::new(heading).num_columns(2).min_col_width(120.0).show(ui, |ui| {
            for line in *lines {
                ui.strong(line.name);
                ui.label(line.what);
                ui.end_row();
            }
        });
    }
}
