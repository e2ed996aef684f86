//! Options of a loader: axes, sides, limits, and what is kept and prepared.

use cullet::prepared::Preparation;

/// How to load.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Axis of the file that points up; `None` takes what the format says, or Y. It turns the
    /// instances; vertices stay as the file has them. 3D Tiles for which it is given are read as
    /// they lie, and not as a place on the globe.
    pub up: Option<Up>,
    /// Overrides what the file says of sides: every part two-sided (`true`) or one-sided (`false`).
    pub two_sided: Option<bool>,
    /// The most triangles that may be decoded, instances counted once.
    pub max_triangles: u64,
    /// The most instances.
    pub max_instances: u64,
    /// Whether what only writers of files need is kept: normals, texture coordinates and colours of
    /// vertices (glTF, OBJ and PLY), and the places of nodes that draw nothing (glTF). Off by
    /// default; it costs up to 36 bytes a vertex and 128 a node.
    pub details: bool,
    /// Whether levels of detail that the file has baked are read (`CULLET_baked` of glTF). On by
    /// default.
    pub levels: bool,
    /// Whether impostors among them are read, where `levels` are. Off by default: they are for
    /// renderers that draw them, and one that does not would draw their boxes.
    pub impostors: bool,
    /// Data for culling to be made of each mesh; [`Scene::prepare`](cullet::Scene::prepare) makes
    /// them later.
    pub prepare: Preparation,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            up: None,
            two_sided: None,
            max_triangles: 500_000_000,
            max_instances: 50_000_000,
            details: false,
            levels: true,
            impostors: false,
            prepare: Preparation::default(),
        }
    }
}

/// Axis of a file that points up; the scene's is Y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Up {
    /// +Y: nothing to do.
    #[default]
    Y,
    /// +Z: (x, y, z) becomes (x, z, −y).
    Z,
}
