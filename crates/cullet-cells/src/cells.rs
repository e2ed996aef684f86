//! Cells of a scene: which instances are in which.

use alloc::boxed::Box;
use alloc::vec::Vec;

use cullet::bounds::Aabb;
use cullet::math;
use cullet::{CullError, Scene, scene::SceneChange};

use crate::bits;
use crate::cell::{CellGraph, CellLocator};
use crate::pvs::{SetsError, Targets, VisibleSets};

/// A graph of cells, where those are, and the instances of a scene in each.
///
/// ```text
///            scene.log_changes()
///   Scene ─────────────────────────► Cells ── CellView::on ──► CellCandidates ──► Culler::cull_among
///            Cells::update           graph, places, sets        eye, visits, rows
/// ```
///
/// [`update`](Self::update) it after each commit of the scene, and in frames in which something
/// moved: the cost is that of what changed. Instances that moved since count as seen from
/// everywhere.
#[derive(Debug)]
pub struct Cells {
    graph: CellGraph,
    place: Box<dyn CellLocator>,
    /// Two numbers per slot: where its cells begin in `all`, and how many they are.
    of_slots: Vec<[u32; 2]>,
    /// Cells of one slot after the other, ascending; what moved leaves gaps.
    all: Vec<u32>,
    /// Place of the slot among the `slots` of that cell, for each entry of `all`.
    places: Vec<u32>,
    /// One bit a slot: seen from everywhere, for it is in no cell or reaches out of them.
    loose: Vec<u64>,
    /// Slots that are to be found, some more than once.
    lost: Vec<u32>,
    /// Slots of each cell, in any order.
    slots: Vec<Vec<u32>>,
    /// A box of each cell around those of its instances that are not loose. What moves makes it
    /// larger; a [commit](Scene::commit) fits it.
    extents: Vec<Aabb>,
    sets: Option<VisibleSets<'static>>,
    /// One bit for each index of a handle: added or moved since the sets were given.
    changed: Vec<u64>,
    /// Tells these cells from all others of the process.
    id: u64,
    /// Rises when slots, their cells or the sets are others.
    version: u64,
    // The scene, as it was when the cells were updated.
    scene: u64,
    order: u64,
    origin: [f64; 3],
    logged: u64,
}

impl Cells {
    /// Finds which instances of a scene are in which cells: all those that each touches by its
    /// bounds. The scene [logs](Scene::log_changes) its changes from here on.
    ///
    /// An instance that touches no cell, or that reaches [out of cells and their
    /// walls](CellLocator::is_within), counts as seen from everywhere. O(instances · log of the
    /// pieces).
    #[must_use]
    pub fn new(scene: &mut Scene, graph: CellGraph, place: impl CellLocator + 'static) -> Self {
        scene.log_changes();
        let mut cells = Self {
            graph,
            place: Box::new(place),
            of_slots: Vec::new(),
            all: Vec::new(),
            places: Vec::new(),
            loose: Vec::new(),
            lost: Vec::new(),
            slots: Vec::new(),
            extents: Vec::new(),
            sets: None,
            changed: Vec::new(),
            id: math::unique(),
            version: 0,
            scene: scene.id(),
            order: 0,
            origin: [0.0; 3],
            logged: 0,
        };
        cells.find_all(scene);
        cells.note(scene);
        cells
    }

    /// Finds again what changed since the last time, at the cost of that. After a
    /// [commit](Scene::commit) or a [rebase](Scene::rebase), and for another scene, it finds all
    /// instances.
    pub fn update(&mut self, scene: &Scene) {
        let is_same = self.scene == scene.id();
        if is_same && self.logged == scene.logged() {
            return;
        }
        let mut are_all = false;
        match scene.changes_since(self.logged).filter(|_| is_same) {
            None => {
                are_all = true;
                self.changed.fill(u64::MAX);
                for handle in scene.slots().filter_map(|slot| scene.handle(slot)) {
                    self.note_changed(handle.index);
                }
            }
            Some(changes) => {
                for change in changes {
                    match change {
                        SceneChange::Moved(slot) => {
                            self.lost.push(slot);
                            if let Some(handle) = scene.handle(slot) {
                                self.note_changed(handle.index);
                            }
                        }
                        SceneChange::Permuted(slot) => self.lost.push(slot),
                        SceneChange::All => are_all = true,
                    }
                }
            }
        }
        match are_all {
            true => self.find_all(scene),
            false => self.find_lost(scene),
        }
        self.note(scene);
    }

