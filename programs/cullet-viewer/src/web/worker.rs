//! Workers: one that keeps a scene, and what they throw.

use js_sys::Reflect;
use wasm_bindgen::prelude::*;
use web_sys::Worker;

/// A worker with the scene that it made. It ends with the last who holds this: that gives its
/// memory back.
#[derive(Debug)]
pub(crate) struct Keeper(pub(super) Worker);

impl Keeper {
    pub(crate) fn worker(&self) -> &Worker {
        &self.0
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        self.0.terminate();
    }
}

/// Text of a JavaScript exception, for people.
pub(crate) fn thrown(what: JsValue) -> String {
    if let Some(text) = what.as_string() {
        return text;
    }
    let message = Reflect::get(&what, &"message".into()).ok().and_then(|m| m.as_string());
    message.unwrap_or_else(|| format!("{what:?}"))
}
