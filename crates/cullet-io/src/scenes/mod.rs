//! Built-in scenes: made by rule from a seed, the same on every machine.
//!
//! A scene is named by a text, `name:key=value,...`: `city`, `city:seed=3,sub=2`, `forest:n=1e7`.
//! [`list`] says which names and keys there are. Lengths are metres; y is up and the ground is near 0.

mod city;
mod forest;
mod knobs;
mod moving;
mod office;
mod plant;
mod rng;
mod shapes;
mod solids;
mod spec;

pub use knobs::knobbly_ball;
pub use spec::{KeyInfo, SceneInfo, SceneSpecError};

pub(crate) use rng::{Rng, sin_cos};

use cullet::mesh::{Alpha, MeshData};
use cullet::{Handle, Instance, Mesh, MeshId, SceneError, Transform};
use glam::{DMat3, DVec3};

use crate::{Material, Model};
use shapes::{Shape, mesh_data};
use spec::Spec;

static SCENES: &[SceneInfo] =
    &[city::INFO, solids::INFO, office::INFO, plant::INFO, forest::INFO, moving::INFO, knobs::INFO];

/// The built-in scenes, with their keys.
#[must_use]
pub fn list() -> &'static [SceneInfo] {
    SCENES
}

/// Whether `text` begins with the name of a built-in scene, so that it is not meant as a file: the part
/// before the first colon is compared.
#[must_use]
pub fn is_builtin(text: &str) -> bool {
    let name = text.split(':').next().unwrap_or_default().trim();
    SCENES.iter().any(|s| s.name == name)
}

/// What to say of a text that names neither a file nor a built-in scene: the built-in scene whose name is most like
/// it, or all of them.
#[must_use]
pub fn no_such_file(text: &str) -> String {
    let name = text.split(':').next().unwrap_or_default().trim();
    match spec::similar(name, SCENES.iter().map(|s| s.name)) {
        Some(like) => format!("there is no file {text}; did you mean the built-in scene {like}?"),
        None => {
            let known: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
            format!("there is no file {text}; the built-in scenes are {}", known.join(", "))
        }
    }
}

/// Makes a built-in scene from its text, `name:key=value,...`; keys left out have their defaults.
///
/// The same text gives the same scene, to the last bit of every position, on every machine. The name of
/// the model is the shortest text that gives it again. Costs less than a microsecond and some 150 bytes
/// an instance.
///
/// # Errors
/// If the text names no scene, or a key or value that the scene does not have; the message lists those
/// that it has.
pub fn build(text: &str) -> Result<Model, SceneSpecError> {
    let spec = Spec::parse(text, SCENES)?;
    match spec.info.name {
        "city" => city::build(&spec),
        "solids" => solids::build(&spec),
        "office" => office::build(&spec),
        "plant" => plant::build(&spec),
        "moving" => moving::build(&spec),
        "knobs" => knobs::build(&spec),
        _ => forest::build(&spec),
    }
}

/// Makes the built-in `moving` as it is `seconds` after the time of its text, to the millisecond.
///
/// # Errors
/// As [`build`]; also if the scene has no such time.
pub(crate) fn build_at(text: &str, seconds: f64) -> Result<Model, SceneSpecError> {
    let mut spec = Spec::parse(text, SCENES)?;
    let t = spec.get("t") as f64 + seconds * 1e3;
    spec.set("t", t)?;
    moving::build(&spec)
}

/// Whether a mesh is drawn from one side or from both.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sides {
    /// A solid: its inside is never seen.
    One,
    /// A sheet.
    Both,
}

/// A model under construction.
struct Builder {
    model: Model,
}

impl Builder {
    fn new(spec: &Spec) -> Self {
        Self { model: Model { name: spec.canonical(), ..Model::default() } }
    }

    /// A material from an sRGB colour, 0xRRGGBB.
    fn material(&mut self, name: &str, srgb: u32) -> u32 {
        self.material_alpha(name, srgb, 1.0)
    }

    fn material_alpha(&mut self, name: &str, srgb: u32, alpha: f32) -> u32 {
        let channel = |shift: u32| {
            let c = f64::from(srgb >> shift & 0xFF) / 255.0;
            let linear = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
            linear as f32
        };
        let color = [channel(16), channel(8), channel(0), alpha];
        self.model.materials.push(Material { name: name.to_owned(), color });
        (self.model.materials.len() - 1) as u32
    }

    fn mesh(
        &mut self,
        name: &str,
        parts: &[(Shape, u32)],
        sides: Sides,
    ) -> Result<MeshId, SceneSpecError> {
        self.mesh_from(name, mesh_data(parts, sides == Sides::Both, Alpha::Opaque))
    }

    fn mesh_from(&mut self, name: &str, data: MeshData) -> Result<MeshId, SceneSpecError> {
        let id = self.model.scene.add_mesh(Mesh::new(data)?);
        self.model.mesh_names.push(name.to_owned());
        Ok(id)
    }

    fn add(&mut self, mesh: MeshId, transform: Transform) -> Result<Handle, SceneError> {
        self.model.scene.add(Instance::new(mesh, transform))
    }

    fn finish(mut self) -> Model {
        self.model.scene.commit();
        self.model
    }
}

/// A box of a mesh that fills −½..½ × 0..1 × −½..½, stretched to fill `min`..`max`.
fn fill(min: [f64; 3], max: [f64; 3]) -> Transform {
    let size: [f32; 3] = std::array::from_fn(|a| (max[a] - min[a]) as f32);
    let base = [(min[0] + max[0]) * 0.5, min[1], (min[2] + max[2]) * 0.5];
    Transform::from_scale_translation(size, base)
}

/// Turned about the y axis by `turns`, scaled, then moved.
fn turned(turns: f64, scale: [f64; 3], at: [f64; 3]) -> Transform {
    let (s, c) = sin_cos(turns);
    let columns = [[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]];
    Transform {
        linear: std::array::from_fn(|i| columns[i].map(|v| (v * scale[i]) as f32 + 0.0)),
        translation: at,
    }
}

/// A rotation drawn evenly from all (Shoemake, *Uniform Random Rotations*, 1992).
fn any_rotation(rng: &mut Rng) -> DMat3 {
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
