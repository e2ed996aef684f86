//! Cells joined by portals.

use thiserror::Error;

use crate::bounds::Plane;

/// How far the corners of a portal may lie off one plane, as a share of the portal's size, and how far its polygon may be
/// dented.
const FLAT: f64 = 1e-3;

/// An opening between two cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Portal {
    /// The cells that it joins: the first lies on the side to which the [plane](CellGraph::plane)'s normal points.
    pub cells: [u32; 2],
    /// Corners of a convex polygon in one plane, counter-clockwise as seen from the first cell.
    pub polygon: Vec<[f64; 3]>,
}

/// Cells joined by portals: which cells there are, and what leads from one to the next.
///
/// Cells are numbered from 0. Their shapes are not needed here: formats such as `.prt` do not have them.
#[derive(Clone, Debug, Default)]
pub struct CellGraph {
    portals: Vec<Portal>,
    planes: Vec<Plane>,
    /// Where the portals of each cell begin, and where those of the last end.
    firsts: Vec<u32>,
    /// Portals of one cell after the other, ascending.
    around: Vec<u32>,
}

impl CellGraph {
    /// So many cells, and what joins them. Cost: linear.
    ///
    /// # Errors
    /// If a portal names a cell that is not there, or joins one with itself; has fewer than three corners, one that is not
    /// finite, or no area; or is not planar or not convex, by more than a thousandth of its size.
    pub fn new(cell_count: u32, portals: Vec<Portal>) -> Result<Self, CellError> {
        let mut firsts = vec![0_u32; cell_count as usize + 1];
        let mut planes = Vec::with_capacity(portals.len());
        for (number, portal) in portals.iter().enumerate() {
            let at = |problem| CellError::Portal { portal: number as u32, problem };
            planes.push(plane_of(portal, cell_count).map_err(at)?);
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
        Ok(Self { portals, planes, firsts, around })
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
}

/// Checks a portal; its plane.
fn plane_of(portal: &Portal, cell_count: u32) -> Result<Plane, PortalProblem> {
    let Portal { cells, polygon } = portal;
    if let Some(&cell) = cells.iter().find(|&&c| c >= cell_count) {
        return Err(PortalProblem::NoSuchCell { cell, cells: cell_count });
    }
    if cells[0] == cells[1] {
        return Err(PortalProblem::OneCell(cells[0]));
    }
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
    let size = polygon.iter().map(|p| vector(polygon[0], *p).length()).fold(0.0, f64::max);
    let limit = size * FLAT;
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

/// Cells or portals that cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CellError {
    /// A portal that cannot be.
    #[error("portal {portal} {problem}")]
    Portal {
        /// Its number.
        portal: u32,
        /// The reason.
        problem: PortalProblem,
    },
}

/// Reasons for which a portal cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PortalProblem {
    /// It names a cell that is not there.
    #[error("joins cell {cell}, of {cells} cells numbered from 0")]
    NoSuchCell {
        /// The cell.
        cell: u32,
        /// How many there are.
        cells: u32,
    },
    /// It joins a cell with itself.
    #[error("joins cell {0} with itself")]
    OneCell(u32),
    /// It is no polygon.
    #[error("has {0} corners; it must have 3 or more")]
    TooFewCorners(usize),
    /// A corner is not finite.
    #[error("has a corner that is not finite: number {corner}")]
    NotFinite {
        /// Number of the corner.
        corner: usize,
    },
    /// Its corners lie on a line, or in a point.
    #[error("has no area")]
    NoArea,
    /// A corner is off the plane of the others.
    #[error(
        "is not planar: corner {corner} lies {distance:.3e} off its plane, over the limit of {limit:.3e}"
    )]
    NotPlanar {
        /// Number of the corner.
        corner: usize,
        /// How far off it lies.
        distance: f64,
        /// The most that is allowed.
        limit: f64,
    },
    /// A corner is on the wrong side of an edge.
    #[error(
        "is not convex: corner {corner} lies {distance:.3e} outside of an edge, over the limit of {limit:.3e}"
    )]
    NotConvex {
        /// Number of the corner.
        corner: usize,
        /// How far outside it lies.
        distance: f64,
        /// The most that is allowed.
        limit: f64,
    },
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
