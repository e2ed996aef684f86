//! Shapes of cells: convex pieces, checked, and found by a small tree.

use alloc::vec::Vec;

use glam::{DMat3, DVec3};

use super::error::{CellError, PieceProblem, PortalProblem};
use super::graph::{CellGraph, FLAT};
use super::locate::CellLocator;
use super::tree::{Bounds, PieceTree};
use cullet::bounds::Plane;

/// Number of pieces near a box that are listed without allocating. A small box rarely touches more.
const FEW: usize = 64;

/// A convex piece of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct CellPiece {
    /// Number of the cell that the piece belongs to.
    pub cell: u32,
    /// Planes that bound the piece. Their normals point out of it and need not have unit length.
    pub planes: Vec<Plane>,
}

impl CellPiece {
    /// Farther from the origin a piece may not reach, in world units.
    pub const REACH: f64 = 1e9;
    /// The most planes of a piece: its corners are found in time that goes by the third power of
    /// their number.
    pub const MOST_PLANES: usize = 64;

    /// The box between two corners.
    #[must_use]
    pub fn from_box(cell: u32, min: [f64; 3], max: [f64; 3]) -> Self {
        let plane = |i: usize| {
            let (axis, sign) = (i / 2, if i.is_multiple_of(2) { -1.0 } else { 1.0 });
            let mut normal = [0.0; 3];
            normal[axis] = sign;
            Plane::new(normal, sign * if i.is_multiple_of(2) { min[axis] } else { max[axis] })
        };
        Self { cell, planes: (0..6).map(plane).collect() }
    }
}

/// A piece as it is kept.
#[derive(Clone, Debug)]
struct Piece {
    cell: u32,
    /// Its planes among all.
    first: u32,
    end: u32,
    /// Around its corners, and a little more; of a box along the axes itself, to the last bit.
    bounds: Bounds,
    is_box: bool,
    /// Holds no eye.
    is_skin: bool,
}

/// Shapes of the cells of a graph: each the union of convex pieces, and walls around them.
///
/// Pieces hold what is free: where an eye may be. Pieces of one cell may overlap and need only
/// touch; those of two cells should share no more than their border. A point on a border is in both
/// cells.
///
/// ```
/// use cullet_cells::cell::{CellGraph, CellLocator, CellPiece, CellShapes, Portal};
///
/// // An L-shaped room, a room beside it, and the door between them.
/// let pieces = vec![
///     CellPiece::from_box(0, [0.0, 0.0, 0.0], [4.0, 3.0, 4.0]),
///     CellPiece::from_box(0, [0.0, 0.0, 4.0], [2.0, 3.0, 8.0]),
///     CellPiece::from_box(1, [4.0, 0.0, 0.0], [8.0, 3.0, 4.0]),
/// ];
/// // Counter-clockwise as seen from cell 0.
/// let polygon = vec![[4.0, 0.0, 1.0], [4.0, 0.0, 2.0], [4.0, 2.0, 2.0], [4.0, 2.0, 1.0]];
/// let graph = CellGraph::new(2, vec![Portal { cells: [0, 1], polygon }])?;
/// let shapes = CellShapes::new(&graph, pieces)?;
/// assert_eq!(shapes.cell_of([1.0, 1.0, 7.0]), Some(0));
/// assert_eq!(shapes.cell_of([3.0, 1.0, 7.0]), None);
/// # Ok::<(), cullet_cells::cell::CellError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct CellShapes {
    pieces: Vec<Piece>,
    planes: Vec<Plane>,
    tree: PieceTree,
    walls: f64,
    is_sealed: bool,
}

impl CellShapes {
    /// Checks pieces, and that the portals and mirrors of the graph are on the borders of their
    /// cells. A cell without a piece is nowhere.
    ///
    /// Cost: for each piece the third power of its planes, and n·log² n of the pieces.
    ///
    /// # Errors
    /// If a piece has no volume, is not closed, has too many planes, or one that is none; if a
    /// corner of a portal lies off the border of a cell that it joins by more than a thousandth of
    /// the portal's size, or its cells are on the wrong sides.
    pub fn new(graph: &CellGraph, pieces: Vec<CellPiece>) -> Result<Self, CellError> {
        Self::with_skins(graph, pieces, Vec::new())
    }

