//! Keys and what they do: one table, which handling, help sheet and the book read.

use eframe::egui::{self, Key};

use crate::camera::Mode;
use crate::session::Session;
use crate::state::{Colour, GhostForm, Layout, REACH, Stages};
use crate::structure;

/// Action of a key.
#[derive(Clone, Copy, Debug)]
pub enum Act {
    /// Once, when it is pressed.
    Press(fn(&mut Session)),
    /// Movement of the camera along an axis, one way, as long as the key is held.
    Hold(Axis, f64),
}

/// How a camera is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// To the right.
    Right,
    /// Upwards.
    Up,
    /// To where it looks.
    Forward,
    /// Turned to the right.
    Yaw,
    /// Turned up.
    Pitch,
    /// Nearer.
    Nearer,
}

/// One line of the table: keys that belong together, or what a pointer does.
#[derive(Clone, Copy, Debug)]
pub struct Shortcut {
    /// The keys, as the help sheet writes them.
    pub name: &'static str,
    /// Their action, in words.
    pub what: &'static str,
    /// Each key and its part; none where a pointer is meant.
    pub keys: &'static [(Key, Act)],
}

/// A part of the table: its heading and its lines.
pub type Section = (&'static str, &'static [Shortcut]);

const fn pointer(name: &'static str, what: &'static str) -> Shortcut {
    Shortcut { name, what, keys: &[] }
}

const fn keys(name: &'static str, what: &'static str, keys: &'static [(Key, Act)]) -> Shortcut {
    Shortcut { name, what, keys }
}

use Act::{Hold, Press};

