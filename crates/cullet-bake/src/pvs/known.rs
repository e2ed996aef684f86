//! Knowledge of which cells see each other, before and between rounds.

use super::flood::candidates;
use super::lines::prove;
use super::openings::Openings;
use super::unit::UnitResult;
use crate::rows::{BitRows, clear, count, has, ones, set};
use crate::threads;

/// Knowledge at the start of a round, constant during it.
#[derive(Clone, Debug)]
pub(super) struct Known {
    /// Cells that may be seen through each opening.
    pub(super) might: BitRows,
    /// Cells that each cell may see.
    pub(super) possible: BitRows,
    /// Cells that a line proves visible from each cell.
    pub(super) visible: BitRows,
}

impl Known {
    /// Returns what floods through whole portals leave possible.
    pub(super) fn new(openings: &Openings, threads: usize) -> Self {
        let cells = openings.cells();
        let mut known = Self {
            might: BitRows::new(openings.len(), cells),
            possible: BitRows::new(cells, cells),
            visible: BitRows::new(cells, cells),
        };
        let width = known.might.width();
        let rows = threads::run(
            threads,
            cells as usize,
            Vec::new,
            |stack, cell| {
                let leaving = openings.leaving(cell as u32);
                let mut rows = vec![0; width * leaving.len()];
                for (k, opening) in leaving.enumerate() {
                    candidates(openings, opening, &mut rows[k * width..][..width], stack);
                }
                rows
            },
            || true,
        );
        // Nobody stops it.
        for (cell, rows) in rows.unwrap_or_default().iter().enumerate() {
            let first = openings.leaving(cell as u32).start as usize * width;
            known.might.words_mut()[first..first + rows.len()].copy_from_slice(rows);
        }
        for cell in 0..cells {
            known.visible.set(cell, cell);
            let row = known.seen_from(openings, cell);
            known.possible.row_mut(cell).copy_from_slice(&row);
        }
        known.possible.keep_symmetric();
        // A second time finds what the first made possible to find; a third finds next to nothing.
        known.tighten(openings);
        known.tighten(openings);
        known
    }

    /// Cells that may be seen from a cell, though no line proves it.
    pub(super) fn open(&self, cell: u32) -> Vec<u64> {
        let rows = self.possible.row(cell).iter().zip(self.visible.row(cell));
        rows.map(|(p, v)| p & !v).collect()
    }

    /// How many cells may be seen from a cell.
    pub(super) fn candidates(&self, cell: u32) -> u64 {
        count(self.possible.row(cell))
    }

    /// A cell, and what may be seen through its openings.
    fn seen_from(&self, openings: &Openings, cell: u32) -> Vec<u64> {
        let mut row = vec![0; self.possible.width()];
        set(&mut row, cell);
        for opening in openings.leaving(cell) {
            row.iter_mut().zip(self.might.row(opening)).for_each(|(a, b)| *a |= b);
        }
        row
    }

    /// Whatever is hidden from a cell is not seen through its openings, nor through those that lead
    /// to it.
    fn narrow(&mut self, openings: &Openings) {
        for number in 0..openings.len() {
            let opening = openings.get(number);
            let (a, b) = (self.possible.row(opening.from), self.possible.row(opening.to));
            for (k, word) in self.might.row_mut(number).iter_mut().enumerate() {
                *word &= a[k] & b[k];
            }
        }
    }

    /// A cell can be seen through an opening only if the cells before and behind that can be seen
    /// back through one of the cell's own.
    fn tighten(&mut self, openings: &Openings) {
        self.narrow(openings);
        for number in 0..openings.len() {
            let opening = openings.get(number);
            let row = self.might.row(number).to_vec();
            for cell in ones(&row) {
                let sees = |back: u32| {
                    let row = self.might.row(back);
                    has(row, opening.from) && (cell == opening.to || has(row, opening.to))
                };
                if !openings.leaving(cell).any(sees) {
                    clear(self.might.row_mut(number), cell);
                }
            }
        }
        for cell in 0..openings.cells() {
            let row = self.seen_from(openings, cell);
            self.possible.row_mut(cell).iter_mut().zip(row).for_each(|(a, b)| *a &= b);
        }
        self.possible.keep_symmetric();
        self.narrow(openings);
    }

    /// Takes in what a unit found, and hands on the lines that proved something new.
    pub(super) fn merge(&mut self, result: &UnitResult, mut proved: impl FnMut(usize)) {
        for &[a, b] in &result.hidden {
            self.possible.clear(a, b);
            self.possible.clear(b, a);
        }
        let width = self.might.width();
        for (k, &opening) in result.closed.iter().enumerate() {
            let lost = &result.closed_rows[k * width..][..width];
            self.might.row_mut(opening).iter_mut().zip(lost).for_each(|(m, l)| *m &= !l);
        }
        for (k, cells) in result.found.cells_of_lines().enumerate() {
            if prove(&mut self.visible, cells) {
                proved(k);
            }
        }
    }

    /// The end of a round: what it found reaches the openings.
    pub(super) fn settle(&mut self, openings: &Openings) {
        // What a line proves is possible, whatever rounding made of a flood.
        self.possible.words_mut().iter_mut().zip(self.visible.words()).for_each(|(p, v)| *p |= v);
        self.narrow(openings);
    }

    /// Bytes in memory.
    pub(super) fn bytes(&self) -> u64 {
        self.might.bytes() + self.possible.bytes() + self.visible.bytes()
    }
}
