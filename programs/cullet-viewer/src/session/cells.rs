//! Cells and portals that a session shows: doors, steps along the chain, sets that are baked.

use super::Session;
use crate::cells::{CellSets, Cells, Chain, cell_boxes};
use crate::task::{Progress, Task};

impl Session {
    /// Opens a portal of the scene, or shuts it: the scene is made again so. Nothing where there is
    /// no such portal.
    pub fn toggle_portal(&mut self, portal: u32) {
        let graph = self.world.as_ref().and_then(|w| w.model.in_cells().graph());
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

    /// Opens or shuts what is nearest: the portal that the chosen step leads through, else the
    /// first of the chain, else the first shut door in sight.
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
        let Some(graph) = self.world.as_ref().and_then(|w| w.model.in_cells().graph()).cloned()
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
        let Some(placed) = &world.model.placed else {
            self.cells = Cells::default();
            return;
        };
        // Doors change no set: what is behind one is potentially visible.
        self.cells.sets.take_if(|sets| sets.pvs.check_graph(placed.graph()).is_err());
        let key = std::sync::Arc::as_ptr(world) as usize;
        if s.cells && self.cells.boxes.as_ref().is_none_or(|(of, _)| *of != key) {
            self.cells.boxes = Some((key, cell_boxes(placed, world.reach)));
        }
        if !s.cells && !s.portals {
            self.cells.chain = None;
        } else if self.cells.chain.as_ref().is_none_or(|c| c.decided != decision.number) {
            let chain = Chain::of(world.model.in_cells(), &decision.request.view, decision.number);
            self.cells.chain = Some(chain);
        }
    }
}
