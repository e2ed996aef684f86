//! The page around the canvas: attributes of its body, and its address.

use wasm_bindgen::prelude::*;

/// Sets the body's attribute `data-NAME`.
pub(super) fn set(name: &str, value: &str) {
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

/// Takes the body's attribute `data-NAME` away.
pub(super) fn take(name: &str) -> Option<String> {
    let body = web_sys::window().and_then(|w| w.document()).and_then(|d| d.body())?;
    let name = format!("data-{name}");
    let value = body.get_attribute(&name)?;
    // As plain a name as those that are set.
    let _ = body.remove_attribute(&name);
    Some(value)
}

/// Whether the browser asks for reduced motion.
pub(super) fn is_calm() -> bool {
    let window = web_sys::window();
    let asked =
        window.and_then(|w| w.match_media("(prefers-reduced-motion: reduce)").ok().flatten());
    asked.is_some_and(|query| query.matches())
}

/// Tells the page that the graphics device is gone: nothing more can be drawn, and the page says
/// what to do.
pub(crate) fn tell_lost(why: &str) {
    set("error", why);
    set("state", "lost");
}

/// Puts the state's text into the address, in place of the one before: turning a scene is no
/// history to go back through.
pub(crate) fn set_address(link: &str) {
    let history = web_sys::window().and_then(|w| w.history().ok());
    if let Some(history) = history {
        // A browser that is asked too often refuses, and is asked again at the next change.
        let _ = history.replace_state_with_url(&JsValue::NULL, "", Some(&format!("#{link}")));
    }
}
