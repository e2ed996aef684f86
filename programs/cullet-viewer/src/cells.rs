//! Cells and portals of the shown scene: the portals that the culling view is seen through, boxes
//! around cells, and which cells can see each other.

use cullet::{Backface, Culler, Output, View};
use cullet_bake::pvs::{PairState, Pvs, PvsSettings, bake};
use cullet_cells::cell::CellGraph;
use cullet_cells::{Cells as PlacedCells, InCells};
use cullet_draw::{DoorInView, ShownPortal, matrix_order, shown_portals, shut_doors};
use glam::DVec3;

use crate::task::Task;

/// Shut doors, as in the pictures of `cullet picture portals`.
pub const SHUT: [u8; 3] = [0xD8, 0x2C, 0x20];
/// The cell that the eye is in.
pub const OWN: [u8; 3] = [0xFF, 0xD2, 0x3F];
/// Cells that portals reach from there.
pub const REACHED: [u8; 3] = [0x6F, 0xD6, 0x77];
/// Cells that are seen from somewhere in that of the eye.
pub const IN_SET: [u8; 3] = [0x4C, 0x9B, 0xF2];
/// The walk through portals from the eye that culls.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Number of the decision that it belongs to.
    pub(crate) decided: u64,
    /// The cell of the eye.
    pub cell: Option<u32>,
    /// Cells that are reached, ascending; `None` where portals hide nothing, as where the eye is in
    /// no cell.
    pub reached: Option<Vec<u32>>,
    /// The portals that are seen through, depth first.
    pub steps: Vec<ShownPortal>,
    /// Doors that are shut.
    pub doors: Vec<DoorInView>,
}

impl Chain {
    /// Walks through the portals of a scene, whatever stages are on. Costs a cull by portals alone.
    #[must_use]
    pub fn of(world: InCells<'_>, view: &View, decided: u64) -> Self {
        let culler = Culler::default()
            .with_frustum(false)
            .with_portal(true)
            .with_backface(Backface::Off)
            .with_degenerate(false)
            .with_detail(None)
            .with_occlusion(None)
            .with_output(Output::Instances);
        let reached = world.reached(&culler, view);
        let reached = reached.as_ref().zip(world.graph());
        let cells = reached.map(|(reached, _)| {
            let mut cells: Vec<u32> = reached.visits().iter().map(|visit| visit.cell).collect();
            cells.sort_unstable();
            cells.dedup();
            cells
        });
        let [x, y, z, w] = view.eye();
        Self {
            decided,
            cell: (w != 0.0).then(|| world.cell_of([x, y, z])).flatten(),
            reached: cells,
            steps: reached.map_or_else(Vec::new, |(reached, _)| shown_portals(view, reached)),
            doors: reached
                .map_or_else(Vec::new, |(reached, graph)| shut_doors(graph, view, reached)),
        }
    }

    /// Returns the steps that are shown where `step` is chosen, 0 being all; the last of them is
    /// the chosen one.
    #[must_use]
    pub fn shown(&self, step: u32) -> &[ShownPortal] {
        let count = if step == 0 { self.steps.len() } else { self.steps.len().min(step as usize) };
        &self.steps[..count]
    }
}

/// Cells that can see each other, and an order of them in which neighbours stand together.
#[derive(Debug)]
pub struct CellSets {
    /// The sets.
    pub pvs: Pvs,
    /// The cells of the matrix, from the top.
    pub order: Vec<u32>,
}

impl CellSets {
    pub(crate) fn of(graph: &CellGraph) -> Self {
        // A page has no threads; and a map's bake may take a while in any case.
        let threads = match cfg!(target_arch = "wasm32") {
            true => 1,
            false => std::thread::available_parallelism().map_or(1, usize::from),
        };
        let pvs = bake(graph, &PvsSettings::default(), threads);
        let neighbours: Vec<Vec<u32>> =
            (0..graph.cell_count()).map(|cell| graph.neighbours_of(cell).collect()).collect();
        Self { pvs, order: matrix_order(&neighbours) }
    }

