//! Work that the user orders and that takes a while: a proof, a measurement, a report, a path.

use std::sync::Arc;

use super::Session;
use crate::cost::Measured;
use crate::journey::json;
use crate::report::{MOST_VIEWS, ReportOrder};
#[cfg(not(target_arch = "wasm32"))]
use crate::task::Task;
use crate::task::clock;
use crate::truth::Truth;

impl Session {
    /// Begins the proof for the present view and settings.
    pub fn prove(&mut self) {
        if let (Some(world), Some(view)) = (&self.world, self.culling_view()) {
            let ctx = self.ctx.clone();
            let culler = self.state.stages.culler(clock);
            let wake = move || ctx.request_repaint();
            self.truth = Truth::start(Arc::clone(world), view, culler, wake);
        }
    }

    /// Begins to measure what every camera of the path costs with the present settings.
    pub fn measure(&mut self) {
        if let Some(world) = &self.world {
            let ctx = self.ctx.clone();
            let (stages, look) = (self.state.stages.clone(), self.state.look.clone());
            let wake = move || ctx.request_repaint();
            let (world, rigs) = (Arc::clone(world), self.journey.rigs.clone());
            let size = self.culling_size();
            self.measured = Measured::start(world, rigs, size, stages, look, wake);
        }
    }

    /// Inputs of a report of the present scene, path and settings: cameras spread over the path, or
    /// without one the camera that culls.
    #[must_use]
    pub fn order(&self) -> Option<ReportOrder> {
        let size = self.culling_size().map(|v| v.max(1));
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let rigs = match self.journey.rigs.as_slice() {
            [] => vec![*self.culling_rig()?],
            rigs => {
                let views = rigs.len().min(MOST_VIEWS);
                let last = (rigs.len() - 1) as f64 / (views.max(2) - 1) as f64;
                (0..views).map(|i| rigs[(i as f64 * last).round() as usize]).collect()
            }
        };
        let views = rigs.len();
        let (scene, stages) = (self.state.scene.clone(), self.state.stages.clone());
        let (cameras, sides) = (json(&rigs, aspect).ok()?, self.state.sides);
        Some(ReportOrder { scene, cameras, views, size, stages, sides })
    }

    /// Whether a report is being made.
    #[must_use]
    pub fn is_reporting(&self) -> bool {
        self.report.is_some()
    }

    /// Begins to make a report with `cullet report`.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn make_report(&mut self) {
        if let Some(order) = self.order() {
            let ctx = self.ctx.clone();
            self.report = Some(Task::start(move || order.run(), move || ctx.request_repaint()));
        }
    }

    /// Begins to make and play one of the scene's own camera paths.
    pub fn travel(&mut self, path: cullet_scenes::paths::PathSpec) {
        if let Some(world) = &self.world {
            let ctx = self.ctx.clone();
            self.journey.make(Arc::clone(world), path, move || ctx.request_repaint());
        }
    }
}
