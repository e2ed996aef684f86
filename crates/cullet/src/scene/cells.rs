//! Cells of a scene: which instances are in which.

use std::sync::atomic::{AtomicU64, Ordering};

use super::Scene;
use super::column::{gather_bits, rearrange, rearrange_bits};
use crate::array::{self, Each};
use crate::bits;
use crate::bounds::Aabb;
use crate::cell::{CellGraph, CellLocator};
use crate::cull::pvs::{SetsError, Targets, VisibleSets};

/// A graph of cells, where those are, and the instances in each.
#[derive(Debug)]
pub(crate) struct SceneCells {
    graph: CellGraph,
    place: Box<dyn CellLocator>,
    /// Two numbers per slot: where its cells begin in `all`, and how many they are.
    of_slots: Vec<[u32; 2]>,
    /// Cells of one slot after the other, ascending; what moved leaves gaps.
    all: Vec<u32>,
    /// Place of the slot among the `slots` of that cell, for each entry of `all`.
    places: Vec<u32>,
    /// One bit a slot: seen from everywhere, for it is in no cell, reaches out of them, or moved since it was found.
    loose: Vec<u64>,
    /// One bit a slot: to be found. All of them are loose.
    moved: Vec<u64>,
    /// Whether nothing is to be found.
    is_found: bool,
    /// Slots of each cell, in any order.
    slots: Vec<Vec<u32>>,
    /// A box of each cell around those of its instances that are not loose. What moves makes it larger; a
    /// [commit](Scene::commit) fits it.
    extents: Vec<Aabb>,
    sets: Option<VisibleSets<'static>>,
    /// One bit a slot: added or moved since the sets were given.
    changed: Vec<u64>,
    /// Tells these cells from all others of the process.
    id: u64,
    /// Rises when slots, their cells or the sets are others.
    version: u64,
}

impl SceneCells {
    /// The graph.
    pub(crate) fn graph(&self) -> &CellGraph {
        &self.graph
    }

    /// Where the cells are.
    pub(crate) fn place(&self) -> &dyn CellLocator {
        &*self.place
    }

    /// Cells that the instance of a slot touches, ascending, as of the last commit.
    pub(crate) fn of_slot(&self, slot: u32) -> &[u32] {
        let [first, count] = self.of_slots.get(slot as usize).copied().unwrap_or_default();
        &self.all[first as usize..][..count as usize]
    }

    /// Slots of the instances that touch a cell, loose ones among them.
    pub(crate) fn slots_in(&self, cell: u32) -> &[u32] {
        self.slots.get(cell as usize).map_or(&[], Vec::as_slice)
    }

    /// A box around the instances in a cell that are not loose, relative to the scene's origin.
    pub(crate) fn extent(&self, cell: u32) -> Aabb {
        self.extents.get(cell as usize).copied().unwrap_or(Aabb::EMPTY)
    }

    /// One bit a slot: instances that are seen from everywhere.
    pub(crate) fn loose(&self) -> &[u64] {
        &self.loose
    }

