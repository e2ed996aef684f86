//! The picture of the scene: shown, turned, zoomed, clicked, and files dropped on it.

use eframe::egui;

use super::Shown;
use crate::camera::{Mode, Rig};
use crate::compose::{Composition, Role};
use crate::numbers::grouped;
use crate::session::Session;
use crate::state::{Colour, GhostForm, Layout};
#[cfg(not(target_arch = "wasm32"))]
use crate::world::Source;

/// Degrees of turning for a point of dragging.
const TURN: f64 = 0.35;

/// Shows the picture and follows the pointer.
pub(super) fn show(ui: &mut egui::Ui, session: &mut Session, shown: Shown, made: &Composition) {
    let size = ui.available_size();
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click_and_drag());
    match shown.texture {
        Some(texture) => {
            let uv = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            ui.painter().image(texture, rect, uv, egui::Color32::WHITE);
        }
        None => welcome(ui, rect, session),
    }
    let ratio = ui.ctx().pixels_per_point();
    let pixel = |p: egui::Pos2| {
        let d = (p - rect.min) * ratio;
        [f64::from(d.x), f64::from(d.y)]
    };
    super::buffer::show(ui, rect, session, made);
    super::portals::show(ui, rect, ratio, session, made);
    labels(ui, rect, ratio, session, made);
    super::map::show(ui, rect, session);
    super::cube::show(ui, rect, session);
    super::tour::show(ui.ctx(), rect, session);
    outcodes(ui, rect, ratio, session, made);
    if session.state.layout == Layout::Wipe {
        wipe(ui, rect, session);
    }
    if response.clicked()
        && let Some(point) = response.interact_pointer_pos()
        && !super::portals::click(point, rect, ratio, session, made)
        && let at = pixel(point)
        && let Some(panel) = made.at(at)
    {
        let [left, top, ..] = panel.place.map(f64::from);
        session.inspect(&panel.view, [at[0] - left, at[1] - top]);
    }
    let fingers = ui.input(egui::InputState::multi_touch).filter(|m| rect.contains(m.start_pos));
    let origin = fingers
        .map(|m| m.start_pos)
        .or(ui.input(|i| i.pointer.press_origin()))
        .or(response.hover_pos());
    let role = origin.map(pixel).and_then(|p| made.at(p)).map(|p| p.role);
    if let Some(fingers) = fingers {
        // The first of them is the pointer as well, and must not turn at the same time.
        drag(session, role, fingers.translation_delta, true, rect.height());
        if fingers.zoom_delta != 1.0 {
            zoom(session, role, f64::from(fingers.zoom_delta));
        }
        return;
    }
    let delta = response.drag_delta();
    let slides = response.dragged_by(egui::PointerButton::Secondary)
        || response.dragged_by(egui::PointerButton::Middle)
        || ui.input(|i| i.modifiers.shift);
    if response.dragged() && delta != egui::Vec2::ZERO {
        drag(session, role, delta, slides, rect.height());
    } else if session.state.hover_turns
        && response.hovered()
        && let Some(rig) = &mut session.state.camera
    {
        let d = ui.input(|i| i.pointer.delta());
        rig.turn(f64::from(-d.x) * TURN, f64::from(-d.y) * TURN);
    }
    if response.hovered() {
        let (wheel, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        let factor = f64::from(wheel / 240.0).exp2() * f64::from(pinch);
        if factor != 1.0 {
            zoom(session, role, factor);
        }
    }
}

fn drag(session: &mut Session, role: Option<Role>, d: egui::Vec2, slides: bool, height: f32) {
    let (x, y) = (f64::from(d.x), f64::from(d.y));
    let height = f64::from(height.max(1.0));
    session.journey.playing = false;
    let frozen = session.state.frozen.is_some();
    let turn = |rig: &mut Rig| {
        if slides || rig.mode == Mode::Top {
            rig.pan(-x / height, y / height);
        } else {
            rig.turn(-x * TURN, -y * TURN);
        }
    };
    match role {
        Some(Role::Outside) => {
            session.chase.yaw -= x * TURN;
            session.chase.pitch = (session.chase.pitch - y * TURN).clamp(-89.0, 20.0);
        }
        Some(Role::Culling | Role::Depth) if frozen => {
            session.state.frozen.iter_mut().for_each(turn);
        }
        _ => session.state.camera.iter_mut().for_each(turn),
    }
}

