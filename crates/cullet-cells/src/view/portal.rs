//! Portal: what is in no cell that is seen through open portals, or beside the portals through which its cells are seen.

use cullet::bounds::Side;
use cullet::cull::frustum::batch::Planes;
use cullet::{
    Scene,
    candidates::Look,
    explain::{CellTest, Evidence},
    view::Frustum,
};

use super::stand::{Idle, list, place_of, stand};
use crate::cells::Cells;
use crate::portal::{PortalOptions, Reached, Visit, walk_portals};
use crate::pvs::{Targets, VisibleSets};

/// Findings of the stage in one view, and memory that is used again.
#[derive(Clone, Debug, Default)]
pub(super) struct Cache {
    reached: Reached,
    /// Whether the eye is in a cell, so that portals hide something.
    idle: Idle,
    /// One bit a slot, of the words that were live: in sight, and wholly so as far as portals go.
    seen: Vec<u64>,
    whole: Vec<u64>,
    starts: Vec<u32>,
}

impl Cache {
    /// Returns the cells that the last cull reached, unless portals did nothing.
    pub(super) fn reached(&self) -> Option<&Reached> {
        (self.idle == Idle::No).then_some(&self.reached)
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
            Some(Targets::Instances) if cells.graph().portals().is_empty() => Err(Idle::NoPortals),
            _ => stand(look.view, cells, &mut self.starts),
        };
        self.idle = Idle::No;
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
        match self.idle {
            Idle::No => self.seen[word] | cells.loose(word),
            _ => u64::MAX,
        }
    }

    /// Returns one bit for each slot of `word`: its instance is seen only in part, as far as
    /// portals go. No bit is set where the stage did nothing.
    pub(super) fn straddling(&self, cells: &Cells, word: usize) -> u64 {
        match self.idle {
            Idle::No => self.seen[word] & !self.whole[word] & !cells.loose(word),
            _ => 0,
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
    pub(super) fn finding(
        &self,
        (scene, cells): (&Scene, &Cells),
        slot: u32,
        is_late: bool,
    ) -> (String, Evidence) {
        if self.idle != Idle::No {
            return (self.idle.words().to_owned(), Evidence::None);
        }
        let own = cells.cells_of(slot);
        let place = place_of(own);
        if is_late || cells.loose(slot as usize / 64) >> (slot % 64) & 1 == 1 {
            let why =
                if own.is_empty() { "" } else { " and beyond, or moved since the last commit" };
            let instance = own.to_vec();
            let eye = self.starts.clone();
            let test = CellTest { instance, eye, in_sight: true, ..CellTest::default() };
            return (format!("{place}{why}: seen from everywhere"), Evidence::Cells(test));
        }
        let start = self.reached.visits()[0].cell;
        let found = |words: String, portals: &[u32], in_sight: bool, shut: Option<u32>| {
            let (instance, eye) = (own.to_vec(), self.starts.clone());
            let test = CellTest { instance, eye, portals: portals.to_vec(), in_sight, shut };
            (words, Evidence::Cells(test))
        };
        let visits =
            (0..).zip(self.reached.visits()).filter(|(_, visit)| own.contains(&visit.cell));
        let mut is_beside = None;
        for (number, visit) in visits {
            let planes =
                Planes::new(&bounds_of((scene, cells), &self.reached, visit, scene.origin()));
            let (by, portals) = self.chain(number);
            if visit.is_start()
                || planes.classify_stored(scene.boxes(), slot as usize) != Side::Outside
            {
                let words = format!("{place}, seen from cell {start}{by}");
                return found(words, &portals, true, None);
            }
            is_beside.get_or_insert((by, portals));
        }
        if let Some((by, portals)) = is_beside {
            let words = format!("{place}, but beside what is seen of that from cell {start}{by}");
            return found(words, &portals, false, None);
        }
        let unseen = format!("{place}, not seen from cell {start}");
        match first_shut(cells, start, own) {
            Way::Shut(portal) => {
                let words = format!("{unseen}: portal {portal} on the way is shut");
                found(words, &[], false, Some(portal))
            }
            Way::Open(portals) => {
                let words = format!(
                    "{unseen}: the way leads by portal{} {}, and no line of sight does",
                    if portals.len() == 1 { "" } else { "s" },
                    list(&portals)
                );
                found(words, &portals, false, None)
            }
            Way::None => found(format!("{unseen}: no portals lead there"), &[], false, None),
        }
    }

    /// The portals of a visit's chain, in words too.
    fn chain(&self, visit: u32) -> (String, Vec<u32>) {
        let chain = self.reached.chain(visit);
        let portals: Vec<u32> = chain.iter().filter_map(|visit| visit.portal).collect();
        let words = match (&portals[..], chain.last().is_some_and(|visit| visit.is_limited)) {
            (_, true) => ", as all is behind the limits of chains".to_owned(),
            ([], _) => " itself".to_owned(),
            ([portal], _) => format!(" through portal {portal}"),
            (portals, _) => format!(" through portals {}", list(portals)),
        };
        (words, portals)
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

/// The way from one cell to others, whatever can be seen along it.
enum Way {
    /// The first shut portal of the shortest, where all are shut somewhere.
    Shut(u32),
    /// The portals of the shortest that is open.
    Open(Vec<u32>),
    None,
}

/// The shortest way, that is open if there is one.
fn first_shut(cells: &Cells, start: u32, to: &[u32]) -> Way {
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
            Some(&portal) => Way::Shut(portal),
            None => Way::Open(portals),
        };
    }
    Way::None
}
