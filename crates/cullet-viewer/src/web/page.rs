//! The page: start, address, and what tests and readers of a screen read of it.

use wasm_bindgen::prelude::*;

use crate::app::{App, Start, setup};
use crate::session::Session;

/// Starts the viewer in the canvas `canvas`. `?webgl` in the address takes WebGL2 even where WebGPU is to be
/// had. The body's `data-state` becomes `running`, or `failed` with `data-error`.
#[wasm_bindgen(start)]
#[expect(unreachable_pub, reason = "the page's script calls it")]
pub fn start() {
    // The worker that loads scenes runs this module too, and has nothing to show.
    if web_sys::window().is_none() {
        return;
    }
    console_error_panic_hook::set_once();
    // A second logger would only mean that the page was started twice.
    let _ = eframe::WebLogger::init(log::LevelFilter::Info);
    wasm_bindgen_futures::spawn_local(async {
        if let Err(error) = run().await {
            set("state", "failed");
            set("error", &error);
            log::error!("{error}");
        }
    });
}

async fn run() -> Result<(), String> {
    let window = web_sys::window().ok_or("there is no window")?;
    let location = window.location();
    let search = location.search().unwrap_or_default();
    let hash = location.hash().unwrap_or_default();
    let backends = search.contains("webgl").then_some(eframe::wgpu::Backends::GL);
    let canvas = window
        .document()
        .and_then(|d| d.get_element_by_id("canvas"))
        .and_then(|e| e.dyn_into::<web_sys::HtmlCanvasElement>().ok())
        .ok_or("the page has no canvas 'canvas'")?;
    let options = eframe::WebOptions { wgpu_options: setup(backends), ..Default::default() };
    let begin = Start { link: hash, ..Start::default() };
    let make = Box::new(move |cc: &eframe::CreationContext<'_>| {
        let app = App::new(cc, begin)?;
        Ok(Box::new(app) as Box<dyn eframe::App>)
    });
    let started = eframe::WebRunner::new().start(canvas, options, make).await;
    started.map_err(|e| e.as_string().unwrap_or_else(|| format!("{e:?}")))?;
    set("state", "running");
    Ok(())
}

fn set(name: &str, value: &str) {
    let body = web_sys::window().and_then(|w| w.document()).and_then(|d| d.body());
    if let Some(body) = body {
        let name = format!("data-{name}");
        // Writing what is there already would wake whoever watches the page.
        if body.get_attribute(&name).as_deref() != Some(value) {
            // The name is plain letters, which no browser refuses.
            let _ = body.set_attribute(&name, value);
        }
    }
}

/// Tells the page that the graphics device is gone: nothing more can be drawn, and the page says what to do.
pub(crate) fn tell_lost(why: &str) {
    set("error", why);
    set("state", "lost");
}

/// Puts the state's text into the address, in place of the one before: turning a scene is no history to go
/// back through.
pub(crate) fn set_address(link: &str) {
    let history = web_sys::window().and_then(|w| w.history().ok());
    if let Some(history) = history {
        // A browser that is asked too often refuses, and is asked again at the next change.
        let _ = history.replace_state_with_url(&JsValue::NULL, "", Some(&format!("#{link}")));
    }
}

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
