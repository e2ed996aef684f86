//! Maps of Quake, Half-Life, Quake 2 and Quake 3: tree, leafs, entities and stored visibility; visibility written back;
//! cells and portals made from the tree.
//!
//! [`load`](crate::load()) makes a model of a map's geometry. What more a map has is here:
//!
//! ```no_run
//! use cullet_maps::bsp::Bsp;
//!
//! let map = Bsp::open("start.bsp".as_ref())?;
//! let start = map.starts()[0].origin;
//! let leaf = map.leaf_at(start);
//! println!("{} of {} leafs seen", map.leafs_seen_from(leaf).len(), map.leafs().len());
//! let graph = map.cells()?;
//! println!("{} cells, {} portals", graph.cell_count(), graph.portals().len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cells;
mod entities;
mod lumps;
mod map;
mod parse;
mod patch;
mod portals;
mod quake;
mod quake2;
mod quake3;
mod rows;
mod scene;
mod surfaces;
mod tree;
mod visibility;
mod write;

pub use entities::{Entity, Lamp, Start};
pub use lumps::Version;
pub use map::{BrushModel, Bsp, Contents, Leaf, Texture};
pub use scene::to_scene;
pub use tree::{Child, Node, Tree};
pub use write::{ClusterRows, clusters_of_leafs, with_visibility};

pub(crate) use scene::read;
