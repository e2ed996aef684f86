//! The example `lists` as a module that a page calls: `cargo xtask test lists` compares its answers with those of this machine.
#![cfg(target_arch = "wasm32")]

mod answers;
mod device;
mod lists;
mod scenes;

use cullet_gpu::Passes;
use wasm_bindgen::prelude::wasm_bindgen;

use answers::{answers, report};
use device::least;

/// The answers of this browser: a line each.
///
/// # Errors
/// If it has no device, or one that lists something else than the CPU; in words.
#[wasm_bindgen]
pub async fn run() -> Result<String, String> {
    console_error_panic_hook::set_once();
    let gpu = least().await.map_err(|e| e.to_string())?;
    let passes = Passes::request(&gpu.device).await.map_err(|e| e.to_string())?;
    let all = answers(Some((&gpu, &passes))).await.map_err(|e| e.to_string())?;
    report(&all)
}
