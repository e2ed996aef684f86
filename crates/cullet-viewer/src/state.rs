//! All that a link holds: which scene, from where, and every switch. Plain data without a window.

use cullet::cull::detail::{Detail, Measure};
use cullet::cull::occlusion::Occlusion;
use cullet::{Backface, CullFace, Culler, FrontFace, Output};
use serde::{Deserialize, Serialize};

use crate::camera::Rig;
use crate::clipping::Clipping;
use crate::cutaway::CutAway;
use crate::draw::{Paint, Style};
use crate::sides::Sides;
use crate::study::Study;

/// What the viewer shows and how. See [`link`](crate::link) for its text.
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
    /// What culls.
    pub stages: Stages,
    /// Which sides the scene's triangles are taken to have.
    pub sides: Sides,
    /// How triangles are drawn.
    pub look: Look,
    /// How what was dropped is shown.
    pub ghosts: Ghosts,
    /// What is shown of the structures behind the answer.
    pub structure: Structure,
    /// What of the scene is cut away.
    pub cut: CutAway,
    /// What is studied of back faces.
    pub study: Study,
    /// The clipping playground.
    pub clipping: Clipping,
    /// What is drawn when: always, or only when something changed.
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
            sides: Sides::default(),
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
    /// What culls.
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
    /// That of a state.
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
    /// What the culling camera sees as depth, beside the occlusion buffer that was made for it.
    Buffer,
}

/// What culls: the settings of a [`Culler`], and whether it is asked at all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Stages {
    /// Whether anything is culled; off draws all.
    pub on: bool,
    /// See [`Culler::frustum`].
    pub frustum: bool,
    /// See [`Culler::frustum_exact`].
    pub frustum_exact: bool,
    /// See [`Culler::backface`].
    pub backface: Backface,
    /// See [`Culler::degenerate`].
    pub degenerate: bool,
    /// The size in pixels under which things are dropped; 0 drops none.
    pub detail_px: f64,
    /// How that size is measured.
    pub detail_by: Measure,
    /// Whether things behind others are dropped; see [`Culler::occlusion`].
    pub occlusion: bool,
    /// See [`Occlusion::width`].
    pub occlusion_width: u32,
    /// See [`Occlusion::budget`].
    pub occlusion_budget: f32,
    /// How deep the answer goes.
    pub depth: Output,
}

impl Default for Stages {
    fn default() -> Self {
        Self {
            on: true,
            frustum: true,
            frustum_exact: false,
            backface: Backface::Fast,
            degenerate: true,
            detail_px: 0.0,
            detail_by: Measure::WidthAndHeight,
            occlusion: true,
            occlusion_width: Occlusion::default().width,
            occlusion_budget: Occlusion::default().budget,
            depth: Output::Clusters,
        }
    }
}

/// The widest [`Occlusion::width`] that a link may ask for: beyond it a buffer is finer than any screen.
pub const WIDEST_BUFFER: u32 = 4096;

impl State {
    /// Whether the occlusion buffer is shown in any way.
    #[must_use]
    pub fn wants_buffer(&self) -> bool {
        self.layout == Layout::Buffer || self.structure.buffer
    }
}

impl Stages {
    /// Nothing is culled.
    #[must_use]
    pub fn none() -> Self {
        Self {
            on: false,
            frustum: false,
            backface: Backface::Off,
            degenerate: false,
            occlusion: false,
            ..Self::default()
        }
    }

    /// Whole instances by the frustum alone, what most engines begin with.
    #[must_use]
    pub fn plain() -> Self {
        Self {
            backface: Backface::Off,
            degenerate: false,
            occlusion: false,
            depth: Output::Instances,
            ..Self::default()
        }
    }

    /// Everything, down to triangles, and what stays under two pixels too.
    #[must_use]
    pub fn all() -> Self {
        Self { frustum_exact: true, detail_px: 2.0, depth: Output::Triangles, ..Self::default() }
    }

    /// All but what asks what lies before what.
    #[must_use]
    pub fn open() -> Self {
        Self { occlusion: false, ..Self::default() }
    }

    /// The culler with these settings, which is asked for reasons and keeps time by `clock`.
    #[must_use]
    pub fn culler(&self, clock: fn() -> u64) -> Culler {
        let on = self.on;
        Culler {
            frustum: on && self.frustum,
            frustum_exact: on && self.frustum_exact,
            backface: if on { self.backface } else { Backface::Off },
            degenerate: on && self.degenerate,
            detail: (on && self.detail_px > 0.0)
                .then_some(Detail { measure: self.detail_by, threshold_px: self.detail_px }),
            occlusion: (on && self.occlusion).then_some(Occlusion {
                width: self.occlusion_width,
                budget: self.occlusion_budget,
                ..Occlusion::default()
            }),
            output: self.depth,
            reasons: true,
            clock: Some(clock),
            ..Culler::default()
        }
    }
}