    /// Returns the sets of what may be seen from each cell, if any.
    pub(crate) fn sets(&self) -> Option<&VisibleSets<'static>> {
        self.sets.as_ref()
    }

    /// One bit a slot: instances that were added or moved since the sets were given.
    pub(crate) fn changed(&self) -> &[u64] {
        &self.changed
    }

    /// Another where the same slot may be of other cells, or in other sets.
    pub(crate) fn version(&self) -> (u64, u64) {
        (self.id, self.version)
    }

    /// Notes that slots were sorted: where what is in slot i was.
    pub(super) fn gather(&mut self, from: &[u32]) {
        gather_bits(&mut self.changed, from);
    }

    /// Moves what is known of slots.
    pub(super) fn rearrange(&mut self, moves: &[[u32; 2]]) {
        rearrange(&mut self.of_slots, moves);
        rearrange_bits(&mut self.loose, moves);
        rearrange_bits(&mut self.moved, moves);
        rearrange_bits(&mut self.changed, moves);
        for &[_, slot] in moves {
            let [first, count] = self.of_slots[slot as usize];
            for at in first as usize..(first + count) as usize {
                self.slots[self.all[at] as usize][self.places[at] as usize] = slot;
            }
        }
        self.version += u64::from(!moves.is_empty());
    }

    /// Makes room for some slots.
    fn resize(&mut self, count: usize) {
        self.of_slots.resize(count, [0; 2]);
        self.loose.resize(count.div_ceil(64), 0);
        self.moved.resize(count.div_ceil(64), 0);
        self.changed.resize(count.div_ceil(64), 0);
    }

    /// Notes that the instance of a slot is to be found.
    fn loosen(&mut self, slot: usize) {
        bits::set(&mut self.loose, slot, true);
        bits::set(&mut self.moved, slot, true);
        self.is_found = false;
    }

    /// Takes a slot out of the lists of its cells.
    fn take_out(&mut self, slot: u32) {
        let [first, count] = std::mem::take(&mut self.of_slots[slot as usize]);
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

impl Scene {
    /// Gives the scene cells, and finds which instances are in them: all those that each touches by its bounds. From then on
    /// [`Culler::portal`](crate::Culler::portal) culls by them.
    ///
    /// An instance that touches no cell, that reaches [out of cells and their walls](CellLocator::is_within), or that moved
    /// since the last [`commit`](Self::commit), [`commit_slice`](Self::commit_slice) or [`refit`](Self::refit) counts as
    /// seen from everywhere. O(instances · log of the pieces).
    pub fn set_cells(&mut self, graph: CellGraph, place: impl CellLocator + 'static) {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        self.cells = Some(Box::new(SceneCells {
            graph,
            place: Box::new(place),
            of_slots: Vec::new(),
            all: Vec::new(),
            places: Vec::new(),
            loose: Vec::new(),
            moved: Vec::new(),
            is_found: false,
            slots: Vec::new(),
            extents: Vec::new(),
            sets: None,
            changed: Vec::new(),
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            version: 0,
        }));
        self.assign_all();
        self.change += 1;
    }

    /// Gives the cells sets of what may be seen from each. From then on [`Culler::pvs`](crate::Culler::pvs) culls by them,
    /// with portals and without.
    ///
    /// Sets of [cells](Targets::Cells) hold whatever moves, for an instance is in the cells that it touches. Those of
    /// [instances](Targets::Instances) hold for the instances as they are now, by the indices of their handles: what is
    /// added or moved from here on is seen from everywhere, and the sets are true for as long as what they saw something hidden
    /// behind stays where it is. O(cells).
    ///
    /// # Errors
    /// If the scene has no cells, or more or fewer than there are sets; nothing is changed then.
    pub fn set_visible_sets(&mut self, sets: VisibleSets<'static>) -> Result<(), SetsError> {
        let cells = self.cells.as_mut().ok_or(SetsError::NoCells)?;
        let (found, count) = (sets.cell_count(), cells.graph.cell_count());
        let of_cells = sets.targets() == Targets::Cells;
        if found != count || (of_cells && sets.target_count() != count) {
            let sets = if found == count { sets.target_count() } else { found };
            return Err(SetsError::Cells { sets, cells: count });
        }
        cells.sets = Some(sets);
        cells.changed.fill(0);
        cells.version += 1;
        self.change += 1;
        Ok(())
    }

    /// The sets of the scene's cells, if it has any: to ask who sees whom, and what must be there where the eye goes.
    #[must_use]
    pub fn visible_sets(&self) -> Option<&VisibleSets<'static>> {
        self.cells.as_ref()?.sets.as_ref()
    }

    /// Takes the cells from the scene, and their sets.
    pub fn clear_cells(&mut self) {
        self.cells = None;
        self.change += 1;
    }

    /// The graph of the scene's cells, if it has any.
    #[must_use]
    pub fn cell_graph(&self) -> Option<&CellGraph> {
        self.cells.as_ref().map(|cells| &cells.graph)
    }

    /// The cell of a point in world space, if the scene has cells; see [`CellLocator::cell_of`].
    #[must_use]
    pub fn cell_of(&self, point: [f64; 3]) -> Option<u32> {
        self.cells.as_ref()?.place.cell_of(point)
    }

    /// Cells that the instance of a slot touches, ascending, as of the last commit; none where the scene has none.
    #[must_use]
    pub fn cells_of(&self, slot: u32) -> &[u32] {
        self.cells.as_ref().map_or(&[], |cells| cells.of_slot(slot))
    }

    /// Opens or shuts a portal of the cells, as a door does. Costs nothing, and moves no instance. Nothing where there is
    /// no such portal.
    pub fn set_portal_open(&mut self, portal: u32, open: bool) {
        if let Some(cells) = &mut self.cells {
            cells.graph.set_open(portal, open);
            self.change += 1;
        }
    }

    /// The cells, for the stage that culls by them.
    pub(crate) fn cells(&self) -> Option<&SceneCells> {
        self.cells.as_deref()
    }

    /// Notes that the instance of a slot may be elsewhere.
    pub(super) fn loosen(&mut self, slot: u32) {
        let Some(cells) = &mut self.cells else { return };
        cells.resize((slot as usize + 1).max(cells.of_slots.len()));
        cells.loosen(slot as usize);
        bits::set(&mut cells.changed, slot as usize, true);
    }

    /// Does what moves no instance, though it touches all: none counts as changed by it.
    pub(super) fn without_change(&mut self, run: impl FnOnce(&mut Self)) {
        let changed = self.cells.as_ref().map(|cells| cells.changed.clone());
        run(self);
        if let (Some(cells), Some(changed)) = (&mut self.cells, changed) {
            cells.changed = changed;
        }
    }

    /// Finds the cells of all instances.
    pub(super) fn assign_all(&mut self) {
        if let Some(cells) = &mut self.cells {
            let count = self.hierarchy.slot_count() as usize;
            let cell_count = cells.graph.cell_count() as usize;
            cells.all.clear();
            cells.places.clear();
            cells.of_slots.clear();
            cells.slots.iter_mut().for_each(Vec::clear);
            cells.slots.resize(cell_count, Vec::new());
            cells.extents.clear();
            cells.extents.resize(cell_count, Aabb::EMPTY);
            // Bits of slots that are no more must not stay.
            cells.loose.clear();
            cells.moved.clear();
            cells.resize(count);
            (0..count).for_each(|slot| cells.loosen(slot));
            // Also where there are no slots: others may have been.
            cells.is_found = false;
            self.assign_moved();
        }
    }

    /// Finds the cells of the instances that moved.
    pub(super) fn assign_moved(&mut self) {
        if self.cells.as_ref().is_none_or(|cells| cells.is_found) {
            return;
        }
        let Some(mut cells) = self.cells.take() else { return };
        let mut moved = std::mem::take(&mut cells.moved);
        cells.close_gaps();
        for slot in bits::in_words(&moved).map(|slot| slot as u32) {
            cells.take_out(slot);
            let first = cells.all.len();
            let mut is_loose = true;
            let b = self.bounds(slot);
            if !self.is_removed(slot) && b.is_finite() && !b.is_empty() {
                let in_world = |v: [f32; 3]| array::from_fn(|a| f64::from(v[a]) + self.origin[a]);
                let [min, max] = [b.min, b.max].each(in_world);
                cells.place.cells_touching(min, max, &mut cells.all);
                cells.all[first..].sort_unstable();
                let mut kept = first;
                for i in first..cells.all.len() {
                    let cell = cells.all[i];
                    // What the graph does not have is nowhere.
                    if cell < cells.graph.cell_count()
                        && cells.all[first..kept].last() != Some(&cell)
                    {
                        cells.all[kept] = cell;
                        kept += 1;
                    }
                }
                cells.all.truncate(kept);
                is_loose = kept == first || !cells.place.is_within(min, max);
            }
            let stored = self.hierarchy.boxes().get(slot as usize);
            cells.put_in(slot, first, (!is_loose).then_some(&stored));
            bits::set(&mut cells.loose, slot as usize, is_loose);
        }
        moved.fill(0);
        cells.moved = moved;
        cells.version += 1;
        cells.is_found = true;
        self.cells = Some(cells);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, MeshData};
    use crate::scene::{Instance, InstanceFlags};
    use crate::transform::Transform;
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
    fn check(scene: &Scene) {
        let cells = scene.cells().expect("a scene with cells");
        let mut count = 0;
        for slot in 0..scene.slot_count() {
            let [first, own] = cells.of_slots[slot as usize];
            let mut expected = Vec::new();
            let b = scene.bounds(slot);
            if !scene.is_removed(slot) {
                let [min, max] = [b.min, b.max].each(|v| v.each(f64::from));
                cells.place.cells_touching(min, max, &mut expected);
            }
            assert_eq!(cells.of_slot(slot), expected, "slot {slot}");
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
        scene.commit();
        scene.set_cells(CellGraph::new(8, Vec::new()).expect("cells alone"), Row(8));
        check(&scene);
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
                    scene.commit();
                }
                1 | 2 => scene.refit(),
                _ => {
                    scene.commit_slice();
                }
            }
            check(&scene);
        }
    }
}
