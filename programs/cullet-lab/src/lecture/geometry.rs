//! What checks of geometry share, besides the [tools](crate::lecture::tools): points in the world and in clip space, products of vectors,
//! numbers at random.

use cullet::{Culler, MeshData, Scene, View, ViewState};
use cullet_draw::{Verification, VerifyOptions, verify};
use cullet_scenes::knobbly_ball;

use crate::lecture::tools::{placed, times};

/// A vector or point in f64.
pub(crate) type Vec3 = [f64; 3];

/// Draws a view with what a culler leaves and without, and compares the pictures pixel by pixel.
pub(crate) fn verified(culler: &Culler, scene: &Scene, view: &View) -> Verification {
    let options = VerifyOptions { samples: 1, ..VerifyOptions::default() };
    verify(scene, view, culler, &mut ViewState::default(), &options)
}

/// The corners in the world of all triangles of all instances.
pub(crate) fn triangles_in_world(scene: &Scene) -> impl Iterator<Item = [Vec3; 3]> {
    scene.slots().flat_map(move |slot| {
        let mesh = scene.mesh(slot);
        (0..mesh.triangle_count())
            .map(move |t| mesh.corners(t).map(|p| placed(scene.transform(slot), p)))
    })
}

/// A point in clip space.
pub(crate) fn in_clip(view: &View, [x, y, z]: Vec3) -> [f64; 4] {
    times(&view.clip_from_world(), [x, y, z, 1.0])
}

/// a·b.
pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// a × b.
pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a + s·b.
pub(crate) fn along(a: Vec3, s: f64, b: Vec3) -> Vec3 {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// Numbers at random, the same on every run (`SplitMix64`: Steele, Lea & Flood, *Fast Splittable Pseudorandom Number
/// Generators*, 2014).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform in `low..high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        low + (high - low) * ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in the box from −`size` to `size`.
    pub(crate) fn point<const D: usize>(&mut self, size: f64) -> [f64; D] {
        std::array::from_fn(|_| self.between(-size, size))
    }
}

/// The positions and indices of a closed ball with knobs, and as many triangles without area as it has vertices.
pub(crate) fn ball_with_degenerate(n: u16) -> MeshData {
    let (positions, mut indices) = knobbly_ball(n);
    let vertices = positions.len() as u32;
    for v in 0..vertices {
        // In turn a vertex three times, and an edge of which one end is there twice.
        let next = (v + 1) % vertices;
        indices.extend(if v % 2 == 0 { [v, v, v] } else { [v, next, v] });
    }
    MeshData { positions, indices, ..MeshData::default() }
}
