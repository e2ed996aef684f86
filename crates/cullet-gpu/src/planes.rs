//! The blocks that a view tests, and what of the view each is tested against, on its own grid.

use bytemuck::{Pod, Zeroable};
use cullet::bounds::{Aabb, Plane, Side};

use super::blocks::Blocks;
use super::grid::{Grid, GridBox};
use super::grid_plane::GridPlane;
use super::sizes::{SizeRows, SizeRule};

/// A block that is tested: 16 bytes, as they lie on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct InUse {
    /// Its number.
    pub block: u32,
    /// Its planes among those of all.
    pub first_plane: u32,
    /// How many planes cross it.
    pub plane_count: u32,
    /// How many rows follow its planes that say which of its boxes are small: four, or none.
    pub size_rows: u32,
}

/// The blocks that one view tests: those that are not outside as a whole, each with the planes that
/// cross it, on its own grid.
#[derive(Clone, Debug, Default)]
pub struct BlockPlanes {
    pub(crate) in_use: Vec<InUse>,
    pub(crate) planes: Vec<GridPlane>,
    layers: u32,
}

impl BlockPlanes {
    /// Brings planes that point out to all blocks. O(blocks × planes); nothing is allocated once it
    /// has grown.
    ///
    /// A block beyond one of them is left out, and a plane that all of a block is within is not
    /// tested there. Of instances those in one of the `layers` are drawn.
    pub fn set(&mut self, blocks: &Blocks, planes: &[Plane], layers: u32) {
        self.set_with(blocks, planes, layers, None);
    }

    /// The same without boxes that are small by a rule.
    pub fn set_with(
        &mut self,
        blocks: &Blocks,
        planes: &[Plane],
        layers: u32,
        sizes: Option<&SizeRule>,
    ) {
        self.in_use.clear();
        self.planes.clear();
        self.layers = layers;
        for (block, ((grid, bounds), weight)) in
            (0..).zip(blocks.grids().iter().zip(blocks.weights()))
        {
            let first_plane = self.planes.len() as u32;
            if self.add(grid, bounds, planes) {
                let plane_count = self.planes.len() as u32 - first_plane;
                let rows = sizes.and_then(|rule| rule.on(grid, bounds, *weight));
                self.planes.extend(rows.iter().flat_map(|rows| rows.0));
                let size_rows = rows.map_or(0, |rows| rows.0.len() as u32);
                self.in_use.push(InUse { block, first_plane, plane_count, size_rows });
            } else {
                self.planes.truncate(first_plane as usize);
            }
        }
    }

    /// Adds the planes that cross a block; false where it is beyond one.
    fn add(&mut self, grid: &Grid, bounds: &Aabb, planes: &[Plane]) -> bool {
        for plane in planes {
            match bounds.side(plane) {
                Side::Outside => return false,
                Side::Inside => {}
                Side::Straddling => self.planes.push(GridPlane::new(plane, grid)),
            }
        }
        true
    }

    /// The blocks that are tested, ascending.
    #[must_use]
    pub fn in_use(&self) -> &[InUse] {
        &self.in_use
    }

    /// Layers that are drawn.
    #[must_use]
    pub fn layers(&self) -> u32 {
        self.layers
    }

    /// Whether a box of one of them is small.
    pub(crate) fn is_small(&self, block: &InUse, own: &GridBox) -> bool {
        let rows = &self.planes[(block.first_plane + block.plane_count) as usize..];
        rows.first_chunk().is_some_and(|rows| block.size_rows > 0 && SizeRows(*rows).is_small(own))
    }

    /// Their planes.
    #[must_use]
    pub fn planes_of(&self, block: &InUse) -> &[GridPlane] {
        &self.planes[block.first_plane as usize..][..block.plane_count as usize]
    }
}
