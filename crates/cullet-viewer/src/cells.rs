//! Cells and portals of the shown scene: the portals that the culling view is seen through, boxes around cells, and
//! which cells can see each other.

use cullet::cell::CellGraph;
use cullet::{Backface, Culler, Output, Scene, View, ViewState, Visible};
use cullet_bake::pvs::{PairState, Pvs, PvsSettings, bake};
use cullet_draw::{DoorInView, ShownPortal, depth_color, matrix_order, shown_portals, shut_doors};
use glam::DVec3;

use crate::lines::{Lines, tint};
use crate::session::Session;
use crate::task::{Progress, Task};

/// Shut doors, as in the pictures of `cullet picture portals`.
pub const SHUT: [u8; 3] = [0xD8, 0x2C, 0x20];
/// The cell that the eye is in.
pub const OWN: [u8; 3] = [0xFF, 0xD2, 0x3F];
/// Cells that portals reach from there.
pub const REACHED: [u8; 3] = [0x6F, 0xD6, 0x77];
/// Cells that are seen from somewhere in that of the eye.
pub const IN_SET: [u8; 3] = [0x4C, 0x9B, 0xF2];
/// All other cells.
const OTHER: [u8; 3] = [0x8C, 0x93, 0x9B];

/// The walk through portals from the eye that culls.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Of which decision.
    decided: u64,
    /// The cell of the eye.
    pub cell: Option<u32>,
    /// Cells that are reached, ascending; `None` where portals hide nothing, as where the eye is in no cell.
    pub reached: Option<Vec<u32>>,
    /// The portals that are seen through, depth first.
    pub steps: Vec<ShownPortal>,
    /// Those that are shut.
    pub doors: Vec<DoorInView>,
}

impl Chain {
    /// Walks through the portals of a scene, whatever stages are on. Costs a cull by portals alone.
    #[must_use]
    pub fn of(scene: &Scene, view: &View, decided: u64) -> Self {
        let culler = Culler {
            frustum: false,
            portal: Some(Default::default()),
            backface: Backface::Off,
            degenerate: false,
            detail: None,
            occlusion: None,
            output: Output::Instances,
            ..Culler::default()
        };
        let mut state = ViewState::default();
        culler.cull_one(scene, view, &mut state, &mut Visible::default());
        let reached = state.reached();
        let cells = reached.map(|reached| {
            let mut cells: Vec<u32> = reached.visits().iter().map(|visit| visit.cell).collect();
            cells.sort_unstable();
            cells.dedup();
            cells
        });
        let [x, y, z, w] = view.eye();
        Self {
            decided,
            cell: (w != 0.0).then(|| scene.cell_of([x, y, z])).flatten(),
            reached: cells,
            steps: reached.map_or_else(Vec::new, |reached| shown_portals(view, reached)),
            doors: reached.map_or_else(Vec::new, |reached| shut_doors(scene, view, reached)),
        }
    }

    /// Those of the steps that are shown where `step` is chosen, 0 being all; the last of them is the chosen one.
    #[must_use]
    pub fn shown(&self, step: u32) -> &[ShownPortal] {
        let count = if step == 0 { self.steps.len() } else { self.steps.len().min(step as usize) };
        &self.steps[..count]
    }
}

/// Which cells can see each other, and an order of them in which neighbours stand together.
#[derive(Debug)]
pub struct CellSets {
    /// The sets.
    pub pvs: Pvs,
    /// The cells of the matrix, from the top.
    pub order: Vec<u32>,
}

impl CellSets {
    fn of(graph: &CellGraph) -> Self {
        // A page has no threads; and a map's bake may take a while in any case.
        let threads = match cfg!(target_arch = "wasm32") {
            true => 1,
            false => std::thread::available_parallelism().map_or(1, usize::from),
        };
        let pvs = bake(graph, &PvsSettings::default(), threads);
        let neighbours: Vec<Vec<u32>> = (0..graph.cell_count())
            .map(|cell| {
                let around = graph.portals_of(cell).iter();
                around
                    .map(|&portal| {
                        let [a, b] = graph.portals()[portal as usize].cells;
                        if a == cell { b } else { a }
                    })
                    .collect()
            })
            .collect();
        Self { pvs, order: matrix_order(&neighbours) }
    }

    /// Whether something of a cell may be seen from another.
    #[must_use]
    pub fn sees(&self, from: u32, to: u32) -> bool {
        let count = self.pvs.cell_count();
        from == to || from < count && to < count && self.pvs.state(from, to) != PairState::Hidden
    }
}

