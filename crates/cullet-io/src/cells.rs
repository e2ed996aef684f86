//! Cells and portals as a model has them: plain values with names, of which the engine's graph and
//! shapes are made.

use cullet::Handle;
use cullet::bounds::Plane;
use cullet_cells::cell::{self, CellError, CellPiece, CellShapes};
use serde::{Deserialize, Serialize};

use crate::convex::Convex;

/// A region of space: a room, or a part of one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Its name; may be empty.
    pub name: String,
    /// Convex pieces whose union it is, each by what it is within: planes `[nx, ny, nz, d]` with
    /// n·x ≤ d inside. A cell without pieces is nowhere.
    pub pieces: Vec<Vec<[f64; 4]>>,
    /// Convex pieces of it where surfaces stand: what stands there is of the cell, but no eye is
    /// there. See [`CellShapes::with_skins`].
    #[serde(default)]
    pub skins: Vec<Vec<[f64; 4]>>,
}

impl Cell {
    /// A cell that is the box between two corners.
    #[must_use]
    pub fn from_box(name: impl Into<String>, min: [f64; 3], max: [f64; 3]) -> Self {
        Self { name: name.into(), pieces: vec![box_planes(min, max)], ..Self::default() }
    }

    /// Whether a point is in a piece of it, border included.
    #[must_use]
    pub fn contains(&self, point: [f64; 3]) -> bool {
        let within = |p: &[f64; 4]| p[0] * point[0] + p[1] * point[1] + p[2] * point[2] <= p[3];
        self.pieces.iter().any(|planes| planes.iter().all(within))
    }

    /// The lowest and highest corner of its first piece, of a room that which holds most of it;
    /// `None` where that has no volume. Cost: of n planes, n³ at the most.
    #[must_use]
    pub fn main_bounds(&self) -> Option<[[f64; 3]; 2]> {
        convex_of(self.pieces.first()?)?.bounds()
    }

    /// The volume of its pieces; what two of them share counts twice.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.pieces.iter().filter_map(|planes| Some(convex_of(planes)?.volume())).sum()
    }
}

/// An opening between two cells.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Portal {
    /// Its name; may be empty.
    pub name: String,
    /// The cells that it joins, by number.
    pub cells: [u32; 2],
    /// Its corners: a planar convex polygon, counter-clockwise as seen from the first cell.
    pub polygon: Vec<[f64; 3]>,
    /// The instance that fills the opening when shut: a door's leaf.
    pub door: Option<Handle>,
    /// Whether that door is shut, so that nothing is seen through.
    pub closed: bool,
    /// Whether it is seen through from the first cell alone.
    pub one_way: bool,
}

/// A mirror on the border of a cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mirror {
    /// Its name; may be empty.
    pub name: String,
    /// The cell that it is seen from, by number.
    pub cell: u32,
    /// Its corners: a planar convex polygon, counter-clockwise as seen from the cell.
    pub polygon: Vec<[f64; 3]>,
}

/// Cells, and the portals between them, in the world space of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellGraph {
    /// The cells.
    pub cells: Vec<Cell>,
    /// The portals.
    pub portals: Vec<Portal>,
    /// The mirrors.
    pub mirrors: Vec<Mirror>,
    /// How thick the walls between cells are, at the most; see [`CellShapes::with_walls`].
    pub walls: f64,
    /// Whether all that is in no cell is solid; see [`CellShapes::sealed`].
    pub sealed: bool,
}

impl CellGraph {
    /// The engine's graph and shapes. Portals that are closed are shut. Cost: that of
    /// [`CellShapes::new`].
    ///
    /// # Errors
    /// As of [`cell::CellGraph::new`], [`cell::CellGraph::with_mirrors`] and [`CellShapes::new`].
    /// Pieces are numbered through all cells; [`piece_place`](Self::piece_place) says which it is.
    pub fn build(&self) -> Result<(cell::CellGraph, CellShapes), CellError> {
        let portals = self.portals.iter();
        let portals = portals.map(|p| cell::Portal { cells: p.cells, polygon: p.polygon.clone() });
        let mirrors = self.mirrors.iter();
        let mirrors = mirrors.map(|m| cell::Mirror { cell: m.cell, polygon: m.polygon.clone() });
        let graph = cell::CellGraph::new(self.cells.len() as u32, portals.collect())?;
        let mut graph = graph.with_mirrors(mirrors.collect())?;
        for (number, portal) in (0..).zip(&self.portals) {
            graph.set_open(number, !portal.closed);
            graph.set_one_way(number, portal.one_way);
        }
        let of = |which: fn(&Cell) -> &Vec<Vec<[f64; 4]>>| {
            let pieces = (0..).zip(&self.cells).flat_map(move |(cell, own)| {
                let planes = which(own).iter().map(|planes| planes.iter().map(plane).collect());
                planes.map(move |planes| CellPiece { cell, planes })
            });
            pieces.collect()
        };
        let shapes = CellShapes::with_skins(&graph, of(|c| &c.pieces), of(|c| &c.skins))?;
        let shapes = shapes.with_walls(self.walls);
        Ok((graph, if self.sealed { shapes.sealed() } else { shapes }))
    }

    /// The cell of a piece by its number through all cells, skins behind all pieces; and its number
    /// within that cell, skins behind its pieces.
    #[must_use]
    pub fn piece_place(&self, piece: u32) -> Option<(u32, u32)> {
        let pieces = (0..).zip(&self.cells).map(|(cell, c)| (cell, 0, c.pieces.len()));
        let skins =
            (0..).zip(&self.cells).map(|(cell, c)| (cell, c.pieces.len() as u32, c.skins.len()));
        let mut left = piece as usize;
        for (cell, first, count) in pieces.chain(skins) {
            match left.checked_sub(count) {
                None => return Some((cell, first + left as u32)),
                Some(rest) => left = rest,
            }
        }
        None
    }
}

/// The planes of the box between two corners, as [`Cell::pieces`] has them.
pub fn box_planes(min: [f64; 3], max: [f64; 3]) -> Vec<[f64; 4]> {
    CellPiece::from_box(0, min, max).planes.iter().map(numbers).collect()
}

/// A plane of a piece.
pub fn plane(&[x, y, z, d]: &[f64; 4]) -> Plane {
    Plane::new([x, y, z], d)
}

/// A plane as [`Cell::pieces`] has it.
pub fn numbers(plane: &Plane) -> [f64; 4] {
    let [x, y, z] = plane.normal;
    [x, y, z, plane.d]
}

/// A piece, if it has a volume and reaches no farther than pieces may.
fn convex_of(planes: &[[f64; 4]]) -> Option<Convex> {
    let planes: Option<Vec<Plane>> = planes.iter().map(|p| plane(p).normalized()).collect();
    let (planes, reach) = (planes?, CellPiece::REACH);
    // Cut out of so large a box corners are off by its rounding; out of a box about what is left
    // they are not.
    let [low, high] = Convex::new(planes.clone(), [-reach; 3], [reach; 3], 1e-6)?.bounds()?;
    Convex::new(planes, low.map(|v| v - 1.0), high.map(|v| v + 1.0), 1e-9)
}
