//! Cells joined by portals.

use alloc::vec;
use alloc::vec::Vec;

use super::error::{CellError, PortalProblem};
use crate::bits;
use cullet::bounds::Plane;

/// How far the corners of a portal may lie off one plane, as a share of the portal's size, and how
/// far its polygon may be dented.
pub(super) const FLAT: f64 = 1e-3;

/// An opening between two cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Portal {
    /// The cells that it joins: the first lies on the side to which the [plane](CellGraph::plane)'s
    /// normal points.
    pub cells: [u32; 2],
    /// Corners of a convex polygon in one plane, counter-clockwise as seen from the first cell.
    pub polygon: Vec<[f64; 3]>,
}

/// A mirror on the border of a cell, seen from within that cell alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    /// The cell.
    pub cell: u32,
    /// Corners of a convex polygon in one plane, counter-clockwise as seen from the cell.
    pub polygon: Vec<[f64; 3]>,
}

/// Cells joined by portals: which cells there are, and what leads from one to the next.
///
/// Cells are numbered from 0. Their shapes are not needed here: formats such as `.prt` do not have
/// them. Where they are known they stand beside it, as [`CellShapes`](super::CellShapes).
///
/// All portals are open at first, and are seen through both ways.
#[derive(Clone, Debug, Default)]
pub struct CellGraph {
    portals: Vec<Portal>,
    planes: Vec<Plane>,
    /// Where the portals of each cell begin, and where those of the last end.
    firsts: Vec<u32>,
    /// Portals of one cell after the other, ascending.
    around: Vec<u32>,
    /// How far the corners of each portal lie apart, at the most.
    sizes: Vec<f64>,
    /// One bit a portal.
    closed: Vec<u64>,
    one_way: Vec<u64>,
    mirrors: Vec<Mirror>,
    mirror_planes: Vec<Plane>,
}

impl CellGraph {
    /// So many cells, and what joins them. Cost: linear.
    ///
    /// # Errors
    /// If a portal names a cell that is not there, or joins one with itself; has fewer than three
    /// corners, one that is not finite, or no area; or is not planar or not convex, by more than a
    /// thousandth of its size.
    pub fn new(cell_count: u32, portals: Vec<Portal>) -> Result<Self, CellError> {
        let mut firsts = vec![0_u32; cell_count as usize + 1];
        let mut planes = Vec::with_capacity(portals.len());
        for (number, portal) in portals.iter().enumerate() {
            let at = |problem| CellError::Portal { portal: number as u32, problem };
            check_cells(portal, cell_count).map_err(at)?;
            planes.push(plane_of(&portal.polygon).map_err(at)?);
            for cell in portal.cells {
                firsts[cell as usize] += 1;
            }
        }
        let mut sum = 0;
        for first in &mut firsts {
            sum += *first;
            *first = sum;
        }
        // Filled from behind, each end becomes where its cell begins.
        let mut around = vec![0; portals.len() * 2];
        for (number, portal) in portals.iter().enumerate().rev() {
            for cell in portal.cells {
                firsts[cell as usize] -= 1;
                around[firsts[cell as usize] as usize] = number as u32;
            }
        }
        let sizes = portals.iter().map(|p| size_of(&p.polygon)).collect();
        let words = portals.len().div_ceil(64);
        let (closed, one_way) = (vec![0; words], vec![0; words]);
        let (mirrors, mirror_planes) = (Vec::new(), Vec::new());
        Ok(Self { portals, planes, firsts, around, sizes, closed, one_way, mirrors, mirror_planes })
    }

    /// The same with mirrors, in place of those that it had.
    ///
    /// # Errors
    /// If a mirror's cell is not there, or its polygon is none, as of a portal.
    pub fn with_mirrors(mut self, mirrors: Vec<Mirror>) -> Result<Self, CellError> {
        self.mirror_planes.clear();
        for (number, mirror) in (0..).zip(&mirrors) {
            let at = |problem| CellError::Mirror { mirror: number, problem };
            if mirror.cell >= self.cell_count() {
                let (cell, cells) = (mirror.cell, self.cell_count());
                return Err(at(PortalProblem::NoSuchCell { cell, cells }));
            }
            self.mirror_planes.push(plane_of(&mirror.polygon).map_err(at)?);
        }
        self.mirrors = mirrors;
        Ok(self)
    }

