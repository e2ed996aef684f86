//! Facts about meshes for readers, bakes, reports and methods of the literature; frames of the
//! engine do not need them. They are the topology of a mesh, the classes of its normals, and its
//! appearance from all around as an [impostor](Impostor).
//!
//! ```
//! let positions = vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
//! let indices = vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
//! let data = cullet::MeshData { positions, indices, ..Default::default() };
//! let mut mesh = cullet::Mesh::new(data)?;
//! // A solid shows no back: declare it one-sided, and its back faces are culled.
//! mesh.set_two_sided(cullet_mesh::solid(&mesh).is_err());
//! assert!(!mesh.is_two_sided());
//! # Ok::<(), cullet::mesh::MeshError>(())
//! ```
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod impostor;
mod masks;
mod nesting;
mod surface;
mod topology;

pub use impostor::{IMPOSTOR_PARTS, Impostor, ImpostorError, ImpostorFrame, Texel};
pub use masks::{BackfaceMask, MaskGrid, NormalMask, NormalMasks, ViewCone};
pub use topology::{NotSolid, Topology, solid};
