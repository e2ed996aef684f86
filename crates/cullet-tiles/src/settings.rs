//! Settings of a world.

use cullet::prepared::Preparation;

/// Settings of a world.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// Bytes that tiles and their scenes may take, also while others are loaded. Meshes, which are
    /// shared by all, are not counted. Default: 1 GiB.
    pub budget: u64,
    /// Tiles are wanted finer while their error is larger than this on the screen, in pixels.
    /// Default: 8.
    pub pixels: f64,
    /// Pixels of a length of one unit at a distance of one: height of the viewport over twice the
    /// tangent of half of the vertical angle of view. Default: 935, a viewport of 1080 pixels at 60
    /// degrees.
    pub scale: f64,
    /// So many seconds ahead tiles are loaded that the motion of the eye leads to. Default: 2.
    pub ahead: f64,
    /// Preparation of meshes, for the culler that will be used. Default: the balanced one.
    pub preparation: Preparation,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            budget: 1 << 30,
            pixels: 8.0,
            scale: 935.0,
            ahead: 2.0,
            preparation: (&cullet::Culler::balanced()).into(),
        }
    }
}

impl Settings {
    /// Returns a copy with another budget, in bytes.
    #[must_use]
    pub fn with_budget(self, budget: u64) -> Self {
        Self { budget, ..self }
    }

    /// Returns a copy with another error on the screen, in pixels; 0 wants everything that the
    /// budget allows.
    #[must_use]
    pub fn with_pixels(self, pixels: f64) -> Self {
        Self { pixels, ..self }
    }
}

/// Bytes of an instance in a scene, measured by `cullet fly` and rounded up.
const OF_A_SCENE: u64 = 288;
/// Bytes of a mesh for each vertex and for each triangle, with what is prepared of it; rounded up.
const OF_A_MESH: [u64; 2] = [16, 64];

/// Bytes that a tile takes: what was loaded, and twice what a scene has of it, for the next scene
/// is built while the last is in use. The last may be of another cut, all instances where the next
/// is all meshes: of what a cut is counted as, scenes of instances take 4/9 and what is loaded with
/// its scene 5/9, and meshes are counted 18/5 times so that they take no more.
pub(crate) fn bytes_of(instances: u32, [vertices, triangles]: [u64; 2]) -> u64 {
    let instance = size_of::<cullet::Instance>() as u64 + 2 * OF_A_SCENE;
    let [vertex, triangle] = OF_A_MESH;
    let meshes = vertices.saturating_mul(vertex).saturating_add(triangles.saturating_mul(triangle));
    (u64::from(instances) * instance).saturating_add(meshes.saturating_mul(18) / 5)
}
