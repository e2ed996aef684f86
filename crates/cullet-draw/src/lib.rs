//! The reference renderer of `cullet`.
#![forbid(unsafe_code)]

mod bounds;
mod frame;
mod geometry;
pub mod picture;
mod prepare;
mod reference;
mod render;
mod sample;
mod tile;
mod verify;

pub use frame::{Frame, FrameStats, PixelId, RenderOptions, Selection};
pub use picture::{
    Picture, depth_complexity, fly_out, kinds, kinds_of, palette, shaded, top_down,
};
pub use reference::render_ref;
pub use render::render;
pub use verify::{FalseCull, Verification, VerifyOptions, verify, verify_visible};
