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
//! *Sides.* Whether a vertex is inside, on or outside of a plane is the exact sign of n·p − d,
//! found once a vertex and plane, so neighbours always agree. A vertex on a plane counts as inside.
//! A triangle with all corners on a plane belongs to the half that it bounds: it is kept inside
//! where it faces the way the plane's normal points, or has no area, and outside where it faces the
//! other way.
//!
//! *New vertices.* One for each edge and plane. Its position is computed from the lower of the
//! edge's two positions (in the order of their coordinates), so that it has the same bits on both
//! sides of a seam, where an edge has two pairs of vertices. Planes are applied in the order they
//! are given, each to what the ones before left: the rest of a triangle is again triangles. On a
//! plane along an axis the coordinate of new vertices is the plane's offset, rounded once.
//!
//! *Caps.* What was removed at a plane leaves edges there, directed by the winding of the
//! triangles; the cap is the chain of triangles whose border they are. A region around which the
//! surface winds w times is covered by |w| sheets, facing out of the plane for w > 0 and into it
//! for w < 0 (the surface is inside out there). So a capped cut of a closed surface is closed,
//! whatever overlaps, is nested or was there twice, and the volumes of the two halves add up.
//! Outlines that cross are split where they do; thin triangles without area join the halves of a
//! split edge to the wall's whole one. Where the winding does not add up (triangles wound both
//! ways) the even–odd rule covers a region once.
//!
//! *Defects* are reported in [`CutReport`]. Outlines that do not close are not capped, unless their
//! ends lie within [`CapOptions::heal`] of each other. Seams that do not quite meet are closed
//! before the cut by [`CapOptions::weld`].
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
