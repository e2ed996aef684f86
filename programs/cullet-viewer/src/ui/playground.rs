//! The clipping playground: a polygon whose corners can be dragged, and the window that cuts it.

use cullet::Stage;
use cullet_draw::clip::outcode::OutcodeResult;
use cullet_draw::palette;
use eframe::egui::{self, Color32, Pos2, Stroke};

use super::words::{button, colour, small};
use crate::clipping::{Clipping, Corner, From, MOST_CORNERS, SIDES};
use crate::session::Session;
use crate::structure::WHOLE;

/// The canvas's side in points.
const SIDE: f32 = 300.0;

/// The window, where it is open.
pub(super) fn window(ctx: &egui::Context, session: &mut Session) {
    if !session.state.clipping.open {
        return;
    }
    let mut open = true;
    let narrow = super::is_narrow(ctx);
    let window = egui::Window::new("Clipping playground")
        .open(&mut open)
        .collapsible(false)
        .resizable(false);
    let window = if narrow {
        let room = ctx.content_rect().size();
        let middle = window.anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO);
        let height = room.y - 80.0;
        middle.default_size([SIDE, height.min(620.0)]).max_height(height).vscroll(true)
    } else {
        window.default_pos([226.0, 60.0]).default_width(SIDE + 190.0)
    };
    window.show(ctx, |ui| {
        let c = &mut session.state.clipping;
        let steps = c.steps();
        // One below the other where there is no room beside.
        if narrow {
            super::for_fingers(ui);
            canvas(ui, c, &steps);
            controls(ui, c);
            words(ui, c, &steps);
            return;
        }
        ui.horizontal_top(|ui| {
            canvas(ui, c, &steps);
            ui.vertical(|ui| {
                ui.set_width(180.0);
                controls(ui, c);
                words(ui, c, &steps);
            });
        });
    });
    session.state.clipping.open &= open;
}

fn controls(ui: &mut egui::Ui, c: &mut Clipping) {
    ui.horizontal(|ui| {
        let back = small(ui, "Back");
        let about = "Undoes the cut by the last plane";
        if ui.add_enabled(c.step > 0, back).on_hover_text(about).clicked() {
            c.step -= 1;
        }
        let on = small(ui, "Next plane");
        let about = "Cuts by the next plane of the window";
        if ui.add_enabled(c.step < c.sides, on).on_hover_text(about).clicked() {
            c.step += 1;
        }
        ui.label(format!("{} of {}", c.step, c.sides));
    });
    ui.horizontal(|ui| {
        ui.label("window");
        let slider = egui::DragValue::new(&mut c.sides).range(SIDES).suffix(" sides");
        let sides = ui.add(slider).on_hover_text("How many planes the convex window has");
        sides.accessible_name("sides of the window");
        c.step = c.step.min(c.sides);
    });
    ui.horizontal(|ui| {
        let more = small(ui, "+ corner");
        let about = "Adds a corner in the middle of the longest edge; drag corners with the mouse";
        if ui.add_enabled(c.polygon.len() < MOST_CORNERS, more).on_hover_text(about).clicked() {
            c.add_corner();
        }
        let fewer = small(ui, "− corner");
        let about = "Takes the last corner away";
        if ui.add_enabled(c.polygon.len() > 3, fewer).on_hover_text(about).clicked() {
            c.polygon.pop();
        }
        if button(ui, "Reset", "The polygon and the window as they were") {
            *c = Clipping { open: true, ..Clipping::default() };
        }
    });
}

/// The outcode's bits, the highest plane first.
fn bits(code: u32, sides: u32) -> String {
    (0..sides).rev().map(|i| if code >> i & 1 == 1 { '1' } else { '0' }).collect()
}

fn words(ui: &mut egui::Ui, c: &Clipping, steps: &[Vec<Corner>]) {
    ui.separator();
    let sides = c.sides;
    let result = match c.classify() {
        OutcodeResult::Accepted => {
            "accepted: the OR of all codes is 0, nothing is to be cut".to_owned()
        }
        OutcodeResult::Rejected(and) => {
            format!(
                "rejected: the AND of all codes is {}, all lies beyond one plane",
                bits(and, sides)
            )
        }
        OutcodeResult::Candidate(or) => {
            format!("to be clipped by the planes of the OR, {}", bits(or, sides))
        }
    };
    ui.label(format!("Outcodes alone: {result}."));
    ui.separator();
    let (Some(now), Some(before)) = (steps.get(c.step as usize), step_before(c, steps)) else {
        return;
    };
    if c.step == 0 {
        ui.weak("Before any cut. Each corner has its outcode: bit i is 1 where it lies outside of plane i.");
    } else {
        let fresh = now.iter().filter(|p| p.from == From::Cut(c.step - 1)).count();
        let gone = before.iter().filter(|p| p.code >> (c.step - 1) & 1 == 1).count();
        ui.weak(format!(
            "Plane {}: {} outside of it go, {} new ones lie on it, {} are left.",
            c.step - 1,
            gone,
            fresh,
            now.len()
        ));
    }
    egui::Grid::new("corners").num_columns(2).spacing([10.0, 1.0]).show(ui, |ui| {
        for corner in now {
            ui.colored_label(paint(corner, c.step), name(corner));
            ui.monospace(bits(corner.code, sides));
            ui.end_row();
        }
    });
    if now.is_empty() {
        ui.strong("Nothing is left.");
    }
}

fn step_before<'a>(c: &Clipping, steps: &'a [Vec<Corner>]) -> Option<&'a Vec<Corner>> {
    steps.get(c.step.saturating_sub(1) as usize)
}

