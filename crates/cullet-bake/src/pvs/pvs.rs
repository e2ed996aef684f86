//! The result of a bake, its states and its file.

use cullet::cell::CellGraph;
use glam::DVec3;
use thiserror::Error;

use super::hash::{hash, hash_of};
use super::known::Known;
use super::lines::{Line, follow, prove};
use super::openings::Openings;
use super::rows::BitRows;

/// A line of sight: all cells along it see each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// A portal that the line passes.
    pub portal: u32,
    /// Whether it passes from the portal's first cell to its second.
    pub forward: bool,
    /// Where it passes.
    pub point: [f64; 3],
    /// In which direction, of unit length.
    pub direction: [f64; 3],
}

/// State of a pair of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairState {
    /// A line of sight was found.
    Visible,
    /// Planes part the portals between them, whichever way.
    Hidden,
    /// Neither; it is kept.
    Undecided,
}

/// Which cells see each other.
///
/// Conservative: whatever is not proven hidden is in the sets. [`Self::undecided`] is how much they may be too large by.
#[derive(Clone, Debug, PartialEq)]
pub struct Pvs {
    graph: u64,
    key: u64,
    visible: BitRows,
    proven: BitRows,
    candidates: u64,
    witnesses: Vec<Witness>,
}

impl Pvs {
    pub(super) fn new(
        openings: &Openings,
        key: u64,
        known: Known,
        candidates: u64,
        lines: &[Line],
    ) -> Self {
        let witness = |line: &Line| {
            let opening = openings.get(line.opening);
            Witness {
                portal: opening.portal,
                forward: opening.forward,
                point: (line.point + openings.middle).to_array(),
                direction: line.direction.to_array(),
            }
        };
        Self {
            graph: openings.hash,
            key,
            visible: known.possible,
            proven: known.visible,
            candidates,
            witnesses: lines.iter().map(witness).collect(),
        }
    }

    /// How many cells there are.
    #[must_use]
    pub fn cell_count(&self) -> u32 {
        self.visible.columns()
    }

    /// The sets: bit b of row a is 1 where cell a may see cell b. Symmetric, and every cell sees itself.
    #[must_use]
    pub fn visible(&self) -> &BitRows {
        &self.visible
    }

    /// The part of the sets that lines of sight prove.
    #[must_use]
    pub fn proven(&self) -> &BitRows {
        &self.proven
    }

    /// Lines that prove that part.
    #[must_use]
    pub fn witnesses(&self) -> &[Witness] {
        &self.witnesses
    }

    /// State of a pair of cells.
    #[must_use]
    pub fn state(&self, a: u32, b: u32) -> PairState {
        match (self.proven.has(a, b), self.visible.has(a, b)) {
            (true, _) => PairState::Visible,
            (false, true) => PairState::Undecided,
            (false, false) => PairState::Hidden,
        }
    }

    /// Ordered pairs in the sets, a cell with itself not counted.
    #[must_use]
    pub fn visible_pairs(&self) -> u64 {
        self.visible.count() - u64::from(self.cell_count())
    }

    /// Those of them that a line proves.
    #[must_use]
    pub fn proven_pairs(&self) -> u64 {
        self.proven.count() - u64::from(self.cell_count())
    }

    /// Those of them that are only kept.
    #[must_use]
    pub fn undecided(&self) -> u64 {
        self.visible_pairs() - self.proven_pairs()
    }

    /// Ordered pairs that a flood through whole portals left to be decided.
    #[must_use]
    pub fn candidates(&self) -> u64 {
        self.candidates
    }

    /// Hash of graph and settings.
    #[must_use]
    pub fn key(&self) -> u64 {
        self.key
    }

    /// Hash of the rows as [`Self::rows_bytes`] has them.
    #[must_use]
    pub fn rows_hash(&self) -> u64 {
        hash(&self.rows_bytes())
    }

    /// The rows as tools exchange them: `PVSROWS1`, the number of cells and the bytes of a row as u32, little-endian, then
    /// the rows; bit b of row a is bit b mod 8 of its byte b / 8.
    #[must_use]
    pub fn rows_bytes(&self) -> Vec<u8> {
        self.visible.to_exchange()
    }

    /// What the witnesses prove when they are followed once more; equal to [`Self::proven`].
    ///
    /// # Errors
    /// If the graph is not the one that was baked.
    pub fn prove_again(&self, graph: &CellGraph) -> Result<BitRows, PvsFileError> {
        self.check_graph(graph)?;
        let openings = Openings::new(graph, 1e-6);
        let mut proven = BitRows::new(self.cell_count(), self.cell_count());
        (0..self.cell_count()).for_each(|cell| proven.set(cell, cell));
        let mut cells = Vec::new();
        for w in &self.witnesses {
            let line = Line {
                opening: openings.of_portal(w.portal, w.forward),
                point: DVec3::from(w.point) - openings.middle,
                direction: w.direction.into(),
            };
            follow(&openings, &line, &mut cells);
            prove(&mut proven, &cells);
        }
        Ok(proven)
    }

