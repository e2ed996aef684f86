//! A view of a scene: settings, what it remembers, and its answer as arrays.

use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Write;

use cullet::{Culler, DrawList, Output, Reason, View, ViewState, Visible, funnel::Unit};

use crate::camera::view_of;
use crate::cells::CellView;
use crate::fault::{Code, Fault};
use crate::listing::Ascending;
use crate::scene::SceneSet;

/// Settings of a view as a page sends them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settings {
    /// 0 exact, 1 balanced, 2 fast.
    pub preset: u32,
    /// 0 instances, 1 clusters, 2 triangles.
    pub output: u32,
    /// Bit 0: without occlusion; bit 1: with reasons.
    pub flags: u32,
    /// Microseconds that a draw takes; the engine's own guess where that is not above 0.
    pub draw_us: f64,
}

/// One view of one scene.
#[derive(Debug)]
pub struct SceneView {
    culler: Culler,
    view: Option<View>,
    state: ViewState,
    among: CellView,
    visible: Visible,
    ids: Ascending,
    reasons: Vec<u8>,
    draws: DrawList,
    funnel: Vec<f64>,
    text: String,
    /// The scene and its state at the last cull: slots of the answer are of no other.
    seen: Option<(u64, u64)>,
}

impl SceneView {
    /// A view that has not seen anything yet.
    pub fn new(settings: Settings) -> Self {
        let mut culler = match settings.preset {
            0 => Culler::exact(),
            2 => Culler::fast(),
            _ => Culler::balanced(),
        };
        culler.output = match settings.output {
            0 => Output::Instances,
            2 => Output::Triangles,
            _ => Output::Clusters,
        };
        if settings.flags & 1 != 0 {
            culler.occlusion = None;
        }
        culler.reasons = settings.flags & 2 != 0;
        if settings.draw_us > 0.0 {
            culler.costs.draw_ns = settings.draw_us * 1e3;
        }
        Self {
            culler,
            view: None,
            state: ViewState::default(),
            among: CellView::default(),
            visible: Visible::default(),
            ids: Ascending::default(),
            reasons: Vec::new(),
            draws: DrawList::default(),
            funnel: Vec::new(),
            text: String::new(),
            seen: None,
        }
    }

    /// The culler, for tests and measurements.
    pub fn culler_mut(&mut self) -> &mut Culler {
        &mut self.culler
    }

    /// Sets the camera: world to clip space, column-major, in pixels of a viewport. Depth is 0
    /// standard, 1 reversed, or 2 from −1 to 1 as in WebGL.
    ///
    /// # Errors
    /// If the matrix shows no volume, or the viewport has no pixel; the camera stays as it was.
    pub fn set_camera(
        &mut self,
        matrix: [f64; 16],
        depth: u32,
        viewport: [u32; 2],
        layers: u32,
    ) -> Result<(), Fault> {
        let view =
            view_of(matrix, depth, viewport).map_err(|error| Fault::new(Code::Camera, error))?;
        self.view = Some(view.with_layers(layers));
        Ok(())
    }

    /// Culls a scene; the ids of what is visible lie at [`ids`](Self::ids).
    ///
    /// # Errors
    /// If there is no camera yet.
    pub fn cull(&mut self, set: &SceneSet) -> Result<(), Fault> {
        let view = self.view.as_ref().ok_or_else(no_camera)?;
        let (state, visible) = (&mut self.state, &mut self.visible);
        set.cells.cull((&set.scene, &mut self.among), &self.culler, view, state, visible);
        self.seen = Some((set.scene.id(), set.scene.change_version()));
        let scene = &set.scene;
        let ids = self.visible.slots().filter_map(|slot| Some(scene.handle(slot)?.index));
        self.ids.fill(self.culler.simd, set.id_count(), ids);
        Ok(())
    }

    /// The ids of visible instances, ascending.
    pub fn ids(&self) -> &[u32] {
        self.ids.list()
    }

    /// Triangles that are left to draw.
    pub fn triangle_count(&self) -> u64 {
        self.visible.triangle_count
    }

    /// That the scene is as it was culled.
    fn check_unchanged(&self, set: &SceneSet) -> Result<(), Fault> {
        if self.seen == Some((set.scene.id(), set.scene.change_version())) {
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
        self.reasons.clear();
        self.reasons.resize(set.id_count(), 0);
        for (slot, reason) in self.visible.reasons.iter().enumerate() {
            if let (Some(reason), Some(handle)) = (reason, set.scene.handle(slot as u32)) {
                self.reasons[handle.index as usize] = reason.stage as u8;
            }
        }
        Ok(&self.reasons)
    }

    /// Fills the draws of the last answer; instances by id.
    ///
    /// # Errors
    /// If the scene has changed since it was culled.
    pub fn fill_draws(&mut self, set: &SceneSet) -> Result<(), Fault> {
        self.check_unchanged(set)?;
        if self.culler.output == Output::Triangles {
            self.draws.fill_triangles(&set.scene, &self.visible, &set.places)
        } else {
            self.draws.fill(&set.scene, &self.visible, &set.places)
        }
        .map_err(|stale| Fault::new(Code::Argument, stale))?;
        for entry in &mut self.draws.instances {
            *entry = set.scene.handle(*entry).map_or(0, |handle| handle.index);
        }
        Ok(())
    }

    /// The draws that were filled.
    pub fn draws(&self) -> &DrawList {
        &self.draws
    }

    /// The rows of the funnel, eight numbers each: stage, unit, three counts in, three out.
    pub fn fill_funnel(&mut self) -> &[f64] {
        self.funnel.clear();
        for row in &self.visible.funnel.rows {
            let counts = [row.entered, row.left];
            let counts = counts.iter().flat_map(|c| [c.instances, c.clusters, c.triangles]);
            self.funnel.extend([f64::from(row.stage as u8), f64::from(row.unit as u8)]);
            self.funnel.extend(counts.map(|n| n as f64));
        }
        &self.funnel
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
        self.text.clear();
        let text = &mut self.text;
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

fn no_camera() -> Fault {
    Fault::new(
        Code::Camera,
        "the view has no camera yet: call setCamera(clipFromWorld, width, height) first",
    )
}
