//! Why one instance is drawn or not, with the numbers of every stage that it came to.

use alloc::vec;
use alloc::vec::Vec;

#[cfg(feature = "candidates")]
use super::candidates::Candidates;
use super::evidence::Evidence;
use super::frame::{Alone, Frame, Viewer};
use super::pipeline::{self, Caches, Scratch};
#[cfg(feature = "shadows")]
use super::shadow::ShadowView;
use super::stage::{degenerate, detail, frustum, layer, lod};
use super::{CullError, Culler, Output};
use crate::bits;
use crate::funnel::{FunnelRow, Reason, Stage, Unit};
use crate::hierarchy::Handle;
use crate::jobs::OneThread;
use crate::scene::Scene;
use crate::view::View;
use crate::visible::Visible;

/// Finding of one stage. Displayed, it is a sentence.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Step {
    /// The stage.
    pub stage: Stage,
    /// Unit that it tested.
    pub unit: Unit,
    /// Number of units that entered the stage: the instance itself (one), its clusters or its
    /// triangles.
    pub entered: u64,
    /// Number of units that the stage passed on.
    pub left: u64,
    /// Measurements of the stage, if it tested the instance as a whole.
    #[cfg_attr(feature = "serde", serde(default))]
    pub evidence: Evidence,
}

/// Explanation of why an instance is drawn or not: every stage that it reached, with its numbers.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Explanation {
    /// Reason why the instance was dropped; `None` if any part of it is drawn.
    pub reason: Option<Reason>,
    /// The stages, in order.
    pub steps: Vec<Step>,
    /// Slots of the instances that hide it, nearest first; empty if it is not hidden.
    pub hidden_by: Vec<u32>,
}

impl Culler {
    /// Replays the stages for one instance alone and says what each of them found. The reason is
    /// the one that [`cull_one`](Self::cull_one) writes.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn explain(
        &self,
        scene: &Scene,
        view: &View,
        handle: Handle,
    ) -> Result<Explanation, CullError> {
        Ok(self.explain_all(scene, Viewer::Camera(view), &[handle])?.remove(0))
    }

    /// Explains many instances, each as [`explain`](Self::explain) does. What the explanations need
    /// of the whole scene is culled once, not once for each of them.
    ///
    /// # Errors
    /// If a handle names no instance.
    pub fn explain_many(
        &self,
        scene: &Scene,
        view: &View,
        handles: &[Handle],
    ) -> Result<Vec<Explanation>, CullError> {
        self.explain_all(scene, Viewer::Camera(view), handles)
    }

    /// Explains an instance for a light, as [`explain`](Self::explain) does for a camera. The
    /// reason is the one that [`cull_shadow`](Self::cull_shadow) writes.
    ///
    /// # Errors
    /// If the handle names no instance.
    #[cfg(feature = "shadows")]
    pub fn explain_shadows(
        &self,
        scene: &Scene,
        shadows: &ShadowView,
        handle: Handle,
    ) -> Result<Explanation, CullError> {
        Ok(self.explain_all(scene, Viewer::Light(shadows), &[handle])?.remove(0))
    }

    /// Explains instances for a view among `candidates`, as [`explain_many`](Self::explain_many)
    /// does for one of the whole scene. The reasons are those that [`cull_among`](Self::cull_among)
    /// writes.
    ///
    /// # Errors
    /// If a handle names no instance, and the errors of [`Candidates::check`].
    #[cfg(feature = "candidates")]
    pub fn explain_among(
        &self,
        scene: &Scene,
        view: &View,
        candidates: &dyn Candidates,
        handles: &[Handle],
    ) -> Result<Vec<Explanation>, CullError> {
        candidates.check(scene)?;
        self.explain_all(scene, Viewer::Among(view, candidates), handles)
    }

    fn explain_all(
        &self,
        scene: &Scene,
        viewer: Viewer<'_>,
        handles: &[Handle],
    ) -> Result<Vec<Explanation>, CullError> {
        let slots = handles.iter().map(|&handle| scene.slot(handle));
        let slots = slots.collect::<Result<Vec<u32>, _>>()?;
        let own = viewer.settings(self).into_owned();
        #[cfg_attr(not(feature = "lossy"), expect(unused_mut, reason = "levels are chosen anew"))]
        let mut telling = Self { reasons: true, clock: None, ..own };
        let (mut scratch, mut all) = (Scratch::default(), Visible::default());
        let lod = telling.lod_settings();
        let has_budget = lod.is_some_and(|lod| lod.triangles.is_some());
        let stands = lod.is_some_and(|lod| lod.stand_ins) && scene.stand_ins().is_some();
        if telling.occlusion.is_some() || has_budget || stands {
            // Occluders of an instance are all the others, a budget is all instances', and who
            // stands for one does so for others too, so the whole scene is culled first.
            let instances = Self { output: Output::Instances, ..telling.clone() };
            pipeline::run((&instances, &OneThread), scene, viewer, None, &mut scratch, &mut all);
            #[cfg(feature = "lossy")]
            if let (Some(lod), Some(pixels)) = (&mut telling.lod, all.lod_pixels) {
                (lod.pixels, lod.triangles) = (pixels, None);
            }
        }
        let mut result = Visible::default();
        let explain = |slot| {
            if scene.stand_ins().is_some() && scene.is_stand_in(slot) {
                return of_stand_in(scene, slot, &all);
            }
            let only = Alone { slot, all: &all };
            telling.explain_alone(scene, viewer, only, &mut scratch, &mut result)
        };
        Ok(slots.into_iter().map(explain).collect())
    }

    fn explain_alone(
        &self,
        scene: &Scene,
        viewer: Viewer<'_>,
        only: Alone<'_>,
        scratch: &mut Scratch,
        result: &mut Visible,
    ) -> Explanation {
        let slot = only.slot;
        pipeline::run((self, &OneThread), scene, viewer, Some(only), scratch, result);
        let reason = result.reasons[slot as usize];
        let frame = Frame::new(self, scene, viewer, Some(only));
        let rows = result.funnel.rows.iter().filter(|row| row.entered.of(row.unit) > 0);
        let steps = rows.map(|row| Step {
            stage: row.stage,
            unit: row.unit,
            entered: row.entered.of(row.unit),
            left: row.left.of(row.unit),
            evidence: evidence(&frame, &scratch.caches, slot, row, reason),
        });
        let hidden = reason.is_some_and(|r| r.stage == Stage::Occlusion);
        let steps = steps.collect();
        let hidden_by =
            if hidden { scratch.caches.occlusion.blockers(&frame, slot) } else { Vec::new() };
        Explanation { reason, steps, hidden_by }
    }
}

