//! Cells of a map as a model has them: their graph, and of each leaf the convex region that the
//! tree cuts out.

use cullet::bounds::Plane;
use glam::DVec3;

use super::map::{Bsp, Contents};
use super::scene::to_scene;
use cullet_io::reader::{Convex, numbers};
use cullet_io::{Cell, CellGraph, ErrorKind, Portal, Up};

/// Cells reach so far out of the map's box, if nothing bounds them before: in a map that leaks.
const MARGIN: f64 = 64.0;
/// Corners within so much of a plane are on it: less than what portals are off the planes of their
/// leafs.
const ON: f64 = 1e-3;
/// Leafs that are thinner than this share of their size are left out: rounding makes them, and
/// nobody fits in.
const THIN: f64 = 1e-4;
/// How thick a sky is.
const FILM: f64 = 0.01;
/// Surfaces and portals are off the planes of the tree by rounding: in Quake 3 corners are whole
/// numbers.
const WALLS: f64 = 2.0;

impl Bsp {
    /// Cells and portals in the axes of the scene that loading makes with the same `up`: the graph
    /// of [`cells`](Self::cells), and for each leaf of a cell a convex piece. All between is rock,
    /// or a surface that engines draw nothing behind.
    ///
    /// All portals are open: doors of a map are brush models, which move, so they shut none.
    ///
    /// # Errors
    /// As [`cells`](Self::cells).
    pub fn model_cells(&self, up: Option<Up>) -> Result<CellGraph, ErrorKind> {
        let graph = self.cells()?;
        let [low, high] = self.models()[0].bounds.map(DVec3::from);
        let [low, high] = [low.min(high) - MARGIN, low.max(high) + MARGIN];
        let mut cells = CellGraph { walls: WALLS, sealed: true, ..CellGraph::default() };
        cells.cells = (0..graph.cell_count())
            .map(|number| Cell { name: format!("cell {number}"), ..Cell::default() })
            .collect();
        for (number, leaf) in (0..).zip(self.leafs()) {
            let Some(cell) = leaf.cell.filter(|_| leaf.contents.is_open()) else { continue };
            let planes = self.tree().planes_of_leaf(number);
            // Of brush models, and Quake 3's first: below no node of the world, it is nowhere.
            if planes.is_empty() && self.leafs().len() > 1 {
                continue;
            }
            let Some(region) = Convex::new(planes, low.into(), high.into(), ON) else { continue };
            if is_thin(&region) {
                continue;
            }
            let turned = |plane: &Plane| numbers(&Plane::new(to_scene(plane.normal, up), plane.d));
            let planes: Vec<_> = region.faces().map(|(plane, _)| turned(plane)).collect();
            let pieces = &mut cells.cells[cell as usize].pieces;
            if leaf.contents == Contents::Sky {
                // Nobody stands in a sky: its surface has one side, and from behind there is
                // nothing to be seen of it. So it is no more than a film within its border, on
                // which its portals are.
                for (plane, _) in region.faces() {
                    let inner = Plane { d: plane.d - FILM, ..*plane }.flipped();
                    pieces.push(planes.iter().copied().chain([turned(&inner)]).collect());
                }
            } else {
                pieces.push(planes);
            }
        }
        cells.portals.extend(graph.portals().iter().map(|portal| Portal {
            cells: portal.cells,
            polygon: portal.polygon.iter().map(|p| to_scene(*p, up)).collect(),
            ..Portal::default()
        }));
        Ok(cells)
    }
}

fn is_thin(region: &Convex) -> bool {
    let (middle, size) = region.middle();
    let depths = region.faces().map(|(plane, _)| -plane.distance(middle));
    depths.fold(f64::INFINITY, f64::min) < size * THIN
}