fn name(corner: &Corner) -> String {
    match corner.from {
        From::Input(i) => format!("corner {}", char::from(b'A' + (i as u8).min(25))),
        From::Cut(plane) => format!("cut at {plane}"),
        From::Fresh => "cut".to_owned(),
    }
}

/// Green was there, yellow is new with this plane, blue was made by an earlier one.
fn paint(corner: &Corner, step: u32) -> Color32 {
    colour(match corner.from {
        From::Input(_) => WHOLE,
        From::Cut(plane) if plane + 1 == step => palette::UNSEEN,
        _ => palette::reason_color(Some(Stage::Frustum)),
    })
}

fn canvas(ui: &mut egui::Ui, c: &mut Clipping, steps: &[Vec<Corner>]) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(SIDE, SIDE), egui::Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let half = SIDE * 0.47;
    let place = |p: [f64; 2]| rect.center() + egui::vec2(p[0] as f32, -p[1] as f32) * half;
    let weak = ui.visuals().weak_text_color();
    let strong = ui.visuals().strong_text_color();
    let font = egui::TextStyle::Small.resolve(ui.style());
    let window: Vec<Pos2> = c.window().into_iter().map(place).collect();
    for (i, &a) in window.iter().enumerate() {
        let b = window[(i + 1) % window.len()];
        let active = i as u32 + 1 == c.step;
        let line = Stroke::new(if active { 2.5 } else { 1.2 }, if active { strong } else { weak });
        let along = (b - a).normalized();
        if active {
            // All of the plane: what is beyond it goes, wherever it lies.
            painter.line_segment([a - along * 900.0, b + along * 900.0], Stroke::new(1.0, weak));
        }
        painter.line_segment([a, b], line);
        // On the screen y points down: out is to the other side.
        let out = egui::vec2(-along.y, along.x);
        let middle = a + (b - a) * 0.5;
        painter.arrow(middle, out * 9.0, line);
        let ink = if active { strong } else { weak };
        painter.text(
            middle + out * 16.0,
            egui::Align2::CENTER_CENTER,
            i.to_string(),
            font.clone(),
            ink,
        );
    }
    let Some(now) = steps.get(c.step as usize) else { return };
    let before: Vec<Pos2> =
        step_before(c, steps).map_or(&[][..], Vec::as_slice).iter().map(|p| place(p.at)).collect();
    let left: Vec<Pos2> = now.iter().map(|p| place(p.at)).collect();
    fill(&painter, &left, colour(WHOLE).gamma_multiply(0.35), rect);
    let gone = colour(palette::reason_color(Some(Stage::Occlusion)));
    let dashes = |points: &[Pos2], ink: Color32| {
        let mut all = points.to_vec();
        all.extend(points.first());
        painter.extend(egui::Shape::dashed_line(&all, Stroke::new(1.0, ink), 4.0, 3.0));
    };
    let came: Vec<Pos2> = steps[0].iter().map(|p| place(p.at)).collect();
    dashes(&came, weak);
    if c.step > 0 {
        dashes(&before, gone);
    }
    painter.add(egui::Shape::closed_line(left, Stroke::new(2.0, colour(WHOLE))));
    for corner in now {
        let at = place(corner.at);
        painter.circle_filled(at, 4.0, paint(corner, c.step));
        let code = bits(corner.code, c.sides);
        let aside =
            if at.x > rect.center().x { egui::vec2(-7.0, -9.0) } else { egui::vec2(7.0, -9.0) };
        let align = if at.x > rect.center().x {
            egui::Align2::RIGHT_CENTER
        } else {
            egui::Align2::LEFT_CENTER
        };
        painter.text(at + aside, align, code, font.clone(), strong);
    }
    // Corners that this plane clipped, crossed out.
    for corner in step_before(c, steps).into_iter().flatten() {
        if c.step > 0 && corner.code >> (c.step - 1) & 1 == 1 {
            let (at, line) = (place(corner.at), Stroke::new(1.6, gone));
            painter.line_segment([at - egui::vec2(4.0, 4.0), at + egui::vec2(4.0, 4.0)], line);
            painter.line_segment([at + egui::vec2(-4.0, 4.0), at + egui::vec2(4.0, -4.0)], line);
        }
    }
    for i in 0..c.polygon.len() {
        let handle = egui::Rect::from_center_size(place(c.polygon[i]), egui::vec2(16.0, 16.0));
        let response = ui
            .interact(handle, ui.scope_id().with(("corner", i)), egui::Sense::drag())
            .on_hover_cursor(egui::CursorIcon::Grab);
        if response.hovered() || response.dragged() {
            painter.circle_stroke(handle.center(), 7.0, Stroke::new(1.5, strong));
        }
        if let Some(p) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let d = (p - rect.center()) / half;
            c.drag(i, [f64::from(d.x), f64::from(-d.y)]);
        }
    }
}

/// Fills a polygon by the even–odd rule, a row of points at a time: what Sutherland & Hodgman leave
/// of one that is not convex may run to and fro along a plane, and no fan of triangles fills that.
fn fill(painter: &egui::Painter, polygon: &[Pos2], ink: Color32, within: egui::Rect) {
    let mut crossings: Vec<f32> = Vec::new();
    let mut y = within.min.y + 0.5;
    while y < within.max.y {
        crossings.clear();
        for (i, a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            if (a.y <= y) != (b.y <= y) {
                crossings.push(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
            }
        }
        crossings.sort_unstable_by(f32::total_cmp);
        for pair in crossings.chunks_exact(2) {
            painter.hline(pair[0]..=pair[1], y, Stroke::new(1.0, ink));
        }
        y += 1.0;
    }
}
