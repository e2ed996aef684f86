//! Cut-aways for `cullet`: meshes and whole models cut open at planes, with caps that leave no open
//! edge.
//!
//! [`cut`] takes plain slices, [`cut_mesh`] a [`Mesh`](cullet::Mesh) with its parts, and
//! [`cut_model`] every instance of a model that planes touch.
//!
//! ```
//! use cullet::bounds::Plane;
//! use cullet_cut::{CapOptions, CutInput, CutOptions, cut};
//!
//! // A tetrahedron, opened at half its height.
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let indices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
//! let input = CutInput { positions: &positions, indices: &indices, ..CutInput::default() };
//! let options = CutOptions { caps: Some(CapOptions::default()), ..CutOptions::default() };
//! let lower = cut(&input, &[Plane::new([0.0, 0.0, 1.0], 0.5)], &options)?;
//! assert_eq!(lower.caps[0].triangles.len(), 1);
//! assert!(cullet_mesh::Topology::of(&lower.positions, &lower.indices).is_closed());
//! # Ok::<(), cullet_cut::CutError>(())
//! ```
//!
//! # Features
//!
//! | feature | what it adds |
//! |---|---|
//! | `model` (on by default) | [`cut_model`], over the models of `cullet-io` |
//!
//! # Rules
//!
//! *Sides.* The exact sign of n·p − d says whether a vertex is inside, on or outside a plane. It is
//! computed once for each vertex and plane, so neighbours always agree. A vertex on a plane counts
//! as inside. A triangle with all corners on a plane belongs to the half that it bounds. It is kept
//! inside if it faces the way the plane's normal points, or has no area, and outside if it faces
//! the other way.
//!
//! *New vertices.* There is one for each edge and plane. Its position is computed from the lower of
//! the edge's two positions (in the order of their coordinates). It therefore has the same bits on
//! both sides of a seam, where an edge has two pairs of vertices. Planes are applied in the given
//! order, each to what the previous ones left: the rest of a triangle is again triangles. On a
//! plane along an axis, the coordinate of new vertices is the plane's offset, rounded once.
//!
//! *Caps.* Removing triangles at a plane leaves edges there, directed by the winding of the
//! triangles. The cap is the chain of triangles whose border these edges are. If the surface winds
//! w times around a region, |w| sheets cover the region. They face out of the plane for w > 0 and
//! into it for w < 0 (there the surface is inside out). So a capped cut of a closed surface is
//! closed, even if parts overlap, are nested or are duplicates, and the volumes of the two halves
//! add up. Outlines that cross are split at the crossing; thin triangles without area join the
//! halves of a split edge to the whole edge of the wall. If the winding does not add up (triangles
//! wound both ways), the even–odd rule covers a region once.
//!
//! *Defects* are reported in [`CutReport`]. An outline that does not close is not capped, unless
//! its ends lie within [`CapOptions::heal`] of each other. [`CapOptions::weld`] closes seams that
//! do not quite meet, before the cut.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod arrange;
mod cap;
mod cut;
mod hash;
mod mesh;
#[cfg(feature = "model")]
mod model;
mod options;
mod outline;
mod result;
mod section;
mod sides;
mod triangles;
mod weld;

pub use cut::{box_planes, cut, cut_both};
pub use mesh::{CutParts, cut_mesh};
#[cfg(feature = "model")]
pub use model::{CutModel, ModelError, ModelOptions, ModelReport, OpenMesh, Section, cut_model};
pub use options::{CapOptions, CutError, CutInput, CutOptions, Keep, MAX_CUT_PLANES};
pub use outline::{Outline, outline_area, section_frame};
pub use result::{Cap, CutMesh, CutReport, NO_ORIGIN};
