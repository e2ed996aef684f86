//! Proof that targets are hidden: things behind voxels that are solid, whatever lines say.
//!
//! A voxel is solid if it lies wholly within a closed mesh: no triangle of that mesh comes into it,
//! and the mesh is wound around it. A line from outside of the mesh into the voxel then crosses a
//! front of the mesh, which is drawn and hides. From a cell to a box, all lines cross each layer of
//! voxels between the two within a rectangle; if all voxels of one layer in it are solid, nothing
//! of the box is seen from the cell. That proves less than is hidden: occluders behind each other
//! are not joined, and thin walls hold no voxel.

use cullet::mesh::Alpha;
use glam::{DVec3, IVec3};

use super::SampledError;
use super::cells::ViewCells;
use super::tree::{Body, RayTree};
use crate::rows::BitRows;
use cullet_draw::Random;

/// Most voxels along an axis.
const MOST: u32 = 512;

/// Voxels of a scene, and which of them are proven solid.
#[derive(Debug)]
pub struct SolidVoxels {
    low: DVec3,
    size: f64,
    counts: [usize; 3],
    /// For each axis, sums over the rectangles from the corner of each layer.
    sums: [Vec<u32>; 3],
    /// Bounds of the solid instances that hold voxels.
    holders: Vec<[DVec3; 2]>,
    solid: u64,
}

impl SolidVoxels {
    /// Voxels over the bounds of all instances, so many along their longest side: 2 to 512. Time
    /// and memory grow with the third power of that.
    ///
    /// # Errors
    /// If the number is out of its range.
    pub fn new(tree: &RayTree<'_>, resolution: u32) -> Result<Self, SampledError> {
        if !(2..=MOST).contains(&resolution) {
            let value = f64::from(resolution);
            return Err(SampledError::Setting {
                name: "resolution",
                value,
                range: "2 to 512 voxels",
            });
        }
        let [low, high] = tree.bounds().map(DVec3::from);
        let size = (high - low).max_element() / f64::from(resolution);
        let counts: [usize; 3] = std::array::from_fn(|a| {
            (((high - low)[a] / size).ceil() as usize).clamp(1, MOST as usize)
        });
        let mut grid =
            Self { low, size, counts, sums: Default::default(), holders: Vec::new(), solid: 0 };
        let mut solid = vec![false; counts.iter().product()];
        let is_solid: Vec<bool> =
            tree.scene.meshes().iter().map(|mesh| cullet_mesh::solid(mesh).is_ok()).collect();
        for body in tree.bodies().iter().filter(|b| is_solid[b.mesh as usize]) {
            grid.fill(tree, body, &mut solid);
        }
        grid.solid = solid.iter().filter(|&&s| s).count() as u64;
        grid.sum(&solid);
        Ok(grid)
    }

    /// How many voxels are solid, and how many there are.
    #[must_use]
    pub fn counts(&self) -> [u64; 2] {
        [self.solid, self.counts.iter().map(|&n| n as u64).product()]
    }

    fn number(&self, at: [usize; 3]) -> usize {
        (at[2] * self.counts[1] + at[1]) * self.counts[0] + at[0]
    }

    /// The voxels that a box comes into, first and last along each axis; `None` for none.
    fn range(&self, low: DVec3, high: DVec3) -> Option<[[usize; 2]; 3]> {
        let mut out = [[0; 2]; 3];
        for a in 0..3 {
            let cell = |v: f64| ((v - self.low[a]) / self.size).floor();
            let (first, last) =
                (cell(low[a]).max(0.0), cell(high[a]).min(self.counts[a] as f64 - 1.0));
            if first > last || first.is_nan() || last.is_nan() {
                return None;
            }
            out[a] = [first as usize, last as usize];
        }
        Some(out)
    }

