//! Cells, portals and visible sets for [`cullet`], and queries of a scene that games and tools
//! make, and no frame.
//!
//! | module | holds |
//! |---|---|
//! | the root | [`Cells`]: which instances of a scene are in which cell; [`CellView`]: what a view sees of those |
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
//! [`Cells`] stand beside the scene and follow it: [`Cells::update`] reads what the scene logged
//! since the last time, and finds that alone again. A [`CellView`] belongs to one view, as a
//! `ViewState` does. After the frustum stage the culler lets its candidates look: for the stage
//! `pvs` at the sets of the cells that the near plane may be in, for the stage `portal` through
//! open portals, at the instances that are left. What they do not see goes, in the rows of these
//! two stages and with the cell for a reason; of an instance that portals cut, the culler asks for
//! the frusta and tests its clusters. What moved since the last update counts as seen from
//! everywhere; slots that were permuted since are an error.
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
