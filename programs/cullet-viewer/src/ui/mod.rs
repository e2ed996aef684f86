//! The window's panels. What they change is the session; they know nothing of graphics but one
//! picture.

mod buffer;
mod canvas;
mod cells;
mod cube;
mod cut;
mod deciding;
mod figures;
mod funnel;
mod help;
mod inspect;
mod lossy;
mod map;
mod playground;
mod portals;
mod scene;
pub mod shortcuts;
mod structures;
mod switches;
mod tour;
mod words;

use eframe::egui;

use crate::compose::Composition;
use crate::session::Session;

/// A window of fewer points has no room for a panel on both sides of the picture: a phone, held
/// upright.
const NARROW: f32 = 560.0;

/// The picture of the scene, as the panels show it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    /// The texture, if something was drawn.
    pub texture: Option<egui::TextureId>,
}

/// Shows everything. `picture` is called with the pixels that there are for the scene's picture,
/// once, and returns what it drew and the panes it is made of.
pub fn show(
    ui: &mut egui::Ui,
    session: &mut Session,
    mut picture: impl FnMut(&mut Session, [u32; 2]) -> (Shown, Composition),
) {
    let theme = if session.state.dark { egui::Theme::Dark } else { egui::Theme::Light };
    ui.ctx().set_theme(theme);
    shortcuts::run(ui.ctx(), session);
    canvas::drops(ui.ctx(), session);
    let narrow = is_narrow(ui.ctx());
    if narrow {
        for_fingers(ui);
    }
    match (session.state.panels, narrow) {
        (true, false) => panels(ui, session),
        (true, true) => sheets(ui, session),
        (false, _) => {}
    }
    egui::CentralPanel::no_frame().show(ui, |ui| {
        let points = ui.available_size();
        let ratio = ui.ctx().pixels_per_point();
        let pixels = [points.x, points.y].map(|v| ((v * ratio).round() as u32).clamp(1, 8192));
        let (shown, composition) = picture(session, pixels);
        canvas::show(ui, session, shown, &composition);
    });
    if !session.state.panels {
        unfold(ui.ctx(), session);
    }
    playground::window(ui.ctx(), session);
    help::sheet(ui.ctx(), session);
}

/// The way back to the panels for whoever has no key for it, or does not know it: frames in pages
/// begin without them.
fn unfold(ctx: &egui::Context, session: &mut Session) {
    egui::Area::new(egui::Id::unique("unfold"))
        .anchor(egui::Align2::LEFT_BOTTOM, [8.0, -8.0])
        .order(egui::Order::Middle)
        .show(ctx, |ui| {
            session.state.panels =
                words::button(ui, "Panels", "Switches, funnel and what was clicked (P)");
        });
}

fn is_narrow(ctx: &egui::Context) -> bool {
    ctx.content_rect().width() < NARROW
}

/// Makes room for what is pressed with a finger rather than with a mouse.
fn for_fingers(ui: &mut egui::Ui) {
    let spacing = ui.spacing_mut();
    spacing.interact_size.y = words::FINGER;
    spacing.button_padding = egui::vec2(8.0, 6.0);
    spacing.item_spacing = egui::vec2(6.0, 6.0);
    spacing.icon_width = 18.0;
}

/// The panel below the picture of a narrow window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sheet {
    Switches,
    Funnel,
}

/// Above and below the picture: one of the side panels at a time, or neither.
fn sheets(ui: &mut egui::Ui, session: &mut Session) {
    let id = egui::Id::unique("sheet");
    let mut sheet: Option<Sheet> = ui.data(|d| d.get_temp(id)).unwrap_or_default();
    egui::Panel::top("title").show(ui, |ui| {
        scene::title(ui, session);
        ui.horizontal_wrapped(|ui| {
            for (own, name) in [(Sheet::Switches, "Switches"), (Sheet::Funnel, "Funnel")] {
                if ui.selectable_label(sheet == Some(own), name).clicked() {
                    sheet = if sheet == Some(own) { None } else { Some(own) };
                }
            }
            ui.separator();
            scene::buttons(ui, session);
        });
    });
    ui.data_mut(|d| d.insert_temp(id, sheet));
    egui::Panel::bottom("figures").show(ui, |ui| figures::bar(ui, session));
    let Some(sheet) = sheet else { return };
    // The picture keeps the larger part.
    let height = ui.available_height() * 0.45;
    egui::Panel::bottom("sheet").exact_size(height).show(ui, |ui| {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match sheet {
            Sheet::Switches => {
                scene::choose(ui, session);
                switches::all(ui, session);
            }
            Sheet::Funnel => {
                funnel::all(ui, session);
                inspect::all(ui, session);
            }
        });
    });
}

/// All around the picture.
fn panels(ui: &mut egui::Ui, session: &mut Session) {
    egui::Panel::top("title").show(ui, |ui| scene::title(ui, session));
    egui::Panel::bottom("figures").show(ui, |ui| figures::bar(ui, session));
    egui::Panel::left("switches").default_size(210.0).size_range(170.0..=320.0).show(ui, |ui| {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            scene::choose(ui, session);
            switches::all(ui, session);
        });
    });
    egui::Panel::right("funnel").default_size(236.0).size_range(200.0..=420.0).show(ui, |ui| {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            funnel::all(ui, session);
            inspect::all(ui, session);
        });
    });
}
