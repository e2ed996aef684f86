//! Culling cost of every camera of a path: culled one after the other in the background, and shown
//! as a strip, on the map and as a line through the scene.

use std::sync::Arc;

use cullet::{ViewState, Visible};
use cullet_draw::palette;

use crate::camera::Rig;
use crate::state::{Look, Stages};
use crate::task::{Progress, Task, clock};
use crate::world::World;

/// The most cameras that are measured: of longer paths every second, third and so on.
pub const MOST: usize = 600;

/// Culling cost of one camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Camera of the path.
    pub camera: usize,
    /// Where its eye is.
    pub eye: [f64; 3],
    /// Triangles left.
    pub triangles: u64,
    /// Milliseconds of culling.
    pub milliseconds: f32,
}

/// The costs of a path's cameras.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Costs {
    /// One a camera, in the path's order.
    pub all: Vec<Cost>,
    /// The most triangles that a camera is left with.
    pub most: u64,
    /// The fewest.
    pub least: u64,
    /// Settings of the measurement.
    pub stages: Stages,
}

impl Costs {
    /// The colour of a cost: dark for the fewest triangles of the path, light for the most.
    #[must_use]
    pub fn colour(&self, cost: &Cost) -> [u8; 3] {
        let wide = (self.most - self.least).max(1) as f64;
        // The darkest of the palette would not show on a dark ground.
        palette::heat(0.2 + 0.8 * (cost.triangles - self.least) as f64 / wide)
    }

    /// Culls every camera of a path for pictures of `size` pixels, in order, so that what is
    /// remembered between frames helps as it would in flight.
    #[must_use]
    pub fn measure(
        world: &World,
        rigs: &[Rig],
        size: [u32; 2],
        stages: &Stages,
        look: &Look,
    ) -> Self {
        let mut culler = stages.culler(clock);
        (culler.reasons, culler.clock) = (false, None);
        let (mut state, mut visible) = (ViewState::default(), Visible::default());
        let mut made = Self { stages: stages.clone(), ..Self::default() };
        let step = rigs.len().div_ceil(MOST).max(1);
        for (camera, rig) in rigs.iter().enumerate().step_by(step) {
            let Ok(mut view) = rig.view(size) else { continue };
            (view.cull_face, view.front_face) = (look.cull, look.front_face());
            let began = clock();
            world.model.in_cells().cull(&culler, &view, &mut state, &mut visible);
            let milliseconds = (clock() - began) as f32 * 1e-6;
            // Off draws all.
            let triangles = if stages.on { visible.triangle_count } else { world.counts.triangles };
            made.all.push(Cost { camera, eye: rig.eye(), triangles, milliseconds });
        }
        made.most = made.all.iter().map(|c| c.triangles).max().unwrap_or(0);
        made.least = made.all.iter().map(|c| c.triangles).min().unwrap_or(0);
        made
    }
}

/// The measurement, if one was requested.
#[derive(Debug, Default)]
pub enum Measured {
    /// None was requested, or the path is another.
    #[default]
    None,
    /// Under way.
    Working(Task<Costs>),
    /// Done.
    Done(Arc<Costs>),
}

impl Measured {
    /// Begins; `wake` is called when it is done.
    pub fn start(
        world: Arc<World>,
        rigs: Vec<Rig>,
        size: [u32; 2],
        stages: Stages,
        look: Look,
        wake: impl FnOnce() + Send + 'static,
    ) -> Self {
        let work = move || Costs::measure(&world, &rigs, size, &stages, &look);
        Self::Working(Task::start(work, wake))
    }

    /// Looks whether it is done; false if it was lost.
    pub fn poll(&mut self) -> bool {
        if let Self::Working(task) = self {
            match task.poll() {
                Progress::Working => {}
                Progress::Done(costs) => *self = Self::Done(Arc::new(costs)),
                Progress::Lost => {
                    *self = Self::None;
                    return false;
                }
            }
        }
        true
    }

    /// The costs, once all are measured.
    #[must_use]
    pub fn costs(&self) -> Option<&Arc<Costs>> {
        match self {
            Self::Done(costs) => Some(costs),
            _ => None,
        }
    }
}
