//! The portals of the culling view on its picture, in the order of the walk.

use cullet_draw::depth_color;
use eframe::egui::{self, Align2, Color32, Pos2, Rect, Shape, Stroke};

use super::words::colour;
use crate::cells::SHUT;
use crate::compose::{Composition, Role};
use crate::session::Session;
use crate::state::Layout;

/// Where the culling view is shown, and how many points a pixel of it is.
fn places(rect: Rect, ratio: f32, session: &Session, made: &Composition) -> Vec<(Rect, [f32; 2])> {
    let Some(decision) = session.decision.as_ref() else { return Vec::new() };
    if !session.state.structure.portals || session.cells.chain.is_none() {
        return Vec::new();
    }
    let [width, height] = decision.request.view.viewport().map(|v| v as f32);
    let own = made.panels.iter().filter(|panel| match panel.role {
        Role::Culling => true,
        Role::Flown => session.state.frozen.is_none() && session.state.layout == Layout::One,
        _ => false,
    });
    own.map(|panel| {
        let [x, y, w, h] = panel.place.map(|v| v as f32 / ratio);
        let place = Rect::from_min_size(rect.min + egui::vec2(x, y), egui::vec2(w, h));
        (place, [w / width, h / height])
    })
    .collect()
}

/// Badge that can be clicked: its place, and the portal that it opens or shuts.
struct Badge {
    at: Rect,
    portal: u32,
}

/// Paints the clipped portals, the chosen one stronger, and doors that are shut.
pub(super) fn show(ui: &egui::Ui, rect: Rect, ratio: f32, session: &Session, made: &Composition) {
    let Some(chain) = &session.cells.chain else { return };
    let chosen = session.state.structure.step as usize;
    for (place, scale) in places(rect, ratio, session, made) {
        let painter = ui.painter_at(place);
        let points = |screen: &[[f64; 2]]| on(place, scale, screen);
        for (number, step) in (1..).zip(chain.shown(session.state.structure.step)) {
            let ink = colour(depth_color(step.depth));
            let strong = chosen == number;
            let fill = ink.gamma_multiply(if strong { 0.35 } else { 0.10 });
            let stroke = Stroke::new(if strong { 3.0 } else { 1.5 }, ink);
            painter.add(Shape::convex_polygon(points(&step.screen), fill, stroke));
        }
        for door in &chain.doors {
            let fill = colour(SHUT).gamma_multiply(0.6);
            let stroke = Stroke::new(2.0, colour(SHUT));
            painter.add(Shape::convex_polygon(points(&door.screen), fill, stroke));
        }
        let font = egui::TextStyle::Small.resolve(ui.style());
        for (badge, words, ground) in badges(place, scale, session) {
            let dark = ground == colour(SHUT);
            painter.rect_filled(badge.at, 3.0, ground);
            let ink = if dark { Color32::WHITE } else { Color32::BLACK };
            painter.text(badge.at.center(), Align2::CENTER_CENTER, words, font.clone(), ink);
        }
    }
}

/// Opens or shuts the portal whose number was clicked, or the shut door; false where nothing of the
/// kind is.
pub(super) fn click(
    at: Pos2,
    rect: Rect,
    ratio: f32,
    session: &mut Session,
    made: &Composition,
) -> bool {
    for (place, scale) in places(rect, ratio, session, made) {
        if !place.contains(at) {
            continue;
        }
        let all = badges(place, scale, session);
        let number = all.iter().find(|(badge, ..)| badge.at.contains(at));
        let door = || {
            let doors = session.cells.chain.iter().flat_map(|chain| &chain.doors);
            let is_in = |screen: &[[f64; 2]]| holds(&on(place, scale, screen), at);
            doors.filter(|door| is_in(&door.screen)).map(|door| door.portal).next()
        };
        if let Some(portal) = number.map(|(badge, ..)| badge.portal).or_else(door) {
            session.toggle_portal(portal);
            return true;
        }
    }
    false
}

fn on(place: Rect, scale: [f32; 2], screen: &[[f64; 2]]) -> Vec<Pos2> {
    let at = |p: &[f64; 2]| place.min + egui::vec2(p[0] as f32 * scale[0], p[1] as f32 * scale[1]);
    screen.iter().map(at).collect()
}

/// Whether a convex polygon holds a point.
fn holds(polygon: &[Pos2], p: Pos2) -> bool {
    let mut turns = [false; 2];
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let turn = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
        turns[usize::from(turn > 0.0)] |= turn != 0.0;
    }
    polygon.len() >= 3 && turns != [true; 2]
}

/// Numbers of the steps that are shown and names of shut doors, beside each other where they would
/// lie on each other.
fn badges(place: Rect, scale: [f32; 2], session: &Session) -> Vec<(Badge, String, Color32)> {
    let Some(chain) = &session.cells.chain else { return Vec::new() };
    let mut all: Vec<(Badge, String, Color32)> = Vec::new();
    let mut put = |screen: &[[f64; 2]], portal: u32, words: String, ground: Color32| {
        let points = on(place, scale, screen);
        if points.len() < 3 {
            return;
        }
        let bounds = Rect::from_points(&points).intersect(place);
        let size = egui::vec2(8.0 + 7.0 * words.len() as f32, 16.0);
        let mut at = Rect::from_center_size(bounds.center(), size);
        // Down the picture, until there is room.
        for _ in 0..20 {
            let Some((other, ..)) = all.iter().find(|(other, ..)| other.at.intersects(at)) else {
                break;
            };
            at = at.translate(egui::vec2(0.0, other.at.max.y - at.min.y + 1.0));
        }
        all.push((Badge { at, portal }, words, ground));
    };
    for (number, step) in (1..).zip(chain.shown(session.state.structure.step)) {
        put(&step.screen, step.portal, format!("{number}"), colour(depth_color(step.depth)));
    }
    for door in &chain.doors {
        put(&door.screen, door.portal, "shut".to_owned(), colour(SHUT));
    }
    all
}
