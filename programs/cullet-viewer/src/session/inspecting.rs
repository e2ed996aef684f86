//! The clicked instance, and the study of it.

use cullet::{Handle, Reason, View, explain::Explanation};

use super::Session;
use crate::decide::{Request, pick};
use crate::levels_alone::{is_dropped, ranges_of};
use crate::outcodes::Coded;
use crate::state::{By, GhostForm};
use crate::study::{self, Cube, Seen};

/// The instance and triangle that the user clicked, and why it is drawn or not.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspected {
    /// The instance.
    pub handle: Handle,
    /// Its slot.
    pub slot: u32,
    /// The triangle that was hit.
    pub triangle: u32,
    /// The stages that it came to.
    pub explanation: Explanation,
    /// The decision that this is about.
    pub decided: u64,
}

impl Session {
    /// Inspects what is seen at a pixel of a view: what is drawn, and ghosts that are shown as they
    /// are. Nothing there ends the inspection.
    pub fn inspect(&mut self, view: &View, pixel: [f64; 2]) {
        let (Some(world), Some(ray)) = (&self.world, view.ray(pixel)) else { return };
        let scene = &world.model.scene;
        let visible = self.decision.as_ref().map(|d| &d.visible);
        let reason =
            |slot: u32| visible.and_then(|v| v.reasons.get(slot as usize).copied().flatten());
        let is_ghost = |slot: u32, reason: Reason| {
            is_dropped(scene, slot, reason) && !self.hides(reason.stage.name())
        };
        // What stands for others has a reason only where it stands for none.
        let stands = |slot: u32| visible.is_some_and(|v| !ranges_of(v, slot).is_empty());
        let shown = |slot: u32| match reason(slot) {
            _ if scene.is_stand_in(slot) => self.state.stages.on && stands(slot),
            Some(reason) => {
                self.state.ghosts.form == GhostForm::Solid && is_ghost(slot, reason)
                    || !self.state.stages.on
            }
            None => true,
        };
        let boxed = self.state.ghosts.form == GhostForm::Boxes;
        let hit = pick(scene, &ray, shown).or_else(|| {
            // Outlines are clicked where nothing that is drawn lies on the way.
            let ghost = |s: u32| boxed && reason(s).is_some_and(|r| is_ghost(s, r));
            pick(scene, &ray, ghost)
        });
        let found = hit.and_then(|hit| Some((scene.handle(hit.slot)?, hit.triangle)));
        self.inspected = None;
        if let Some((handle, triangle)) = found {
            self.inspect_handle(handle, triangle);
        }
    }

    /// Inspects an instance by its slot.
    pub fn inspect_slot(&mut self, slot: u32) {
        let handle = self.world.as_ref().and_then(|w| w.model.scene.handle(slot));
        if let Some(handle) = handle {
            self.inspect_handle(handle, 0);
        }
    }

    /// Inspects an instance by its handle.
    pub fn inspect_handle(&mut self, handle: Handle, triangle: u32) {
        let (Some(world), Some(decision)) = (&self.world, &self.decision) else { return };
        let Request { view, culler, .. } = &decision.request;
        let scene = &world.model.scene;
        let explained = world.model.in_cells().explain(culler, view, handle);
        let (slot, explanation) = match (scene.slot(handle), explained) {
            (Ok(slot), Ok(explanation)) => (slot, explanation),
            (Err(error), _) => return self.tell(error.to_string(), true),
            (_, Err(error)) => return self.tell(error.to_string(), true),
        };
        let decided = decision.number;
        self.inspected = Some(Inspected { handle, slot, triangle, explanation, decided });
    }

    /// Whether ghosts of a stage are switched off.
    #[must_use]
    pub fn hides(&self, stage: &str) -> bool {
        self.state.ghosts.hidden.iter().any(|h| h == stage)
    }

    /// Studies the back faces of what is inspected, where anything of that changed.
    pub(super) fn study(&mut self) {
        let settings = &self.state.study;
        let wanted =
            (settings.by != By::None).then_some((&self.world, &self.decision, &self.inspected));
        let Some((Some(world), Some(decision), Some(inspected))) = wanted else {
            (self.figures, self.studied) = (None, None);
            return;
        };
        let key = (decision.number, inspected.slot, settings.clone());
        if self.studied.as_ref() != Some(&key) {
            let scene = &world.model.scene;
            let view = &decision.request.view;
            let (mesh, transform) = (scene.mesh(inspected.slot), scene.transform(inspected.slot));
            self.figures = Some(Seen { mesh, transform, view }.study(settings));
            self.studied = Some(key);
        }
    }

    /// The triangle that was clicked against the planes of the culling view.
    #[must_use]
    pub fn coded(&self) -> Option<Coded> {
        let (world, inspected) = (self.world.as_ref()?, self.inspected.as_ref()?);
        let (scene, view) = (&world.model.scene, &self.decision.as_ref()?.request.view);
        let slot = inspected.slot;
        Coded::new(view, scene.mesh(slot), scene.transform(slot), inspected.triangle)
    }

    /// The cube of directions: of what is inspected in its own space, or else of the whole culling
    /// view.
    #[must_use]
    pub fn cube(&self) -> Option<Cube> {
        let (world, decision) = (self.world.as_ref()?, self.decision.as_ref()?);
        let view = &decision.request.view;
        let cone = match &self.inspected {
            Some(i) => {
                let scene = &world.model.scene;
                Seen { mesh: scene.mesh(i.slot), transform: scene.transform(i.slot), view }.cone()
            }
            None => study::sight(view),
        };
        Cube::new(self.state.study.cells, cone)
    }
}