/// What is known of the cells of a session's scene.
#[derive(Debug, Default)]
pub struct Cells {
    /// The walk of the newest decision, while it is shown.
    pub chain: Option<Chain>,
    /// Boxes around cells, and whose they are: the address of a world that lives as long.
    boxes: Option<(usize, Vec<Option<[DVec3; 2]>>)>,
    sets: Option<CellSets>,
    baking: Option<Task<CellSets>>,
}

impl Cells {
    /// Which cells can see each other, once that was baked.
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

impl Session {
    /// Opens a portal of the scene, or shuts it: the scene is made again so. Nothing where there is no such portal.
    pub fn toggle_portal(&mut self, portal: u32) {
        let graph = self.world.as_ref().and_then(|w| w.model.scene.cell_graph());
        if graph.is_none_or(|graph| portal as usize >= graph.portals().len()) {
            return;
        }
        let doors = &mut self.state.doors;
        let before = doors.len();
        doors.retain(|&door| door != portal);
        if doors.len() == before {
            doors.push(portal);
        }
    }

    /// Opens or shuts what is nearest: the portal that the chosen step leads through, else the first of the chain, else the first shut door
    /// in sight.
    pub fn toggle_nearest_portal(&mut self) {
        let Some(chain) = &self.cells.chain else { return };
        let step = chain.shown(self.state.structure.step.max(1)).last().map(|step| step.portal);
        let portal = step.or_else(|| chain.doors.first().map(|door| door.portal));
        if let Some(portal) = portal {
            self.toggle_portal(portal);
        }
    }

    /// Goes along the chain of portals by so many steps, and shows it.
    pub fn step_portals(&mut self, by: i64) {
        self.state.structure.portals = true;
        let count = self.cells.chain.as_ref().map_or(0, |chain| chain.steps.len());
        let step = i64::from(self.state.structure.step);
        self.state.structure.step = (step + by).rem_euclid(count as i64 + 1) as u32;
    }

    /// Begins to bake which cells can see each other.
    pub fn bake_cells(&mut self) {
        let Some(graph) = self.world.as_ref().and_then(|w| w.model.scene.cell_graph()).cloned()
        else {
            return;
        };
        let ctx = self.ctx.clone();
        let task = Task::start(move || CellSets::of(&graph), move || ctx.request_repaint());
        self.cells.baking = Some(task);
    }

    /// Goes on with what is shown of cells.
    pub(crate) fn follow_cells(&mut self) {
        if let Some(task) = &self.cells.baking {
            match task.poll() {
                Progress::Working => {}
                Progress::Done(sets) => (self.cells.sets, self.cells.baking) = (Some(sets), None),
                Progress::Lost => {
                    self.cells.baking = None;
                    self.tell("The sets of cells ended without a result.", true);
                }
            }
        }
        let s = &self.state.structure;
        let (Some(world), Some(decision)) = (&self.world, &self.decision) else {
            self.cells = Cells::default();
            return;
        };
        let scene = &world.model.scene;
        let Some(graph) = scene.cell_graph() else {
            self.cells = Cells::default();
            return;
        };
        // Doors change no set: what is behind one is potentially visible.
        self.cells.sets.take_if(|sets| sets.pvs.check_graph(graph).is_err());
        let key = std::sync::Arc::as_ptr(world) as usize;
        if s.cells && self.cells.boxes.as_ref().is_none_or(|(of, _)| *of != key) {
            self.cells.boxes = Some((key, cell_boxes(scene, graph, world.reach)));
        }
        if !s.cells && !s.portals {
            self.cells.chain = None;
        } else if self.cells.chain.as_ref().is_none_or(|c| c.decided != decision.number) {
            let chain = Chain::of(scene, &decision.request.view, decision.number);
            self.cells.chain = Some(chain);
        }
    }
}

/// Adds cells and the chain of portals as they are seen from outside.
pub fn draw(session: &Session, lines: &mut Lines, faces: &mut Lines) {
    let s = &session.state.structure;
    let (Some(chain), Some(decision)) = (&session.cells.chain, &session.decision) else { return };
    let boxes = session.cells.boxes.as_ref().filter(|_| s.cells);
    for (cell, found) in (0..).zip(boxes.map_or(&[][..], |(_, boxes)| boxes)) {
        let Some([low, high]) = *found else { continue };
        let in_set = || {
            let sets = session.cells.sets();
            chain.cell.zip(sets).is_some_and(|(own, sets)| sets.sees(own, cell))
        };
        let reached = chain.reached.as_ref();
        let colour = match cell {
            cell if chain.cell == Some(cell) => tint(OWN, 255),
            cell if reached.is_some_and(|r| r.binary_search(&cell).is_ok()) => tint(REACHED, 255),
            _ if in_set() => tint(IN_SET, 220),
            _ => tint(OTHER, 110),
        };
        wire(low, high, colour, lines);
    }
    if !s.portals {
        return;
    }
    let [x, y, z, _] = decision.request.view.eye();
    let eye = DVec3::new(x, y, z);
    let shown = chain.shown(s.step);
    for (number, step) in (1..).zip(shown) {
        let colour = depth_color(step.depth);
        let corners: Vec<DVec3> = step.polygon.iter().map(|p| DVec3::from(*p)).collect();
        ring(&corners, tint(colour, 255), lines);
        // What is seen through the last of a chosen few: a pyramid from the eye.
        if number == s.step as usize {
            corners.iter().for_each(|&c| lines.line(eye, c, tint(colour, 160)));
            fan(&corners, tint(colour, 90), faces);
        }
    }
    for door in &chain.doors {
        let corners: Vec<DVec3> = door.polygon.iter().map(|p| DVec3::from(*p)).collect();
        ring(&corners, tint(SHUT, 255), lines);
        fan(&corners, tint(SHUT, 120), faces);
    }
}

fn ring(corners: &[DVec3], colour: [u8; 4], lines: &mut Lines) {
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        lines.line(*a, *b, colour);
    }
}