    /// The same with skins: pieces in which surfaces stand, so that no eye may be there. What
    /// stands in them is of their cell, and portals may be on their borders; but a point in them is
    /// in no cell. They are numbered behind the other pieces.
    ///
    /// # Errors
    /// As of [`new`](Self::new).
    pub fn with_skins(
        graph: &CellGraph,
        pieces: Vec<CellPiece>,
        skins: Vec<CellPiece>,
    ) -> Result<Self, CellError> {
        let mut shapes = Self::default();
        let free = pieces.len() as u32;
        let mut corners = Vec::with_capacity(pieces.len() + skins.len());
        for (number, piece) in (0..).zip(pieces.iter().chain(&skins)) {
            let at = |problem| CellError::Piece { piece: number, problem };
            let (cell, cells) = (piece.cell, graph.cell_count());
            if cell >= cells {
                return Err(at(PieceProblem::NoSuchCell { cell, cells }));
            }
            let first = shapes.planes.len();
            for (i, plane) in piece.planes.iter().enumerate() {
                let plane = plane.normalized().filter(Plane::is_finite);
                shapes.planes.push(plane.ok_or_else(|| at(PieceProblem::NoPlane(i)))?);
            }
            let own = corners_of(&shapes.planes[first..]).map_err(at)?;
            let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
            for corner in &own {
                for a in 0..3 {
                    // Corners are off by their rounding, and its planes decide.
                    let slack = 1e-9 * (1.0 + corner[a].abs());
                    bounds[0][a] = bounds[0][a].min(corner[a] - slack);
                    bounds[1][a] = bounds[1][a].max(corner[a] + slack);
                }
            }
            let sides = sides_of(&shapes.planes[first..]);
            let (first, end) = (first as u32, shapes.planes.len() as u32);
            let (bounds, is_box) = (sides.unwrap_or(bounds), sides.is_some());
            let is_skin = number >= free;
            shapes.pieces.push(Piece { cell, first, end, bounds, is_box, is_skin });
            corners.push(own);
        }
        let boxes: Vec<Bounds> = shapes.pieces.iter().map(|piece| piece.bounds).collect();
        shapes.tree = PieceTree::new(&boxes);
        for (number, portal) in (0..).zip(graph.portals()) {
            let at = |problem| CellError::Portal { portal: number, problem };
            for (cell, side) in [(portal.cells[0], 1.0), (portal.cells[1], -1.0)] {
                shapes
                    .check_border(&corners, &portal.polygon, graph.plane(number), cell, side)
                    .map_err(at)?;
            }
        }
        for (number, mirror) in (0..).zip(graph.mirrors()) {
            let at = |problem| CellError::Mirror { mirror: number, problem };
            let plane = graph.mirror_plane(number);
            shapes.check_border(&corners, &mirror.polygon, plane, mirror.cell, 1.0).map_err(at)?;
        }
        Ok(shapes)
    }

    /// The same with walls around the pieces, so thick, in world units. What lies within so much of
    /// a piece's planes is within cells and walls; what lies within half of it belongs to the
    /// piece's cell, for there stands what bounds it; but no eye is there. Default 0. A thickness
    /// that is not above zero is none.
    #[must_use]
    pub fn with_walls(self, walls: f64) -> Self {
        Self { walls: if walls > 0.0 { walls } else { 0.0 }, ..self }
    }

    /// The same, in which all that is in no cell is solid: nothing is seen there, and no cell from
    /// there. Otherwise instances that reach out of cells and walls are seen from everywhere.
    #[must_use]
    pub fn sealed(self) -> Self {
        Self { is_sealed: true, ..self }
    }

    /// How many pieces there are.
    #[must_use]
    pub fn piece_count(&self) -> u32 {
        self.pieces.len() as u32
    }

    /// The cell of a piece, and its planes, of unit length.
    #[must_use]
    pub fn piece(&self, number: u32) -> (u32, &[Plane]) {
        let piece = &self.pieces[number as usize];
        (piece.cell, self.planes_of(piece))
    }

    fn planes_of(&self, piece: &Piece) -> &[Plane] {
        &self.planes[piece.first as usize..piece.end as usize]
    }

    /// Whether a point is in a piece, its border included.
    #[inline]
    fn is_in(&self, piece: &Piece, p: [f64; 3]) -> bool {
        if piece.is_box {
            let [min, max] = &piece.bounds;
            return (0..3).all(|a| min[a] <= p[a] && p[a] <= max[a]);
        }
        self.planes_of(piece).iter().all(|plane| plane.distance(p) <= 0.0)
    }

