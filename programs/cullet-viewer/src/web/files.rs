//! Files that a user of a page chooses, and pictures that are handed to them.

use eframe::egui;
use js_sys::{Object, Promise, Reflect, Uint8Array, Uint8ClampedArray};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{CustomEvent, CustomEventInit, HtmlInputElement};

use super::worker::thrown;
use crate::inbox::Read;

/// Opens the browser's dialog; what is chosen is read and put. A browser opens it only soon after a
/// click or a key, and says nothing of one that was closed.
pub(crate) fn choose(put: impl Fn(Read) + 'static) -> Result<(), String> {
    let input = web_sys::window()
        .and_then(|w| w.document()?.get_element_by_id("file"))
        .and_then(|e| e.dyn_into::<HtmlInputElement>().ok())
        .ok_or("The page has no input 'file'")?;
    // Or the same file could not be chosen twice.
    input.set_value("");
    let chosen = Promise::new(&mut |done, _| input.set_onchange(Some(&done)));
    input.click();
    spawn_local(async move {
        // It never fails, but it may never come.
        let _ = JsFuture::from(chosen).await;
        let Some(files) = input.files() else { return };
        let mut all = Vec::new();
        for file in (0..files.length()).filter_map(|i| files.get(i)) {
            match JsFuture::from(file.array_buffer()).await {
                Ok(bytes) => all.push((file.name(), Uint8Array::new(&bytes).to_vec())),
                Err(why) => return put(Err((file.name(), thrown(why)))),
            }
        }
        put(Ok(all));
    });
    Ok(())
}

/// Hands a picture to the page's script, which offers it as a download: browsers can write PNG
/// themselves.
pub(crate) fn download(image: &egui::ColorImage) -> Result<(), String> {
    let refused = |e| format!("The picture cannot be saved: {}.", thrown(e));
    let picture = Object::new();
    let set = |name: &str, value: &JsValue| Reflect::set(&picture, &name.into(), value);
    set("width", &JsValue::from(image.size[0] as u32)).map_err(refused)?;
    let pixels = Uint8ClampedArray::new_with_length(image.as_raw().len() as u32);
    pixels.copy_from(image.as_raw());
    set("pixels", &pixels).map_err(refused)?;
    let options = CustomEventInit::new();
    options.set_detail(&picture);
    let event = CustomEvent::new_with_event_init_dict("picture", &options).map_err(refused)?;
    let window = web_sys::window().ok_or("There is no window.")?;
    window.dispatch_event(&event).map_err(refused)?;
    Ok(())
}