/// All of them.
pub const TABLE: [Section; 6] = [
    (
        "Moving",
        &[
            pointer("drag", "turn around the middle; in flight, look about"),
            pointer("right drag, Shift drag, two fingers", "move sideways"),
            pointer("wheel, pinch", "nearer, farther"),
            pointer("click", "inspect what is there"),
            keys(
                "W A S D, Q E",
                "move; with Shift faster",
                &[
                    (Key::W, Hold(Axis::Forward, 1.0)),
                    (Key::S, Hold(Axis::Forward, -1.0)),
                    (Key::A, Hold(Axis::Right, -1.0)),
                    (Key::D, Hold(Axis::Right, 1.0)),
                    (Key::Q, Hold(Axis::Up, -1.0)),
                    (Key::E, Hold(Axis::Up, 1.0)),
                ],
            ),
            keys(
                "arrows, + −",
                "turn, nearer, farther",
                &[
                    (Key::ArrowLeft, Hold(Axis::Yaw, -1.0)),
                    (Key::ArrowRight, Hold(Axis::Yaw, 1.0)),
                    (Key::ArrowUp, Hold(Axis::Pitch, 1.0)),
                    (Key::ArrowDown, Hold(Axis::Pitch, -1.0)),
                    (Key::Plus, Hold(Axis::Nearer, 1.0)),
                    // The same key without Shift where + is above =.
                    (Key::Equals, Hold(Axis::Nearer, 1.0)),
                    (Key::Minus, Hold(Axis::Nearer, -1.0)),
                ],
            ),
            keys("G", "orbit, fly", &[(Key::G, Press(orbit_or_fly))]),
            keys("Home", "show the whole scene", &[(Key::Home, Press(Session::fit))]),
        ],
    ),
    (
        "Culling",
        &[
            keys("C", "culling on, off", &[(Key::C, Press(|s| flip(&mut s.state.stages.on)))]),
            keys(
                "6 7 8 9",
                "cull by frustum only, + back faces, default, all",
                &[
                    (Key::Num6, Press(|s| s.state.stages = Stages::frustum_only())),
                    (Key::Num7, Press(|s| s.state.stages = Stages::without_occlusion())),
                    (Key::Num8, Press(|s| s.state.stages = Stages::default())),
                    (Key::Num9, Press(|s| s.state.stages = Stages::all())),
                ],
            ),
            keys(
                "'",
                "decided by the CPU, by the device",
                &[(Key::Quote, Press(|s| flip(&mut s.state.device.on)))],
            ),
            keys("V", "verify this view", &[(Key::V, Press(Session::prove))]),
            keys(
                "F",
                "freeze what is drawn, and fly on; again: let it go",
                &[(Key::F, Press(Session::toggle_freeze))],
            ),
            keys(
                "O",
                "freeze and fly out; again: back in",
                &[(Key::O, Press(Session::toggle_outside))],
            ),
            keys("B", "what was dropped: hidden, boxes, solid", &[(Key::B, Press(next_ghosts))]),
        ],
    ),
    (
        "Picture",
        &[
            keys(
                "1",
                "one picture; in the tour: the first answer",
                &[(Key::Num1, Press(|s| answer_or_divide(s, 0, Layout::One)))],
            ),
            keys(
                "2",
                "split: both cameras; in the tour: the second answer",
                &[(Key::Num2, Press(|s| answer_or_divide(s, 1, Layout::Split)))],
            ),
            keys(
                "3",
                "wipe: with and without culling; in the tour: the third answer",
                &[(Key::Num3, Press(|s| answer_or_divide(s, 2, Layout::Wipe)))],
            ),
            keys(
                "4",
                "depth beside the occlusion buffer",
                &[(Key::Num4, Press(|s| s.state.layout = Layout::Buffer))],
            ),
            keys(
                "5",
                "the occlusion buffer over the picture",
                &[(Key::Num5, Press(|s| flip(&mut s.state.structure.buffer)))],
            ),
            keys(
                "0",
                "occluders only",
                &[(Key::Num0, Press(|s| flip(&mut s.state.structure.occluders)))],
            ),
            keys("M", "map", &[(Key::M, Press(|s| flip(&mut s.state.map)))]),
            keys("N", "next colours", &[(Key::N, Press(next_colour))]),
            keys("X", "wireframe", &[(Key::X, Press(|s| flip(&mut s.state.look.wireframe)))]),
            keys(
                "P",
                "panels: off, the picture has all of the window",
                &[(Key::P, Press(|s| flip(&mut s.state.panels)))],
            ),
            keys("R", "draw again", &[(Key::R, Press(|s| s.refresh = true))]),
        ],
    ),
    (
        "Structures",
        &[
            keys("Z", "cut away", &[(Key::Z, Press(|s| flip(&mut s.state.cut.on)))]),
            keys(
                "Page Up, Page Down",
                "move the plane of the cut",
                &[
                    (Key::PageUp, Press(|s| move_cut(s, CUT_STEP))),
                    (Key::PageDown, Press(|s| move_cut(s, -CUT_STEP))),
                ],
            ),
            keys("End", "face the cut", &[(Key::End, Press(face_cut))]),
            keys("K", "cube of directions", &[(Key::K, Press(|s| flip(&mut s.state.study.cube)))]),
            keys(
                "T",
                "clipping playground",
                &[(Key::T, Press(|s| flip(&mut s.state.clipping.open)))],
            ),
            keys(
                "/",
                "portals, in the order of the walk",
                &[(Key::Slash, Press(|s| flip(&mut s.state.structure.portals)))],
            ),
            keys(
                "[ ]",
                "a portal of the walk back, on",
                &[
                    (Key::OpenBracket, Press(|s| s.step_portals(-1))),
                    (Key::CloseBracket, Press(|s| s.step_portals(1))),
                ],
            ),
            keys(
                "Delete",
                "open or shut that portal",
                &[(Key::Delete, Press(Session::toggle_nearest_portal))],
            ),
            keys(
                ";",
                "cells, from outside",
                &[(Key::Semicolon, Press(|s| flip(&mut s.state.structure.cells)))],
            ),
            keys(
                "Backspace",
                "next level of the hierarchy; in the tour: a step back",
                &[(Key::Backspace, Press(back_or_next_level))],
            ),
        ],
    ),
    (
        "Camera path",
        &[
            keys("U", "record, stop", &[(Key::U, Press(|s| s.journey.toggle_recording()))]),
            keys("Space", "play, pause", &[(Key::Space, Press(|s| flip(&mut s.journey.playing)))]),
            keys(
                ", .",
                "a camera back, on",
                &[(Key::Comma, Press(|s| step(s, -1.0))), (Key::Period, Press(|s| step(s, 1.0)))],
            ),
        ],
    ),
    (
        "Files and help",
        &[
            keys("L", "open a file", &[(Key::L, Press(Session::choose_file))]),
            keys("\\", "clear the scene: none is open", &[(Key::Backslash, Press(Session::clear))]),
            keys("I", "save a picture of the window", &[(Key::I, Press(|s| s.shoot = true))]),
            keys("Y", "copy the link", &[(Key::Y, Press(Session::copy_link))]),
            keys("J", "copy the funnel as JSON", &[(Key::J, Press(Session::copy_funnel))]),
            keys(
                "Enter",
                "the tour of what culling does; again: go on",
                &[(Key::Enter, Press(Session::tour_on))],
            ),
            keys("H", "help", &[(Key::H, Press(|s| flip(&mut s.help)))]),
            keys(
                "Esc",
                "close help, tour, playground, what was clicked",
                &[(Key::Escape, Press(close))],
            ),
        ],
    ),
];

/// How far a key moves the cut, in half extents of the scene.
const CUT_STEP: f64 = 0.05;

fn flip(on: &mut bool) {
    *on = !*on;
}

fn orbit_or_fly(session: &mut Session) {
    if let Some(rig) = &mut session.state.camera {
        rig.mode = if rig.mode == Mode::Fly { Mode::Orbit } else { Mode::Fly };
    }
}