    /// Marks the voxels wholly within a closed instance.
    fn fill(&mut self, tree: &RayTree<'_>, body: &Body, solid: &mut [bool]) {
        let mesh = tree.scene.mesh(body.slot);
        let opaque =
            !body.is_transparent() && mesh.parts().iter().all(|p| p.alpha == Alpha::Opaque);
        let b = tree.scene.bounds(body.slot);
        let bounds = [b.min, b.max].map(|v| DVec3::from(v.map(f64::from)) + tree.origin);
        // Not worth it where no voxel fits in.
        let Some(range) = self.range(bounds[0], bounds[1]) else { return };
        if !opaque || range.iter().any(|[first, last]| last - first < 2) {
            return;
        }
        let extents: [usize; 3] = std::array::from_fn(|a| range[a][1] - range[a][0] + 1);
        let mut touched = vec![false; extents.iter().product()];
        let at = |p: [usize; 3]| (p[2] * extents[1] + p[1]) * extents[0] + p[0];
        // What is rounded, of corners and of voxels.
        let slack = self.size * 1e-3 + bounds[0].abs().max(bounds[1].abs()).max_element() * 1e-6;
        for t in 0..mesh.triangle_count() {
            let corners = mesh.corners(t).map(|p| body.place_of(p) + tree.origin);
            self.touch(&corners, slack, &range, |p| touched[at(p)] = true);
        }
        let mut held = false;
        let mut random = Random::new(0x736f_6c69, [body.handle.index, 0]);
        for z in 0..extents[2] {
            for y in 0..extents[1] {
                // Runs of voxels without a triangle are all within or all without.
                let mut within = None;
                for x in 0..extents[0] {
                    if touched[at([x, y, z])] {
                        within = None;
                        continue;
                    }
                    let place = [x + range[0][0], y + range[1][0], z + range[2][0]];
                    let is_within = *within
                        .get_or_insert_with(|| self.is_within(tree, body, place, &mut random));
                    if is_within {
                        solid[self.number(place)] = true;
                        held = true;
                    }
                }
            }
        }
        if held {
            self.holders.push(bounds);
        }
    }

