//! Automatic cells and portals of closed interiors: rooms, and the doors between them, found in the
//! triangles alone.
//!
//! 1. *Voxels*: which of them surfaces of closed opaque meshes touch, and which lie wholly within
//!    such a mesh.
//! 2. *Sides* of touched voxels: which are proven closed, because every point of them lies within
//!    closed meshes.
//! 3. *Basins*: the free voxels, cut where they are narrow (the watershed of the distance to
//!    surfaces).
//! 4. *Regions*: cuts made straight, and the touched voxels given to the room from which they are
//!    reached.
//! 5. *Shapes*: boxes of the voxels of each room, and rectangles of the open sides between two.
//!
//! However the rooms are cut, nothing is lost by it: a line of sight goes from voxel to voxel
//! through their sides, never through one that is proven closed, and **each open side between
//! voxels of two cells is part of a portal**. So a cut in the wrong place, or an opening in a wall
//! that nobody drew on purpose, costs tightness alone.
//!
//! An eye in a touched voxel may be within a mesh, whose surface is not drawn from behind. So these
//! voxels are *skins* of their cells
//! ([`CellShapes::with_skins`](cullet_cells::cell::CellShapes::with_skins)): what stands there is
//! of the cell, but an eye there is in none, and portals hide nothing from it.
//!
//! After Haumont, Debeir & Sillion, *Volumetric cell-and-portal generation*, 2003, for the basins;
//! what is proven closed, and that nothing else is, is our own.

mod basins;
mod find;
mod found;
mod options;
mod regions;
mod shapes;
mod sides;
mod voxels;

pub use find::find_cells;
pub use found::{FoundCell, FoundCells};
pub use options::{FindOptions, FindStep, FoundFigures, RoomsError};
