//! Two judges of what is hidden, both in f64 and neither with a line of the engine's occlusion
//! culling in it: `reference` looks at samples, and so may call hidden what shows between them;
//! `proof` calls hidden only what it can prove to be, between the samples too.

pub(crate) mod interval;
pub(crate) mod planar;
pub(crate) mod proof;
pub(crate) mod reference;

use std::error::Error;
use std::fmt;

use cullet::mesh::{MeshError, Part};
use cullet::{Instance, Mesh, MeshData, Scene, SceneError, Transform};

/// Triangles that may hide something: a mesh of its own, and where it stands.
#[derive(Clone, Copy, Debug)]
pub struct OccluderTriangles<'a> {
    /// Vertices, before the transform. May be those of many meshes: only what `indices` use is
    /// read.
    pub positions: &'a [[f32; 3]],
    /// Three for each triangle, counter-clockwise seen from its front. What is left over is not
    /// read.
    pub indices: &'a [u32],
    /// To the world; the view's matrix follows it in f64.
    pub transform: Transform,
    /// Whether the back of a triangle hides as its front does. If not, only what the view draws of
    /// a one-sided mesh hides.
    pub two_sided: bool,
}

/// Why occluders make no scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum OccluderError {
    /// A triangle refers to a vertex that is not there.
    Index {
        /// Number of the occluder.
        occluder: usize,
        /// The vertex.
        index: u32,
        /// How many there are.
        vertices: usize,
    },
    /// The triangles make no mesh.
    Mesh {
        /// Number of the occluder.
        occluder: usize,
        /// Why.
        error: MeshError,
    },
    /// The occluder fits no scene.
    Scene {
        /// Number of the occluder.
        occluder: usize,
        /// Why.
        error: SceneError,
    },
}

impl fmt::Display for OccluderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Index { occluder, index, vertices } => write!(
                f,
                "occluder {occluder} refers to vertex {index}, but there are only {vertices} (from 0)"
            ),
            Self::Mesh { occluder, error } => write!(f, "occluder {occluder}: {error}"),
            Self::Scene { occluder, error } => write!(f, "occluder {occluder}: {error}"),
        }
    }
}

impl Error for OccluderError {}

/// A scene of occluders, one instance each and in their order, for
/// [`sampled_boxes`](crate::sampled_boxes). Those without a triangle are left out.
///
/// # Errors
/// If an index is out of range, or the triangles make no mesh; the message names the occluder.
pub fn occluder_scene(occluders: &[OccluderTriangles]) -> Result<Scene, OccluderError> {
    let mut scene = Scene::new();
    for (occluder, o) in occluders.iter().enumerate() {
        let indices = o.indices.as_chunks::<3>().0.as_flattened();
        let (Some(&low), Some(&high)) = (indices.iter().min(), indices.iter().max()) else {
            continue;
        };
        let vertices = o.positions.len();
        let Some(positions) = o.positions.get(low as usize..=high as usize) else {
            return Err(OccluderError::Index { occluder, index: high, vertices });
        };
        let triangle_count = (indices.len() / 3) as u32;
        let part = Part { triangle_count, two_sided: o.two_sided, ..Part::default() };
        let data = MeshData {
            positions: positions.to_vec(),
            indices: indices.iter().map(|i| i - low).collect(),
            parts: vec![part],
            ..MeshData::default()
        };
        let mesh = Mesh::new(data).map_err(|error| OccluderError::Mesh { occluder, error })?;
        let mesh = scene.add_mesh(mesh);
        let added = scene.add(Instance::new(mesh, o.transform));
        added.map_err(|error| OccluderError::Scene { occluder, error })?;
    }
    scene.commit(&cullet::Culler::default());
    Ok(scene)
}
