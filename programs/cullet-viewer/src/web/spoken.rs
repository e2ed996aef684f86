//! The session in words: for readers of a screen, and for tests and pages that embed the viewer.

use super::page::{set, take};
use crate::session::{STOPS, Session};

/// The line that is read aloud when it changes: the lecture's counter, and what is frozen, clicked
/// or said.
fn spoken(session: &Session, left: u64, all: u64) -> String {
    let share = if all == 0 { 0.0 } else { left as f64 / all as f64 * 100.0 };
    let frozen = if session.state.frozen.is_some() { ", frozen" } else { "" };
    let mut line = format!("faces rendered: {left}/{all} ({share:.1} %){frozen}");
    if let Some(words) = session.tour_in_words() {
        // Figures that change with every step would have it all read again.
        line = words.trim_end_matches('.').to_owned();
    }
    if let (Some(inspected), Some(world)) = (&session.inspected, &session.world) {
        line.push_str(". ");
        line.push_str(&world.model.instance_name(inspected.handle));
        match inspected.explanation.reason {
            Some(reason) => line.push_str(&format!(": dropped by {}", reason.stage.name())),
            None => line.push_str(": drawn"),
        }
    }
    if let Some(sentence) = session.kept_backs() {
        line.push_str(". ");
        line.push_str(&sentence);
    }
    if let Some(notice) = session.notices.last() {
        line.push_str(". ");
        line.push_str(&notice.text);
    }
    line
}

/// Tells the page, for those who test it or embed it: `data-faces` (left/all), `data-settled`,
/// `data-frozen`, `data-reason` of what is inspected, `data-notice`; in the tour `data-step`
/// (step/all) and `data-answer`, `right` or `wrong` once one was given.
pub(crate) fn tell(session: &Session) {
    let all = session.world.as_ref().map_or(0, |w| w.counts.triangles);
    let left = match &session.decision {
        Some(d) if session.state.stages.on => d.visible.triangle_count,
        _ => all,
    };
    let line = web_sys::window().and_then(|w| w.document()?.get_element_by_id("spoken"));
    if let Some(line) = line.filter(|_| session.is_settled()) {
        let text = spoken(session, left, all);
        if line.text_content().as_ref() != Some(&text) {
            line.set_text_content(Some(&text));
        }
    }
    set("faces", &format!("{left}/{all}"));
    set("settled", if session.is_settled() { "yes" } else { "no" });
    set("frozen", if session.state.frozen.is_some() { "yes" } else { "no" });
    set("scene", session.world.as_ref().map_or("", |w| &w.name));
    let inspected = session.inspected.as_ref();
    let reason = inspected.map_or("", |i| match i.explanation.reason {
        Some(r) => r.stage.name(),
        None => "drawn",
    });
    set("reason", reason);
    let tour = session.tour.as_ref();
    set("step", &tour.map_or(String::new(), |t| format!("{}/{}", t.at() + 1, STOPS.len())));
    let given = tour.and_then(|t| t.given());
    set("answer", given.map_or("", |g| if g.is_right() { "right" } else { "wrong" }));
    set("notice", session.notices.last().map_or("", |n| &n.text));
}

/// Does what a button of the page for readers of a screen orders, if one was pressed since: see
/// `main.js`.
pub(crate) fn obey(session: &mut Session) {
    match take("order").as_deref() {
        Some("on") => session.tour_on(),
        Some("back") => session.tour_back(),
        Some("end") => session.end_tour(),
        Some(n) => n.parse().into_iter().for_each(|choice: usize| session.answer(choice)),
        None => {}
    }
}
