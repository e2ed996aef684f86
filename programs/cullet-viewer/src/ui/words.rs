//! Switches and buttons with a sentence, and colours.

use eframe::egui;

/// A switch with a sentence that says what it does and costs. True when it was thrown.
pub(super) fn switch(ui: &mut egui::Ui, on: &mut bool, name: &str, about: &str) -> bool {
    ui.checkbox(on, name).on_hover_text(about).changed()
}

/// How high, in points, what is pressed with a finger is at least.
pub(super) const FINGER: f32 = 28.0;

/// A small button with a sentence, larger where there are fingers. True when it was pressed.
pub(super) fn button(ui: &mut egui::Ui, name: &str, about: &str) -> bool {
    ui.add(small(ui, name)).on_hover_text(about).clicked()
}

/// A small button, larger where there are fingers.
pub(super) fn small(ui: &egui::Ui, name: &str) -> egui::Button<'static> {
    let button = egui::Button::new(name.to_owned());
    if ui.spacing().interact_size.y < FINGER { button.small() } else { button }
}

/// A colour of the palette.
pub(super) fn colour([r, g, b]: [u8; 3]) -> egui::Color32 {
    egui::Color32::from_rgb(r, g, b)
}

/// A filled square of a colour, as high as the text, with a rim so that light ones show on a light
/// ground.
pub(super) fn swatch(ui: &mut egui::Ui, rgb: [u8; 3]) {
    let side = ui.text_style_height(&egui::TextStyle::Small);
    let (rect, _) = ui.allocate_exact_size(egui::vec2(side, side), egui::Sense::hover());
    ui.painter().rect_filled(rect, 2.0, colour(rgb));
    let rim = egui::Stroke::new(1.0, ui.visuals().weak_text_color());
    ui.painter().rect_stroke(rect, 2.0, rim, egui::StrokeKind::Inside);
}

/// Choices in a row, each with a sentence. True when another was chosen. Readers of a screen are
/// told, before each, what is chosen.
pub(super) fn choices<T: PartialEq + Copy>(
    ui: &mut egui::Ui,
    what: &str,
    chosen: &mut T,
    all: &[(T, &str, &str)],
) -> bool {
    let before = *chosen;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for (value, name, about) in all {
            let choice = ui.selectable_value(chosen, *value, *name).on_hover_text(*about);
            choice.accessible_name(format!("{what}: {name}"));
        }
    });
    *chosen != before
}
