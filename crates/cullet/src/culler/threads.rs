//! One view on several threads.

use super::frame::Viewer;
use super::standing::Looks;
use super::{Culler, ViewState, pipeline};
use crate::jobs::{Jobs, OneThread};
use crate::scene::Scene;
use crate::view::View;
use crate::visible::Visible;

impl Culler {
    /// Culls for one view on several threads, with the answer of [`cull_one`](Self::cull_one), bit
    /// for bit. [Occlusion](Self::occlusion) alone is split into jobs, and only in a view whose
    /// last cull had enough to do; all else takes a few microseconds. To cull several views at
    /// once, [`cull`](Self::cull) does better: then each thread has a view of its own.
    ///
    /// Jobs and what they work on are in the memory of `state`, which is larger by a few hundred
    /// kilobytes for each thread; where that has grown, this allocates nothing but what the pool
    /// does.
    pub fn cull_one_on(
        &self,
        jobs: &dyn Jobs,
        scene: &Scene,
        view: &View,
        state: &mut ViewState,
        result: &mut Visible,
    ) {
        let ViewState { scratch, standing } = state;
        let was_long = self.occlusion.is_some() && scratch.caches.occlusion.was_long();
        let wakes = was_long && jobs.threads() > 1;
        standing.answer((self, scene), Looks::Camera(view.clone()), result, |result| {
            let mut cull = |jobs: &dyn Jobs| {
                pipeline::run((self, jobs), scene, Viewer::Camera(view), None, scratch, result);
            };
            if wakes {
                jobs.keep_awake(&mut || cull(jobs));
            } else {
                cull(&OneThread);
            }
        });
    }
}
