//! The funnel: what came into each stage and what went on, with its history, the legend, and the
//! proof.

use cullet::{
    Stage,
    funnel::{Funnel, Unit},
};
use cullet_draw::palette;
use eframe::egui;

use super::words::{button, colour, swatch};
use crate::compose::MOST_GHOSTS;
use crate::numbers::{grouped, percent};
use crate::session::{HISTORY, Session};
use crate::state::GhostForm;
use crate::truth::Truth;

/// How high a stage's bar is.
const BAR: f32 = 3.0;

/// All of it.
pub(super) fn all(ui: &mut egui::Ui, session: &mut Session) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.strong("Funnel").on_hover_text("What entered each stage of culling, and what passed it");
        if button(ui, "Copy", "Copies the funnel as JSON (J)") {
            session.copy_funnel();
        }
    });
    if let Some(decision) = &session.decision {
        rows(ui, &decision.visible.funnel);
    } else {
        ui.weak("Nothing is decided yet.");
    }
    super::deciding::figures(ui, session);
    history(ui, session);
    ui.separator();
    legend(ui, session);
    ui.separator();
    proof(ui, session);
    ui.separator();
}

fn rows(ui: &mut egui::Ui, funnel: &Funnel) {
    let mut unit = None;
    for row in &funnel.rows {
        if unit != Some(row.unit) {
            unit = Some(row.unit);
            ui.weak(match row.unit {
                Unit::Instances => "instances",
                Unit::Clusters => "clusters of what is left",
                Unit::Triangles => "triangles of what is left",
            });
        }
        let (entered, left) = (row.entered.of(row.unit), row.left.of(row.unit));
        let dropped = entered - left;
        let share = if entered == 0 { 1.0 } else { left as f32 / entered as f32 };
        let wide = ui.available_width();
        let text_high = ui.text_style_height(&egui::TextStyle::Small) + 1.0;
        let size = egui::vec2(wide, text_high + BAR + 2.0);
        let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
        // The culled share is the coloured end of the bar, under the words: on top of it they would
        // be unreadable.
        let painter = ui.painter();
        let mut bar = rect;
        bar.min.y += text_high;
        bar.max.y = bar.min.y + BAR;
        painter.rect_filled(bar, 1.0, ui.visuals().weak_text_color());
        bar.min.x += bar.width() * share;
        painter.rect_filled(bar, 1.0, colour(palette::reason_color(Some(row.stage))));
        let font = egui::TextStyle::Small.resolve(ui.style());
        let put = |x: f32, align, words: String, ink| {
            painter.text(egui::pos2(x, rect.min.y), align, words, font.clone(), ink);
        };
        let (strong, plain) = (ui.visuals().strong_text_color(), ui.visuals().text_color());
        // Stages that dropped something stand out.
        let ink = if dropped > 0 { strong } else { plain };
        put(rect.min.x, egui::Align2::LEFT_TOP, row.stage.name().to_owned(), ink);
        let words = format!("−{}   {} left", grouped(dropped), grouped(left));
        put(rect.max.x, egui::Align2::RIGHT_TOP, words, ink);
        let took = row.time().map_or(String::new(), |n| format!(", in {:.3} ms", n as f64 * 1e-6));
        response.on_hover_text(format!(
            "{}: {} of {} {} dropped ({}), {} triangles with them{took}",
            row.stage.name(),
            grouped(dropped),
            grouped(entered),
            row.unit.name(),
            percent(dropped, entered),
            grouped(row.dropped().triangles),
        ));
    }
    let w = funnel.frustum;
    if w.nodes + w.blocks + w.swept > 0 {
        let text =
            format!("{} nodes tested, {} plane tests", grouped(w.nodes), grouped(w.plane_tests));
        ui.weak(text).on_hover_text(format!(
            "The frustum's walk of the hierarchy: {} blocks of 16 instances tested one by one, {} \
             instances swept without testing a node",
            grouped(w.blocks),
            grouped(w.swept)
        ));
    }
}

