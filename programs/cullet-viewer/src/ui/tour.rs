//! The tour's card over the picture, and the line that invites those who see this for the first
//! time.

use eframe::egui;

use crate::numbers::{grouped, percent};
use crate::session::{Given, STOPS, Session, Stop};
use crate::state::{GhostForm, Layout};

/// How wide the card is where there is room.
const WIDTH: f32 = 420.0;

/// How far from the picture's edge the card is, and its contents from the card's, in points.
const MARGIN: f32 = 8.0;

fn width(picture: egui::Rect) -> f32 {
    WIDTH.min(picture.width() - 36.0).max(120.0)
}

/// Where the card ends that lies over a picture.
pub(super) fn card_right(picture: egui::Rect) -> f32 {
    picture.left() + width(picture) + 3.0 * MARGIN
}

/// The card while the tour goes on; the invitation while nothing was done yet.
pub(super) fn show(ctx: &egui::Context, rect: egui::Rect, session: &mut Session) {
    if session.tour.is_some() {
        card(ctx, rect, session);
    } else {
        invite(ctx, rect, session);
    }
}

fn invite(ctx: &egui::Context, rect: egui::Rect, session: &mut Session) {
    let state = &session.state;
    let fresh = state.frozen.is_none()
        && state.panels
        && (state.layout == Layout::One || session.is_as_it_began())
        && state.ghosts.form == GhostForm::Off
        && session.inspected.is_none()
        && session.world.is_some();
    if !fresh {
        return;
    }
    let mut begin = false;
    // Below the name of the pane, where it has one.
    let below = if state.layout == Layout::One { 0.0 } else { 22.0 };
    over(
        ctx,
        "invite",
        rect.left_top() + egui::vec2(MARGIN, MARGIN + below),
        egui::Align2::LEFT_TOP,
        |ui| {
            ui.set_max_width((rect.width() - 36.0).max(120.0));
            ui.horizontal_wrapped(|ui| {
                let words = egui::RichText::new("Show me what is culled").strong();
                let about = "A tour of every kind of culling, with a question about each (Enter)";
                begin = ui.add(emphasised(ui, words)).on_hover_text(about).clicked();
                ui.label(if ctx.input(egui::InputState::any_touches) || super::is_narrow(ctx) {
                    "One finger turns, two move and zoom."
                } else {
                    "Drag to turn, wheel to zoom, H helps."
                });
            });
        },
    );
    if begin {
        session.tour_on();
    }
}

/// Button that was pressed on the card.
enum Pressed {
    On,
    Back,
    End,
    Choice(usize),
}

fn card(ctx: &egui::Context, rect: egui::Rect, session: &mut Session) {
    let Some(tour) = &session.tour else { return };
    let (at, stop, given, ready) = (tour.at(), tour.stop(), tour.given().cloned(), tour.is_ready());
    let all = session.world.as_ref().map_or(0, |w| w.counts.triangles);
    let left = session.decision.as_ref().map(|d| d.visible.triangle_count);
    let left = if session.state.stages.on { left } else { Some(all) };
    let loading = session.loading().map(str::to_owned);
    let mut pressed = None;
    // The way back to the panels lies in the same corner.
    let up = if session.state.panels { MARGIN } else { 40.0 };
    let corner = rect.left_bottom() + egui::vec2(MARGIN, -up);
    over(ctx, "tour", corner, egui::Align2::LEFT_BOTTOM, |ui| {
        ui.set_width(width(rect));
        ui.horizontal_wrapped(|ui| {
            ui.strong(stop.title);
            ui.weak(format!("{} of {}", at + 1, STOPS.len()));
            if let Some(name) = loading {
                ui.weak(format!("loading {name} …"));
            }
        });
        let ink = ui.visuals().strong_text_color();
        ui.colored_label(ink, stop.words);
        ui.separator();
        pressed = question(ui, stop, given.as_ref(), ready).map(Pressed::Choice);
        if let (Some(left), Some(_)) = (left, &given) {
            let share = percent(left, all);
            ui.weak(format!("To draw: {} of {} triangles, {share}", grouped(left), grouped(all)));
        }
        ui.horizontal(|ui| {
            let last = at + 1 == STOPS.len();
            let words = egui::RichText::new(if last { "Done" } else { "Next" }).strong();
            if ui.add(emphasised(ui, words)).on_hover_text("Enter").clicked() {
                pressed = Some(Pressed::On);
            }
            let back = ui.add_enabled(at > 0, egui::Button::new("Back"));
            if back.on_hover_text("Backspace").clicked() {
                pressed = Some(Pressed::Back);
            }
            let about = "Puts scene, cameras and switches back to where they were (Esc)";
            if !last && ui.button("End").on_hover_text(about).clicked() {
                pressed = Some(Pressed::End);
            }
        });
    });
    match pressed {
        Some(Pressed::On) => session.tour_on(),
        Some(Pressed::Back) => session.tour_back(),
        Some(Pressed::End) => session.end_tour(),
        Some(Pressed::Choice(choice)) => session.answer(choice),
        None => {}
    }
}

/// The question with its choices, and once one was taken whether it is right, in words. The choice
/// that was pressed.
fn question(ui: &mut egui::Ui, stop: &Stop, given: Option<&Given>, ready: bool) -> Option<usize> {
    let mut pressed = None;
    ui.strong(stop.question);
    for (n, choice) in stop.choices.iter().enumerate() {
        let words = format!("{}  {choice}", n + 1);
        let Some(given) = given else {
            let button = egui::Button::new(words).wrap();
            if ui.add_enabled(ready, button).on_hover_text(format!("{}", n + 1)).clicked() {
                pressed = Some(n);
            }
            continue;
        };
        match n == given.right {
            true => ui.strong(words),
            false => ui.weak(words),
        };
    }
    if let Some(given) = given {
        ui.label(format!("{} {}", given.in_words(stop), given.because));
    }
    pressed
}

/// The button that leads on.
fn emphasised(ui: &egui::Ui, words: egui::RichText) -> egui::Button<'static> {
    let chosen = ui.visuals().selection;
    egui::Button::new(words.color(chosen.stroke.color)).fill(chosen.bg_fill)
}

/// Something that lies over the picture, on a ground of its own.
fn over(
    ctx: &egui::Context,
    id: &'static str,
    at: egui::Pos2,
    align: egui::Align2,
    add: impl FnOnce(&mut egui::Ui),
) {
    egui::Area::new(egui::Id::unique(id))
        .fixed_pos(at)
        .pivot(align)
        .order(egui::Order::Middle)
        .show(ctx, |ui| {
            egui::Frame::popup(ui.style()).shadow(egui::Shadow::NONE).show(ui, |ui| {
                if super::is_narrow(ctx) {
                    super::for_fingers(ui);
                }
                add(ui);
            });
        });
}
