//! Where the eye of a view stands among cells: what portals and sets begin with.

use alloc::vec::Vec;

#[cfg(not(feature = "std"))]
use cullet::math::Float as _;
use cullet::{Reason, View, explain::Evidence};

use crate::cells::Cells;
use crate::portal::PortalView;

/// The view, and the cells that its near plane may be in, that of the eye first.
pub(super) fn stand(
    view: &View,
    cells: &Cells,
    starts: &mut Vec<u32>,
) -> Result<PortalView, Evidence> {
    let view = PortalView::new(view).ok_or(Evidence::Orthographic)?;
    let (place, count) = (cells.place(), cells.graph().cell_count());
    let cell = place.cell_of(view.eye()).filter(|&c| c < count).ok_or(Evidence::NoCell)?;
    // What the near plane cuts away hides nothing: walls do only where none is cut.
    let near = view.near_box().filter(|[min, max]| place.is_free(*min, *max));
    let [min, max] = near.ok_or(Evidence::InWall)?;
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
