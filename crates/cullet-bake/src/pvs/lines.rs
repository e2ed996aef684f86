//! Lines of sight: what a straight line meets, found by walking from cell to cell.

use glam::DVec3;

use super::openings::Openings;
use crate::rows::BitRows;

/// Cells that one line is followed through, each way.
const MOST_CELLS: usize = 512;

/// Share of the tolerance by which a line must be inside of every portal that it passes: enough for
/// what is rounded.
const MARGIN: f64 = 1e-3;

/// A line through a point of an opening, which proves that all cells along it see each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) opening: u32,
    /// About the middle of the graph, as all coordinates here.
    pub(super) point: DVec3,
    pub(super) direction: DVec3,
}

/// Follows a line both ways. The cells along it, from the one behind to the one ahead; none where
/// it does not pass its opening.
///
/// Followed as if from the point in coordinates of the graph: so it gives the same cells whenever
/// it is followed again.
pub(super) fn follow(openings: &Openings, line: &Line, cells: &mut Vec<u32>) {
    cells.clear();
    let margin = openings.tolerance * MARGIN;
    let opening = openings.get(line.opening);
    let point = (line.point + openings.middle) - openings.middle;
    if opening.normal.dot(line.direction) <= 1e-6 || !openings.holds(line.opening, point, margin) {
        return;
    }
    walk(openings, opening.from, point, -line.direction, margin, cells);
    cells.reverse();
    cells.push(opening.from);
    cells.push(opening.to);
    walk(openings, opening.to, point, line.direction, margin, cells);
}

/// Goes on from a point of a cell's border, and names the cells that are entered.
fn walk(
    openings: &Openings,
    mut cell: u32,
    point: DVec3,
    direction: DVec3,
    margin: f64,
    cells: &mut Vec<u32>,
) {
    let mut at = 0.0;
    for _ in 0..MOST_CELLS {
        let mut next = None;
        let mut nearest = f64::MAX;
        for number in openings.leaving(cell) {
            let opening = openings.get(number);
            let speed = opening.normal.dot(direction);
            if speed <= 1e-6 {
                continue;
            }
            let t = (opening.d - opening.normal.dot(point)) / speed;
            // Where it is passed lies behind the last, but for what is rounded.
            if t < at - margin || t >= nearest {
                continue;
            }
            if openings.holds(number, point + direction * t, margin) {
                (nearest, next) = (t, Some(opening.to));
            }
        }
        let Some(entered) = next else { return };
        cells.push(entered);
        (cell, at) = (entered, nearest);
    }
}

/// Lines that proved something, with the cells along each.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Found {
    pub(super) lines: Vec<Line>,
    /// The cells of one line after the other.
    pub(super) cells: Vec<u32>,
    /// Where each line's cells end.
    pub(super) ends: Vec<u32>,
}

impl Found {
    pub(super) fn push(&mut self, line: Line, cells: &[u32]) {
        self.lines.push(line);
        self.cells.extend_from_slice(cells);
        self.ends.push(self.cells.len() as u32);
    }

    pub(super) fn append(&mut self, other: &Self) {
        let before = self.cells.len() as u32;
        self.lines.extend_from_slice(&other.lines);
        self.cells.extend_from_slice(&other.cells);
        self.ends.extend(other.ends.iter().map(|end| before + end));
    }

    pub(super) fn cells_of_lines(&self) -> impl Iterator<Item = &[u32]> {
        let mut first = 0;
        self.ends.iter().map(move |&end| {
            let cells = &self.cells[first..end as usize];
            first = end as usize;
            cells
        })
    }
}

/// Whether two of the cells were not known to see each other.
pub(super) fn is_new(visible: &BitRows, cells: &[u32]) -> bool {
    cells.iter().enumerate().any(|(k, &a)| {
        let row = visible.row(a);
        cells[k + 1..].iter().any(|&b| !crate::rows::has(row, b))
    })
}

/// Notes that all of the cells see each other; whether that was new.
pub(super) fn prove(visible: &mut BitRows, cells: &[u32]) -> bool {
    if !is_new(visible, cells) {
        return false;
    }
    for &a in cells {
        let row = visible.row_mut(a);
        cells.iter().for_each(|&b| crate::rows::set(row, b));
    }
    true
}
