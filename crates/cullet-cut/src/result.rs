//! Result of a cut: the mesh, and the report.

use std::ops::Range;

/// [`CutMesh::origin`] of a triangle of a cap.
pub const NO_ORIGIN: u32 = u32::MAX;

/// The part of a [`CutMesh`] that closes one plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cap {
    /// Number of the plane.
    pub plane: usize,
    /// Its triangles.
    pub triangles: Range<usize>,
}

/// A mesh after a cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutMesh {
    /// Vertex positions: those of the input that are kept, in their order, then new ones.
    pub positions: Vec<[f32; 3]>,
    /// Attributes of the vertices, as many numbers a vertex as the input has.
    pub attributes: Vec<f32>,
    /// Three indices a triangle: first the untouched ones in their order, then what is left of
    /// those that were cut, by origin, then the caps.
    pub indices: Vec<u32>,
    /// Input triangle of each triangle; [`NO_ORIGIN`] in caps.
    pub origin: Vec<u32>,
    /// How many of the triangles are untouched.
    pub untouched: usize,
    /// The caps, in the order of the planes; empty ones and planes without caps are left out.
    pub caps: Vec<Cap>,
    /// Counts and defects of the cut.
    pub report: CutReport,
}

/// Counts and defects found while cutting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CutReport {
    /// Triangles that were cut or touched from outside.
    pub cut_triangles: usize,
    /// Cut triangles that were there twice and are kept once, because their copy left the surface
    /// open. Where all of a surface is there twice nothing is dropped, and its caps are there twice
    /// too. Only with caps.
    pub duplicates: usize,
    /// Outlines at the cut that do not close and so have no cap.
    pub open_chains: usize,
    /// Edges of those outlines: they are open in the result.
    pub open_edges: usize,
    /// Vertices that were moved to meet others ([`CapOptions::weld`](crate::CapOptions::weld)).
    pub welded: usize,
    /// Straight lines that closed an outline ([`CapOptions::heal`](crate::CapOptions::heal)).
    pub healed: usize,
    /// Connected outlines that were filled by the even–odd rule, because triangles are wound both
    /// ways.
    pub even_odd: usize,
    /// Points where outlines cross, that is where the surface penetrates itself at the cut.
    pub crossings: usize,
    /// Edges at the cut that are the border of more than one triangle on the same side.
    pub non_manifold_edges: usize,
    /// Planes whose outlines cross so often that their cap is a fan: closed, but folded over
    /// itself.
    pub folded: usize,
}
