//! The page's controls beside the canvas, for readers of a screen: see `controls.js`.

use eframe::egui;

use super::page::{set, take};
use crate::controls;

/// Hands what egui knows of its controls to the page in `data-controls`, once the page asks for it
/// by `data-control="on"`; then takes what is done to them from there. Until then it costs a look
/// at an attribute per frame.
pub(crate) struct Mirror;

impl egui::Plugin for Mirror {
    fn debug_name(&self) -> &'static str {
        "controls for readers of a screen"
    }

    fn input_hook(&mut self, ctx: &egui::Context, input: &mut egui::RawInput) {
        match take("control").as_deref() {
            Some("on") => ctx.enable_accesskit(),
            Some(order) => {
                let request = controls::request(order);
                input.events.extend(request.map(egui::Event::AccessKitActionRequest));
            }
            None => {}
        }
    }

    fn output_hook(&mut self, _: &egui::Context, output: &mut egui::FullOutput) {
        if let Some(update) = output.platform_output.accesskit_update.take() {
            set("controls", &controls::rows(&update));
        }
    }
}
