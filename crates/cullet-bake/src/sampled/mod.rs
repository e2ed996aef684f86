//! Potentially visible sets of any scene: what can be seen from boxes that an eye may be in, found
//! by sampled lines.
//!
//! For scenes without cells and portals. Nothing is asked of the geometry: rays meet just the
//! triangles that are drawn, as they are drawn, so no crack or foliage spoils it. Every line serves
//! all cells that it passes; what is new is followed up, past its outline and from the cells
//! beside. What no line found is missing: the result says how much that is likely to be, by [an
//! estimate](ScenePvs::missing) that costs nothing and by [pictures](check_pictures) from random
//! places. [Solid voxels](SolidVoxels) prove some of the rest hidden, which no line may ever
//! contradict. Where nothing may ever be missing, bake a [graph of portals](crate::pvs), or use no
//! sets.
//!
//! ```
//! use cullet::{Instance, Scene, Transform};
//! use cullet_bake::sampled::{RayTree, RayTreeOptions, SampledSettings, ViewCells, bake_sampled};
//! # use cullet::{Mesh, MeshData};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let quad = |size: f32| Mesh::new(MeshData {
//! #     positions: vec![[-size, -size, 0.0], [size, -size, 0.0], [size, size, 0.0], [-size, size, 0.0]],
//! #     indices: vec![0, 1, 2, 0, 2, 3],
//! #     ..MeshData::default()
//! # });
//! // A wall, with something before and something behind it.
//! let mut scene = Scene::new();
//! let (wall, plate) = (scene.add_mesh(quad(50.0)?), scene.add_mesh(quad(0.5)?));
//! scene.add(Instance::new(wall, Transform::from_translation([0.0, 0.0, -5.0])))?;
//! let before = scene.add(Instance::new(plate, Transform::from_translation([0.0, 0.0, -4.0])))?;
//! let behind = scene.add(Instance::new(plate, Transform::from_translation([0.0, 0.0, -9.0])))?;
//! scene.commit(&cullet::Culler::default());
//!
//! let tree = RayTree::new(&scene, &RayTreeOptions::default())?;
//! let cells = ViewCells::grid([[-2.0, 0.0, -2.0], [2.0, 2.0, 2.0]], [2, 1, 2])?;
//! let pvs = bake_sampled(&tree, &cells, &SampledSettings::default().with_rays(200_000), 1)?;
//! let cell = cells.cell_of([1.0, 1.0, 1.0]).expect("within the region");
//! assert!(pvs.visible.has(cell, before.index) && !pvs.visible.has(cell, behind.index));
//! # Ok(())
//! # }
//! ```

mod bake;
mod box_tree;
mod boxes;
mod cells;
mod crossing;
mod edit;
mod error;
mod file;
mod line;
mod near;
mod pictures;
mod plan;
mod sets;
mod settings;
mod solid;
mod split;
mod targets;
mod tree;
mod unit;
mod unit_file;

pub use bake::{SampledBake, SampledPart, bake_sampled};
pub use cells::ViewCells;
pub use cullet_io::baked::{Region, SceneSets, SceneSetsError, instance_marks, scene_hash};
pub use edit::EditCounts;
pub use error::SampledError;

pub use pictures::{PictureCheck, WorstPose, check_pictures, check_pictures_from};
pub use sets::ScenePvs;
pub use settings::SampledSettings;
pub use solid::SolidVoxels;
pub(crate) use split::direction;
pub use targets::{Granularity, Targets};
pub(crate) use tree::Body;
pub use tree::{RayTree, RayTreeOptions, TreeHit};
