//! Methods of visibility culling beside those that [`cullet`] runs: what the literature has, what
//! was tried and does not win, and what shows how the ones in use work.
//!
//! Nothing here is called in a frame. It is what `cullet reproduce` measures, what `cullet picture`
//! and the viewer's study views draw, and what tests hold the engine against. All of it is
//! conservative, as the engine is: what is culled is proved.
//!
//! | room | what | where it stands |
//! |---|---|---|
//! | [`cluster`] | bounds of the normals of a cluster, with one trait over all; trackers, trees, culling volumes | the engine uses the elliptic cone |
//! | [`Groups`] | normal masks with a viewing cone for each group of triangles | Zhang & Hoff (1997) |
//! | [`sectors`] | normal masks by the corners of a frustum, and for its sectors | Zhang & Hoff (1997) |
//! | [`Planes16`], [`Planes32`] | planes of triangles in 8 and 16 bytes | lose to the engine's 4 bytes |
//! | [`Bulk`] | the answers of many tests as a mask, a count or a list | the engine wants masks alone |
//! | [`BezierPatch`] | curved patches, culled before they are tessellated | after Shirman & Abi-Ezzi (1993) |
//! | [`screen`] | the back-face test after projection, as graphics hardware does it | equal to the engine's |
//! | [`back_regions`] | connected regions of what faces away | how small clusters must be |
//!
//! ```
//! use cullet::Simd;
//! use cullet::cull::backface::{ClusterPlanes, EllipticCone};
//! use cullet_lab::methods::Bulk;
//! use cullet_lab::methods::cluster::{Bound, ClusterBounds, NormalBox, NormalCone};
//!
//! // One triangle that faces up, and one that faces down, seen from above.
//! let up = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
//! let down = [up[0], up[2], up[1]];
//! fn culled<B: Bound>(clusters: [[[f32; 3]; 3]; 2]) -> Vec<u64> {
//!     let bounds: ClusterBounds<B> =
//!         clusters.into_iter().map(|t| B::fit(&ClusterPlanes::new([t]))).collect();
//!     let mut culled = Vec::new();
//!     bounds.cull(Simd::best(), [0.3, 2.0, 0.3, 1.0], &mut culled);
//!     culled
//! }
//! assert_eq!(culled::<EllipticCone>([up, down]), [0b10]);
//! assert_eq!(culled::<NormalCone>([up, down]), [0b10]);
//! assert_eq!(culled::<NormalBox>([up, down]), [0b10]);
//! ```
#![forbid(unsafe_code)]

mod back_regions;
mod bulk;
pub mod cluster;
mod groups;
mod patch;
mod planes;
mod planes16;
mod planes32;
pub mod screen;
pub mod sectors;

pub use back_regions::back_regions;
pub use bulk::Bulk;
pub use groups::Groups;
pub use patch::{BezierPatch, PatchError};
pub use planes16::Planes16;
pub use planes32::Planes32;
