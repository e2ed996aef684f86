//! Portal: what is in no cell that is seen through open portals, or beside the portals through
//! which its cells are seen.

use alloc::vec;
use alloc::vec::Vec;

use cullet::bounds::Side;
use cullet::cull::frustum::batch::Planes;
#[cfg(not(feature = "std"))]
use cullet::math::Float as _;
use cullet::{
    Scene,
    candidates::Look,
    explain::{CellTest, Evidence, Sight},
    view::Frustum,
};

use super::stand::stand;
use crate::cells::Cells;
use crate::portal::{PortalOptions, Reached, Visit, walk_portals};
use crate::pvs::{Targets, VisibleSets};

/// Findings of the stage in one view, and memory that is used again.
#[derive(Clone, Debug, Default)]
pub(super) struct Cache {
    reached: Reached,
    /// The eye is in a cell, so that portals hide something; otherwise `idle` says why not.
    is_used: bool,
    idle: Evidence,
    /// One bit a slot, of the words that were live: in sight, and wholly so as far as portals go.
    seen: Vec<u64>,
    whole: Vec<u64>,
    starts: Vec<u32>,
}

impl Cache {
    /// Returns the cells that the last cull reached, unless portals did nothing.
    pub(super) fn reached(&self) -> Option<&Reached> {
        self.is_used.then_some(&self.reached)
    }

    /// Looks from a view, among the instances that are left.
    pub(super) fn look(
        &mut self,
        look: &Look<'_>,
        cells: &Cells,
        options: &PortalOptions,
        left: (&[u64], &[u32]),
    ) {
        let stands = match cells.visible_sets().map(VisibleSets::targets) {
            // Cells for sets of instances are not rooms, and nothing is beyond their borders.
            Some(Targets::Instances) if cells.graph().portals().is_empty() => {
                Err(Evidence::NoPortals)
            }
            _ => stand(look.view, cells, &mut self.starts),
        };
        self.is_used = stands.is_ok();
        match stands {
            Err(idle) => self.idle = idle,
            Ok(view) => {
                walk_portals(cells.graph(), &view, &self.starts, options, &mut self.reached);
                self.find_seen((look.scene, cells), left);
            }
        }
    }

    /// Finds which instances are in sight.
    fn find_seen(&mut self, (scene, cells): (&Scene, &Cells), (alive, live): (&[u64], &[u32])) {
        self.seen.resize(alive.len(), 0);
        self.whole.resize(alive.len(), 0);
        for &word in live {
            (self.seen[word as usize], self.whole[word as usize]) = (0, 0);
        }
        let boxes = scene.boxes();
        for visit in self.reached.visits() {
            let mut planes = None;
            for &slot in cells.slots_in(visit.cell) {
                let (word, bit) = (slot as usize / 64, 1 << (slot % 64));
                if alive[word] & !self.whole[word] & bit == 0 {
                    continue;
                }
                // In the cell of the eye the frustum has said all.
                let side = if visit.is_start() {
                    Side::Inside
                } else {
                    let planes = planes.get_or_insert_with(|| {
                        Planes::new(&bounds_of(
                            (scene, cells),
                            &self.reached,
                            visit,
                            scene.origin(),
                        ))
                    });
                    planes.classify_stored(boxes, slot as usize)
                };
                if side != Side::Outside {
                    self.seen[word] |= bit;
                }
                if side == Side::Inside {
                    self.whole[word] |= bit;
                }
            }
        }
    }

    /// Returns one bit for each slot of `word`: in sight, or seen from everywhere.
    pub(super) fn word(&self, cells: &Cells, word: usize) -> u64 {
        if self.is_used { self.seen[word] | cells.loose(word) } else { u64::MAX }
    }

    /// Returns one bit for each slot of `word`: its instance is seen only in part, as far as
    /// portals go. No bit is set where the stage did nothing.
    pub(super) fn straddling(&self, cells: &Cells, word: usize) -> u64 {
        match self.is_used {
            true => self.seen[word] & !self.whole[word] & !cells.loose(word),
            false => 0,
        }
    }

