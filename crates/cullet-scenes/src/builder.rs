//! Building a scene: materials, meshes and instances, and where they are put.

use cullet::math;
use cullet::mesh::{Alpha, MeshData};
use cullet::{Handle, Instance, Mesh, MeshId, SceneError, Transform};
use glam::{DMat3, DVec3};

use super::rng::{Rng, sin_cos};
use super::shapes::{Shape, mesh_data};
use super::spec::{SceneSpecError, Spec};
use cullet_io::{Material, Model};

/// Whether a mesh is drawn from one side or from both.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Sides {
    /// A solid: its inside is never seen.
    One,
    /// A sheet.
    Both,
}

/// A model under construction.
pub(super) struct SceneBuilder {
    pub(super) model: Model,
}

impl SceneBuilder {
    pub(super) fn new(spec: &Spec) -> Self {
        Self { model: Model { name: spec.canonical(), ..Model::default() } }
    }

    /// A material from an sRGB colour, 0xRRGGBB.
    pub(super) fn material(&mut self, name: &str, srgb: u32) -> u32 {
        self.material_alpha(name, srgb, 1.0)
    }

    pub(super) fn material_alpha(&mut self, name: &str, srgb: u32, alpha: f32) -> u32 {
        let channel = |shift: u32| {
            let c = f64::from(srgb >> shift & 0xFF) / 255.0;
            let linear = if c <= 0.04045 { c / 12.92 } else { math::pow((c + 0.055) / 1.055, 2.4) };
            linear as f32
        };
        let color = [channel(16), channel(8), channel(0), alpha];
        self.model.materials.push(Material { name: name.to_owned(), color });
        (self.model.materials.len() - 1) as u32
    }

    pub(super) fn mesh(
        &mut self,
        name: &str,
        parts: &[(Shape, u32)],
        sides: Sides,
    ) -> Result<MeshId, SceneSpecError> {
        self.mesh_from(name, mesh_data(parts, sides == Sides::Both, Alpha::Opaque))
    }

    pub(super) fn mesh_from(
        &mut self,
        name: &str,
        data: MeshData,
    ) -> Result<MeshId, SceneSpecError> {
        let id = self.model.scene.add_mesh(Mesh::new(data)?);
        self.model.mesh_names.push(name.to_owned());
        Ok(id)
    }

    pub(super) fn add(&mut self, mesh: MeshId, transform: Transform) -> Result<Handle, SceneError> {
        self.model.scene.add(Instance::new(mesh, transform))
    }

    pub(super) fn finish(mut self) -> Model {
        self.model.scene.commit(&cullet::Culler::default());
        self.model
    }
}

/// A box of a mesh that fills −½..½ × 0..1 × −½..½, stretched to fill `min`..`max`.
pub(super) fn fill(min: [f64; 3], max: [f64; 3]) -> Transform {
    let size: [f32; 3] = std::array::from_fn(|a| (max[a] - min[a]) as f32);
    let base = [(min[0] + max[0]) * 0.5, min[1], (min[2] + max[2]) * 0.5];
    Transform::from_scale_translation(size, base)
}

/// Turned about the y axis by `turns`, scaled, then moved.
pub(super) fn turned(turns: f64, scale: [f64; 3], at: [f64; 3]) -> Transform {
    let (s, c) = sin_cos(turns);
    let columns = [[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]];
    Transform {
        linear: std::array::from_fn(|i| columns[i].map(|v| (v * scale[i]) as f32 + 0.0)),
        translation: at,
    }
}

/// A rotation drawn evenly from all (Shoemake, *Uniform Random Rotations*, 1992).
pub(super) fn any_rotation(rng: &mut Rng) -> DMat3 {
    let r = rng.unit();
    let (s1, c1) = sin_cos(rng.unit());
    let (s2, c2) = sin_cos(rng.unit());
    let (a, b) = ((1.0 - r).sqrt(), r.sqrt());
    let [x, y, z, w] = [a * s1, a * c1, b * s2, b * c2];
    DMat3::from_cols(
        DVec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        DVec3::new(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        DVec3::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
}