fn next_ghosts(session: &mut Session) {
    session.show_ghosts(match session.state.ghosts.form {
        GhostForm::Off => GhostForm::Boxes,
        GhostForm::Boxes => GhostForm::Solid,
        GhostForm::Solid => GhostForm::Off,
    });
}

fn next_colour(session: &mut Session) {
    let colour = &mut session.state.look.colour;
    let at = Colour::ALL.iter().position(|c| c.0 == *colour).unwrap_or(0);
    *colour = Colour::ALL[(at + 1) % Colour::ALL.len()].0;
}

/// The tour's keys are there as long as it goes on.
fn answer_or_divide(session: &mut Session, choice: usize, layout: Layout) {
    match session.tour {
        Some(_) => session.answer(choice),
        None => session.state.layout = layout,
    }
}

fn back_or_next_level(session: &mut Session) {
    match session.tour {
        Some(_) => session.tour_back(),
        None => next_level(session),
    }
}

fn next_level(session: &mut Session) {
    let levels = session.world.as_ref().map_or(0, |w| structure::level_count(&w.model.scene));
    let level = &mut session.state.structure.level;
    *level = if *level >= levels { 0 } else { *level + 1 };
}

fn move_cut(session: &mut Session, by: f64) {
    let cut = &mut session.state.cut;
    if cut.on {
        // To a hundredth, as the slider has it, so that links stay short.
        cut.at = ((cut.at + by) * 100.0).round().clamp(-REACH * 100.0, REACH * 100.0) / 100.0;
    }
}

fn face_cut(session: &mut Session) {
    if session.state.cut.on {
        session.face_cut();
    }
}

/// Goes along the path by so many cameras.
fn step(session: &mut Session, by: f64) {
    if let Some(rig) = session.journey.step(by) {
        session.state.camera = Some(rig);
    }
}

fn close(session: &mut Session) {
    session.help = false;
    session.end_tour();
    session.inspected = None;
    session.state.clipping.open = false;
}

/// Follows the keys that were pressed since the last frame, unless a text is being typed.
pub(super) fn run(ctx: &egui::Context, session: &mut Session) {
    if ctx.egui_wants_keyboard_input() {
        return;
    }
    // With these a key is the system's, the browser's or a text's.
    let plain = ctx.input(|i| !i.modifiers.command && !i.modifiers.ctrl && !i.modifiers.alt);
    if !plain {
        return;
    }
    let mut moved = [0.0; 6];
    for &(key, act) in TABLE.iter().flat_map(|(_, lines)| *lines).flat_map(|line| line.keys) {
        match act {
            Press(press) if ctx.input(|i| i.key_pressed(key)) => press(session),
            Hold(axis, way) if ctx.input(|i| i.key_down(key)) => moved[axis as usize] += way,
            _ => {}
        }
    }
    if moved.iter().any(|m| *m != 0.0) {
        fly(ctx, session, moved);
    }
}

/// Keys that are held: flight, or turning for those without a mouse.
fn fly(ctx: &egui::Context, session: &mut Session, moved: [f64; 6]) {
    let reach = session.world.as_ref().map_or(1.0, |w| w.reach);
    let Some(rig) = &mut session.state.camera else { return };
    let (dt, fast) = ctx.input(|i| (f64::from(i.stable_dt.min(0.1)), i.modifiers.shift));
    let [right, up, forward, yaw, pitch, nearer] = moved;
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

/// The table for the book.
#[must_use]
pub fn markdown() -> String {
    let mut out = String::from("| keys, pointer | what they do |\n|---|---|\n");
    for (heading, lines) in TABLE {
        out.push_str(&format!("| **{heading}** | |\n"));
        for line in lines {
            out.push_str(&format!("| {} | {} |\n", line.name, line.what));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn no_two_keys_collide() {
        let mut taken = HashSet::new();
        for line in TABLE.iter().flat_map(|(_, lines)| *lines) {
            for (key, _) in line.keys {
                assert!(taken.insert(*key), "{key:?} has two actions: {}", line.what);
            }
        }
        assert!(taken.len() > 40, "only {} keys", taken.len());
    }

    #[test]
    fn every_key_has_its_name_on_the_sheet() {
        for line in TABLE.iter().flat_map(|(_, lines)| *lines) {
            assert!(!line.name.is_empty() && !line.what.is_empty());
            for (key, _) in line.keys {
                let name = match key {
                    Key::ArrowUp | Key::ArrowDown | Key::ArrowLeft | Key::ArrowRight => "arrows",
                    Key::PageUp => "Page Up",
                    Key::PageDown => "Page Down",
                    Key::Escape => "Esc",
                    Key::Equals => "+",
                    Key::Comma => ",",
                    Key::Period => ".",
                    Key::Quote => "'",
                    key => key.symbol_or_name(),
                };
                assert!(line.name.contains(name), "{key:?} is not in '{}'", line.name);
            }
        }
    }
}