/// Whether an instance that stands for others is drawn in their place.
fn of_stand_in(scene: &Scene, slot: u32, all: &Visible) -> Explanation {
    let reason = all.reasons.get(slot as usize).copied().flatten();
    let left = u64::from(reason.is_none_or(|r| r.stage != Stage::Layer));
    let (count, is_off) = (scene.stood_for_by(slot).len() as u32, scene.is_stand_in_off(slot));
    let evidence = Evidence::StandIn { count, is_off };
    let step = Step { stage: Stage::Lod, unit: Unit::Instances, entered: 1, left, evidence };
    Explanation { reason, steps: vec![step], hidden_by: Vec::new() }
}

/// Returns the numbers of a stage's test of the instance of `slot`.
fn evidence(
    frame: &Frame<'_>,
    caches: &Caches,
    slot: u32,
    row: &FunnelRow,
    reason: Option<Reason>,
) -> Evidence {
    if row.unit != Unit::Instances {
        return Evidence::None;
    }
    match row.stage {
        Stage::Layer => layer::evidence(frame, slot),
        Stage::Occlusion => caches.occlusion.evidence(frame, slot),
        _ if bits::get(frame.scene.exempt(), slot as usize) => Evidence::Exempt,
        Stage::Frustum => {
            frustum::evidence(frame, slot, reason.filter(|_| row.left.instances == 0))
        }
        Stage::Pvs | Stage::Portal => frame
            .candidates_of(row.stage)
            .map_or(Evidence::None, |all| all.explain(row.stage, frame.scene, slot)),
        Stage::Detail if cfg!(feature = "lossy") => detail::evidence(frame, slot),
        Stage::Degenerate => degenerate::evidence(frame, slot),
        Stage::Lod => lod::evidence(frame, &caches.lod, slot),
        Stage::Detail | Stage::Backface => Evidence::None,
    }
}
