//! Occlusion: what lies behind something opaque.
//!
//! *Hidden* is a proof here. Occluders are drawn into an [`OcclusionBuffer`], in which a pixel
//! counts as covered only if all of it is, as a closed square of the image plane, and then by the
//! farthest that the occluder is in it. A box is hidden when every pixel that it may touch is
//! covered by something nearer. So no sample of an image of any resolution sees what is in it: the
//! buffer may be a quarter as wide as the screen, which costs a little of what is found and nothing
//! of what is true. (Occlusion buffers that sample pixel centres call hidden what is seen through
//! gaps narrower than a pixel.)
//!
//! Four layers; each names those to its left alone:
//!
//! ```text
//!  raster                               occluder, query                          select
//!  ───────────────────────────────      ───────────────────────────────────      ──────────────────────────
//!  outline  ◄───────────────────────────  Convex: its silhouette            ◄──  choice, within a budget
//!  surface: facets, shared edges    ◄──  Patch: some triangles of a mesh    ◄──  list, without what is hidden
//!     └─► tiles, their least  ◄─────────  boxes, nodes, one box in f64      ◄──
//! ```
//!
//! Ned Greene, Michael Kass & Gavin Miller, *Hierarchical Z-Buffer Visibility*, 1993, is where
//! tiles that keep their farthest pixel come from; Hansong Zhang et al., *Visibility Culling Using
//! Hierarchical Occlusion Maps*, 1997, where occluders are chosen and drawn apart; Jon Hasselgren,
//! Magnus Andersson & Tomas Akenine-Möller, *Masked Software Occlusion Culling*, 2016, is the state
//! of the art for a CPU, and samples pixel centres.

mod occluder;
mod query;
mod raster;
mod select;

pub use occluder::{Convex, Occluder, Patch, Shape};
pub(crate) use occluder::{CostModel, LeastCost, cross, dot};
pub use query::Visibility;
pub(crate) use query::{BoxTests, Nearest};
pub(crate) use raster::{BLOCK, Canvas};
pub use raster::{OcclusionBuffer, ScreenBounds, TILE};
pub(crate) use select::Candidate;
pub use select::{DynamicSurface, Occlusion};

use thiserror::Error;

/// Why an occlusion buffer or an occluder cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OcclusionError {
    /// A buffer without pixels, or with too many.
    #[error("an occlusion buffer of {0}x{1} pixels is not between 1x1 and {2}x{2}")]
    Size(u32, u32, u32),
    /// An occluder without extent.
    #[error("an occluder needs at least three corners, or a box that is not empty")]
    Empty,
    /// Faces that do not close.
    #[error("the faces of a convex occluder must share each edge in pairs")]
    Open,
    /// A vertex with a NaN or infinite coordinate.
    #[error("vertex {vertex} is not finite: {position:?}")]
    NotFinite {
        /// The index of the vertex.
        vertex: usize,
        /// Where it is.
        position: [f32; 3],
    },
    /// More vertices than a convex occluder has.
    #[error("a convex occluder of {0} vertices; at most {1} are drawn as one")]
    TooManyVertices(usize, usize),
    /// An index beyond the vertices.
    #[error("index {0}, but there are {1} vertices")]
    Index(u32, usize),
    /// A range that is none of triangles of the list.
    #[error("triangles {start}..{end} of {count}")]
    Range {
        /// First triangle.
        start: u32,
        /// One beyond the last.
        end: u32,
        /// How many triangles there are.
        count: usize,
    },
}
