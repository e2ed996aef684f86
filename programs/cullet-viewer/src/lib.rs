//! The viewer: what is culled, and why, in a window and in a browser.
#![forbid(unsafe_code)]
// The page's server, the other program of this package, is built without any of it.
#![cfg(feature = "window")]

pub mod app;
pub mod audit;
#[cfg(not(target_arch = "wasm32"))]
pub mod bench;
pub mod bytes;
pub mod camera;
mod cell_lines;
pub mod cells;
#[cfg(not(target_arch = "wasm32"))]
mod chooser;
pub mod clipping;
pub mod compose;
pub mod controls;
pub mod cost;
pub mod cutaway;
pub mod decide;
pub mod device;
pub mod draw;
pub mod examples;
pub mod fades;
#[cfg(not(target_arch = "wasm32"))]
pub mod headless;
pub mod inbox;
pub mod journey;
mod levels_alone;
pub mod lines;
pub mod link;
pub mod measures;
pub mod nearness;
pub mod numbers;
pub mod outcodes;
#[cfg(not(target_arch = "wasm32"))]
pub mod pace;
pub mod packed;
mod painter;
pub mod pops;
mod present;
pub mod remaking;
pub mod report;
pub mod script;
pub mod session;
pub mod sides;
mod snapshot;
pub mod state;
pub mod structure;
pub mod study;
pub mod task;
#[cfg(not(target_arch = "wasm32"))]
pub mod tiles;
pub mod truth;
pub mod ui;
pub mod web;
pub mod world;