    /// Gives the cells sets of what may be seen from each.
    ///
    /// Sets of [cells](Targets::Cells) hold whatever moves, for an instance is in the cells that it
    /// touches. Those of [instances](Targets::Instances) hold for the instances as they are now, by
    /// the indices of their handles: what is added or moved from here on is seen from everywhere,
    /// and the sets are true for as long as what they saw something hidden behind stays where it
    /// is. O(cells).
    ///
    /// # Errors
    /// If there are more or fewer cells than sets; nothing is changed then.
    pub fn set_visible_sets(&mut self, sets: VisibleSets<'static>) -> Result<(), SetsError> {
        let (found, count) = (sets.cell_count(), self.graph.cell_count());
        let of_cells = sets.targets() == Targets::Cells;
        if found != count || (of_cells && sets.target_count() != count) {
            let sets = if found == count { sets.target_count() } else { found };
            return Err(SetsError::Cells { sets, cells: count });
        }
        self.sets = Some(sets);
        self.changed.fill(0);
        self.version += 1;
        Ok(())
    }

    /// Takes the sets away: portals alone hide from then on.
    pub fn clear_visible_sets(&mut self) {
        self.sets = None;
        self.version += 1;
    }

    /// Returns the sets of what may be seen from each cell, if any: to ask who sees whom, and what
    /// must be there where the eye goes.
    #[must_use]
    pub fn visible_sets(&self) -> Option<&VisibleSets<'static>> {
        self.sets.as_ref()
    }

    /// Returns the graph.
    #[must_use]
    pub fn graph(&self) -> &CellGraph {
        &self.graph
    }

    /// Returns the cell of a point in world space; see [`CellLocator::cell_of`].
    #[must_use]
    pub fn cell_of(&self, point: [f64; 3]) -> Option<u32> {
        self.place.cell_of(point)
    }

    /// Returns the cells that the instance of `slot` touches, ascending, as of the last update. An
    /// empty slot keeps those of the instance that was removed until slots are permuted.
    #[must_use]
    pub fn cells_of(&self, slot: u32) -> &[u32] {
        let [first, count] = self.of_slots.get(slot as usize).copied().unwrap_or_default();
        &self.all[first as usize..][..count as usize]
    }

    /// Opens or shuts a portal, as a door does. It costs nothing and moves no instance. It does
    /// nothing where there is no such portal.
    pub fn set_portal_open(&mut self, portal: u32, open: bool) {
        self.graph.set_open(portal, open);
    }

    /// Whether the cells are of the scene as it is, but for instances that moved.
    ///
    /// # Errors
    /// [`CullError::Order`] where they are not.
    pub(crate) fn check(&self, scene: &Scene) -> Result<(), CullError> {
        let is_same = self.scene == scene.id() && self.origin == scene.origin();
        if is_same && self.order == scene.order_version() {
            return Ok(());
        }
        Err(CullError::Order { found: self.order, expected: scene.order_version() })
    }

    /// Returns where the cells are.
    pub(crate) fn place(&self) -> &dyn CellLocator {
        &*self.place
    }

    /// Returns the slots of the instances that touch a cell, loose ones among them.
    pub(crate) fn slots_in(&self, cell: u32) -> &[u32] {
        self.slots.get(cell as usize).map_or(&[], Vec::as_slice)
    }

    /// Returns a box around the instances in a cell that are not loose, relative to the scene's
    /// origin.
    pub(crate) fn extent(&self, cell: u32) -> Aabb {
        self.extents.get(cell as usize).copied().unwrap_or(Aabb::EMPTY)
    }

    /// Returns one bit for each slot of `word`: instances that are seen from everywhere.
    pub(crate) fn loose(&self, word: usize) -> u64 {
        // Words that are not there are of slots that came since.
        self.loose.get(word).copied().unwrap_or(u64::MAX)
    }

    /// Whether the instance with this index of a handle was added or moved since the sets were
    /// given.
    pub(crate) fn has_changed(&self, index: u32) -> bool {
        self.changed.get(index as usize / 64).is_some_and(|w| w >> (index % 64) & 1 == 1)
    }

    /// Returns a number that is another where the same slot may be of other cells, or in other
    /// sets.
    pub(crate) fn version(&self) -> (u64, u64) {
        (self.id, self.version)
    }

    /// Returns the number of changes that the scene had logged at the last update.
    pub(crate) fn logged(&self) -> u64 {
        self.logged
    }

    fn note(&mut self, scene: &Scene) {
        self.scene = scene.id();
        (self.order, self.origin) = (scene.order_version(), scene.origin());
        self.logged = scene.logged();
    }

    fn note_changed(&mut self, index: u32) {
        let words = (index as usize / 64 + 1).max(self.changed.len());
        self.changed.resize(words, 0);
        bits::set(&mut self.changed, index as usize, true);
    }

    /// Finds the cells of all instances.
    fn find_all(&mut self, scene: &Scene) {
        let cell_count = self.graph.cell_count() as usize;
        self.all.clear();
        self.places.clear();
        self.of_slots.clear();
        // Bits of slots that are no more must not stay.
        self.loose.clear();
        self.slots.iter_mut().for_each(Vec::clear);
        self.slots.resize(cell_count, Vec::new());
        self.extents.clear();
        self.extents.resize(cell_count, Aabb::EMPTY);
        self.lost.clear();
        self.lost.extend(0..scene.slot_count());
        self.find_lost(scene);
    }

    /// Finds the cells of the instances that are lost.
    fn find_lost(&mut self, scene: &Scene) {
        let count = scene.slot_count() as usize;
        self.of_slots.resize(count, [0; 2]);
        self.loose.resize(count.div_ceil(64), 0);
        self.close_gaps();
        let lost = core::mem::take(&mut self.lost);
        // All of them leave before one comes in, for some may be where another was.
        lost.iter().for_each(|&slot| self.take_out(slot));
        for &slot in &lost {
            // One that is there more than once is found anew.
            self.take_out(slot);
            let first = self.all.len();
            let mut is_loose = true;
            let b = scene.bounds(slot);
            if !scene.is_removed(slot) && b.is_finite() && !b.is_empty() {
                let in_world =
                    |v: [f32; 3]| core::array::from_fn(|a| f64::from(v[a]) + scene.origin()[a]);
                let [min, max] = [b.min, b.max].map(in_world);
                self.place.cells_touching(min, max, &mut self.all);
                self.all[first..].sort_unstable();
                let mut kept = first;
                for i in first..self.all.len() {
                    let cell = self.all[i];
                    // Cells missing from the graph have no instances.
                    let is_new = self.all[first..kept].last() != Some(&cell);
                    if cell < self.graph.cell_count() && is_new {
                        self.all[kept] = cell;
                        kept += 1;
                    }
                }
                self.all.truncate(kept);
                is_loose = kept == first || !self.place.is_within(min, max);
            }
            let stored = scene.boxes().get(slot as usize);
            self.put_in(slot, first, (!is_loose).then_some(&stored));
            bits::set(&mut self.loose, slot as usize, is_loose);
        }
        self.lost = lost;
        self.lost.clear();
        self.version += 1;
    }

    /// Takes a slot out of the lists of its cells.
    fn take_out(&mut self, slot: u32) {
        let [first, count] = core::mem::take(&mut self.of_slots[slot as usize]);
        for at in first as usize..(first + count) as usize {
            let (cell, place) = (self.all[at], self.places[at]);
            let slots = &mut self.slots[cell as usize];
            slots.swap_remove(place as usize);
            // The last one of the list is where this one was.
            if let Some(&last) = slots.get(place as usize) {
                let [first, count] = self.of_slots[last as usize];
                let own = first as usize..(first + count) as usize;
                if let Some(at) = own.into_iter().find(|&at| self.all[at] == cell) {
                    self.places[at] = place;
                }
            }
        }
    }

    /// Puts a slot into the lists of its cells, which are those of `all` from `first` on.
    fn put_in(&mut self, slot: u32, first: usize, bounds: Option<&Aabb>) {
        for &cell in &self.all[first..] {
            let slots = &mut self.slots[cell as usize];
            self.places.push(slots.len() as u32);
            slots.push(slot);
            if let Some(bounds) = bounds {
                let extent = &mut self.extents[cell as usize];
                *extent = extent.union(bounds);
            }
        }
        self.of_slots[slot as usize] = [first as u32, (self.all.len() - first) as u32];
    }

    /// Closes the gaps in `all` where they are more than what is there.
    fn close_gaps(&mut self) {
        let used: usize = self.slots.iter().map(Vec::len).sum();
        if self.all.len() <= 2 * used + 1024 {
            return;
        }
        let (mut all, mut places) = (Vec::with_capacity(used), Vec::with_capacity(used));
        for [first, count] in &mut self.of_slots {
            let own = *first as usize..(*first + *count) as usize;
            *first = all.len() as u32;
            all.extend_from_slice(&self.all[own.clone()]);
            places.extend_from_slice(&self.places[own]);
        }
        (self.all, self.places) = (all, places);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::{Instance, InstanceFlags, Mesh, MeshData, Transform};
    use cullet_testkit::Rng;

    /// Cells in a row along x, ten units each, with nothing beyond.
    #[derive(Debug)]
    struct Row(u32);

    impl CellLocator for Row {
        fn cell_of(&self, [x, ..]: [f64; 3]) -> Option<u32> {
            (x >= 0.0 && x < f64::from(self.0) * 10.0).then(|| (x / 10.0) as u32)
        }

        fn cells_touching(&self, min: [f64; 3], max: [f64; 3], cells: &mut Vec<u32>) {
            let touches =
                |c: &u32| min[0] <= f64::from(*c + 1) * 10.0 && max[0] >= f64::from(*c) * 10.0;
            cells.extend((0..self.0).filter(touches));
        }

        fn is_free(&self, _: [f64; 3], _: [f64; 3]) -> bool {
            true
        }

        fn is_within(&self, min: [f64; 3], max: [f64; 3]) -> bool {
            min[0] >= 0.0 && max[0] <= f64::from(self.0) * 10.0
        }
    }

    /// The lists of slots are those of the cells of each slot, and places lead back.
    fn check(scene: &Scene, cells: &Cells) {
        let mut count = 0;
        for slot in 0..scene.slot_count() {
            let [first, own] = cells.of_slots[slot as usize];
            let b = scene.bounds(slot);
            if !scene.is_removed(slot) {
                let mut expected = Vec::new();
                let [min, max] = [b.min, b.max].map(|v| v.map(f64::from));
                cells.place.cells_touching(min, max, &mut expected);
                assert_eq!(cells.cells_of(slot), expected, "slot {slot}");
            }
            for at in first as usize..(first + own) as usize {
                let listed = &cells.slots[cells.all[at] as usize];
                assert_eq!(listed[cells.places[at] as usize], slot);
            }
            count += own as usize;
        }
        assert_eq!(cells.slots.iter().map(Vec::len).sum::<usize>(), count);
        for (cell, slots) in (0..).zip(&cells.slots) {
            for &slot in slots.iter().filter(|&&slot| !bits::get(&cells.loose, slot as usize)) {
                let (extent, b) = (cells.extent(cell), scene.boxes().get(slot as usize));
                assert_eq!(extent.union(&b), extent, "cell {cell}, slot {slot}");
            }
        }
    }

    #[test]
    fn what_moves_is_in_the_lists_of_the_cells_where_it_is() {
        let positions = vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0]];
        let data = MeshData { positions, indices: vec![0, 1, 2], ..MeshData::default() };
        let mut rng = Rng(3);
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::new(data).expect("a triangle"));
        let mut handles = Vec::new();
        let place =
            |rng: &mut Rng| Transform::from_translation([rng.range(-20.0, 120.0), 0.0, 0.0]);
        let add = |scene: &mut Scene, rng: &mut Rng| {
            let flags = InstanceFlags { dynamic: true, ..InstanceFlags::default() };
            let instance = Instance { flags, ..Instance::new(mesh, place(rng)) };
            scene.add(instance).expect("a mesh that is there")
        };
        for _ in 0..3000 {
            handles.push(add(&mut scene, &mut rng));
        }
        scene.commit(&cullet::Culler::default());
        let graph = CellGraph::new(8, Vec::new()).expect("cells alone");
        let mut cells = Cells::new(&mut scene, graph, Row(8));
        check(&scene, &cells);
        for round in 0..60 {
            for _ in 0..rng.below(200) {
                let at = rng.index(handles.len());
                match rng.below(10) {
                    0 => scene.remove(handles.swap_remove(at)).expect("an instance"),
                    1 => handles.push(add(&mut scene, &mut rng)),
                    _ => scene.set_transform(handles[at], place(&mut rng)).expect("an instance"),
                }
            }
            match round % 5 {
                0 => {
                    scene.commit(&cullet::Culler::default());
                }
                1 | 2 => scene.refit(),
                _ => {
                    scene.commit_slice();
                }
            }
            cells.update(&scene);
            check(&scene, &cells);
        }
    }
}