fn zoom(session: &mut Session, role: Option<Role>, factor: f64) {
    let frozen = session.state.frozen.is_some();
    match role {
        Some(Role::Outside) => {
            session.chase.nearer = (session.chase.nearer * factor).clamp(0.1, 50.0);
        }
        Some(Role::Culling | Role::Depth) if frozen => {
            session.state.frozen.iter_mut().for_each(|r| r.zoom(factor));
        }
        _ => session.state.camera.iter_mut().for_each(|r| r.zoom(factor)),
    }
}

/// Greeting in place of the first picture.
fn welcome(ui: &egui::Ui, rect: egui::Rect, session: &Session) {
    let text = match session.loading() {
        Some(name) => format!("loading {name} …"),
        None => "Choose a scene on the left, drop a file here, or press L.".to_owned(),
    };
    let font = egui::TextStyle::Heading.resolve(ui.style());
    let ink = ui.visuals().weak_text_color();
    ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, text, font, ink);
}

/// Names of the panes.
fn labels(ui: &egui::Ui, rect: egui::Rect, ratio: f32, session: &Session, made: &Composition) {
    let painter = ui.painter_at(rect);
    let font = egui::TextStyle::Small.resolve(ui.style());
    let ink = ui.visuals().strong_text_color();
    let ground = ui.visuals().panel_fill.gamma_multiply(0.8);
    let put = |at: egui::Pos2, align, words: &str| {
        let galley = painter.layout_no_wrap(words.to_owned(), font.clone(), ink);
        let place = align_rect(align, at, galley.size());
        painter.rect_filled(place.expand(3.0), 3.0, ground);
        painter.galley(place.min, galley, ink);
    };
    let left = session.decision.as_ref().map_or(0, |d| d.visible.triangle_count);
    let all = session.world.as_ref().map_or(0, |w| w.counts.triangles);
    let frozen = session.state.frozen.is_some();
    let by_device = session.by_device();
    let coloured = session.state.ghosts.form == GhostForm::Solid
        && session.state.look.colour == Colour::Material;
    for panel in &made.panels {
        let [x, y, w, h] = panel.place.map(|v| v as f32 / ratio);
        let area = egui::Rect::from_min_size(rect.min + egui::vec2(x, y), egui::vec2(w, h));
        let words = match (panel.role, session.state.layout) {
            (Role::Culling, _) => "what the camera sees".to_owned(),
            (Role::Depth, _) => "true depth of what the camera sees".to_owned(),
            (Role::Outside, _) if coloured => "from outside: only white is drawn".to_owned(),
            (Role::Outside, _) if session.state.look.colour == Colour::Sides => {
                "from outside: orange is seen from behind".to_owned()
            }
            (Role::Outside, _) => "from outside: what is drawn".to_owned(),
            (Role::Bare, _) if by_device && session.state.device.compare => {
                format!("decided by the CPU: {} triangles", grouped(left))
            }
            (Role::Bare, _) => format!("without culling: {} triangles", grouped(all)),
            (Role::Flown, Layout::Wipe) if by_device => {
                let left = session.device.figures.triangles;
                format!("decided by the device: {} triangles", grouped(left))
            }
            (Role::Flown, Layout::Wipe) => {
                format!("with culling: {} triangles", grouped(left))
            }
            (Role::Flown, _) if frozen => "frozen: the frustum decided what is drawn".to_owned(),
            (Role::Flown, _) => continue,
        };
        let (at, align) = match panel.role {
            Role::Bare => (area.right_top() + egui::vec2(-8.0, 8.0), egui::Align2::RIGHT_TOP),
            _ => (area.left_top() + egui::vec2(8.0, 8.0), egui::Align2::LEFT_TOP),
        };
        put(at, align, &words);
    }
    if session.state.layout == Layout::Buffer
        && let Some(panel) = made.panels.first()
    {
        let at = rect.min + egui::vec2(panel.place[2] as f32 / ratio + 8.0, 8.0);
        let buffer = session.decision.as_ref().and_then(|d| d.buffer.as_ref());
        let mut words = buffer.map_or("the occlusion buffer".to_owned(), |b| {
            let [w, h] = b.size();
            format!("occlusion buffer, {w} × {h}: what is proved covered; blue is open")
        });
        if by_device {
            let (level, [w, h]) = session.state.device.shown(session.culling_size());
            words = format!("depth pyramid, level {level}, {w} × {h}: blue is open");
        }
        put(at, egui::Align2::LEFT_TOP, &words);
    }
    if made.volume == Some(false) {
        let at = rect.left_top() + egui::vec2(8.0, 30.0);
        let words = "This cluster has no culling volume: from everywhere some of it is seen from the front.";
        put(at, egui::Align2::LEFT_TOP, words);
    }
}