    /// How many cells there are.
    #[must_use]
    pub fn cell_count(&self) -> u32 {
        (self.firsts.len().max(1) - 1) as u32
    }

    /// All portals.
    #[must_use]
    pub fn portals(&self) -> &[Portal] {
        &self.portals
    }

    /// The plane of a portal, its normal of unit length and towards the first cell.
    #[must_use]
    pub fn plane(&self, portal: u32) -> &Plane {
        &self.planes[portal as usize]
    }

    /// The portals of a cell, ascending.
    #[must_use]
    pub fn portals_of(&self, cell: u32) -> &[u32] {
        let [first, end] = [cell, cell + 1].map(|c| self.firsts[c as usize] as usize);
        &self.around[first..end]
    }

    /// The cells on the other side of a cell's portals, open or shut, in the order of
    /// [`portals_of`](Self::portals_of): one that several portals lead to comes as often.
    pub fn neighbours_of(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        self.portals_of(cell).iter().map(move |&portal| {
            let [first, second] = self.portals[portal as usize].cells;
            if first == cell { second } else { first }
        })
    }

    /// The cell that a portal leads to from one of its two; `None` where it is shut, or lets nobody
    /// see that way.
    #[must_use]
    pub fn beyond(&self, portal: u32, from: u32) -> Option<u32> {
        self.is_open(portal).then(|| self.if_open(portal, from)).flatten()
    }

    /// Returns the cell that `portal` leads to from `from`, like [`beyond`](Self::beyond), but as
    /// if the portal were open.
    pub(crate) fn if_open(&self, portal: u32, from: u32) -> Option<u32> {
        let [first, second] = self.portals[portal as usize].cells;
        if from == first {
            return Some(second);
        }
        (from == second && !self.is_one_way(portal)).then_some(first)
    }

    /// Whether a portal is open.
    #[must_use]
    pub fn is_open(&self, portal: u32) -> bool {
        !bits::get(&self.closed, portal as usize)
    }

    /// Opens or shuts a portal, as a door does. Nothing where there is no such portal.
    pub fn set_open(&mut self, portal: u32, open: bool) {
        if (portal as usize) < self.portals.len() {
            bits::set(&mut self.closed, portal as usize, !open);
        }
    }

    /// Whether a portal is seen through from its first cell alone.
    #[must_use]
    pub fn is_one_way(&self, portal: u32) -> bool {
        bits::get(&self.one_way, portal as usize)
    }

    /// Says whether a portal is seen through from its first cell alone. Nothing where there is no
    /// such portal.
    pub fn set_one_way(&mut self, portal: u32, one_way: bool) {
        if (portal as usize) < self.portals.len() {
            bits::set(&mut self.one_way, portal as usize, one_way);
        }
    }

    /// How far the corners of a portal lie apart, at the most: what its tolerances are relative to.
    pub(crate) fn size(&self, portal: u32) -> f64 {
        self.sizes[portal as usize]
    }

    /// How far the corners of a portal may lie off the borders of its cells.
    pub(crate) fn tolerance(&self, portal: u32) -> f64 {
        self.size(portal) * FLAT
    }

    /// All mirrors.
    #[must_use]
    pub fn mirrors(&self) -> &[Mirror] {
        &self.mirrors
    }

    /// How far the corners of a mirror may lie off the border of its cell.
    pub(crate) fn mirror_tolerance(&self, mirror: u32) -> f64 {
        size_of(&self.mirrors[mirror as usize].polygon) * FLAT
    }

    /// The plane of a mirror, its normal of unit length and towards the cell.
    #[must_use]
    pub(crate) fn mirror_plane(&self, mirror: u32) -> &Plane {
        &self.mirror_planes[mirror as usize]
    }
}

/// How far corners lie apart: from the first, twice as far at the most.
pub(super) fn size_of(polygon: &[[f64; 3]]) -> f64 {
    let first = glam::DVec3::from(polygon[0]);
    polygon.iter().map(|p| (glam::DVec3::from(*p) - first).length()).fold(0.0, f64::max)
}