fn history(ui: &mut egui::Ui, session: &Session) {
    let size = egui::vec2(ui.available_width(), 46.0);
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let slowest = session.history.iter().map(|p| p.milliseconds).fold(0.1, f32::max);
    let line = |value: &dyn Fn(usize) -> f32, rgb: [u8; 3]| {
        let from = HISTORY - session.history.len();
        let points: Vec<egui::Pos2> = (0..session.history.len())
            .map(|i| {
                let x = rect.min.x + rect.width() * (from + i) as f32 / (HISTORY - 1) as f32;
                egui::pos2(x, rect.max.y - 3.0 - (rect.height() - 16.0) * value(i).clamp(0.0, 1.0))
            })
            .collect();
        painter.add(egui::Shape::line(points, egui::Stroke::new(1.5, colour(rgb))));
    };
    let faces = palette::UNSEEN;
    let times = palette::reason_color(Some(Stage::Frustum));
    line(&|i| session.history[i].milliseconds / slowest, times);
    line(&|i| session.history[i].share, faces);
    // The palette's light colours are no ink on a light ground: each name has a dot of its colour.
    let font = egui::TextStyle::Small.resolve(ui.style());
    let ink = ui.visuals().text_color();
    let named = |from_left: bool, words: String, rgb: [u8; 3]| {
        let galley = painter.layout_no_wrap(words, font.clone(), ink);
        let wide = galley.size().x + 10.0;
        let x = if from_left { rect.min.x + 4.0 } else { rect.max.x - 4.0 - wide };
        let middle = rect.min.y + 1.0 + galley.size().y * 0.5;
        painter.circle_filled(egui::pos2(x + 3.0, middle), 3.0, colour(rgb));
        painter.galley(egui::pos2(x + 10.0, rect.min.y + 1.0), galley, ink);
    };
    named(true, "triangles left".to_owned(), faces);
    named(false, format!("culling, to {slowest:.1} ms"), times);
    response.on_hover_text(
        "The last 240 decisions: the share of triangles left, and the time of culling",
    );
}

fn legend(ui: &mut egui::Ui, session: &mut Session) {
    ui.strong("Culled by reason")
        .on_hover_text("The colours of map, ghosts and funnel. Switches show or hide ghosts");
    let mut counts = [0u64; Stage::ALL.len()];
    let mut kept = 0;
    if let Some(decision) = &session.decision {
        kept = decision.visible.instance_count;
        let scene = &decision.request.world.model.scene;
        // What would stand for others is none of the instances.
        let reasons = (0..).zip(&decision.visible.reasons).filter(|(s, _)| !scene.is_stand_in(*s));
        for reason in reasons.filter_map(|(_, reason)| *reason) {
            counts[reason.stage as usize - 1] += 1;
        }
    }
    ui.horizontal(|ui| {
        swatch(ui, palette::SEEN);
        ui.label("kept");
        ui.weak(grouped(kept));
    });
    for (stage, count) in Stage::ALL.into_iter().zip(counts).filter(|(_, count)| *count > 0) {
        ui.horizontal(|ui| {
            swatch(ui, palette::reason_color(Some(stage)));
            let mut shown = !session.hides(stage.name());
            let about = "Whether its ghosts are shown";
            if ui
                .checkbox(&mut shown, palette::reason_label(Some(stage)))
                .on_hover_text(about)
                .changed()
            {
                let hidden = &mut session.state.ghosts.hidden;
                hidden.retain(|h| h != stage.name());
                if !shown {
                    hidden.push(stage.name().to_owned());
                }
            }
            ui.weak(grouped(count));
        });
    }
    let shown: u64 = Stage::ALL
        .into_iter()
        .zip(counts)
        .filter(|(s, _)| !session.hides(s.name()))
        .map(|(_, c)| c)
        .sum();
    if session.state.ghosts.form == GhostForm::Boxes && shown > MOST_GHOSTS as u64 {
        ui.weak(format!("{} of {} boxes are drawn", grouped(MOST_GHOSTS as u64), grouped(shown)));
    }
}

fn proof(ui: &mut egui::Ui, session: &mut Session) {
    let mut begin = false;
    ui.horizontal(|ui| {
        ui.strong("Truth");
        if matches!(session.truth, Truth::Working(_)) {
            ui.spinner();
            ui.weak("drawing twice and comparing");
        } else {
            let about = "Draws this view on the processor with and without culling and compares every pixel, as \
                         cullet verify does: some seconds for millions of faces (V)";
            begin = button(ui, "Verify this view", about);
        }
    });
    if begin {
        session.prove();
    }
    let Some(found) = session.truth.finding() else { return };
    let present = session.culling_view();
    if found.view != present {
        ui.weak("The view has moved on since:");
    }
    if found.lost.is_empty() {
        ui.label("Nothing visible was lost.");
    } else {
        ui.horizontal(|ui| {
            swatch(ui, palette::LOST);
            ui.label(format!("{} visible instances were dropped!", found.lost.len()));
        });
        if session.state.stages.detail_px > 0.0 {
            ui.weak("Dropping what is small may lose what is seen.");
        }
    }
    if session.state.stages.lod_px > 0.0 {
        ui.weak("Levels of detail aside: cullet verify --lod measures those.");
    }
    ui.horizontal(|ui| {
        swatch(ui, palette::UNSEEN);
        let text = format!("{} of {} kept instances are hidden", grouped(found.unseen_count), grouped(found.kept_instances));
        ui.label(text).on_hover_text("Kept, though no pixel shows them: what occlusion culling could gain. Yellow in colours by reason");
    });
    let tight = found.kept as f64 / found.visible.max(1) as f64;
    ui.label(format!(
        "{} triangles visible, {} kept: tightness {tight:.1}",
        grouped(found.visible),
        grouped(found.kept)
    ))
    .on_hover_text(format!(
        "Compared at {} × {} pixels; 1 would be perfect",
        found.size[0], found.size[1]
    ));
}
