//! Occlusion: what lies behind something opaque.
//!
//! *Hidden* is a proof here. Occluders are drawn into an [`OcclusionBuffer`], in which a pixel counts as covered only if all
//! of it is, as a closed square of the image plane, and then by the farthest that the occluder is in it. A thing is
//! hidden when every pixel that it may touch is covered by something nearer. So no sample of an image of any
//! resolution sees it: the buffer may be a quarter as wide as the screen, which costs a little of what is found and
//! nothing of what is true. (Occlusion buffers that sample pixel centres call things hidden that are seen
//! through gaps narrower than a pixel.)
//!
//! ```text
//! Convex (boxes, polygons, convex meshes) ── silhouette ───────► outline ─┐
//!                                                                          ├─► tiles, their least ─► ask: rectangle
//! Patch (any triangles) ──┬─ each triangle ────────────────────► outline ─┤
//!                         └─ edges, with the faces along them ─► fringe ──┘
//! ```
//!
//! Ned Greene, Michael Kass & Gavin Miller, *Hierarchical Z-Buffer Visibility*, 1993, is where tiles that keep
//! their farthest pixel come from; Hansong Zhang et al., *Visibility Culling Using Hierarchical Occlusion
//! Maps*, 1997, where occluders are chosen and drawn apart; Jon Hasselgren, Magnus Andersson & Tomas
//! Akenine-Möller, *Masked Software Occlusion Culling*, 2016, is the state of the art for a CPU, and samples
//! pixel centres.

mod ask;
mod band;
mod body;
mod buffer;
mod choose;
mod convex;
mod cut;
mod draw;
mod fringe;
mod list;
mod occluder;
mod outline;
mod patch;
mod piece;
#[cfg(feature = "serde")]
mod plain;
mod plane;
mod record;
mod screen;
mod surface;
mod tile;

pub(crate) use ask::{Asker, Nearest};
pub use ask::{Footprint, Verdict};
pub use band::Band;
pub use buffer::{OcclusionBuffer, OcclusionError, TILE};
pub use choose::Occlusion;
pub(crate) use choose::{Candidate, Cheapest, Choice};
pub use convex::Convex;
pub use list::DrawJob;
pub use occluder::{Occluder, Shape};
pub use patch::Patch;
pub use record::{Difference, Differences, Recording, RecordingError};

use thiserror::Error;

/// Why an occluder cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OccluderError {
    /// It has no extent.
    #[error("an occluder needs at least three corners, or a box that is not empty")]
    Empty,
    /// Its faces do not close.
    #[error("the faces of a convex occluder must share each edge in pairs")]
    Open,
    /// A vertex with a NaN or infinite coordinate.
    #[error("vertex {vertex} is not finite: {position:?}")]
    NotFinite {
        /// Which vertex.
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
