//! The viewer: what is culled, and why, in a window and in a browser.
#![forbid(unsafe_code)]

pub mod app;
pub mod audit;
pub mod camera;
pub mod clipping;
pub mod compose;
pub mod cutaway;
pub mod decide;
pub mod draw;
pub mod inbox;
pub mod journey;
pub mod lines;
pub mod link;
pub mod outcodes;
mod present;
pub mod script;
pub mod session;
pub mod state;
pub mod structure;
pub mod study;
pub mod task;
pub mod truth;
pub mod ui;
pub mod web;
pub mod world;
