//! Portal: what is in no cell that is seen through open portals, or beside the portals through which its cells are seen.

use super::super::evidence::{CellTest, Evidence, Finding};
use super::super::frame::Frame;
use super::super::log::Log;
use super::super::run::is_parted;
use super::super::sets::{Clusters, Instances};
use super::stand::{Idle, detail, list, place_of, stand};
use crate::bits;
use crate::bounds::Side;
use crate::cull::frustum::batch::Planes;
use crate::cull::frustum::tree::Cut;
use crate::cull::portal::{Reached, Visit, walk_portals};
use crate::cull::pvs::{Targets, VisibleSets};
use crate::funnel::{Reason, Stage, Unit};
use crate::mesh::Mesh;
use crate::scene::{SceneCells, Tally};
use crate::view::Frustum;

/// Findings of the stage in one view, and memory that is used again.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Cache {
    reached: Reached,
    /// Whether the eye is in a cell, so that portals hide something.
    idle: Idle,
    /// One bit a slot, of the words that were live: in sight, and wholly so as far as portals go.
    seen: Vec<u64>,
    whole: Vec<u64>,
    starts: Vec<u32>,
    cut: Cut,
    kept: Vec<u64>,
}

/// Drops the instances of cells that are not seen, and those that are beside the portals of those that are.
pub(in super::super) fn instances(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Instances,
    log: &mut Log<'_>,
) {
    cache.idle = Idle::NoCells;
    let (Some(options), Some(cells)) = (frame.culler.portal, frame.scene.cells()) else { return };
    let mut dropped = Tally::default();
    let stands = match cells.sets().map(VisibleSets::targets) {
        // Cells for sets of instances are not rooms, and nothing is beyond their borders.
        Some(Targets::Instances) if cells.graph().portals().is_empty() => Err(Idle::NoPortals),
        _ => stand(frame, cells, &mut cache.starts),
    };
    match stands {
        Err(idle) => cache.idle = idle,
        Ok(view) => {
            cache.idle = Idle::No;
            walk_portals(cells.graph(), &view, &cache.starts, &options, &mut cache.reached);
            cache.look(frame, cells, set);
            dropped = cache.drop_unseen(frame, cells, set, log);
        }
    }
    log.instance_row(Stage::Portal, dropped);
}

impl Cache {
    /// Cells that were reached by the last cull, unless the stage did nothing.
    pub(in super::super) fn reached(&self) -> Option<&Reached> {
        (self.idle == Idle::No).then_some(&self.reached)
    }

