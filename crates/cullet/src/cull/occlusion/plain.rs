//! What occluders are made of, for `serde`: all else follows from it. Numbers are checked when they are read; that a body is
//! convex, and that a shape lies within what its mesh hides, is for the writer to see to, as with the constructors.

use serde::{Deserialize, Serialize};

use super::patch::Surface;
use super::{Convex, Occluder, OccluderError, Patch, Shape};
use crate::bounds::Aabb;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ConvexData {
    vertices: Vec<[f32; 3]>,
    /// Loops, counter-clockwise seen from outside. That of the back of a one-sided polygon is empty.
    faces: Vec<Vec<u32>>,
}

impl From<Convex> for ConvexData {
    fn from(convex: Convex) -> Self {
        let faces = (0..convex.face_count()).map(|f| convex.face(f).to_vec()).collect();
        Self { faces, vertices: convex.vertices }
    }
}

impl TryFrom<ConvexData> for Convex {
    type Error = OccluderError;

    fn try_from(ConvexData { vertices, faces }: ConvexData) -> Result<Self, OccluderError> {
        let count = vertices.len();
        check_indices(faces.iter().flatten().copied(), count)?;
        if let [front, back] = &faces[..]
            && back.is_empty()
        {
            let corners: Vec<_> = front.iter().map(|&v| vertices[v as usize]).collect();
            return Self::from_one_sided_polygon(&corners);
        }
        if faces.iter().any(|corners| corners.len() < 3) {
            return Err(OccluderError::Empty);
        }
        // What closes has two sides; of more faces than a body has there would be no room for which are seen.
        if !(2..=count * 2).contains(&faces.len()) {
            return Err(OccluderError::Open);
        }
        Self::from_loops(vertices, &faces)
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PatchData {
    vertices: Vec<[f32; 3]>,
    /// Its own, then those around it, each in the order of the surface.
    triangles: Vec<[u32; 3]>,
    /// How many are its own.
    own: u32,
    two_sided: bool,
}

impl From<Patch> for PatchData {
    fn from(patch: Patch) -> Self {
        Self {
            vertices: patch.vertices().collect(),
            triangles: patch.triangles().collect(),
            own: patch.triangle_count() as u32,
            two_sided: patch.two_sided,
        }
    }
}

impl TryFrom<PatchData> for Patch {
    type Error = OccluderError;

    fn try_from(data: PatchData) -> Result<Self, OccluderError> {
        let PatchData { vertices, triangles, own, two_sided } = data;
        check_indices(triangles.iter().flatten().copied(), vertices.len())?;
        let not_finite = |p: &[f32; 3]| !p.iter().all(|v| v.is_finite());
        if let Some(vertex) = vertices.iter().position(not_finite) {
            return Err(OccluderError::NotFinite { vertex, position: vertices[vertex] });
        }
        if own as usize > triangles.len() {
            return Err(OccluderError::Range { start: 0, end: own, count: triangles.len() });
        }
        Ok(Surface::new(&vertices, &triangles, two_sided).patch(0..own))
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OccluderData {
    shapes: Vec<Shape>,
    /// How many of them, the last, are for views that begin within `sealed`.
    near: u32,
    sealed: Vec<Aabb>,
}

impl From<Occluder> for OccluderData {
    fn from(occluder: Occluder) -> Self {
        Self {
            shapes: occluder.shapes().to_vec(),
            near: occluder.near as u32,
            sealed: occluder.sealed().to_vec(),
        }
    }
}

impl TryFrom<OccluderData> for Occluder {
    type Error = OccluderError;

    fn try_from(data: OccluderData) -> Result<Self, OccluderError> {
        let OccluderData { mut shapes, near, sealed } = data;
        let count = shapes.len();
        let range = OccluderError::Range { start: 0, end: near, count };
        let far = count.checked_sub(near as usize).ok_or(range)?;
        let near = shapes.split_off(far);
        Ok(Self::new(shapes).with_sealed(sealed).with_near(near))
    }
}

fn check_indices(
    mut indices: impl Iterator<Item = u32>,
    vertices: usize,
) -> Result<(), OccluderError> {
    match indices.find(|&v| v as usize >= vertices) {
        Some(index) => Err(OccluderError::Index(index, vertices)),
        None => Ok(()),
    }
}
