//! Cells as they are found.

use cullet_cells::cell::{CellError, CellGraph, CellPiece, CellShapes, Portal};
use cullet_io::{Cell, CellGraph as NamedGraph, Portal as NamedPortal};

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

    /// Returns the cells as a model has them: the first is named `outside`, the others `room 1` and
    /// so on.
    #[must_use]
    pub fn into_graph(self) -> NamedGraph {
        let planes = |boxes: Vec<[[f64; 3]; 2]>| {
            let planes = |[low, high]: [[f64; 3]; 2]| Cell::from_box("", low, high).pieces;
            boxes.into_iter().flat_map(planes).collect()
        };
        let name = |number: usize| match number {
            0 => "outside".to_owned(),
            _ => format!("room {number}"),
        };
        let cells = self.cells.into_iter().enumerate().map(|(number, cell)| Cell {
            name: name(number),
            pieces: planes(cell.pieces),
            skins: planes(cell.skins),
        });
        let portals = self.portals.into_iter().map(|portal| NamedPortal {
            cells: portal.cells,
            polygon: portal.polygon,
            ..NamedPortal::default()
        });
        NamedGraph {
            cells: cells.collect(),
            portals: portals.collect(),
            sealed: true,
            ..NamedGraph::default()
        }
    }
}
