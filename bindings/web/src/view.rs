//! A view of a scene: settings, what it remembers, and its answer as arrays.

#[cfg(feature = "clusters")]
mod answers;
#[cfg(feature = "queries")]
pub(crate) mod lights;

use cullet::{Culler, Output, View, ViewState, Visible};

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
    pub(crate) culler: Culler,
    pub(crate) view: Option<View>,
    pub(crate) state: ViewState,
    among: CellView,
    pub(crate) visible: Visible,
    ids: Ascending,
    #[cfg(feature = "clusters")]
    pub(crate) more: answers::More,
    /// Whether the camera is that of the last cull.
    #[cfg(feature = "queries")]
    is_culled: bool,
    #[cfg(feature = "queries")]
    pub(crate) lights: lights::Lights,
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
            #[cfg(feature = "clusters")]
            1 => Output::Clusters,
            #[cfg(feature = "clusters")]
            2 => Output::Triangles,
            _ => Output::Instances,
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
            #[cfg(feature = "clusters")]
            more: Default::default(),
            #[cfg(feature = "queries")]
            is_culled: false,
            #[cfg(feature = "queries")]
            lights: Default::default(),
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
        #[cfg(feature = "queries")]
        {
            self.is_culled = false;
        }
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
        self.list(set);
        Ok(())
    }

    /// Lists what a cull has found, and notes what it was of.
    pub(crate) fn list(&mut self, set: &SceneSet) {
        #[cfg(feature = "clusters")]
        self.more.note(set.scene.id(), set.scene.change_version());
        #[cfg(feature = "queries")]
        {
            self.is_culled = true;
        }
        let scene = &set.scene;
        let ids = self.visible.slots().filter_map(|slot| Some(scene.handle(slot)?.index));
        self.ids.fill(self.culler.simd, set.id_count(), ids);
    }

    /// The camera.
    ///
    /// # Errors
    /// If there is none yet.
    #[cfg(feature = "queries")]
    pub(crate) fn camera(&self) -> Result<&View, Fault> {
        self.view.as_ref().ok_or_else(no_camera)
    }

    /// That the scene and the camera are as they were culled.
    #[cfg(feature = "queries")]
    pub(crate) fn check_culled(&self, set: &SceneSet) -> Result<(), Fault> {
        self.camera()?;
        self.check_unchanged(set)?;
        if self.is_culled {
            return Ok(());
        }
        let message = "the camera has changed since this view culled the scene last: cull first";
        Err(Fault::new(Code::Argument, message))
    }

    /// The ids of visible instances, ascending.
    pub fn ids(&self) -> &[u32] {
        self.ids.list()
    }

    /// Triangles that are left to draw.
    pub fn triangle_count(&self) -> u64 {
        self.visible.triangle_count
    }
}

pub(crate) fn no_camera() -> Fault {
    Fault::new(
        Code::Camera,
        "the view has no camera yet: call setCamera(clipFromWorld, width, height) first",
    )
}
