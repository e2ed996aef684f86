//! The session in words: for readers of a screen, and for tests and pages that embed the viewer.

use super::page::set;
use crate::session::Session;

/// The line that is read aloud when it changes: the lecture's counter, and what is frozen, clicked or said.
fn spoken(session: &Session, left: u64, all: u64) -> String {
    let share = if all == 0 { 0.0 } else { left as f64 / all as f64 * 100.0 };
    let frozen = if session.state.frozen.is_some() { ", frozen" } else { "" };
    let mut line = format!("faces rendered: {left}/{all} ({share:.1} %){frozen}");
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

/// Tells the page, for those who test it or embed it: `data-faces` (left/all), `data-settled`, `data-frozen`,
/// `data-reason` of what is inspected, `data-notice`.
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
    set("notice", session.notices.last().map_or("", |n| &n.text));
}
