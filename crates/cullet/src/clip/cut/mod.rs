//! Cut-aways: a mesh cut open at planes, with caps that leave no open edge.
//!
//! ```
//! use cullet::bounds::Plane;
//! use cullet::clip::cut::{CapOptions, CutInput, CutOptions, cut};
//!
//! // A tetrahedron, opened at half its height.
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let indices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
//! let input = CutInput { positions: &positions, indices: &indices, ..CutInput::default() };
//! let options = CutOptions { caps: Some(CapOptions::default()), ..CutOptions::default() };
//! let lower = cut(&input, &[Plane::new([0.0, 0.0, 1.0], 0.5)], &options)?;
//! assert_eq!(lower.caps[0].triangles.len(), 1);
//! assert!(cullet::mesh::Topology::of(&lower.positions, &lower.indices).is_closed());
//! # Ok::<(), cullet::clip::cut::CutError>(())
//! ```
//!
//! # Rules
//!
//! *Sides.* Whether a vertex is inside, on or outside of a plane is the exact sign of n·p − d, found once
//! a vertex and plane, so neighbours always agree. A vertex on a plane counts as inside. A triangle with
//! all corners on a plane belongs to the half that it bounds: it is kept inside where it faces the way
//! the plane's normal points, or has no area, and outside where it faces the other way.
//!
//! *New vertices.* One for each edge and plane. Its position is computed from the lower of the edge's two
//! positions (in the order of their coordinates), so that it has the same bits on both sides of a
//! seam, where an edge has two pairs of vertices. Planes are applied in the order they are given, each to
//! what the ones before left: the rest of a triangle is again triangles. On a plane along an axis the
//! coordinate of new vertices is the plane's offset, rounded once.
//!
//! *Caps.* What was removed at a plane leaves edges there, directed by the winding of the triangles; the
//! cap is the chain of triangles whose border they are. A region around which the surface winds w times is
//! covered by |w| sheets, facing out of the plane for w > 0 and into it for w < 0 (the surface is inside
//! out there). So a capped cut of a closed surface is closed, whatever overlaps, is nested or was there
//! twice, and the volumes of the two halves add up. Outlines that cross are split where they do; thin
//! triangles without area join the halves of a split edge to the wall's whole one. Where the winding does
//! not add up (triangles wound both ways) the even–odd rule covers a region once.
//!
//! *Defects* are reported in [`CutReport`]. Outlines that do not close are not capped, unless their ends
//! lie within [`CapOptions::heal`] of each other. Seams that do not quite meet are closed before the cut by
//! [`CapOptions::weld`].

mod arrange;
mod cap;
mod hash;
mod mesh;
mod outline;
mod pieces;
mod section;
mod sides;
mod weld;

pub use mesh::{CutParts, cut_mesh};
pub use outline::{Outline, outline_area, section_frame};

use std::ops::Range;

use thiserror::Error;

use crate::bounds::Plane;

/// The most planes of one region.
pub const MAX_CUT_PLANES: usize = 32;

/// [`CutMesh::origin`] of a triangle of a cap.
pub const NO_ORIGIN: u32 = u32::MAX;

/// What is cut: plain slices.
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

/// Which part is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Keep {
    /// What is inside of every plane.
    #[default]
    Inside,
    /// What is outside of any.
    Outside,
}

/// How to cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutOptions {
    /// Which part is kept; the inside unless said otherwise.
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
    /// Vertices that are at most this far apart, in units of the mesh, are moved to one position before
    /// the cut, all over the mesh: seams that do not quite meet then close. 0, the default, moves none, nor
    /// does a NaN or infinity. Takes 12 bytes a vertex more, and a look-up or eight.
    pub weld: f32,
    /// The attributes of a vertex of a cap, before normal and texture coordinates are written into them;
    /// zeros where it is shorter than the stride.
    pub template: Vec<f32>,
    /// At which attribute the three numbers of the cap's normal go.
    pub normal_at: Option<usize>,
    /// At which attribute its two texture coordinates go: lengths along the plane, in units of the mesh.
    pub uv_at: Option<usize>,
}

/// The part of a [`CutMesh`] that closes one plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cap {
    /// Which plane.
    pub plane: usize,
    /// Its triangles.
    pub triangles: Range<usize>,
}

/// What remains of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutMesh {
    /// Vertex positions: those of the input that are kept, in their order, then new ones.
    pub positions: Vec<[f32; 3]>,
    /// As many numbers a vertex as the input has.
    pub attributes: Vec<f32>,
    /// Three indices a triangle: first the untouched ones in their order, then what is left of those
    /// that were cut, by origin, then the caps.
    pub indices: Vec<u32>,
    /// Which triangle of the input each triangle is of; [`NO_ORIGIN`] in caps.
    pub origin: Vec<u32>,
    /// How many of the triangles are untouched.
    pub untouched: usize,
    /// The caps, in the order of the planes; empty ones and planes without caps are left out.
    pub caps: Vec<Cap>,
    /// What was found.
    pub report: CutReport,
}

