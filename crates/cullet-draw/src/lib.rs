//! The reference renderer of `cullet`.
#![forbid(unsafe_code)]

mod bounds;
mod frame;
mod geometry;
mod prepare;
mod reference;
mod render;
mod sample;
mod tile;
mod verify;

pub use frame::{Frame, FrameStats, PixelId, RenderOptions, Selection};
pub use reference::render_ref;
pub use render::render;
pub use verify::{FalseCull, Verification, VerifyOptions, verify, verify_visible};