    /// Whether these are a graph's sets.
    ///
    /// # Errors
    /// If they are another's.
    pub fn check_graph(&self, graph: &CellGraph) -> Result<(), PvsFileError> {
        let (found, expected) = (self.graph, hash_of(graph));
        if found == expected { Ok(()) } else { Err(PvsFileError::OtherGraph { found, expected }) }
    }
}

/// The first bytes of a file, the last of them the version.
const MAGIC: &[u8; 8] = b"CULLPVS1";
/// Bytes before the rows.
const HEADER: usize = 8 + 3 * 8 + 4 + 4;
const WITNESS: usize = 4 + 6 * 8;

/// Reason for which bytes are no sets of cells, or not those of a graph.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PvsFileError {
    /// They begin otherwise.
    #[error("it does not begin with CULLPVS1: no file of cullet pvs, or one of another version")]
    Magic,
    /// They are too few or too many.
    #[error("{found} bytes, but its header says {expected}: cut short?")]
    Size {
        /// How many there are.
        found: u64,
        /// How many there should be.
        expected: u64,
    },
    /// The checksum is wrong.
    #[error("its checksum is wrong: damaged")]
    Damaged,
    /// They are of another graph.
    #[error(
        "it was baked from another map: hash {found:016x}, this one has {expected:016x}; bake it again"
    )]
    OtherGraph {
        /// Hash of the graph that was baked.
        found: u64,
        /// Hash of this one.
        expected: u64,
    },
}

impl Pvs {
    /// The bytes of a file: little-endian, with a checksum at the end.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        [self.graph, self.key, self.candidates].iter().for_each(|v| out.extend(v.to_le_bytes()));
        out.extend(self.cell_count().to_le_bytes());
        out.extend((self.witnesses.len() as u32).to_le_bytes());
        for word in self.visible.words().iter().chain(self.proven.words()) {
            out.extend(word.to_le_bytes());
        }
        for w in &self.witnesses {
            // The lowest bit is the direction.
            out.extend((w.portal << 1 | u32::from(w.forward)).to_le_bytes());
            w.point.iter().chain(&w.direction).for_each(|v| out.extend(v.to_le_bytes()));
        }
        out.extend(hash(&out).to_le_bytes());
        out
    }

    /// Reads such bytes.
    ///
    /// # Errors
    /// If they begin otherwise, are cut short, or were changed.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PvsFileError> {
        if !bytes.starts_with(MAGIC) {
            return Err(PvsFileError::Magic);
        }
        let found = bytes.len() as u64;
        let size = |expected: u64| PvsFileError::Size { found, expected };
        let header = bytes.get(..HEADER).ok_or(size(HEADER as u64 + 8))?;
        let long = |at: usize| u64::from_le_bytes(std::array::from_fn(|k| header[at + k]));
        let short = |at: usize| u32::from_le_bytes(std::array::from_fn(|k| header[at + k]));
        let (cells, lines) = (short(32), short(36));
        let words = u64::from(cells) * u64::from(cells.div_ceil(64)) * 2;
        let expected = HEADER as u64 + words * 8 + u64::from(lines) * WITNESS as u64 + 8;
        if found != expected {
            return Err(size(expected));
        }
        let (body, sum) = bytes.split_at(bytes.len() - 8);
        if hash(body).to_le_bytes() != sum {
            return Err(PvsFileError::Damaged);
        }
        let (rows, rest) = body[HEADER..].split_at(words as usize * 8);
        let mut words = rows.as_chunks::<8>().0.iter().map(|w| u64::from_le_bytes(*w));
        let mut read = || {
            let mut rows = BitRows::new(cells, cells);
            rows.words_mut().iter_mut().for_each(|w| *w = words.next().unwrap_or(0));
            rows
        };
        let (visible, proven) = (read(), read());
        let witness = |w: &[u8; WITNESS]| {
            let first = u32::from_le_bytes([w[0], w[1], w[2], w[3]]);
            let float = |k: usize| f64::from_le_bytes(std::array::from_fn(|i| w[4 + k * 8 + i]));
            Witness {
                portal: first >> 1,
                forward: first & 1 != 0,
                point: std::array::from_fn(float),
                direction: std::array::from_fn(|k| float(3 + k)),
            }
        };
        let witnesses = rest.as_chunks::<WITNESS>().0.iter().map(witness).collect();
        Ok(Self { graph: long(8), key: long(16), visible, proven, candidates: long(24), witnesses })
    }
}
