//! Visible sets of the cells of a graph, as `cullet pvs` bakes them of maps and rooms.

use cullet_cells::cell::CellGraph;
use cullet_cells::pvs::{SetsError, VisibleSets};
use thiserror::Error;

use super::container::{Container, ContainerError, Tag};
use super::hash::graph_hash;

/// Sets of cells in a file.
#[derive(Clone, Copy, Debug)]
pub struct CellSets<'a> {
    file: Container<'a>,
    /// Hash of the graph that they are of.
    pub graph: u64,
    /// Hash of graph and settings.
    pub key: u64,
    /// Ordered pairs that a flood through whole portals left to be decided.
    pub candidates: u64,
}

/// Reason for which bytes are no sets of cells, or not those of a graph.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PvsFileError {
    /// They are no baked file, or not one of cells and portals.
    #[error(transparent)]
    Container(#[from] ContainerError),
    /// Their rows are none.
    #[error(transparent)]
    Sets(#[from] SetsError),
    /// They contradict themselves.
    #[error("{0}: written by another program?")]
    Odd(&'static str),
    /// They are of another graph.
    #[error(
        "it was baked from other cells: hash {found:016x}, this one has {expected:016x}; bake it again"
    )]
    OtherGraph {
        /// Hash of the graph that was baked.
        found: u64,
        /// Hash of this one.
        expected: u64,
    },
}

impl<'a> CellSets<'a> {
    /// The chunk of hashes and counts, which a file of these begins with.
    pub const HEAD: Tag = *b"PVSG";
    /// The chunk of the sets.
    pub const SETS: Tag = *b"SETS";
    /// The chunk of the part of them that lines of sight prove.
    pub const PROVEN: Tag = *b"SURE";
    /// The chunk of those lines.
    pub const LINES: Tag = *b"LINE";

    /// Whether a file is one of these: that it has their first chunk.
    #[must_use]
    pub fn is_of(file: &Container<'_>) -> bool {
        file.tags().any(|tag| tag == Self::HEAD)
    }

    /// Reads hashes and counts; the sets are not looked at.
    ///
    /// # Errors
    /// If the file is of something else, or was changed.
    pub fn open(file: Container<'a>) -> Result<Self, PvsFileError> {
        let [graph, key, candidates] = file.chunk(Self::HEAD)?.as_chunks::<8>().0 else {
            return Err(PvsFileError::Odd("its head has not three numbers"));
        };
        let [graph, key, candidates] = [graph, key, candidates].map(|v| u64::from_le_bytes(*v));
        Ok(Self { file, graph, key, candidates })
    }

    /// Whether all chunks are as they were written. O(bytes).
    ///
    /// # Errors
    /// If one was changed.
    pub fn check(&self) -> Result<(), PvsFileError> {
        for tag in [Self::SETS, Self::PROVEN, Self::LINES] {
            self.file.chunk(tag)?;
        }
        Ok(())
    }

    /// The sets where they lie, for a file that is mapped. Their sum is not checked.
    ///
    /// # Errors
    /// If the file has none, or they are not of this graph.
    pub fn of_graph(&self, graph: &CellGraph) -> Result<VisibleSets<'a>, PvsFileError> {
        let (found, expected) = (self.graph, graph_hash(graph));
        if found != expected {
            return Err(PvsFileError::OtherGraph { found, expected });
        }
        Ok(VisibleSets::from_bytes(self.file.unchecked(Self::SETS)?)?)
    }
}
