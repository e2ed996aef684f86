//! Who decides what is drawn: the culler on the CPU, in a thread of its own natively, on a page in
//! the worker that made the scene. Drawing never waits for it: it draws the last decision there is,
//! and of requests that wait only the newest is answered.

mod message;
mod pick;
#[cfg(not(target_arch = "wasm32"))]
mod threaded;
#[cfg(target_arch = "wasm32")]
mod worker;

pub use pick::{Hit, pick};
#[cfg(not(target_arch = "wasm32"))]
pub use threaded::Decider;
#[cfg(target_arch = "wasm32")]
pub use worker::Decider;
#[cfg(target_arch = "wasm32")]
pub(crate) use worker::keep;

use std::sync::Arc;

use cullet::cull::occlusion::OcclusionBuffer;
use cullet::{Culler, View, ViewState, Visible};
use cullet_cells::CellView;

use crate::task::clock;
use crate::world::World;

/// A request to cull a view.
#[derive(Clone, Debug)]
pub struct Request {
    /// Scene of the request.
    pub world: Arc<World>,
    /// The view that culls.
    pub view: View,
    /// Settings of the request.
    pub culler: Culler,
    /// Whether the occlusion buffer is wanted too: copying it takes a tenth of a millisecond or so.
    pub buffer: bool,
    /// Tells this request from others of the same session, and rises from one to the next.
    pub number: u64,
}

/// The answer to a request.
#[derive(Clone, Debug)]
pub struct Decision {
    /// The request that it answers.
    pub request: Request,
    /// The visible set, with reasons and the funnel.
    pub visible: Visible,
    /// The slots of which something was drawn into the occlusion buffer, ascending; empty without
    /// that stage.
    pub occluders: Vec<u32>,
    /// The occlusion buffer, where it was wanted and made.
    pub buffer: Option<OcclusionBuffer>,
    /// How long it took.
    pub milliseconds: f32,
    /// Rises by one with each.
    pub number: u64,
}

/// Decides with what it remembers of the view.
#[derive(Debug, Default)]
struct Memory {
    state: ViewState,
    among: CellView,
    decided: u64,
    /// An earlier answer, whose memory the next one takes: that of a million instances is some
    /// megabytes, which the system would hand out page by page.
    spare: Visible,
}

impl Memory {
    fn decide(&mut self, request: Request) -> Decision {
        let began = clock();
        let mut visible = std::mem::take(&mut self.spare);
        let Request { world, view, culler, buffer, .. } = &request;
        let world = world.model.in_cells();
        self.among.cull(world, culler, view, &mut self.state, &mut visible);
        self.decided += 1;
        let milliseconds = (clock() - began) as f32 * 1e-6;
        // A buffer of an earlier view stays in the memory when the stage is switched off.
        let made = culler.occlusion.is_some();
        let drawn = if made { self.state.occluders_drawn() } else { &[] };
        let mut occluders: Vec<u32> = drawn.iter().map(|d| d.0).collect();
        occluders.sort_unstable();
        occluders.dedup();
        let buffer = self.state.occlusion_buffer().filter(|_| made && *buffer).cloned();
        Decision { request, visible, occluders, buffer, milliseconds, number: self.decided }
    }
}
