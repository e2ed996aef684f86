//! Plain data of occluders, for `serde`: all else follows from it. Numbers are checked when they
//! are read; that a body is convex, and that a shape lies within what its mesh hides, is for the
//! writer to see to, as with the constructors.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::super::OcclusionError;
use super::{Convex, Occluder, Patch, Shape};
use crate::bounds::Aabb;

/// Reads and writes shapes as their plain data.
macro_rules! as_data {
    ($($shape:ty: $data:ty),*) => {$(
        impl Serialize for $shape {
            fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                <$data>::from(self).serialize(to)
            }
        }

        impl<'de> Deserialize<'de> for $shape {
            fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                Self::try_from(<$data>::deserialize(from)?).map_err(D::Error::custom)
            }
        }
    )*};
}

as_data!(Convex: ConvexData, Patch: PatchData, Occluder: OccluderData);

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ConvexData {
    vertices: Vec<[f32; 3]>,
    /// Loops, counter-clockwise seen from outside. That of the back of a one-sided polygon is
    /// empty.
    faces: Vec<Vec<u32>>,
}

impl From<&Convex> for ConvexData {
    fn from(convex: &Convex) -> Self {
        let faces = (0..convex.face_count()).map(|f| convex.face(f).to_vec()).collect();
        Self { faces, vertices: convex.vertices.clone() }
    }
}

impl TryFrom<ConvexData> for Convex {
    type Error = OcclusionError;

    fn try_from(ConvexData { vertices, faces }: ConvexData) -> Result<Self, OcclusionError> {
        let count = vertices.len();
        check_indices(faces.iter().flatten().copied(), count)?;
        if let [front, back] = &faces[..]
            && back.is_empty()
        {
            let corners: Vec<_> = front.iter().map(|&v| vertices[v as usize]).collect();
            return Self::from_one_sided_polygon(&corners);
        }
        if faces.iter().any(|corners| corners.len() < 3) {
            return Err(OcclusionError::Empty);
        }
        // A closed body has two faces at least; for more than a body can have, bits of visible
        // faces have no room.
        if !(2..=count * 2).contains(&faces.len()) {
            return Err(OcclusionError::Open);
        }
        Self::from_loops(vertices, &faces)
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PatchData {
    vertices: Vec<[f32; 3]>,
    /// Facets: quads whose diagonal runs from the first vertex to the third, and triangles, the
    /// last vertex of which stands twice. Its own, and those around it.
    own: Vec<[u32; 4]>,
    around: Vec<[u32; 4]>,
    two_sided: bool,
}

impl From<&Patch> for PatchData {
    fn from(patch: &Patch) -> Self {
        let [own, around] = patch.facets();
        let vertices = patch.vertices().collect();
        Self { vertices, own, around, two_sided: patch.mesh.two_sided }
    }
}

impl TryFrom<PatchData> for Patch {
    type Error = OcclusionError;

    fn try_from(data: PatchData) -> Result<Self, OcclusionError> {
        let PatchData { vertices, own, around, two_sided } = data;
        check_indices(own.iter().chain(&around).flatten().copied(), vertices.len())?;
        Self::from_facets(&vertices, &own, &around, two_sided)
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OccluderData {
    shapes: Vec<Shape>,
    /// How many of them, the last, are for views that begin within `sealed`.
    near: u32,
    sealed: Vec<Aabb>,
}

impl From<&Occluder> for OccluderData {
    fn from(occluder: &Occluder) -> Self {
        Self {
            shapes: occluder.shapes().to_vec(),
            near: occluder.near as u32,
            sealed: occluder.sealed().to_vec(),
        }
    }
}

impl TryFrom<OccluderData> for Occluder {
    type Error = OcclusionError;

    fn try_from(data: OccluderData) -> Result<Self, OcclusionError> {
        let OccluderData { mut shapes, near, sealed } = data;
        let count = shapes.len();
        let range = OcclusionError::Range { start: 0, end: near, count };
        let far = count.checked_sub(near as usize).ok_or(range)?;
        let near = shapes.split_off(far);
        Ok(Self::new(shapes).with_sealed(sealed).with_near(near))
    }
}

fn check_indices(
    mut indices: impl Iterator<Item = u32>,
    vertices: usize,
) -> Result<(), OcclusionError> {
    match indices.find(|&v| v as usize >= vertices) {
        Some(index) => Err(OcclusionError::Index(index, vertices)),
        None => Ok(()),
    }
}
