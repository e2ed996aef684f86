//! The figures of the last frame, along the bottom.

use eframe::egui;

use super::words::button;
use crate::numbers::{grouped, percent};
use crate::session::Session;
use crate::state::Sides;

/// The line of figures.
pub(super) fn bar(ui: &mut egui::Ui, session: &mut Session) {
    ui.horizontal_wrapped(|ui| {
        let all = session.world.as_ref().map_or(0, |w| w.counts.triangles);
        let Some(decision) = &session.decision else {
            ui.weak("Nothing is decided yet.");
            return;
        };
        let v = &decision.visible;
        let by_device = session.by_device();
        let told = &session.device.figures;
        let (left, ms) = if by_device {
            (told.triangles, told.times.map(|times| times.sum()))
        } else if session.state.stages.on {
            (v.triangle_count, Some(decision.milliseconds))
        } else {
            (all, Some(0.0))
        };
        ui.strong(format!("triangles {} / {}", grouped(left), grouped(all)));
        ui.label(format!("({})", percent(left, all)));
        ui.separator();
        let saved = all.saturating_sub(left);
        let share = if all == 0 { 0.0 } else { saved as f32 / all as f32 };
        let bar = egui::ProgressBar::new(share).desired_width(90.0).desired_height(12.0);
        ui.add(bar.text(format!("saved {}", percent(saved, all))))
            .on_hover_text("The share of triangles that culling saved the graphics card");
        let backs = session.whole().is_some_and(|w| w.kept_backs.is_most(w.counts.triangles));
        let sentence = session.kept_backs().filter(|_| backs);
        let mut one_sided = false;
        if let Some(sentence) = sentence {
            ui.separator();
            ui.strong(sentence);
            let about = "Takes every triangle to have a front alone, so that back faces are culled. The switch 'sides' \
                         takes it back";
            let helps = session.state.sides == Sides::Automatic
                && session.whole().is_some_and(|w| w.kept_backs.two_sided > 0);
            one_sided = helps && button(ui, "take as one-sided", about);
        }
        ui.separator();
        if let Some(ms) = ms {
            let by = if by_device { "graphics device" } else { "processor" };
            let about = format!("By the {by}, for this view");
            ui.label(format!("culling {ms:.2} ms")).on_hover_text(about);
        }
        let d = &session.drawn;
        let device = d.device_ms.map_or(String::new(), |ms| format!(" + {ms:.1} on the card"));
        ui.label(format!("· drawing {:.1} ms{device}", d.milliseconds)).on_hover_text(format!(
            "{} triangles in {} draw calls, all panes together",
            grouped(d.triangles),
            grouped(u64::from(d.draws))
        ));
        if session.state.always || session.journey.playing {
            ui.label(format!("· {:.0} frames/s", d.per_second));
        } else {
            ui.weak("· drawn when something changes");
        }
        if session.state.frozen.is_some() {
            ui.separator();
            ui.strong("frozen").on_hover_text(
                "What is drawn was decided for the frustum in the picture (F lets it go)",
            );
        }
        if one_sided {
            session.state.sides = Sides::OneSided;
        }
    });
}
