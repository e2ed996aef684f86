//! Cells, portals and visible sets for [`cullet`], and queries of a scene for games and tools,
//! apart from drawing.
//!
//! | module | holds |
//! |---|---|
//! | the root | [`Cells`]: which instances of a scene are in which cell; [`CellView`]: which of them a view sees |
//! | [`cell`] | graphs of cells, where they are, and the portals between them |
//! | [`portal`] | the walk from the cell of an eye through open portals |
//! | [`pvs`] | visible sets at run time |
//! | [`query`] | line of sight, volume to volume, lights, what may be seen from a box of eyes and along a motion |
//!
//! # How cells reach the culler
//!
//! ```text
//!  Scene ── log of changes ──► Cells ──► CellView::on ──► CellCandidates ──► Culler::cull_among
//!                              graph, places,             by the trait
//!                              slots of each cell, sets   cullet::candidates::Candidates
//! ```
//!
//! [`Cells`] belong to a scene and follow its changes: [`Cells::update`] reads the changes that the
//! scene logged since the last update, and places only the changed instances again. A [`CellView`]
//! belongs to one view, like a `ViewState`. After the frustum stage the culler asks its candidates.
//! For the stage `pvs`, they look up the sets of the cells that the near plane may be in. For the
//! stage `portal`, they look at the remaining instances through open portals. Instances that they
//! do not see are dropped in the rows of these two stages, with the cell as the reason. If portals
//! cut an instance, the culler asks for the frusta and tests its clusters. Instances that moved
//! since the last update count as seen from everywhere. If slots were permuted since then, the
//! answer is [`CullError::Order`](cullet::CullError::Order).
//!
//! ```
//! use cullet::{Instance, Mesh, MeshData, Scene, Transform};
//! use cullet_cells::query::{SightOptions, line_of_sight};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
//! # let wall = Mesh::new(MeshData { positions, indices: vec![0, 1, 2], ..MeshData::default() })?;
//! let mut scene = Scene::new();
//! let wall = scene.add_mesh(wall);
//! scene.add(Instance::new(wall, Transform::from_translation([0.0, 0.0, -5.0])))?;
//! scene.commit(&cullet::Culler::default());
//!
//! let [guard, thief] = [[0.0; 3], [0.0, 0.0, -20.0]];
//! assert!(line_of_sight(&scene, guard, thief, &SightOptions::default()).is_blocked());
//! # Ok(())
//! # }
//! ```
#![cfg_attr(not(any(feature = "std", test)), no_std)]
#![forbid(unsafe_code)]
#![warn(clippy::std_instead_of_core, clippy::std_instead_of_alloc, clippy::alloc_instead_of_core)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

extern crate alloc;

mod bits;
pub mod cell;
mod cells;
mod exact;
pub mod portal;
pub mod pvs;
pub mod query;
mod view;

pub use cells::Cells;
pub use view::{CellCandidates, CellView, InCells};

/// A rounded f64 is off by less than this, as a share of it, after the few operations that make a
/// plane or a point.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
