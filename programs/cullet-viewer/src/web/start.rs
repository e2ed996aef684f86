//! The start of the page.

use wasm_bindgen::prelude::*;

use super::page::{is_calm, set};
use crate::app::{App, Start, setup};

/// Starts the viewer in the canvas `canvas`. `?webgl` in the address takes WebGL2 even where WebGPU
/// is to be had, `?tour` begins with the tour. The body's `data-state` becomes `running`, or
/// `failed` with `data-error`.
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
    let tour = search.contains("tour");
    let begin = Start { link: hash, calm: is_calm(), tour, ..Start::default() };
    let make = Box::new(move |cc: &eframe::CreationContext<'_>| {
        let app = App::new(cc, begin)?;
        Ok(Box::new(app) as Box<dyn eframe::App>)
    });
    let started = eframe::WebRunner::new().start(canvas, options, make).await;
    started.map_err(|e| e.as_string().unwrap_or_else(|| format!("{e:?}")))?;
    set("state", "running");
    Ok(())
}
