//! Where the eye of a view stands among cells: what portals and sets begin with.

use cullet::{Reason, View};

use crate::cells::Cells;
use crate::portal::PortalView;

/// Why cells hide nothing from a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Idle {
    /// They do.
    No,
    /// The stage has not run.
    #[default]
    NotRun,
    NoPortals,
    NoSets,
    Orthographic,
    NoCell,
    InWall,
}

impl Idle {
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::No => "",
            Self::NotRun => "the stage has not run",
            Self::NoPortals => "the cells have no portals, only sets",
            Self::NoSets => "the cells have no sets",
            Self::Orthographic => "left out: an orthographic view has no eye in a cell",
            Self::NoCell => "left out: the eye is in no cell",
            Self::InWall => "left out: the near plane reaches out of the cells, into a wall",
        }
    }
}

/// The view, and the cells that its near plane may be in, that of the eye first.
pub(super) fn stand(view: &View, cells: &Cells, starts: &mut Vec<u32>) -> Result<PortalView, Idle> {
    let view = PortalView::new(view).ok_or(Idle::Orthographic)?;
    let (place, count) = (cells.place(), cells.graph().cell_count());
    let cell = place.cell_of(view.eye()).filter(|&c| c < count).ok_or(Idle::NoCell)?;
    // What the near plane cuts away hides nothing: walls do only where none is cut.
    let near = view.near_box().filter(|[min, max]| place.is_free(*min, *max));
    let [min, max] = near.ok_or(Idle::InWall)?;
    starts.clear();
    place.cells_touching(min, max, starts);
    // Between cells may be walls that are thin as paper, so that it cuts them and leaves no cell.
    starts.retain(|&c| c != cell && c < count);
    starts.sort_unstable();
    starts.dedup();
    starts.insert(0, cell);
    let eye = view.eye();
    let reach = (0..3).map(|a| (max[a] - eye[a]).max(eye[a] - min[a]).powi(2)).sum::<f64>().sqrt();
    Ok(view.with_door_reach(reach + place.walls()))
}

/// The cell of an instance, if it is one alone and its number fits.
pub(super) fn detail(cells: &Cells, slot: u32) -> u8 {
    match cells.cells_of(slot) {
        [cell] => u8::try_from(*cell).unwrap_or(Reason::MIXED),
        _ => Reason::MIXED,
    }
}

/// The cells of an instance, in words.
pub(super) fn place_of(own: &[u32]) -> String {
    match own {
        [] => "in no cell".to_owned(),
        [cell] => format!("in cell {cell}"),
        own => format!("in cells {}", list(own)),
    }
}

pub(super) fn list(numbers: &[u32]) -> String {
    let numbers: Vec<String> = numbers.iter().map(u32::to_string).collect();
    numbers.join(", ")
}