/// Checks which cells a portal joins.
fn check_cells(portal: &Portal, cell_count: u32) -> Result<(), PortalProblem> {
    let cells = portal.cells;
    if let Some(&cell) = cells.iter().find(|&&c| c >= cell_count) {
        return Err(PortalProblem::NoSuchCell { cell, cells: cell_count });
    }
    if cells[0] == cells[1] {
        return Err(PortalProblem::OneCell(cells[0]));
    }
    Ok(())
}

/// Checks a polygon; its plane.
fn plane_of(polygon: &[[f64; 3]]) -> Result<Plane, PortalProblem> {
    if polygon.len() < 3 {
        return Err(PortalProblem::TooFewCorners(polygon.len()));
    }
    if let Some(corner) = polygon.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        return Err(PortalProblem::NotFinite { corner });
    }
    let vector = |from: [f64; 3], to: [f64; 3]| glam::DVec3::from(to) - glam::DVec3::from(from);
    let edges = || polygon.iter().zip(polygon.iter().cycle().skip(1));
    // Newell's sum, about the first corner: twice the area.
    let area = edges().fold(glam::DVec3::ZERO, |sum, (a, b)| {
        sum + vector(polygon[0], *a).cross(vector(polygon[0], *b))
    });
    let plane = Plane::from_point_normal(polygon[0], area).ok_or(PortalProblem::NoArea)?;
    let limit = size_of(polygon) * FLAT;
    for (corner, p) in polygon.iter().enumerate() {
        let distance = plane.distance(*p).abs();
        if distance > limit {
            return Err(PortalProblem::NotPlanar { corner, distance, limit });
        }
    }
    let normal = glam::DVec3::from(plane.normal);
    for (a, b) in edges() {
        // To the inner side.
        let Some(inward) = normal.cross(vector(*a, *b)).try_normalize() else { continue };
        for (corner, p) in polygon.iter().enumerate() {
            let distance = -inward.dot(vector(*a, *p));
            if distance > limit {
                return Err(PortalProblem::NotConvex { corner, distance, limit });
            }
        }
    }
    Ok(plane)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(cells: [u32; 2], x: f64) -> Portal {
        let polygon = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        Portal { cells, polygon: polygon.map(|[y, z]| [x, y, z]).to_vec() }
    }

    #[test]
    fn cells_know_their_portals_and_portals_their_planes() {
        let graph =
            CellGraph::new(4, vec![square([1, 0], 0.0), square([1, 2], 5.0), square([2, 0], 7.0)]);
        let graph = graph.unwrap();
        let of = |cell| graph.portals_of(cell).to_vec();
        assert_eq!([of(0), of(1), of(2), of(3)], [vec![0, 2], vec![0, 1], vec![1, 2], vec![]]);
        assert_eq!(graph.plane(1), &Plane::new([1.0, 0.0, 0.0], 5.0));
        assert_eq!((graph.cell_count(), CellGraph::default().cell_count()), (4, 0));
    }

    #[test]
    fn each_fault_of_a_portal_is_named() {
        let with = |change: fn(&mut Portal)| {
            let mut portal = square([0, 1], 0.0);
            change(&mut portal);
            CellGraph::new(2, vec![square([0, 1], 9.0), portal]).unwrap_err().to_string()
        };
        assert_eq!(with(|p| p.cells[1] = 2), "portal 1 joins cell 2, of 2 cells numbered from 0");
        assert_eq!(with(|p| p.cells[1] = 0), "portal 1 joins cell 0 with itself");
        assert_eq!(
            with(|p| p.polygon.truncate(2)),
            "portal 1 has 2 corners; it must have 3 or more"
        );
        assert!(with(|p| p.polygon[2][0] = f64::NAN).contains("not finite: number 2"));
        assert_eq!(with(|p| p.polygon.fill([1.0; 3])), "portal 1 has no area");
        assert!(with(|p| p.polygon[3][0] = 0.1).contains("not planar: corner"));
        assert!(with(|p| p.polygon[2] = [0.0, 0.2, 0.2]).contains("not convex: corner"));
    }
}
