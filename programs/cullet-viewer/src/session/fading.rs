//! Fades between levels of detail, from decision to decision.

use std::sync::Arc;

use super::Session;
use crate::decide::{Decision, Request};
use crate::fades::{Cut, Fades, share_by_size};
use crate::levels_alone::levels_alone;

impl Session {
    /// Goes on with what fades from the present decision to the next, where that is wanted.
    pub(super) fn follow_fades(&mut self, next: &Decision) {
        let Request { world, view, culler, .. } = &next.request;
        let scene = &world.model.scene;
        let is_wanted = self.state.stages.lod_fade > 0.0;
        let alone =
            is_wanted.then(|| levels_alone(scene, (culler, view), &next.visible, false)).flatten();
        let before = self.decision.as_ref().filter(|d| Arc::ptr_eq(&d.request.world, world));
        let old = before.zip(self.alone.as_ref());
        match (old, &alone) {
            (Some((before, old)), Some(new)) => {
                let before = Cut { visible: &before.visible, alone: old };
                let after = Cut { visible: &next.visible, alone: new };
                // What fades by its size already changes at once: a pixel knows of one share.
                let detail = culler.detail.filter(|detail| detail.fade > 0.0);
                let by_size =
                    |slot| detail.is_some_and(|d| share_by_size(scene, view, &d, slot) < 1.0);
                self.fades.follow(scene, [before, after], by_size);
            }
            _ => self.fades.clear(),
        }
        self.alone = alone;
    }

    /// Lets `dt` seconds of the fades pass.
    pub(super) fn fade(&mut self, dt: f64) {
        if self.fades.advance(dt, self.state.stages.lod_fade) {
            self.refresh = true;
            self.ctx.request_repaint();
        }
    }

    /// Forgets what fades, of another scene.
    pub(super) fn end_fades(&mut self) {
        (self.fades, self.alone) = (Fades::default(), None);
    }
}
