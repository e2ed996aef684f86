//! Cells and portals: the chain, step by step, doors, and which cells can see each other.

use cullet_bake::pvs::PairState;
use cullet_draw::{PairShown, depth_color};
use eframe::egui;

use super::words::{button, colour, small, swatch, switch};
use crate::cells::{CellSets, IN_SET, OWN, REACHED, SHUT};
use crate::numbers::{grouped, percent};
use crate::session::Session;

/// Lines of the chain that are written.
const MOST_LINES: usize = 14;

/// Whether the scene has any.
pub(super) fn are_there(session: &Session) -> bool {
    session.world.as_ref().is_some_and(|w| w.model.placed.is_some())
}

/// The section.
pub(super) fn section(ui: &mut egui::Ui, session: &mut Session) {
    let s = &mut session.state.structure;
    ui.horizontal_wrapped(|ui| {
        switch(
            ui,
            &mut s.portals,
            "portals in view",
            "What is seen of each portal, numbered in the order of the walk; a click on a number, or on a shut door, \
             opens or shuts it (/)",
        );
        switch(
            ui,
            &mut s.cells,
            "cells",
            "Their outlines, in the picture from outside: fly out or split to see them (;)",
        );
    });
    place(ui, session);
    if session.state.structure.portals {
        chain(ui, session);
    }
    sets(ui, session);
}

/// The name of a cell, and its number.
fn name(session: &Session, cell: u32) -> String {
    let names = session.world.as_ref().map(|w| &w.model.cells.cells);
    match names.and_then(|cells| cells.get(cell as usize)).filter(|cell| !cell.name.is_empty()) {
        Some(own) => format!("{cell} ({})", own.name),
        None => format!("{cell}"),
    }
}

/// Where one is, and what is reached from there.
fn place(ui: &mut egui::Ui, session: &Session) {
    let Some(chain) = &session.cells.chain else { return };
    match chain.cell {
        Some(cell) => ui.label(format!("in cell {}", name(session, cell))),
        None => ui.label("in no cell"),
    };
    let graph = session.world.as_ref().and_then(|w| w.model.in_cells().graph());
    let all = u64::from(graph.map_or(0, cullet_cells::cell::CellGraph::cell_count));
    match &chain.reached {
        Some(reached) => {
            let cells: Vec<String> = reached.iter().take(40).map(u32::to_string).collect();
            ui.weak(format!("{} of {} cells reached", reached.len(), grouped(all)))
                .on_hover_text(format!("Cells {}", cells.join(", ")));
        }
        None => {
            ui.weak("Portals hide nothing from here: the eye, or its near plane, is not in cells alone.");
        }
    }
    if session.state.structure.cells {
        ui.horizontal_wrapped(|ui| {
            for (ink, words) in [(OWN, "own"), (REACHED, "reached"), (IN_SET, "in its set")] {
                swatch(ui, ink);
                ui.weak(words);
            }
        });
    }
}

/// The chain, step by step.
fn chain(ui: &mut egui::Ui, session: &mut Session) {
    let Some(chain) = session.cells.chain.clone() else { return };
    let count = chain.steps.len() as u32;
    let mut by = 0;
    ui.horizontal(|ui| {
        if button(ui, "Back", "A portal back ([)") {
            by = -1;
        }
        if button(ui, "On", "The next portal of the walk (])") {
            by = 1;
        }
        ui.spacing_mut().slider_width = 70.0;
        let step = &mut session.state.structure.step;
        ui.add(egui::Slider::new(step, 0..=count.max(1)))
            .on_hover_text("Which portals of the walk are shown: 0 is all, 3 the first three")
            .accessible_name("portals of the walk that are shown");
    });
    if by != 0 {
        session.step_portals(by);
    }
    let mut toggled = None;
    let chosen = session.state.structure.step;
    let first = (chosen as usize).saturating_sub(MOST_LINES);
    for (number, step) in (1_u32..).zip(&chain.steps).skip(first).take(MOST_LINES) {
        ui.horizontal(|ui| {
            ui.add_space(6.0 * (step.depth.min(8) - 1) as f32);
            swatch(ui, depth_color(step.depth));
            let [from, to] = step.cells;
            let words = format!("{number}  {from} → {to}");
            let about = format!(
                "Portal {}, from cell {} into {}, through {} in all",
                step.portal,
                name(session, from),
                name(session, to),
                step.depth
            );
            if ui.selectable_label(chosen == number, words).on_hover_text(about).clicked() {
                session.state.structure.step = if chosen == number { 0 } else { number };
            }
            let shut = ui.add(small(ui, "shut")).on_hover_text("Shuts it, as a door");
            if shut.accessible_name(format!("shut portal {}", step.portal)).clicked() {
                toggled = Some(step.portal);
            }
        });
    }
    if chain.steps.len() > first + MOST_LINES {
        ui.weak(format!("and {} more", chain.steps.len() - first - MOST_LINES));
    }
    for door in chain.doors.iter().take(MOST_LINES) {
        ui.horizontal(|ui| {
            swatch(ui, SHUT);
            let [from, to] = door.cells;
            ui.label(format!("{from} | {to}")).on_hover_text(format!(
                "Portal {}, from cell {} into {}, is shut",
                door.portal,
                name(session, from),
                name(session, to)
            ));
            if button(ui, "open", "Opens it") {
                toggled = Some(door.portal);
            }
        });
    }
    if let Some(portal) = toggled {
        session.toggle_portal(portal);
    }
    if !session.state.doors.is_empty() {
        let about = "All portals as the scene has them";
        if button(ui, "Doors as they were", about) {
            session.state.doors.clear();
        }
    }
}