    /// Calls `each` with what bounds the instance of `slot` at each visit to its cells.
    pub(super) fn frusta(
        &self,
        (scene, cells): (&Scene, &Cells),
        slot: u32,
        each: &mut dyn FnMut(&Frustum),
    ) {
        let own = cells.cells_of(slot);
        for visit in self.reached.visits().iter().filter(|visit| own.contains(&visit.cell)) {
            each(&bounds_of((scene, cells), &self.reached, visit, [0.0; 3]));
        }
    }

    /// Returns the portals through which the instance of `slot` is seen, or why it is not seen.
    pub(super) fn evidence(
        &self,
        (scene, cells): (&Scene, &Cells),
        slot: u32,
        is_late: bool,
    ) -> Evidence {
        if !self.is_used {
            return self.idle.clone();
        }
        let own = cells.cells_of(slot);
        let (instance, eye) = (own.to_vec(), self.starts.clone());
        let mut test = CellTest { instance, eye, in_sight: true, ..CellTest::default() };
        if is_late || cells.loose(slot as usize / 64) >> (slot % 64) & 1 == 1 {
            return Evidence::Cells(test);
        }
        let all = (0..).zip(self.reached.visits());
        let mut visits = all.filter(|(_, visit)| own.contains(&visit.cell)).peekable();
        let first = visits.peek().copied();
        let seen = visits.find(|(_, visit)| {
            let bounds = bounds_of((scene, cells), &self.reached, visit, scene.origin());
            let side = Planes::new(&bounds).classify_stored(scene.boxes(), slot as usize);
            visit.is_start() || side != Side::Outside
        });
        test.in_sight = seen.is_some();
        if let Some((number, visit)) = seen.or(first) {
            let chain = self.reached.chain(number);
            test.portals = chain.iter().filter_map(|visit| visit.portal).collect();
            test.sight = if visit.is_limited { Sight::Limited } else { Sight::Portals };
        } else {
            (test.sight, test.portals) = way(cells, self.reached.visits()[0].cell, own);
        }
        Evidence::Cells(test)
    }
}

/// Returns the frustum around what is seen of the cell at `visit`, relative to `origin`.
fn bounds_of(
    (scene, cells): (&Scene, &Cells),
    reached: &Reached,
    visit: &Visit,
    origin: [f64; 3],
) -> Frustum {
    let extent = cells.extent(visit.cell);
    // How far from the eye anything is.
    let far = (0..3).map(|a| {
        let eye = visit.eye[a] - scene.origin()[a];
        (f64::from(extent.max[a]) - eye).abs().max((f64::from(extent.min[a]) - eye).abs())
    });
    reached.frustum(visit, origin, far.map(|v| v * v).sum::<f64>().sqrt())
}

/// Returns the shortest way from one cell to others, an open one if there is one. Nothing is seen
/// along it.
fn way(cells: &Cells, start: u32, to: &[u32]) -> (Sight, Vec<u32>) {
    for open_only in [true, false] {
        let graph = cells.graph();
        let mut from = vec![None; graph.cell_count() as usize];
        let (mut queue, mut at) = (vec![start], 0);
        while let Some(&cell) = queue.get(at) {
            at += 1;
            for &portal in graph.portals_of(cell) {
                let next = if open_only {
                    graph.beyond(portal, cell)
                } else {
                    graph.if_open(portal, cell)
                };
                if let Some(next) = next.filter(|&n| n != start && from[n as usize].is_none()) {
                    from[next as usize] = Some((cell, portal));
                    queue.push(next);
                }
            }
        }
        let Some(&end) = queue.iter().find(|cell| to.contains(cell)) else { continue };
        let (mut portals, mut cell) = (Vec::new(), end);
        while let Some((before, portal)) = from[cell as usize].filter(|_| cell != start) {
            portals.push(portal);
            cell = before;
        }
        portals.reverse();
        return match portals.iter().find(|&&portal| !graph.is_open(portal)) {
            Some(&portal) => (Sight::Shut(portal), Vec::new()),
            None => (Sight::Open, portals),
        };
    }
    (Sight::NoWay, Vec::new())
}