    /// How far a point is outside of a piece, at the most of its planes.
    fn excess(&self, piece: &Piece, p: [f64; 3]) -> f64 {
        let planes = self.planes_of(piece).iter();
        planes.map(|plane| plane.distance(p)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Checks that a polygon is on the border of a cell that is on one side of its plane.
    fn check_border(
        &self,
        corners: &[Vec<DVec3>],
        polygon: &[[f64; 3]],
        plane: &Plane,
        cell: u32,
        side: f64,
    ) -> Result<(), PortalProblem> {
        let limit = super::graph::size_of(polygon) * FLAT;
        let middle = polygon.iter().map(|p| DVec3::from(*p)).sum::<DVec3>() / polygon.len() as f64;
        for (corner, p) in polygon.iter().enumerate() {
            // A little inward, where the piece is that it belongs to, and not one that touches it
            // there.
            let p = DVec3::from(*p).lerp(middle, 1e-3);
            let grown = [(p - limit).to_array(), (p + limit).to_array()];
            let (mut nearest, mut reaches) = (f64::INFINITY, f64::INFINITY);
            self.tree.visit(&grown, |number| {
                let piece = &self.pieces[number as usize];
                if piece.cell != cell {
                    return;
                }
                let excess = self.excess(piece, p.into());
                nearest = nearest.min(excess);
                if excess <= limit {
                    let heights = corners[number as usize].iter();
                    let other = heights.map(|c| -plane.distance(*c) * side);
                    reaches = reaches.min(other.fold(f64::NEG_INFINITY, f64::max));
                }
            });
            if nearest > limit {
                let pieces = self.pieces.iter().filter(|piece| piece.cell == cell);
                let distance =
                    pieces.map(|piece| self.excess(piece, p.into())).fold(f64::INFINITY, f64::min);
                return Err(PortalProblem::OffBorder { cell, corner, distance, limit });
            }
            if reaches > limit {
                return Err(PortalProblem::WrongSide { cell, corner, distance: reaches, limit });
            }
        }
        Ok(())
    }

    /// Whether a box is in pieces grown by `reach`, with skins or without.
    fn holds(&self, b: &Bounds, reach: f64, skins: bool) -> bool {
        let grown = [b[0].map(|v| v - reach), b[1].map(|v| v + reach)];
        // A frame does this for its near plane, and allocates nothing.
        let (mut few, mut count) = ([0; FEW], 0);
        let counts = |number: u32| skins || !self.pieces[number as usize].is_skin;
        self.tree.visit(&grown, |number| {
            if !counts(number) {
                return;
            }
            if let Some(near) = few.get_mut(count) {
                *near = number;
            }
            count += 1;
        });
        let mut budget = 512;
        if count <= FEW {
            return self.holds_part(b, reach, &few[..count], &mut budget);
        }
        let mut near = Vec::with_capacity(count);
        self.tree.visit(&grown, |number| {
            if counts(number) {
                near.push(number);
            }
        });
        self.holds_part(b, reach, &near, &mut budget)
    }

    /// Whether a part of it is, by halves: cut at the sides of pieces, for most stand along the
    /// axes.
    fn holds_part(&self, b: &Bounds, reach: f64, near: &[u32], budget: &mut u32) -> bool {
        let [min, max] = b;
        // Boxes of instances are rounded outward to f32.
        let slack =
            (0..3).map(|a| min[a].abs().max(max[a].abs())).fold(0.0, f64::max) * 4e-7 + 4e-9;
        let mut cut = None;
        for &number in near {
            let piece = &self.pieces[number as usize];
            let outermost = self.planes_of(piece).iter().map(|plane| {
                let far = |a: usize| if plane.normal[a] > 0.0 { max[a] } else { min[a] };
                plane.distance([far(0), far(1), far(2)])
            });
            if outermost.fold(f64::NEG_INFINITY, f64::max) <= reach + slack {
                return true;
            }
            for a in 0..3 {
                let sides = [piece.bounds[0][a] - reach, piece.bounds[1][a] + reach];
                let inside = sides.into_iter().find(|&v| v > min[a] + slack && v < max[a] - slack);
                cut = cut.or(inside.map(|v| (a, v)));
            }
        }
        let Some((axis, at)) = cut.filter(|_| *budget > 1) else { return false };
        *budget -= 2;
        let (mut low, mut high) = (*b, *b);
        (low[1][axis], high[0][axis]) = (at, at);
        self.holds_part(&low, reach, near, budget) && self.holds_part(&high, reach, near, budget)
    }
}

impl CellLocator for CellShapes {
    /// Cost: logarithmic, where pieces do not overlap much.
    fn cell_of(&self, point: [f64; 3]) -> Option<u32> {
        // No cell has the last number: it is below how many there are.
        let mut found = u32::MAX;
        self.tree.visit(&[point, point], |number| {
            let piece = &self.pieces[number as usize];
            if piece.cell < found && !piece.is_skin && self.is_in(piece, point) {
                found = piece.cell;
            }
        });
        (found != u32::MAX).then_some(found)
    }

    fn cells_touching(&self, min: [f64; 3], max: [f64; 3], cells: &mut Vec<u32>) {
        let half = self.walls * 0.5;
        let grown = [min.map(|v| v - half), max.map(|v| v + half)];
        self.tree.visit(&grown, |number| {
            let piece = &self.pieces[number as usize];
            let touches = self.planes_of(piece).iter().all(|plane| {
                let near = |a: usize| if plane.normal[a] > 0.0 { min[a] } else { max[a] };
                let near = [near(0), near(1), near(2)];
                let slack = 1e-9 * (1.0 + near.iter().map(|v| v.abs()).fold(0.0, f64::max));
                plane.distance(near) <= half + slack
            });
            if touches {
                cells.push(piece.cell);
            }
        });
    }

    /// Tests by halves: a box that lies in no single piece is cut at a side of a piece's box, and
    /// both halves are tested. The test is exact where pieces are boxes along the axes, for up to
    /// 256 cuts. A box that needs more cuts counts as reaching out. Where other pieces meet along
    /// slanted sides, a part of the box that lies in no single one of them counts as reaching out.
    fn is_within(&self, min: [f64; 3], max: [f64; 3]) -> bool {
        self.is_sealed || self.holds(&[min, max], self.walls, true)
    }

    fn is_free(&self, min: [f64; 3], max: [f64; 3]) -> bool {
        self.holds(&[min, max], 0.0, false)
    }

    fn walls(&self) -> f64 {
        self.walls
    }
}

/// The sides of a box along the axes; `None` of what is no such box, or has more planes than six.
fn sides_of(planes: &[Plane]) -> Option<Bounds> {
    let mut sides = [[f64::NAN; 3], [f64::NAN; 3]];
    for plane in planes {
        let axis = plane.normal.iter().position(|n| n.abs() == 1.0)?;
        if plane.normal.iter().filter(|n| **n != 0.0).count() > 1 {
            return None;
        }
        let is_high = plane.normal[axis] > 0.0;
        sides[usize::from(is_high)][axis] = if is_high { plane.d } else { -plane.d };
    }
    let is_whole = planes.len() == 6 && sides.iter().flatten().all(|v| !v.is_nan());
    is_whole.then_some(sides)
}

/// The corners of a convex piece.
fn corners_of(planes: &[Plane]) -> Result<Vec<DVec3>, PieceProblem> {
    if planes.len() > CellPiece::MOST_PLANES {
        let limit = CellPiece::MOST_PLANES;
        return Err(PieceProblem::TooManyPlanes { planes: planes.len(), limit });
    }
    // With the sides of a large box, on which what is not closed has corners.
    let reach = CellPiece::REACH;
    let mut all = planes.to_vec();
    all.extend(CellPiece::from_box(0, [-2.0 * reach; 3], [2.0 * reach; 3]).planes);
    let mut corners = Vec::new();
    let planes: Vec<(DVec3, f64)> = all.iter().map(|p| (DVec3::from(p.normal), p.d)).collect();
    for (i, (a, da)) in planes.iter().enumerate() {
        for (j, (b, db)) in planes.iter().enumerate().skip(i + 1) {
            for (c, dc) in &planes[j + 1..] {
                let m = DMat3::from_cols(*a, *b, *c).transpose();
                if m.determinant().abs() < 1e-9 {
                    continue;
                }
                let p = m.inverse() * DVec3::new(*da, *db, *dc);
                let slack = 1e-7 * (1.0 + p.length());
                if planes.iter().all(|(n, d)| n.dot(p) - d <= slack) {
                    corners.push(p);
                }
            }
        }
    }
    if corners.is_empty() {
        return Err(PieceProblem::NoVolume);
    }
    if corners.iter().any(|p| p.abs().max_element() > reach) {
        return Err(PieceProblem::Unbounded(reach));
    }
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let size = corners.iter().map(|p| (p - middle).length()).fold(0.0, f64::max);
    // The middle of what has a volume is inside of every plane by a share of its size.
    if planes.iter().any(|(n, d)| n.dot(middle) - d > -1e-6 * size) {
        return Err(PieceProblem::NoVolume);
    }
    Ok(corners)
}