fn fan(corners: &[DVec3], colour: [u8; 4], faces: &mut Lines) {
    for i in 2..corners.len() {
        faces.triangle([corners[0], corners[i - 1], corners[i]], colour);
    }
}

/// The edges of a box of the world.
fn wire(low: DVec3, high: DVec3, colour: [u8; 4], lines: &mut Lines) {
    let corner = |i: usize| {
        let of = |a: usize| if i >> a & 1 == 1 { high[a] } else { low[a] };
        DVec3::new(of(0), of(1), of(2))
    };
    for i in 0..8_usize {
        for a in (0..3).filter(|a| i >> a & 1 == 0) {
            lines.line(corner(i), corner(i | 1 << a), colour);
        }
    }
}

/// A box in each cell: of a room of six walls the room, of another shape what is measured across its middle. Found by where
/// its scene says that the cell ends, so that it serves cells of any kind; none of a cell without portals.
fn cell_boxes(scene: &Scene, graph: &CellGraph, reach: f64) -> Vec<Option<[DVec3; 2]>> {
    (0..graph.cell_count()).map(|cell| cell_box(scene, graph, cell, reach)).collect()
}

fn cell_box(scene: &Scene, graph: &CellGraph, cell: u32, reach: f64) -> Option<[DVec3; 2]> {
    graph.portals_of(cell).iter().find_map(|&portal| {
        let of = &graph.portals()[portal as usize];
        let count = of.polygon.len() as f64;
        let middle = of.polygon.iter().map(|p| DVec3::from(*p)).sum::<DVec3>() / count;
        let side = if of.cells[0] == cell { 1.0 } else { -1.0 };
        let inward = DVec3::from(graph.plane(portal).normal) * side;
        let is_in = |p: DVec3| scene.cell_of(p.into()) == Some(cell);
        let near = [1e-6, 1e-5, 1e-4, 1e-3].map(|share| middle + inward * (share * reach));
        let from = near.into_iter().find(|p| is_in(*p))?;
        // Out of the way through the wall, into the room.
        let mut at = from + inward * (way(scene, cell, from, inward, reach) * 0.5);
        let (mut low, mut high) = (at, at);
        for _ in 0..2 {
            for (a, axis) in DVec3::AXES.into_iter().enumerate().rev() {
                let [back, on] = [-axis, axis].map(|d| way(scene, cell, at, d, reach));
                (low[a], high[a]) = (at[a] - back, at[a] + on);
                at[a] = (low[a] + high[a]) * 0.5;
            }
        }
        Some([low, high])
    })
}

/// How far a cell goes from one of its points, as far as steps find it.
fn way(scene: &Scene, cell: u32, from: DVec3, along: DVec3, reach: f64) -> f64 {
    let is_in = |t: f64| scene.cell_of((from + along * t).into()) == Some(cell);
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
    use cullet_io::scenes;

    use super::*;

    #[test]
    fn the_boxes_of_an_office_are_its_rooms() {
        let model = scenes::build("office").expect("built in");
        let graph = model.scene.cell_graph().expect("it has cells");
        let boxes = cell_boxes(&model.scene, graph, 30.0);
        let found = boxes.iter().flatten().count();
        assert!(found * 10 >= boxes.len() * 9, "{found} of {}", boxes.len());
        for (cell, found) in (0..).zip(&boxes) {
            let Some([low, high]) = found else { continue };
            assert_eq!(model.scene.cell_of(((*low + *high) * 0.5).into()), Some(cell));
            assert!((*high - *low).min_element() > 0.3, "cell {cell}: {low} to {high}");
        }
    }
}