    /// Finds which instances are in sight.
    fn look(&mut self, frame: &Frame<'_>, cells: &SceneCells, set: &Instances) {
        self.seen.resize(set.alive.len(), 0);
        self.whole.resize(set.alive.len(), 0);
        for &word in &set.live {
            (self.seen[word as usize], self.whole[word as usize]) = (0, 0);
        }
        let boxes = frame.scene.boxes();
        for visit in self.reached.visits() {
            let mut planes = None;
            for &slot in cells.slots_in(visit.cell) {
                let (word, bit) = (slot as usize / 64, 1 << (slot % 64));
                if set.alive[word] & !self.whole[word] & bit == 0 {
                    continue;
                }
                // In the cell of the eye the frustum has said all.
                let side = if visit.is_start() {
                    Side::Inside
                } else {
                    let planes = planes.get_or_insert_with(|| {
                        Planes::new(&bounds_of(
                            frame,
                            cells,
                            &self.reached,
                            visit,
                            frame.scene.origin(),
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

    /// Drops what is not in sight.
    fn drop_unseen(
        &self,
        frame: &Frame<'_>,
        cells: &SceneCells,
        set: &mut Instances,
        log: &mut Log<'_>,
    ) -> Tally {
        let (scene, mut sum) = (frame.scene, Tally::default());
        for &word in &set.live {
            let at = word as usize;
            let kept = self.seen[at] | cells.loose()[at] | scene.exempt()[at];
            let dropped = set.alive[at] & !kept;
            set.alive[at] &= kept;
            sum += scene.tally_of_bits(at, dropped);
            if log.wants_reasons() {
                for bit in bits::ones(dropped) {
                    let slot = word * 64 + bit as u32;
                    log.drop_slot(
                        slot,
                        Reason { stage: Stage::Portal, detail: detail(cells, slot) },
                    );
                }
            }
        }
        sum
    }

    /// Returns one bit for each slot of `word`: its instance is seen only in part, as far as
    /// portals go. No bit is set where the stage did nothing.
    pub(super) fn straddling(&self, frame: &Frame<'_>, word: usize) -> u64 {
        match frame.scene.cells().filter(|_| frame.culler.portal.is_some() && self.idle == Idle::No)
        {
            None => 0,
            Some(cells) => {
                self.seen[word]
                    & !self.whole[word]
                    & !cells.loose()[word]
                    & !frame.scene.exempt()[word]
            }
        }
    }

    /// Whether some cluster of an instance may be beside the portals.
    pub(super) fn may_cut(&self, frame: &Frame<'_>, slot: u32) -> bool {
        self.may_cut_mesh(frame, slot, frame.scene.mesh(slot))
    }

    /// The same of an instance that is drawn by a mesh, its own or that of its levels.
    fn may_cut_mesh(&self, frame: &Frame<'_>, slot: u32, mesh: &Mesh) -> bool {
        self.straddling(frame, slot as usize / 64) >> (slot % 64) & 1 == 1
            && mesh.clusters().len() > 1
            && is_parted(mesh)
            && frame.scene.is_rigid(slot)
    }

    /// Returns the portals through which the instance of `slot` is seen, or why it is not seen.
    pub(in super::super) fn finding(&self, frame: &Frame<'_>, slot: u32) -> Finding {
        let Some(cells) = frame.scene.cells() else { return Idle::NoCells.words().into() };
        if self.idle != Idle::No {
            return self.idle.words().into();
        }
        let own = cells.of_slot(slot);
        let place = place_of(own);
        if bits::get(cells.loose(), slot as usize) {
            let why =
                if own.is_empty() { "" } else { " and beyond, or moved since the last commit" };
            let instance = own.to_vec();
            let eye = self.starts.clone();
            let test = CellTest { instance, eye, in_sight: true, ..CellTest::default() };
            let words = format!("{place}{why}: seen from everywhere");
            return Finding::new(words, Evidence::Cells(test));
        }
        let start = self.reached.visits()[0].cell;
        let found = |words: String, portals: &[u32], in_sight: bool, shut: Option<u32>| {
            let (instance, eye) = (own.to_vec(), self.starts.clone());
            let test = CellTest { instance, eye, portals: portals.to_vec(), in_sight, shut };
            Finding::new(words, Evidence::Cells(test))
        };
        let visits =
            (0..).zip(self.reached.visits()).filter(|(_, visit)| own.contains(&visit.cell));
        let mut is_beside = None;
        for (number, visit) in visits {
            let planes =
                Planes::new(&bounds_of(frame, cells, &self.reached, visit, frame.scene.origin()));
            let (by, portals) = self.chain(number);
            if visit.is_start()
                || planes.classify_stored(frame.scene.boxes(), slot as usize) != Side::Outside
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

/// Drops the clusters that are beside the portals through which their instance is seen.
pub(in super::super) fn clusters(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Clusters,
    log: &mut Log<'_>,
) {
    let Some(cells) = frame.scene.cells() else { return };
    if cache.idle != Idle::No {
        let entered = log.left.counts;
        log.row(Stage::Portal, Unit::Clusters, entered);
        return;
    }
    set.filter(frame.scene, Stage::Portal, log, |runs, culled| {
        let (slot, mesh) = (runs[0].slot, &frame.scene.meshes()[runs[0].mesh as usize]);
        if !cache.may_cut_mesh(frame, slot, mesh) {
            return false;
        }
        cache.keep_clusters(frame, cells, slot, mesh);
        culled.clear();
        culled.extend(cache.kept.iter().map(|word| !word));
        true
    });
}

impl Cache {
    /// Sets the bits of the clusters of an instance that are in sight.
    fn keep_clusters(&mut self, frame: &Frame<'_>, cells: &SceneCells, slot: u32, mesh: &Mesh) {
        let scene = frame.scene;
        let own = cells.of_slot(slot);
        self.kept.clear();
        self.kept.resize(mesh.clusters().len().div_ceil(64), 0);
        for visit in self.reached.visits().iter().filter(|visit| own.contains(&visit.cell)) {
            let frustum = bounds_of(frame, cells, &self.reached, visit, [0.0; 3]);
            let planes = Planes::in_object_space(&frustum, scene.transform(slot), u32::MAX);
            self.cut.cull(frame.culler.level, &planes, mesh.cluster_nodes(), mesh.cluster_boxes());
            for word in self.cut.touched() {
                self.kept[word] |= self.cut.visible()[word];
            }
        }
    }
}

/// Returns the frustum around what is seen of the cell at `visit`, relative to `origin`.
fn bounds_of(
    frame: &Frame<'_>,
    cells: &SceneCells,
    reached: &Reached,
    visit: &Visit,
    origin: [f64; 3],
) -> Frustum {
    let extent = cells.extent(visit.cell);
    // How far from the eye anything is.
    let far = (0..3).map(|a| {
        let eye = visit.eye[a] - frame.scene.origin()[a];
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
fn first_shut(cells: &SceneCells, start: u32, to: &[u32]) -> Way {
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
