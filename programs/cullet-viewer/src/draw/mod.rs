//! Who draws: a renderer on wgpu that follows what was decided elsewhere.
//!
//! - [`frame`](self): what is to be drawn, as panes; plain data.
//! - [`Renderer`]: uploads a scene once, then draws panes of it into its own texture.
//!
//! Every cluster is a range of its mesh's indices, every instance a slot of a list that is grouped
//! by mesh; so a frame is a few instanced calls for what is whole, and one for each range of what
//! is not. Transforms lie in a texture, since WebGL2 knows no storage buffers.

#[cfg(not(target_arch = "wasm32"))]
mod culling;
#[cfg(target_arch = "wasm32")]
#[path = "no_culling.rs"]
mod culling;
mod error;
mod frame;
mod geometry;
mod groups;
mod impostors;
mod list;
mod pane;
mod pass;
mod pipelines;
mod renderer;
mod textures;
mod timer;
mod upload;

pub use error::DrawError;
pub use frame::{
    DeviceFigures, DeviceTimes, DeviceView, DrawStats, LineVertex, Paint, Pane, Style,
};
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use geometry::linear;
pub use renderer::Renderer;