    /// Calls `touch` with all voxels, from the first of a range, that a triangle may come into.
    fn touch(
        &self,
        corners: &[DVec3; 3],
        slack: f64,
        within: &[[usize; 2]; 3],
        mut touch: impl FnMut([usize; 3]),
    ) {
        let [p, q, r] = *corners;
        let (low, high) = (p.min(q).min(r) - slack, p.max(q).max(r) + slack);
        let Some(range) = self.range(low, high) else { return };
        let normal = (q - p).cross(r - p);
        let half = self.size * 0.5;
        // A voxel as far from the plane as this holds nothing of it; a triangle without area has no
        // plane.
        let reach = normal.abs().element_sum() * half + normal.length() * slack;
        let first: [usize; 3] = std::array::from_fn(|a| range[a][0].max(within[a][0]));
        let last: [usize; 3] = std::array::from_fn(|a| range[a][1].min(within[a][1]));
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let middle = self.middle([x, y, z]);
                    if normal.dot(middle - p).abs() <= reach * (1.0 + 1e-9) {
                        touch([x - within[0][0], y - within[1][0], z - within[2][0]]);
                    }
                }
            }
        }
    }

    fn middle(&self, at: [usize; 3]) -> DVec3 {
        self.low + (IVec3::from_array(at.map(|v| v as i32)).as_dvec3() + 0.5) * self.size
    }

    /// Whether the surface is wound around a voxel, by three rays that must agree.
    fn is_within(
        &self,
        tree: &RayTree<'_>,
        body: &Body,
        at: [usize; 3],
        random: &mut Random,
    ) -> bool {
        let middle = self.middle(at);
        let mut windings =
            [(); 3].map(|()| tree.winding(body, middle, super::split::direction(random)));
        windings.sort_unstable();
        windings[0] == windings[2] && windings[0] > 0
    }

    /// Sums of each layer along each axis.
    fn sum(&mut self, solid: &[bool]) {
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let (wide, high) = (self.counts[u] + 1, self.counts[v] + 1);
            let mut sums = vec![0_u32; self.counts[axis] * wide * high];
            for layer in 0..self.counts[axis] {
                let base = layer * wide * high;
                for y in 1..high {
                    let mut row = 0;
                    for x in 1..wide {
                        let mut at = [layer; 3];
                        (at[u], at[v]) = (x - 1, y - 1);
                        row += u32::from(solid[self.number(at)]);
                        sums[base + y * wide + x] = sums[base + (y - 1) * wide + x] + row;
                    }
                }
            }
            self.sums[axis] = sums;
        }
    }

    /// Whether a box is proven hidden from every point of a cell, both in the world. Instances that
    /// the cell may reach into prove nothing for it: from within, one-sided ones are looked
    /// through.
    #[must_use]
    pub fn hides(&self, cell: [[f64; 3]; 2], target: [[f64; 3]; 2]) -> bool {
        let (cell, target) = (cell.map(DVec3::from), target.map(DVec3::from));
        self.hides_from(&cell, &target, &self.around(&cell))
    }

    /// The instances that a cell may reach into.
    fn around(&self, cell: &[DVec3; 2]) -> Vec<&[DVec3; 2]> {
        self.holders.iter().filter(|holder| meet(holder, cell)).collect()
    }

    fn hides_from(&self, cell: &[DVec3; 2], target: &[DVec3; 2], around: &[&[DVec3; 2]]) -> bool {
        let is_sound = |b: &[DVec3; 2]| b.iter().all(|v| v.is_finite()) && b[0].cmple(b[1]).all();
        if self.solid == 0 || !is_sound(cell) || !is_sound(target) {
            return false;
        }
        (0..3).any(|axis| self.layer_hides(axis, cell, target, around))
    }

    fn layer_hides(
        &self,
        axis: usize,
        cell: &[DVec3; 2],
        target: &[DVec3; 2],
        around: &[&[DVec3; 2]],
    ) -> bool {
        // The gap along the axis.
        let (low, high) = if cell[1][axis] < target[0][axis] {
            (cell[1][axis], target[0][axis])
        } else if target[1][axis] < cell[0][axis] {
            (target[1][axis], cell[0][axis])
        } else {
            return false;
        };
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let first = ((low - self.low[axis]) / self.size).ceil().max(0.0) as usize;
        let mut end = ((high - self.low[axis]) / self.size).floor();
        end = end.clamp(0.0, self.counts[axis] as f64);
        for layer in first..end as usize {
            let place = |k: usize| self.low[axis] + k as f64 * self.size;
            let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
            for height in [place(layer), place(layer + 1)] {
                // How far on the way from the one to the other, from each end of both; the lines
                // that are farthest out go from border to border.
                for k in 0..2 {
                    for l in 0..2 {
                        let span = target[l][axis] - cell[k][axis];
                        let share = ((height - cell[k][axis]) / span).clamp(0.0, 1.0);
                        for (n, across) in [u, v].into_iter().enumerate() {
                            let at = |e: usize| {
                                cell[e][across] + (target[e][across] - cell[e][across]) * share
                            };
                            least[n] = least[n].min(at(0));
                            most[n] = most[n].max(at(1));
                        }
                    }
                }
            }
            if self.is_full(axis, layer, least, most, around) {
                return true;
            }
        }
        false
    }

    /// Whether all voxels of a rectangle of a layer are solid, by instances that a cell is not
    /// around.
    fn is_full(
        &self,
        axis: usize,
        layer: usize,
        least: [f64; 2],
        most: [f64; 2],
        around: &[&[DVec3; 2]],
    ) -> bool {
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        let slack = self.size * 1e-3;
        let mut ends = [[0_usize; 2]; 2];
        let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
        low[axis] = self.low[axis] + layer as f64 * self.size;
        high[axis] = low[axis] + self.size;
        for (n, &a) in across.iter().enumerate() {
            (low[a], high[a]) = (least[n] - slack, most[n] + slack);
            let first = ((low[a] - self.low[a]) / self.size).floor();
            let last = ((high[a] - self.low[a]) / self.size).floor();
            // Beyond the voxels nothing is solid.
            if !(first >= 0.0 && last < self.counts[a] as f64) {
                return false;
            }
            ends[n] = [first as usize, last as usize + 1];
        }
        if around.iter().any(|holder| meet(holder, &[low - self.size, high + self.size])) {
            return false;
        }
        let wide = self.counts[across[0]] + 1;
        let base = layer * wide * (self.counts[across[1]] + 1);
        let sum = |x: usize, y: usize| self.sums[axis][base + y * wide + x];
        let [[x0, x1], [y0, y1]] = ends;
        let full = ((x1 - x0) * (y1 - y0)) as u32;
        sum(x1, y1) + sum(x0, y0) - sum(x0, y1) - sum(x1, y0) == full
    }

    /// Returns for each cell the targets that are proven hidden; O(cells · targets · voxels along a
    /// side). Conservative: rows hold only proven targets. Targets that take no part are in no row.
    #[must_use]
    pub fn hidden(&self, tree: &RayTree<'_>, cells: &ViewCells) -> BitRows {
        let targets = tree.targets().count();
        let mut rows = BitRows::new(cells.len(), targets);
        let bounds: Vec<_> = (0..targets).map(|target| tree.target_bounds(target)).collect();
        for (cell, of_cell) in (0..).zip(cells.boxes()) {
            let around = self.around(of_cell);
            for (target, bounds) in (0..).zip(&bounds) {
                if bounds.is_some_and(|b| self.hides_from(of_cell, &b, &around)) {
                    rows.set(cell, target);
                }
            }
        }
        rows
    }
}

fn meet(a: &[DVec3; 2], b: &[DVec3; 2]) -> bool {
    a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all()
}
