//! Input of a view, for `serde`: all else follows from it, and is checked when it is read. Without
//! the ball of eyes, which is a frame's: recordings of views are binary, and one more field would
//! make others of them.

use serde::{Deserialize, Serialize};

use super::{CullFace, Depth, FrontFace, View, ViewError};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ViewData {
    /// Column-major.
    clip_from_world: [f64; 16],
    depth: Depth,
    viewport: [u32; 2],
    layers: u32,
    front_face: FrontFace,
    cull_face: CullFace,
}

impl From<View> for ViewData {
    fn from(view: View) -> Self {
        Self {
            clip_from_world: view.clip_from_world(),
            depth: view.depth,
            viewport: view.viewport,
            layers: view.layers,
            front_face: view.front_face,
            cull_face: view.cull_face,
        }
    }
}

impl TryFrom<ViewData> for View {
    type Error = ViewError;

    fn try_from(data: ViewData) -> Result<Self, ViewError> {
        let ViewData { clip_from_world, depth, viewport, layers, front_face, cull_face } = data;
        let view = Self::from_matrix(clip_from_world, depth, viewport)?;
        Ok(Self { layers, front_face, cull_face, ..view })
    }
}
