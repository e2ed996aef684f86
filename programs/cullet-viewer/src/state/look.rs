//! How triangles and what was dropped of them are drawn.

use cullet::view::{CullFace, FrontFace};
use serde::{Deserialize, Serialize};

/// The quantity that colours triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Colour {
    /// Their material.
    #[default]
    Material,
    /// Why their instance was dropped.
    Reason,
    /// Colour of the side that is seen.
    Sides,
    /// Their cluster.
    Clusters,
    /// How often pixels are drawn to.
    Overdraw,
    /// How many pixels a triangle covers.
    Size,
    /// Distance.
    Depth,
    /// How often they were simplified.
    Levels,
    /// Whether their instance changed since the picture before for its size alone: what pops.
    Pops,
}

impl Colour {
    /// All of them, with what a menu says.
    pub const ALL: [(Self, &'static str, &'static str); 9] = [
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
        (
            Self::Levels,
            "levels",
            "How often triangles were simplified: cream in full, then from blue over green and red to grey.",
        ),
        (
            Self::Pops,
            "pops",
            "What small-object culling and levels of detail changed since the picture before: green came, orange is drawn at another level.",
        ),
    ];
}

/// How triangles are drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Look {
    /// The quantity that colours them.
    pub colour: Colour,
    /// Filled.
    pub fill: bool,
    /// Their edges.
    pub wireframe: bool,
    /// Faces of one-sided meshes that are culled.
    pub cull: CullFace,
    /// Whether the graphics hardware drops those faces too, of every mesh, two-sided ones not
    /// excepted.
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
    /// Returns the winding that a view takes for front.
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
    /// Boxes.
    Boxes,
    /// Solid instances, in the colour of the reason.
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
