//! Cells and portals of a model, as its scene culls by them.

use cullet::bounds::Plane;
use cullet::cell::{CellError, CellGraph as Graph, CellPiece, CellShapes, Portal as Opening};
use glam::DVec3;

use crate::model::{CellGraph, Model, Portal};

impl Model {
    /// Gives the scene the model's [cells](Self::cells), if there are any: what is left of each within its walls, and of
    /// each opening the way through half of the wall that it is in. Portals that are closed are shut.
    ///
    /// # Errors
    /// If a cell has no volume within its walls, or a portal is none, or not on the border of both its cells.
    pub fn place_cells(&mut self) -> Result<(), CellError> {
        if !self.cells.cells.is_empty() {
            let (graph, shapes) = self.cells.shapes()?;
            self.scene.set_cells(graph, shapes);
        }
        Ok(())
    }
}

impl CellGraph {
    fn shapes(&self) -> Result<(Graph, CellShapes), CellError> {
        let walls = DVec3::from(self.walls);
        let openings: Vec<Opening> = self.portals.iter().map(|p| self.opening(p)).collect();
        let mut graph = Graph::new(self.cells.len() as u32, openings)?;
        let mut pieces = Vec::with_capacity(self.cells.len() + 2 * self.portals.len());
        for (number, cell) in (0..).zip(&self.cells) {
            let (min, max) = (DVec3::from(cell.min) + walls, DVec3::from(cell.max) - walls);
            pieces.push(CellPiece::from_box(number, min.into(), max.into()));
        }
        for (number, portal) in (0..).zip(&self.portals) {
            graph.set_open(number, !portal.closed);
            // Half of the wall is on either side. Without walls there is no way through.
            let plane = *graph.plane(number);
            let depth = DVec3::from(plane.normal).abs().dot(walls);
            if depth > 0.0 {
                let polygon = &graph.portals()[number as usize].polygon;
                for (cell, plane) in portal.cells.into_iter().zip([plane, plane.flipped()]) {
                    pieces.push(CellPiece {
                        cell,
                        planes: way(polygon, &graph.plane(number).normal, &plane, depth),
                    });
                }
            }
        }
        let shapes = CellShapes::new(&graph, pieces)?;
        Ok((graph, shapes.with_walls(2.0 * walls.max_element())))
    }

    /// A portal with its corners counter-clockwise as seen from its first cell.
    fn opening(&self, portal: &Portal) -> Opening {
        let Portal { cells, polygon, .. } = portal;
        let mut polygon = polygon.clone();
        let middles = cells.map(|c| {
            self.cells
                .get(c as usize)
                .map(|cell| (DVec3::from(cell.min) + DVec3::from(cell.max)) * 0.5)
        });
        if let ([Some(first), Some(second)], [a, b, c, ..]) = (middles, &polygon[..]) {
            let [a, b, c] = [a, b, c].map(|p| DVec3::from(*p));
            if (b - a).cross(c - a).dot(first - second) < 0.0 {
                polygon.reverse();
            }
        }
        Opening { cells: *cells, polygon }
    }
}

/// The way through a portal that is counter-clockwise about `normal`, to the side that `plane` points to.
fn way(polygon: &[[f64; 3]], normal: &[f64; 3], plane: &Plane, depth: f64) -> Vec<Plane> {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let sides = edges.filter_map(|(a, b)| {
        let along = DVec3::from(*b) - DVec3::from(*a);
        Plane::from_point_normal(*a, along.cross((*normal).into()))
    });
    let end = Plane { d: plane.d + depth, ..*plane };
    sides.chain([plane.flipped(), end]).collect()
}
