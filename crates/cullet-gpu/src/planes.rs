//! Planes in steps of grids, rounded so that what they reject is outside.

use bytemuck::{Pod, Zeroable};
use cullet::bounds::{Aabb, Plane, Side};

use super::blocks::Blocks;
use super::grid::{Grid, GridBox, MOST};
use super::sizes::{SizeRows, SizeRule};

/// Components of normals reach so far, and 3 · 8191 · 32767 fits 30 bits.
const NORMAL: f64 = 8191.0;
/// Offsets beyond this decide by themselves; with it the sum stays below 2³¹.
const OFFSET: f64 = 1.3e9;

/// A plane in steps of a [`Grid`]: a box is outside where N·q + offset is above 0 at its lowest corner along N. 16 bytes, as
/// they lie on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridPlane {
    /// The normal, outward.
    pub normal: [i32; 3],
    /// What is added.
    pub offset: i32,
}

impl GridPlane {
    /// A plane that points out, on a grid. Rejects nothing that the plane does not, whatever lies within the grid; nothing at all where the
    /// plane is not finite.
    ///
    /// With x = o + s q the plane n·x > d is K n·q > K (d − n·o) / s for any K > 0. N is K n rounded, and K n·q is at
    /// least N·q − Σ |N − K n| 32767.
    #[must_use]
    pub fn new(plane: &Plane, grid: &Grid) -> Self {
        let most = plane.normal.iter().fold(0.0, |m: f64, n| m.max(n.abs()));
        if !plane.is_finite() || most < 1e-300 {
            return Self::default();
        }
        let scale = NORMAL / most;
        let mut normal = [0; 3];
        let (mut away, mut size, mut lost) = (-plane.d, plane.d.abs(), 0.0);
        for a in 0..3 {
            let exact = plane.normal[a] * scale;
            let rounded = exact.round();
            normal[a] = rounded as i32;
            lost += (exact - rounded).abs() * MOST;
            let part = plane.normal[a] * grid.origin[a];
            away += part;
            size += part.abs();
        }
        // Four operations, each off by half an ulp of what has come together.
        let away = away - size * (8.0 * f64::EPSILON);
        // One for what the sums above were rounded by.
        let offset = (away / grid.step * scale - lost).floor() - 1.0;
        // Not a number where sizes overflow: then nothing is rejected.
        let offset = if offset.is_nan() { -OFFSET } else { offset.clamp(-OFFSET, OFFSET) };
        Self { normal, offset: offset as i32 }
    }

    /// Whether a box is outside. The device's shader does the same.
    #[must_use]
    pub fn rejects(&self, of: &GridBox) -> bool {
        self.lowest(of) > 0
    }

    /// N·q + offset at the lowest corner of a box along N.
    pub(crate) fn lowest(&self, of: &GridBox) -> i32 {
        let mut sum = self.offset;
        for a in 0..3 {
            let n = self.normal[a];
            sum += n * i32::from(if n >= 0 { of.low[a] } else { of.high[a] });
        }
        sum
    }
}

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

/// The blocks that one view tests: those that are not outside as a whole, each with the planes that cross it, on its own grid.
#[derive(Clone, Debug, Default)]
pub struct BlockPlanes {
    pub(crate) in_use: Vec<InUse>,
    pub(crate) planes: Vec<GridPlane>,
    layers: u32,
}

impl BlockPlanes {
    /// Brings planes that point out to all blocks. O(blocks × planes); nothing is allocated once it has grown.
    ///
    /// A block beyond one of them is left out, and a plane that all of a block is within is not tested there. Of instances those
    /// in one of the `layers` are drawn.
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
