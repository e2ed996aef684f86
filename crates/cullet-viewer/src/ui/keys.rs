//! Keys: one list, which the help sheet prints.

use eframe::egui::{self, Key};

use crate::camera::Mode;
use crate::session::Session;
use crate::state::Layout;

/// Keys that are pressed once, and what they do.
pub(super) const KEYS: [(Key, &str); 15] = [
    (Key::H, "this sheet"),
    (Key::C, "culling on, off"),
    (Key::F, "freeze what is drawn, and fly on; again: let it go"),
    (Key::O, "freeze and fly out; again: back in"),
    (Key::G, "orbit, fly"),
    (Key::Num1, "one picture"),
    (Key::Num2, "split: both cameras"),
    (Key::Num3, "wipe: with and without culling"),
    (Key::Num4, "depth beside the occlusion buffer"),
    (Key::P, "panels: off, the picture has all of the window"),
    (Key::M, "map"),
    (Key::X, "wireframe"),
    (Key::V, "verify this view"),
    (Key::Space, "play, pause the camera path"),
    (Key::Home, "show the whole scene"),
];

/// Follows the keys that were pressed since the last frame, unless a text is being typed.
pub(super) fn run(ctx: &egui::Context, session: &mut Session) {
    if ctx.egui_wants_keyboard_input() {
        return;
    }
    let pressed: Vec<Key> = ctx.input(|i| {
        let plain = !i.modifiers.command && !i.modifiers.alt;
        KEYS.iter().map(|(k, _)| *k).filter(|k| plain && i.key_pressed(*k)).collect()
    });
    for key in pressed {
        press(session, key);
    }
    if ctx.input(|i| i.key_pressed(Key::R) && !i.modifiers.command) {
        session.refresh = true;
    }
    if ctx.input(|i| i.key_pressed(Key::Escape)) {
        session.help = false;
        session.inspected = None;
    }
    fly(ctx, session);
}

fn press(session: &mut Session, key: Key) {
    let state = &mut session.state;
    match key {
        Key::H => session.help = !session.help,
        Key::C => state.stages.on = !state.stages.on,
        Key::F => session.toggle_freeze(),
        Key::O => session.toggle_outside(),
        Key::G => {
            if let Some(rig) = &mut state.camera {
                rig.mode = if rig.mode == Mode::Fly { Mode::Orbit } else { Mode::Fly };
            }
        }
        Key::Num1 => state.layout = Layout::One,
        Key::Num2 => state.layout = Layout::Split,
        Key::Num3 => state.layout = Layout::Wipe,
        Key::Num4 => state.layout = Layout::Buffer,
        Key::P => state.panels = !state.panels,
        Key::M => state.map = !state.map,
        Key::X => state.look.wireframe = !state.look.wireframe,
        Key::V => session.prove(),
        Key::Space => session.journey.playing = !session.journey.playing,
        Key::Home => session.fit(),
        _ => {}
    }
}

/// Keys that are held: flight, or turning for those without a mouse.
fn fly(ctx: &egui::Context, session: &mut Session) {
    let reach = session.world.as_ref().map_or(1.0, |w| w.reach);
    let Some(rig) = &mut session.state.camera else { return };
    let (held, dt, fast) = ctx.input(|i| {
        let held = |a: Key, b: Key| f64::from(i8::from(i.key_down(b)) - i8::from(i.key_down(a)));
        let held = [
            held(Key::A, Key::D),
            held(Key::Q, Key::E),
            held(Key::S, Key::W),
            held(Key::ArrowLeft, Key::ArrowRight),
            held(Key::ArrowDown, Key::ArrowUp),
            held(Key::Minus, Key::Plus),
        ];
        (held, f64::from(i.stable_dt.min(0.1)), i.modifiers.shift)
    });
    if held.iter().all(|h| *h == 0.0) {
        return;
    }
    let [right, up, forward, yaw, pitch, nearer] = held;
    let speed = reach * dt * if fast { 0.8 } else { 0.16 };
    if rig.mode == Mode::Top {
        rig.pan((right + yaw) * dt * 0.6, (forward + pitch) * dt * 0.6);
    } else {
        rig.shift(right * speed, up * speed, forward * speed);
        rig.turn(-yaw * dt * 70.0, pitch * dt * 50.0);
    }
    rig.zoom(2f64.powf(nearer * dt));
    session.journey.playing = false;
    ctx.request_repaint();
}
