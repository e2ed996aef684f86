//! Input and options of a cut, and the errors that refuse them.

use cullet::bounds::Plane;
use cullet::mesh::MeshError;
use thiserror::Error;

/// The most planes of one region.
pub const MAX_CUT_PLANES: usize = 32;

/// Input of a cut: plain slices.
#[derive(Clone, Copy, Debug, Default)]
pub struct CutInput<'a> {
    /// Vertex positions, all finite.
    pub positions: &'a [[f32; 3]],
    /// Three indices a triangle.
    pub indices: &'a [u32],
    /// `stride` numbers for each vertex: normals, texture coordinates, colours, anything. They are
    /// interpolated as they are: a normal is not brought to unit length again.
    pub attributes: &'a [f32],
    /// How many numbers a vertex has in `attributes`.
    pub stride: usize,
}

/// Part that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Keep {
    /// All that is inside of every plane.
    #[default]
    Inside,
    /// All that is outside of any plane.
    Outside,
}

/// How to cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutOptions {
    /// Part that is kept; the inside unless said otherwise.
    pub keep: Keep,
    /// Whether to close the cut; `None` leaves it open.
    pub caps: Option<CapOptions>,
}

/// How to close a cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CapOptions {
    /// Ends of open outlines that are at most this far apart, in units of the mesh, are joined by a
    /// straight line. 0, the default, joins nothing; infinity closes every outline.
    pub heal: f32,
    /// Vertices that are at most this far apart, in units of the mesh, are moved to one position
    /// before the cut, all over the mesh: seams that do not quite meet then close. 0, the default,
    /// moves none, nor does a NaN or infinity. Takes 12 bytes a vertex more, and a look-up or
    /// eight.
    pub weld: f32,
    /// The attributes of a vertex of a cap, before normal and texture coordinates are written into
    /// them; zeros where it is shorter than the stride.
    pub template: Vec<f32>,
    /// At which attribute the three numbers of the cap's normal go.
    pub normal_at: Option<usize>,
    /// At which attribute its two texture coordinates go: lengths along the plane, in units of the
    /// mesh.
    pub uv_at: Option<usize>,
}

/// Why a mesh cannot be cut.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CutError {
    /// A plane whose normal is zero, or with a number that is not finite.
    #[error(
        "plane {plane}: {value:?} is not a plane: its normal must not be zero, and all must be finite"
    )]
    Plane {
        /// Which.
        plane: usize,
        /// The plane that was given.
        value: Plane,
    },
    /// Too many planes.
    #[error("{0} planes exceed the limit of {MAX_CUT_PLANES}; cut several times")]
    TooManyPlanes(usize),
    /// The input is not a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The attributes are not `stride` numbers a vertex, or a cap's do not fit in them.
    #[error("{what}: {count} where {expected} are needed")]
    Attributes {
        /// Which.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many it takes.
        expected: usize,
    },
}

/// Refuses what does not fit together; planes and positions are checked where they are used.
pub(crate) fn check(input: &CutInput<'_>, options: &CutOptions) -> Result<(), CutError> {
    const LIMIT: usize = (u32::MAX / 3) as usize;
    let (vertices, indices) = (input.positions.len(), input.indices.len());
    if !indices.is_multiple_of(3) {
        return Err(MeshError::NotTriangles(indices).into());
    }
    for (what, count) in [("vertices", vertices), ("triangles", indices / 3)] {
        if count > LIMIT {
            return Err(MeshError::TooMany { what, count, limit: LIMIT }.into());
        }
    }
    // The greatest first: that is found many at a time.
    let greatest = input.indices.iter().fold(0, |m, &i| m.max(i));
    let wrong = |&i: &u32| i as usize >= vertices;
    if wrong(&greatest)
        && let Some(at) = input.indices.iter().position(wrong)
    {
        return Err(MeshError::Index { at, index: input.indices[at], vertices }.into());
    }
    let attributes = |what, count, expected| Err(CutError::Attributes { what, count, expected });
    let expected = vertices.saturating_mul(input.stride);
    if input.attributes.len() != expected {
        return attributes("attributes of all vertices", input.attributes.len(), expected);
    }
    let Some(caps) = &options.caps else { return Ok(()) };
    if caps.template.len() > input.stride {
        return attributes("attributes of a vertex", input.stride, caps.template.len());
    }
    for (what, at, size) in
        [("room for a cap's normal", caps.normal_at, 3), ("room for a cap's uv", caps.uv_at, 2)]
    {
        let Some(at) = at else { continue };
        if at.saturating_add(size) > input.stride {
            return attributes(what, input.stride.saturating_sub(at), size);
        }
    }
    Ok(())
}
