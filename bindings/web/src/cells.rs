//! Cells of a scene: those of a file, for nothing else makes any.

#[cfg(feature = "clusters")]
use cullet::{CullError, Handle, explain::Explanation};
use cullet::{Culler, Scene, View, ViewState, Visible};
#[cfg(feature = "files")]
use cullet_cells::InCells;

/// Cells that a scene may have.
#[derive(Debug, Default)]
pub(crate) struct Cells(#[cfg(feature = "files")] pub(crate) Option<cullet_cells::Cells>);

/// State of one view among them.
#[derive(Debug, Default)]
pub(crate) struct CellView(#[cfg(feature = "files")] cullet_cells::CellView);

#[cfg(feature = "files")]
impl Cells {
    pub(crate) fn update(&mut self, scene: &Scene) {
        if let Some(cells) = &mut self.0 {
            cells.update(scene);
        }
    }

    pub(crate) fn cull(
        &self,
        (scene, among): (&Scene, &mut CellView),
        culler: &Culler,
        view: &View,
        state: &mut ViewState,
        visible: &mut Visible,
    ) {
        among.0.cull(InCells::new(scene, self.0.as_ref()), culler, view, state, visible);
    }

    pub(crate) fn explain(
        &self,
        scene: &Scene,
        culler: &Culler,
        view: &View,
        handle: Handle,
    ) -> Result<Explanation, CullError> {
        InCells::new(scene, self.0.as_ref()).explain(culler, view, handle)
    }
}

#[cfg(not(feature = "files"))]
impl Cells {
    pub(crate) fn update(&mut self, _: &Scene) {}

    pub(crate) fn cull(
        &self,
        (scene, _): (&Scene, &mut CellView),
        culler: &Culler,
        view: &View,
        state: &mut ViewState,
        visible: &mut Visible,
    ) {
        culler.cull_one(scene, view, state, visible);
    }

    #[cfg(feature = "clusters")]
    pub(crate) fn explain(
        &self,
        scene: &Scene,
        culler: &Culler,
        view: &View,
        handle: Handle,
    ) -> Result<Explanation, CullError> {
        culler.explain(scene, view, handle)
    }
}
