//! Answers of a view beyond the ids: reasons, draws, counts and explanations.

use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Write;

use cullet::{DrawList, Output, Reason, funnel::Unit};

use super::{SceneView, no_camera};
use crate::fault::{Code, Fault};
use crate::scene::SceneSet;

/// Memory of these answers.
#[derive(Debug, Default)]
pub(crate) struct More {
    reasons: Vec<u8>,
    draws: DrawList,
    funnel: Vec<f64>,
    text: String,
    /// The scene and its state at the last cull: slots of the answer are of no other.
    seen: Option<(u64, u64)>,
}

impl More {
    /// Notes what was culled: the id of a scene and its version.
    pub(crate) fn note(&mut self, id: u64, version: u64) {
        self.seen = Some((id, version));
    }
}

impl SceneView {
    /// That the scene is as it was culled.
    pub(crate) fn check_unchanged(&self, set: &SceneSet) -> Result<(), Fault> {
        if self.more.seen == Some((set.scene.id(), set.scene.change_version())) {
            return Ok(());
        }
        let message =
            "the scene has changed since this view culled it last, or it never did: cull first";
        Err(Fault::new(Code::Argument, message))
    }

    /// The stage that took each instance, by id; 0 for what is visible and for ids that name
    /// nothing.
    ///
    /// # Errors
    /// If the scene has changed since it was culled.
    pub fn reasons(&mut self, set: &SceneSet) -> Result<&[u8], Fault> {
        self.check_unchanged(set)?;
        self.more.reasons.clear();
        self.more.reasons.resize(set.id_count(), 0);
        for (slot, reason) in self.visible.reasons.iter().enumerate() {
            if let (Some(reason), Some(handle)) = (reason, set.scene.handle(slot as u32)) {
                self.more.reasons[handle.index as usize] = reason.stage as u8;
            }
        }
        Ok(&self.more.reasons)
    }

    /// Fills the draws of the last answer; instances by id.
    ///
    /// # Errors
    /// If the scene has changed since it was culled.
    pub fn fill_draws(&mut self, set: &SceneSet) -> Result<(), Fault> {
        self.check_unchanged(set)?;
        if self.culler.output == Output::Triangles {
            self.more.draws.fill_triangles(&set.scene, &self.visible, &set.places)
        } else {
            self.more.draws.fill(&set.scene, &self.visible, &set.places)
        }
        .map_err(|stale| Fault::new(Code::Argument, stale))?;
        for entry in &mut self.more.draws.instances {
            *entry = set.scene.handle(*entry).map_or(0, |handle| handle.index);
        }
        Ok(())
    }

    /// The draws that were filled.
    pub fn draws(&self) -> &DrawList {
        &self.more.draws
    }

    /// The rows of the funnel, eight numbers each: stage, unit, three counts in, three out.
    pub fn fill_funnel(&mut self) -> &[f64] {
        self.more.funnel.clear();
        for row in &self.visible.funnel.rows {
            let counts = [row.entered, row.left];
            let counts = counts.iter().flat_map(|c| [c.instances, c.clusters, c.triangles]);
            self.more.funnel.extend([f64::from(row.stage as u8), f64::from(row.unit as u8)]);
            self.more.funnel.extend(counts.map(|n| n as f64));
        }
        &self.more.funnel
    }

    /// Why an instance is drawn or not, as lines: the stage and detail that took it, or nothing;
    /// the ids that hide it; then a line for each stage with unit, counts and finding, all parted
    /// by tabs.
    ///
    /// # Errors
    /// If the id names nothing, or there is no camera yet.
    pub fn explain(&mut self, set: &SceneSet, id: u32) -> Result<&str, Fault> {
        let view = self.view.as_ref().ok_or_else(no_camera)?;
        let handle = set.handle(id)?;
        let explanation = set
            .cells
            .explain(&set.scene, &self.culler, view, handle)
            .map_err(|error| Fault::new(Code::Id, error))?;
        self.more.text.clear();
        let text = &mut self.more.text;
        if let Some(Reason { stage, detail }) = explanation.reason {
            let _ = write!(text, "{}\t{detail}", stage.name());
        }
        text.push('\n');
        let hiders = explanation.hidden_by.iter().filter_map(|&slot| set.scene.handle(slot));
        for (i, handle) in hiders.enumerate() {
            let _ = write!(text, "{}{}", if i > 0 { "\t" } else { "" }, handle.index);
        }
        for step in &explanation.steps {
            let (stage, unit) = (step.stage.name(), Unit::name(step.unit));
            let _ = write!(text, "\n{stage}\t{unit}\t{}\t{}\t{step}", step.entered, step.left);
        }
        Ok(text)
    }
}
