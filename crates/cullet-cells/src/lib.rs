//! Queries of a scene of [`cullet`] that games and tools make, and no frame: line of sight, volume to volume, lights, and what
//! may be seen from a box of eyes or along a motion.
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
//! scene.commit();
//!
//! let [guard, thief] = [[0.0; 3], [0.0, 0.0, -20.0]];
//! assert!(line_of_sight(&scene, guard, thief, &SightOptions::default()).is_blocked());
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

mod bits;
mod exact;
pub mod query;