/// What was found while cutting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CutReport {
    /// Triangles that were cut or touched from outside.
    pub cut_triangles: usize,
    /// Cut triangles that were there twice and are kept once, because their copy left the surface open. Where
    /// all of a surface is there twice nothing is dropped, and its caps are there twice too. Only with caps.
    pub duplicates: usize,
    /// Outlines at the cut that do not close and so have no cap.
    pub open_chains: usize,
    /// Edges of those outlines: they are open in the result.
    pub open_edges: usize,
    /// Vertices that were moved to meet others ([`CapOptions::weld`]).
    pub welded: usize,
    /// Straight lines that closed an outline ([`CapOptions::heal`]).
    pub healed: usize,
    /// Connected outlines that were filled by the even–odd rule, because triangles are wound both ways.
    pub even_odd: usize,
    /// Points where outlines cross, that is where the surface penetrates itself at the cut.
    pub crossings: usize,
    /// Edges at the cut that are the border of more than one triangle on the same side.
    pub non_manifold_edges: usize,
    /// Planes whose outlines cross so often that their cap is a fan: closed, but folded over itself.
    pub folded: usize,
}

/// Why a mesh cannot be cut.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CutError {
    /// A plane whose normal is zero, or with a number that is not finite.
    #[error("plane {plane}: {value:?} is no plane; its normal must not be zero, and all be finite")]
    Plane {
        /// Which.
        plane: usize,
        /// What was given.
        value: Plane,
    },
    /// Too many planes.
    #[error("{0} planes exceed the limit of {MAX_CUT_PLANES}; cut several times")]
    TooManyPlanes(usize),
    /// A vertex that is not finite.
    #[error("vertex {vertex} is not finite: {position:?}")]
    NotFinite {
        /// Which.
        vertex: usize,
        /// Where it is.
        position: [f32; 3],
    },
    /// An index beyond the vertices.
    #[error("index {at} is {index}, but there are {vertices} vertices")]
    Index {
        /// Which entry of the index list.
        at: usize,
        /// Its value.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The number of indices is not a multiple of three.
    #[error("{0} indices do not make whole triangles")]
    NotTriangles(usize),
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
    /// More triangles or vertices than 32-bit numbers name.
    #[error("{0} triangles or vertices exceed the limit of {limit}", limit = u32::MAX / 3)]
    TooLarge(usize),
}

/// The six planes of a box, pointing out: for [`cut`].
#[must_use]
pub fn box_planes(min: [f64; 3], max: [f64; 3]) -> [Plane; 6] {
    std::array::from_fn(|i| {
        let (axis, high) = (i / 2, i % 2 == 1);
        let mut normal = [0.0; 3];
        normal[axis] = if high { 1.0 } else { -1.0 };
        Plane::new(normal, if high { max[axis] } else { -min[axis] })
    })
}

/// Cuts a mesh at a convex region of up to 32 planes whose normals point out (of any length; n·x ≤ d is
/// inside), and keeps what is inside of all of them or outside of any, in one pass. No planes: all is
/// inside. An empty result is a value. The rules are at the [module](self).
///
/// Cost: O(vertices · planes + triangles), and what the caps take: a sort-like effort over the edges at
/// the cut. Takes 8 bytes a vertex besides the result.
///
/// # Errors
/// If a plane is none, a vertex is not finite, an index is out of range or the attributes do not fit.
pub fn cut(
    input: &CutInput<'_>,
    planes: &[Plane],
    options: &CutOptions,
) -> Result<CutMesh, CutError> {
    check(input, options)?;
    let planes = sides::prepare(planes)?;
    welded(input, options.caps.as_ref(), |input, moved| {
        let sides = sides::Sides::new(input.positions, &planes)?;
        let mut done = pieces::run(input, &planes, &sides, options);
        done.report.welded = moved;
        Ok(done)
    })
}

/// Cuts, and gives both parts: what is inside of all planes, and what is outside of any. Each is what [`cut`]
/// gives; the sides of the vertices are found once.
///
/// # Errors
/// As [`cut`].
pub fn cut_both(
    input: &CutInput<'_>,
    planes: &[Plane],
    caps: Option<&CapOptions>,
) -> Result<[CutMesh; 2], CutError> {
    let [inside, outside] =
        [Keep::Inside, Keep::Outside].map(|keep| CutOptions { keep, caps: caps.cloned() });
    check(input, &inside)?;
    let planes = sides::prepare(planes)?;
    welded(input, caps, |input, moved| {
        let sides = sides::Sides::new(input.positions, &planes)?;
        Ok([&inside, &outside].map(|options| {
            let mut done = pieces::run(input, &planes, &sides, options);
            done.report.welded = moved;
            done
        }))
    })
}

/// Hands on the input with the positions that are wanted, and how many of them moved.
fn welded<R>(
    input: &CutInput<'_>,
    caps: Option<&CapOptions>,
    run: impl FnOnce(&CutInput<'_>, usize) -> R,
) -> R {
    let tolerance = caps.map_or(0.0, |c| c.weld);
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return run(input, 0);
    }
    let (positions, moved) = weld::weld(input.positions, tolerance);
    run(&CutInput { positions: &positions, ..*input }, moved)
}

fn check(input: &CutInput<'_>, options: &CutOptions) -> Result<(), CutError> {
    if !input.indices.len().is_multiple_of(3) {
        return Err(CutError::NotTriangles(input.indices.len()));
    }
    let vertices = input.positions.len();
    for count in [vertices, input.indices.len() / 3] {
        if count > (u32::MAX / 3) as usize {
            return Err(CutError::TooLarge(count));
        }
    }
    let greatest = input.indices.iter().fold(0, |m, &i| m.max(i));
    if !input.indices.is_empty() && greatest as usize >= vertices {
        let at = input.indices.iter().position(|&i| i == greatest).unwrap_or_default();
        return Err(CutError::Index { at, index: greatest, vertices });
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
