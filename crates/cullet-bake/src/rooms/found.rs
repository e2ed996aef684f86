//! Cells as they are found.

use cullet_cells::cell::{CellError, CellGraph, CellPiece, CellShapes, Portal};

use super::options::FoundFigures;

/// A cell that was found: boxes along the axes, by their lowest and highest corners, in the world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundCell {
    /// Where an eye may be.
    pub pieces: Vec<[[f64; 3]; 2]>,
    /// Where surfaces are: no eye is there. See [`CellShapes::with_skins`].
    pub skins: Vec<[[f64; 3]; 2]>,
}

/// Cells that were found, and the portals between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundCells {
    /// The cells. The first is the outside, around all walls; it may have no portal.
    pub cells: Vec<FoundCell>,
    /// Rectangles, all open.
    pub portals: Vec<Portal>,
    /// Figures.
    pub figures: FoundFigures,
}

impl FoundCells {
    /// The engine's graph and shapes, sealed: what is neither in a piece nor in a skin is seen from
    /// no cell.
    ///
    /// # Errors
    /// As of [`CellGraph::new`] and [`CellShapes::new`].
    pub fn build(&self) -> Result<(CellGraph, CellShapes), CellError> {
        let graph = CellGraph::new(self.cells.len() as u32, self.portals.clone())?;
        let of = |which: fn(&FoundCell) -> &Vec<[[f64; 3]; 2]>| {
            let all = (0..).zip(&self.cells);
            all.flat_map(|(cell, own)| {
                which(own).iter().map(move |&[low, high]| CellPiece::from_box(cell, low, high))
            })
            .collect::<Vec<_>>()
        };
        let shapes = CellShapes::with_skins(&graph, of(|c| &c.pieces), of(|c| &c.skins))?;
        Ok((graph, shapes.sealed()))
    }
}