/// The outcodes of the triangle that was clicked, at its corners.
fn outcodes(ui: &egui::Ui, rect: egui::Rect, ratio: f32, session: &Session, made: &Composition) {
    let Some(coded) = session.coded().filter(|_| session.state.structure.outcodes) else { return };
    let font = egui::TextStyle::Small.resolve(ui.style());
    let ink = ui.visuals().strong_text_color();
    let ground = ui.visuals().panel_fill.gamma_multiply(0.8);
    for panel in &made.panels {
        let [x, y, w, h] = panel.place.map(|v| v as f32 / ratio);
        let area = egui::Rect::from_min_size(rect.min + egui::vec2(x, y), egui::vec2(w, h));
        let painter = ui.painter_at(area);
        for (i, (corner, code)) in coded.corners.iter().enumerate() {
            let Some([u, v, _]) = panel.view.project_point(corner.to_array()) else { continue };
            let at = area.min + egui::vec2(u as f32, v as f32) / ratio;
            let name = char::from(b'A' + i as u8);
            let words = format!("{name} {:06b}", code.outside & 0b11_1111);
            let galley = painter.layout_no_wrap(words, font.clone(), ink);
            let place = egui::Rect::from_min_size(at + egui::vec2(5.0, -12.0), galley.size());
            painter.rect_filled(place.expand(2.0), 2.0, ground);
            painter.galley(place.min, galley, ink);
            painter.circle_filled(at, 2.5, ink);
        }
    }
}

fn align_rect(align: egui::Align2, at: egui::Pos2, size: egui::Vec2) -> egui::Rect {
    align.anchor_size(at, size)
}

/// The divider of the wipe.
fn wipe(ui: &mut egui::Ui, rect: egui::Rect, session: &mut Session) {
    let x = rect.min.x + rect.width() * session.state.wipe;
    let handle = egui::Rect::from_center_size(
        egui::pos2(x, rect.center().y),
        egui::vec2(14.0, rect.height()),
    );
    let response = ui
        .interact(handle, ui.scope_id().with("wipe"), egui::Sense::drag())
        .on_hover_cursor(egui::CursorIcon::ResizeHorizontal);
    if let Some(p) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        session.state.wipe = ((p.x - rect.min.x) / rect.width().max(1.0)).clamp(0.0, 1.0);
    }
    let ink = ui.visuals().strong_text_color();
    let painter = ui.painter_at(rect);
    painter.vline(x, rect.y_range(), egui::Stroke::new(1.5, ink));
    painter.circle_filled(egui::pos2(x, rect.center().y), 6.0, ink);
}

/// Opens what was dropped on the window.
pub(super) fn drops(ctx: &egui::Context, session: &mut Session) {
    let files = ctx.input(|i| i.raw.dropped_files.clone());
    if !files.is_empty() {
        #[cfg(not(target_arch = "wasm32"))]
        {
            // Files that it names are read from its folder.
            let names: Vec<String> = files.iter().map(|f| f.path().display().to_string()).collect();
            let model = session.choose_model(names.iter().map(String::as_str));
            session.open(Source::File(files[model].path().to_owned()));
        }
        #[cfg(target_arch = "wasm32")]
        session.read_dropped(files);
    }
    for read in session.dropped() {
        session.open_read(read);
    }
}