/// Shows the cells that can see each other.
fn sets(ui: &mut egui::Ui, session: &mut Session) {
    if session.cells.is_baking() {
        ui.horizontal(|ui| {
            ui.spinner();
            ui.weak("baking …");
        });
        return;
    }
    let Some(sets) = session.cells.sets() else {
        let about = "Finds for each pair of cells whether a line of sight joins them, and proves it: the potentially \
                     visible sets. A moment for an office; a page stands still meanwhile";
        if button(ui, "Bake what sees what", about) {
            session.bake_cells();
        }
        return;
    };
    let count = sets.pvs.cell_count();
    let pairs = u64::from(count) * u64::from(count.saturating_sub(1));
    let undecided = percent(sets.pvs.undecided(), pairs);
    ui.weak(format!(
        "{} of {} pairs of cells can see each other; {undecided} undecided",
        grouped(sets.pvs.visible_pairs()),
        grouped(pairs),
    ));
    let own = session.cells.chain.as_ref().and_then(|chain| chain.cell);
    if let Some(own) = own {
        let seen = (0..count).filter(|&to| to != own && sets.sees(own, to)).count();
        ui.weak(format!("from somewhere in cell {own}: {seen} others"));
    }
    matrix(ui, sets, own);
}

/// The matrix as the panel shows it, and the sets that it was made from.
#[derive(Clone)]
struct Made {
    key: (u64, u32),
    texture: egui::TextureHandle,
}

/// A matrix of cells: a row is what one sees.
fn matrix(ui: &mut egui::Ui, sets: &CellSets, own: Option<u32>) {
    let count = sets.order.len();
    // A texture may not be larger, and no panel shows so many.
    if count == 0 || count > 4096 {
        return;
    }
    let key = (sets.pvs.rows_hash(), sets.pvs.cell_count());
    let id = egui::Id::unique("matrix of cells");
    let texture = match ui.data(|d| d.get_temp::<Made>(id)).filter(|made| made.key == key) {
        Some(made) => made.texture,
        None => {
            let pairs = sets.order.iter().flat_map(|&a| sets.order.iter().map(move |&b| (a, b)));
            let shown = |(a, b): (u32, u32)| {
                colour(match sets.pvs.state(a, b) {
                    _ if a == b => PairShown::Visible.color(),
                    PairState::Visible => PairShown::Visible.color(),
                    PairState::Undecided => PairShown::Undecided.color(),
                    PairState::Hidden => PairShown::Hidden.color(),
                })
            };
            let image = egui::ColorImage::new([count, count], pairs.map(shown).collect());
            let options = egui::TextureOptions::NEAREST;
            let texture = ui.ctx().load_texture("matrix of cells", image, options);
            ui.data_mut(|d| d.insert_temp(id, Made { key, texture: texture.clone() }));
            texture
        }
    };
    let side = ui.available_width().min(220.0);
    let (rect, response) = ui.allocate_exact_size(egui::Vec2::splat(side), egui::Sense::hover());
    let uv = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    ui.painter().image(texture.id(), rect, uv, egui::Color32::WHITE);
    let cell = side / count as f32;
    if let Some(row) = own.and_then(|own| sets.order.iter().position(|&c| c == own)) {
        let top = rect.min + egui::vec2(0.0, row as f32 * cell);
        let line = egui::Rect::from_min_size(top, egui::vec2(side, cell.max(1.0)));
        let stroke = egui::Stroke::new(1.0, colour(OWN));
        ui.painter().rect_stroke(line, 0.0, stroke, egui::StrokeKind::Outside);
    }
    response.on_hover_ui_at_pointer(|ui| {
        let at = ui.input(|i| i.pointer.hover_pos()).unwrap_or(rect.min);
        let place = |v: f32| sets.order[((v / cell) as usize).min(count - 1)];
        let (from, to) = (place(at.y - rect.min.y), place(at.x - rect.min.x));
        let words = match sets.pvs.state(from, to) {
            _ if from == to => "the same cell",
            PairState::Visible => "proven visible",
            PairState::Undecided => "undecided, and kept",
            PairState::Hidden => "proven hidden",
        };
        ui.label(format!("cell {from}, cell {to}: {words}"));
    });
}
