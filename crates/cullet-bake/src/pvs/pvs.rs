//! The result of a bake, its states and its file.

use cullet_cells::cell::CellGraph;
use cullet_cells::pvs::{Targets, VisibleSets};
use cullet_io::baked::{CellSets, Container, PvsFileError, graph_hash, hash, write_chunks};
use glam::DVec3;

use super::known::Known;
use super::lines::{Line, follow, prove};
use super::openings::Openings;
use crate::rows::BitRows;

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

/// Visible sets of cells.
///
/// Conservative: whatever is not proven hidden is in the sets. [`Self::undecided`] is the number of
/// pairs by which they may be too large.
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

    /// The sets: bit b of row a is 1 where cell a may see cell b. Symmetric, and every cell sees
    /// itself.
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

    /// Returns the number of visible pairs that a line proves.
    #[must_use]
    pub fn proven_pairs(&self) -> u64 {
        self.proven.count() - u64::from(self.cell_count())
    }

    /// Returns the number of visible pairs that are kept without proof.
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

    /// The rows as tools exchange them: `PVSROWS1`, the number of cells and the bytes of a row as
    /// u32, little-endian, then the rows; bit b of row a is bit b mod 8 of its byte b / 8.
    #[must_use]
    pub fn rows_bytes(&self) -> Vec<u8> {
        self.visible.to_exchange()
    }

    /// Returns what the witnesses prove when they are followed once more; equal to
    /// [`Self::proven`].
    ///
    /// # Errors
    /// If the graph is not the one that was baked.
    pub fn prove_again(&self, graph: &CellGraph) -> Result<BitRows, PvsFileError> {
        self.check_graph(graph)?;
        let openings = Openings::new(graph, 1e-6);
        let mut proven = BitRows::new(self.cell_count(), self.cell_count());
        (0..self.cell_count()).for_each(|cell| proven.set(cell, cell));
        let mut cells = Vec::new();
        for (_, line) in self.followed(&openings) {
            follow(&openings, &line, &mut cells);
            prove(&mut proven, &cells);
        }
        Ok(proven)
    }

    /// The lines, as they are followed.
    fn followed(&self, openings: &Openings) -> impl Iterator<Item = (Witness, Line)> {
        let portals = openings.portals();
        self.witnesses.iter().filter(move |w| w.portal < portals).map(|w| {
            let line = Line {
                opening: openings.of_portal(w.portal, w.forward),
                point: DVec3::from(w.point) - openings.middle,
                direction: w.direction.into(),
            };
            (*w, line)
        })
    }

    /// A line of sight between two cells: proof that they see each other. `None` where they do not,
    /// where that is [undecided](PairState::Undecided), and for a cell with itself. Follows the
    /// lines until one is found: O(lines · cells along one).
    ///
    /// # Errors
    /// If the graph is not the one that was baked.
    pub fn proof(
        &self,
        graph: &CellGraph,
        a: u32,
        b: u32,
    ) -> Result<Option<Witness>, PvsFileError> {
        self.check_graph(graph)?;
        if a == b || self.state(a, b) != PairState::Visible {
            return Ok(None);
        }
        let openings = Openings::new(graph, 1e-6);
        let mut cells = Vec::new();
        Ok(self.followed(&openings).find_map(|(witness, line)| {
            follow(&openings, &line, &mut cells);
            (cells.contains(&a) && cells.contains(&b)).then_some(witness)
        }))
    }

    /// Whether these are a graph's sets.
    ///
    /// # Errors
    /// If they are another's.
    pub fn check_graph(&self, graph: &CellGraph) -> Result<(), PvsFileError> {
        let (found, expected) = (self.graph, graph_hash(graph));
        if found == expected { Ok(()) } else { Err(PvsFileError::OtherGraph { found, expected }) }
    }
}

/// More cells than any baker's graph has, and rows of a gigabyte.
const MOST_CELLS: u32 = 100_000;
/// Bytes of a line: portal and direction, where, and whither.
const WITNESS: usize = 4 + 6 * 8;

impl Pvs {
    /// The sets, as they are asked at run time.
    #[must_use]
    pub fn sets(&self) -> VisibleSets<'static> {
        packed(&self.visible)
    }

    /// The bytes of a file: a [container](Container).
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let head = [self.graph, self.key, self.candidates].map(u64::to_le_bytes).concat();
        let [visible, proven] = [&self.visible, &self.proven].map(|rows| packed(rows).to_bytes());
        let mut lines = Vec::with_capacity(self.witnesses.len() * WITNESS);
        for w in &self.witnesses {
            // The lowest bit is the direction.
            lines.extend((w.portal << 1 | u32::from(w.forward)).to_le_bytes());
            w.point.iter().chain(&w.direction).for_each(|v| lines.extend(v.to_le_bytes()));
        }
        write_chunks(&[
            (CellSets::HEAD, &head),
            (CellSets::SETS, &visible),
            (CellSets::PROVEN, &proven),
            (CellSets::LINES, &lines),
        ])
    }

    /// Reads such bytes.
    ///
    /// # Errors
    /// If they are no container, of something else, cut short, or were changed.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PvsFileError> {
        let file = Container::open(bytes)?;
        let CellSets { graph, key, candidates, .. } = CellSets::open(file)?;
        let [visible, proven] = [CellSets::SETS, CellSets::PROVEN]
            .map(|tag| Ok::<_, PvsFileError>(VisibleSets::from_bytes(file.chunk(tag)?)?));
        let (visible, proven) = (visible?, proven?);
        let cells = visible.cell_count();
        if [visible.target_count(), proven.cell_count(), proven.target_count()] != [cells; 3] {
            return Err(PvsFileError::Odd("sets of cells have not as many rows as cells"));
        }
        // Equal rows take no room in a file, but do here.
        if cells > MOST_CELLS {
            return Err(PvsFileError::Odd("it has more than 100,000 cells"));
        }
        let (visible, proven) = (unpacked(&visible), unpacked(&proven));
        let float = |w: &[u8; WITNESS], k: usize| {
            f64::from_le_bytes(std::array::from_fn(|i| w[4 + k * 8 + i]))
        };
        let witness = |w: &[u8; WITNESS]| {
            let first = u32::from_le_bytes([w[0], w[1], w[2], w[3]]);
            Witness {
                portal: first >> 1,
                forward: first & 1 != 0,
                point: std::array::from_fn(|k| float(w, k)),
                direction: std::array::from_fn(|k| float(w, 3 + k)),
            }
        };
        let (lines, rest) = file.chunk(CellSets::LINES)?.as_chunks::<WITNESS>();
        if !rest.is_empty() {
            return Err(PvsFileError::Odd("bytes are left behind the last line"));
        }
        let witnesses = lines.iter().map(witness).collect();
        Ok(Self { graph, key, visible, proven, candidates, witnesses })
    }
}

fn packed(rows: &BitRows) -> VisibleSets<'static> {
    let each = (0..rows.rows()).map(|row| rows.row(row));
    VisibleSets::from_rows(Targets::Cells, rows.columns(), each)
}

fn unpacked(sets: &VisibleSets<'_>) -> BitRows {
    let mut rows = BitRows::new(sets.cell_count(), sets.target_count());
    for cell in 0..rows.rows() {
        rows.row_mut(cell).copy_from_slice(&sets.union(&[cell]));
    }
    rows
}
