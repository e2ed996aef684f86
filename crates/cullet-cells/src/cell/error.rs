//! Errors of cells and portals.

use thiserror::Error;

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
    /// A mirror that cannot be.
    #[error("mirror {mirror} {problem}")]
    Mirror {
        /// Its number.
        mirror: u32,
        /// The reason.
        problem: PortalProblem,
    },
    /// A piece of a cell that cannot be.
    #[error("piece {piece} {problem}")]
    Piece {
        /// Its number.
        piece: u32,
        /// The reason.
        problem: PieceProblem,
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
    /// A corner is in no piece of a cell that it joins.
    #[error(
        "is not on the border of cell {cell}: corner {corner} lies {distance:.3e} outside of all its pieces, over the \
         limit of {limit:.3e}"
    )]
    OffBorder {
        /// The cell whose border the corner is off.
        cell: u32,
        /// Number of the corner.
        corner: usize,
        /// How far outside it lies.
        distance: f64,
        /// The most that is allowed.
        limit: f64,
    },
    /// A cell reaches through it to the other side.
    #[error(
        "is not on the border of cell {cell}, or has its cells in the wrong order: at corner {corner} that cell reaches \
         {distance:.3e} to the other side, over the limit of {limit:.3e}"
    )]
    WrongSide {
        /// The cell that reaches through to the other side.
        cell: u32,
        /// Number of the corner.
        corner: usize,
        /// How far the cell reaches.
        distance: f64,
        /// The most that is allowed.
        limit: f64,
    },
}

/// Reasons for which a convex piece of a cell cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PieceProblem {
    /// It is of a cell that is not there.
    #[error("is of cell {cell}, of {cells} cells numbered from 0")]
    NoSuchCell {
        /// The cell.
        cell: u32,
        /// How many there are.
        cells: u32,
    },
    /// A plane has no direction, or a number that is not finite.
    #[error("has a plane that is none: number {0} is not finite or has no direction")]
    NoPlane(usize),
    /// Too many planes.
    #[error("has {planes} planes; it may have {limit}")]
    TooManyPlanes {
        /// How many.
        planes: usize,
        /// The most that it may have.
        limit: usize,
    },
    /// Nothing is within its planes, or nothing with a volume.
    #[error(
        "has no volume: its planes leave nothing between them; their normals must point out of it"
    )]
    NoVolume,
    /// It reaches too far.
    #[error(
        "is not closed: it reaches farther than {0:.0e} from the origin; add the planes that bound it"
    )]
    Unbounded(f64),
}
