//! All that a link holds: which scene, from where, and every switch. Plain data without a window.

mod cut;
mod device;
mod look;
mod sides;
mod stages;
mod study;

use serde::{Deserialize, Serialize};

use crate::camera::Rig;
use crate::clipping::Clipping;

pub use cut::{CutAway, Part, REACH, Shape};
pub use device::OnDevice;
pub use look::{Colour, GhostForm, Ghosts, Look};
pub use sides::{Alteration, Sides};
pub use stages::Stages;
pub use study::{By, MOST_GROUPS, Study};

/// Settings of the viewer: the scene, the cameras, culling and how it is shown. See
/// [`link`](crate::link) for their text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct State {
    /// The built-in scene's text (`city:seed=3`), or the name of the file that was opened.
    pub scene: String,
    /// The camera that is flown; `None` until a scene is there to fit it to.
    pub camera: Option<Rig>,
    /// The camera that decides what is drawn, where it is not the one that is flown.
    pub frozen: Option<Rig>,
    /// How the picture is divided.
    pub layout: Layout,
    /// Where the wipe's divider stands: 0 at the left edge, 1 at the right.
    pub wipe: f32,
    /// Whether a map from above lies in the corner.
    pub map: bool,
    /// The culling settings.
    pub stages: Stages,
    /// Who decides.
    pub device: OnDevice,
    /// Sides that the scene's triangles are taken to have.
    pub sides: Sides,
    /// Portals that are shut though the scene has them open, or the other way around.
    pub doors: Vec<u32>,
    /// How triangles are drawn.
    pub look: Look,
    /// How what was dropped is shown.
    pub ghosts: Ghosts,
    /// Structures behind the result that are shown.
    pub structure: Structure,
    /// The cut-away.
    pub cut: CutAway,
    /// The study of back faces.
    pub study: Study,
    /// The clipping playground.
    pub clipping: Clipping,
    /// Whether every frame is drawn, or only when something changed.
    pub always: bool,
    /// Whether mere movement of the pointer turns the camera.
    pub hover_turns: bool,
    /// Dark or light.
    pub dark: bool,
    /// Whether the panels are there; without them the picture has all of the window.
    pub panels: bool,
}

impl Default for State {
    fn default() -> Self {
        Self {
            scene: "city".to_owned(),
            camera: None,
            frozen: None,
            layout: Layout::default(),
            wipe: 0.5,
            map: true,
            stages: Stages::default(),
            device: OnDevice::default(),
            sides: Sides::default(),
            doors: Vec::new(),
            look: Look::default(),
            ghosts: Ghosts::default(),
            structure: Structure::default(),
            cut: CutAway::default(),
            study: Study::default(),
            clipping: Clipping::default(),
            always: false,
            hover_turns: false,
            dark: true,
            panels: true,
        }
    }
}

/// In which manner a scene is shown, apart from where one looks from.
#[derive(Clone, Debug, PartialEq)]
pub struct Manner {
    /// How the picture is divided.
    pub layout: Layout,
    /// Whether a map from above lies in the corner.
    pub map: bool,
    /// The culling settings.
    pub stages: Stages,
    /// How triangles are drawn.
    pub look: Look,
}

impl Default for Manner {
    fn default() -> Self {
        Self::of(&State::default())
    }
}

impl Manner {
    /// Returns the manner of a state.
    #[must_use]
    pub fn of(state: &State) -> Self {
        let State { layout, map, stages, look, .. } = state;
        Self { layout: *layout, map: *map, stages: stages.clone(), look: look.clone() }
    }

    /// Shows a state in this manner.
    pub fn apply(&self, state: &mut State) {
        let Self { layout, map, stages, look } = self.clone();
        (state.layout, state.map, state.stages, state.look) = (layout, map, stages, look);
    }
}

/// How the picture is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// One picture.
    #[default]
    One,
    /// The culling camera's picture beside one from outside.
    Split,
    /// One picture with culling to the left of a divider and without to the right.
    Wipe,
    /// The culling camera's depth, beside the occlusion buffer that was made for it.
    Buffer,
}

/// The widest [`Occlusion::width`](cullet::cull::occlusion::Occlusion::width) that a link may ask
/// for: beyond it a buffer is finer than any screen.
pub const WIDEST_BUFFER: u32 = 4096;

impl State {
    /// Whether the occlusion buffer is shown in any way.
    #[must_use]
    pub fn wants_buffer(&self) -> bool {
        self.layout == Layout::Buffer || self.structure.buffer
    }
}

/// Structures behind the result that are shown.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Structure {
    /// Boxes of the hierarchy that the walk tested, of this level: 1 is just above the instances, 0
    /// none.
    pub level: u32,
    /// The cones of normals of the clusters of the inspected instance.
    pub cones: bool,
    /// The occlusion buffer over the picture of the camera that it was made for.
    pub buffer: bool,
    /// Coarser level of the occlusion buffer: the farthest of each tile of 8 × 8 pixels.
    pub tiles: bool,
    /// Only the instances of which something was drawn into the buffer are drawn.
    pub occluders: bool,
    /// Where an eye sees the cluster that was clicked wholly from behind.
    pub volume: bool,
    /// The outcodes of the triangle that was clicked, and the planes of the frustum that they are
    /// about.
    pub outcodes: bool,
    /// Instances that leave the bounds which culling goes by.
    pub audit: bool,
    /// Outlines of the scene's cells, from outside.
    pub cells: bool,
    /// View through each portal, in the order of the walk.
    pub portals: bool,
    /// How many of those are shown, the last of them stronger; 0 is all.
    pub step: u32,
}