/// What triangles are coloured by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Colour {
    /// Their material.
    #[default]
    Material,
    /// Why their instance was dropped.
    Reason,
    /// Which side is seen.
    Sides,
    /// Their cluster.
    Clusters,
    /// How often pixels are drawn to.
    Overdraw,
    /// How many pixels a triangle covers.
    Size,
    /// Distance.
    Depth,
}

impl Colour {
    /// All of them, with what a menu says.
    pub const ALL: [(Self, &'static str, &'static str); 7] = [
        (Self::Material, "material", "The colours of the file."),
        (Self::Reason, "reason", "Each instance in the colour of the stage that dropped it."),
        (Self::Sides, "sides", "Front faces light, back faces in another colour."),
        (Self::Clusters, "clusters", "A colour for each cluster of up to 124 triangles."),
        (Self::Overdraw, "overdraw", "How often each pixel is drawn to: bright is waste."),
        (
            Self::Size,
            "triangle size",
            "Bright triangles cover few pixels: they cost most for least.",
        ),
        (Self::Depth, "depth", "Distance from the eye."),
    ];
}

/// How triangles are drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Look {
    /// What they are coloured by.
    pub colour: Colour,
    /// Filled.
    pub fill: bool,
    /// Their edges.
    pub wireframe: bool,
    /// Which faces of one-sided meshes are culled.
    pub cull: CullFace,
    /// Whether the graphics hardware drops those faces too, of every mesh, two-sided ones not excepted.
    pub hardware: bool,
    /// Front faces are those that are clockwise.
    pub clockwise: bool,
    /// A line from the middle of each face.
    pub face_normals: bool,
    /// A line from each vertex.
    pub vertex_normals: bool,
    /// Four samples a pixel.
    pub fine: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            colour: Colour::Material,
            fill: true,
            wireframe: false,
            cull: CullFace::Back,
            hardware: false,
            clockwise: false,
            face_normals: false,
            vertex_normals: false,
            fine: false,
        }
    }
}

impl Look {
    /// What the renderer is told.
    #[must_use]
    pub fn style(&self) -> Style {
        Style {
            paint: match self.colour {
                Colour::Material => Paint::Material,
                Colour::Reason => Paint::Instances,
                Colour::Sides => Paint::Sides,
                Colour::Clusters => Paint::Clusters,
                Colour::Overdraw => Paint::Overdraw,
                Colour::Size => Paint::TriangleSize,
                Colour::Depth => Paint::Depth,
            },
            fill: self.fill,
            wireframe: self.wireframe,
            cull_face: if self.hardware { self.cull } else { CullFace::None },
            clockwise: self.clockwise,
            face_normals: self.face_normals,
            vertex_normals: self.vertex_normals,
            samples: if self.fine { 4 } else { 1 },
        }
    }

    /// Which winding a view takes for front.
    #[must_use]
    pub fn front_face(&self) -> FrontFace {
        if self.clockwise { FrontFace::Clockwise } else { FrontFace::CounterClockwise }
    }
}

/// How what was dropped is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GhostForm {
    /// Not at all.
    #[default]
    Off,
    /// As boxes.
    Boxes,
    /// As it is, in the colour of the reason.
    Solid,
}

/// Ghosts of what was dropped.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ghosts {
    /// How they are shown.
    pub form: GhostForm,
    /// Names of the stages whose ghosts are not shown.
    pub hidden: Vec<String>,
}

/// What is shown of the structures behind the answer.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Structure {
    /// Boxes of the hierarchy that the walk asked, of this level: 1 is just above the instances, 0 none.
    pub level: u32,
    /// The cones of normals of the clusters of the thing inspected.
    pub cones: bool,
    /// The occlusion buffer over the picture of the camera that it was made for.
    pub buffer: bool,
    /// Of the buffer its coarser level: the farthest of each tile of 8 × 8 pixels.
    pub tiles: bool,
    /// Only the things of which something was drawn into the buffer are drawn.
    pub occluders: bool,
    /// Where an eye sees the cluster that was clicked wholly from behind.
    pub volume: bool,
    /// The outcodes of the triangle that was clicked, and the planes of the frustum that they are about.
    pub outcodes: bool,
    /// Things that leave the bounds which culling goes by.
    pub audit: bool,
}