    /// Whether something of a cell may be seen from another.
    #[must_use]
    pub fn sees(&self, from: u32, to: u32) -> bool {
        let count = self.pvs.cell_count();
        from == to || from < count && to < count && self.pvs.state(from, to) != PairState::Hidden
    }
}

/// Knowledge about the cells of a session's scene.
#[derive(Debug, Default)]
pub struct Cells {
    /// The walk of the newest decision, while it is shown.
    pub chain: Option<Chain>,
    /// Boxes around cells, and whose they are: the address of a world that lives as long.
    pub(crate) boxes: Option<(usize, Vec<Option<[DVec3; 2]>>)>,
    pub(crate) sets: Option<CellSets>,
    pub(crate) baking: Option<Task<CellSets>>,
}

impl Cells {
    /// Returns the cells that can see each other, once that was baked.
    #[must_use]
    pub fn sets(&self) -> Option<&CellSets> {
        self.sets.as_ref()
    }

    /// Whether that is being baked.
    #[must_use]
    pub fn is_baking(&self) -> bool {
        self.baking.is_some()
    }
}

/// A box in each cell: of a room of six walls the room, of another shape what is measured across
/// its middle. Found by where its scene says that the cell ends, so that it serves cells of any
/// kind; none of a cell without portals.
pub(crate) fn cell_boxes(cells: &PlacedCells, reach: f64) -> Vec<Option<[DVec3; 2]>> {
    (0..cells.graph().cell_count()).map(|cell| cell_box(cells, cell, reach)).collect()
}

fn cell_box(cells: &PlacedCells, cell: u32, reach: f64) -> Option<[DVec3; 2]> {
    let graph = cells.graph();
    graph.portals_of(cell).iter().find_map(|&portal| {
        let of = &graph.portals()[portal as usize];
        let count = of.polygon.len() as f64;
        let middle = of.polygon.iter().map(|p| DVec3::from(*p)).sum::<DVec3>() / count;
        let side = if of.cells[0] == cell { 1.0 } else { -1.0 };
        let inward = DVec3::from(graph.plane(portal).normal) * side;
        let is_in = |p: DVec3| cells.cell_of(p.into()) == Some(cell);
        let near = [1e-6, 1e-5, 1e-4, 1e-3].map(|share| middle + inward * (share * reach));
        let from = near.into_iter().find(|p| is_in(*p))?;
        // Out of the way through the wall, into the room.
        let mut at = from + inward * (way(cells, cell, from, inward, reach) * 0.5);
        let (mut low, mut high) = (at, at);
        for _ in 0..2 {
            for (a, axis) in DVec3::AXES.into_iter().enumerate().rev() {
                let [back, on] = [-axis, axis].map(|d| way(cells, cell, at, d, reach));
                (low[a], high[a]) = (at[a] - back, at[a] + on);
                at[a] = (low[a] + high[a]) * 0.5;
            }
        }
        Some([low, high])
    })
}

/// How far a cell goes from one of its points, as far as steps find it.
fn way(cells: &PlacedCells, cell: u32, from: DVec3, along: DVec3, reach: f64) -> f64 {
    let is_in = |t: f64| cells.cell_of((from + along * t).into()) == Some(cell);
    let (mut inside, mut step) = (0.0, reach * 1e-3);
    while inside < 4.0 * reach && is_in(inside + step) {
        inside += step;
        step *= 1.3;
    }
    let mut outside = inside + step;
    for _ in 0..30 {
        let middle = (inside + outside) * 0.5;
        if is_in(middle) { inside = middle } else { outside = middle }
    }
    inside
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn the_boxes_of_an_office_are_its_rooms() {
        let model = cullet_scenes::build("office").expect("built in");
        let placed = model.placed.as_ref().expect("it has cells");
        let boxes = cell_boxes(placed, 30.0);
        let found = boxes.iter().flatten().count();
        assert!(found * 10 >= boxes.len() * 9, "{found} of {}", boxes.len());
        for (cell, found) in (0..).zip(&boxes) {
            let Some([low, high]) = found else { continue };
            assert_eq!(placed.cell_of(((*low + *high) * 0.5).into()), Some(cell));
            assert!((*high - *low).min_element() > 0.3, "cell {cell}: {low} to {high}");
        }
    }
}
