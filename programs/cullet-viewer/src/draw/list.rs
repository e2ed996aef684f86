//! From what is visible to draw calls: a list of slots grouped by mesh, and ranges of triangles.

use std::ops::Range;

use cullet::Visible;

use super::geometry::Geometry;
use super::groups::{Instances, NO_GROUP};

/// Some instances of a group, one after the other in the list, and what is drawn of each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Item {
    pub(super) group: u32,
    /// Entries of the list.
    pub(super) entries: Range<u32>,
    pub(super) what: What,
}

/// The triangles of a mesh that are drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum What {
    /// Successive triangles of the mesh.
    Triangles(Range<u32>),
    /// Entries of [`DrawList::picked`].
    Picked(Range<u32>),
}

/// Entries that are uploaded together: 4 KiB.
const BLOCK: usize = 1024;

/// The list that one view draws, kept from frame to frame: only changed parts are made and uploaded
/// again.
#[derive(Debug, Default)]
pub(super) struct DrawList {
    /// Slots. Every group has its place, as large as all its instances, so that a change in one
    /// moves nothing of another.
    pub(super) entries: Vec<u32>,
    pub(super) items: Vec<Item>,
    /// Triangles of meshes, where single triangles were culled.
    pub(super) picked: Vec<u32>,
    /// The group of each run of `picked`.
    picks: Vec<(u32, Range<u32>)>,
    source: ListSource,
    /// One a block of entries: whether it has to be uploaded.
    dirty: Vec<bool>,
    /// How many entries of each group are in use.
    used: Vec<u32>,
    partial: Vec<Item>,
}

/// The source that a list was made from.
#[derive(Debug, Default)]
enum ListSource {
    #[default]
    Nothing,
    All {
        layers: u32,
    },
    Visible(Box<Visible>),
}

impl DrawList {
    /// Forgets everything, for another scene.
    pub(super) fn reset(&mut self, instances: &Instances) {
        let len = instances.groups.last().map_or(0, |g| g.first + g.count) as usize;
        self.entries.clear();
        self.entries.resize(len, 0);
        self.dirty.clear();
        self.dirty.resize(len.div_ceil(BLOCK), true);
        self.items.clear();
        self.picked.clear();
        self.picks.clear();
        self.source = ListSource::Nothing;
    }

    /// Makes the list follow `visible`, or everything in `layers`; true if it changed. Costs a
    /// comparison where it did not, else some nanoseconds a visible instance.
    pub(super) fn update(
        &mut self,
        geometry: &Geometry,
        instances: &Instances,
        visible: Option<&Visible>,
        layers: u32,
    ) -> bool {
        match (&mut self.source, visible) {
            (ListSource::All { layers: known }, None) if *known == layers => return false,
            (ListSource::Visible(known), Some(v)) => {
                if same(known, v) {
                    return false;
                }
                known.whole.clone_from(&v.whole);
                known.partial.clone_from(&v.partial);
                known.triangle_ranges.clone_from(&v.triangle_ranges);
                known.triangles.clone_from(&v.triangles);
            }
            (source, Some(v)) => {
                *source = ListSource::Visible(Box::new(Visible {
                    whole: v.whole.clone(),
                    partial: v.partial.clone(),
                    triangle_ranges: v.triangle_ranges.clone(),
                    triangles: v.triangles.clone(),
                    ..Visible::default()
                }));
            }
            (source, None) => *source = ListSource::All { layers },
        }
        self.used.clear();
        self.used.resize(instances.groups.len(), 0);
        self.partial.clear();
        self.picked.clear();
        self.picks.clear();
        match visible {
            None => {
                for (slot, own) in instances.layers.iter().enumerate() {
                    if own & layers != 0 {
                        self.push(instances, slot as u32, 0);
                    }
                }
            }
            Some(v) if v.triangle_ranges.is_empty() => self.push_clusters(geometry, instances, v),
            Some(v) => self.push_triangles(geometry, instances, v),
        }
        self.collect(geometry, instances);
        true
    }

    /// Adds a slot to its group at a level of detail: the group and the entry.
    fn push(&mut self, instances: &Instances, slot: u32, level: u32) -> Option<(u32, u32)> {
        let group = *instances.group.get(slot as usize).filter(|g| **g != NO_GROUP)?;
        let group = instances.at_level(group, level)?;
        let place = &instances.groups[group as usize];
        let used = &mut self.used[group as usize];
        // A result that names a slot twice is not a culler's; it must not reach into the next
        // group.
        if *used == place.count {
            return None;
        }
        let entry = place.first + *used;
        *used += 1;
        let held = &mut self.entries[entry as usize];
        if *held != slot {
            *held = slot;
            self.dirty[entry as usize / BLOCK] = true;
        }
        Some((group, entry))
    }

    /// Whole and partial instances, merged in the order of their slots: where two surfaces are
    /// equally near, the first one drawn is seen, and that must not depend on what was culled.
    fn push_clusters(&mut self, geometry: &Geometry, instances: &Instances, v: &Visible) {
        let mut partial = v.partial.chunk_by(|a, b| a.slot == b.slot).peekable();
        for range in &v.whole {
            for slot in range.first..range.first.saturating_add(range.count) {
                while let Some(ranges) = partial.next_if(|p| p[0].slot < slot) {
                    self.push_partial(geometry, instances, ranges);
                }
                self.push(instances, slot, 0);
            }
        }
        partial.for_each(|ranges| self.push_partial(geometry, instances, ranges));
    }

    fn push_partial(
        &mut self,
        geometry: &Geometry,
        instances: &Instances,
        ranges: &[cullet::draw::DrawRange],
    ) {
        let cullet::draw::DrawRange { slot, level, .. } = ranges[0];
        let Some((group, entry)) = self.push(instances, slot, level) else { return };
        let mesh = &geometry.meshes[instances.groups[group as usize].kind.mesh as usize];
        for r in ranges {
            let triangles = mesh.triangles(r.first_cluster, r.cluster_count);
            let what = What::Triangles(triangles);
            self.partial.push(Item { group, entries: entry..entry + 1, what });
        }
    }

    fn push_triangles(&mut self, geometry: &Geometry, instances: &Instances, v: &Visible) {
        for r in &v.triangle_ranges {
            let Some((group, entry)) = self.push(instances, r.slot, r.level) else { continue };
            let mesh = &geometry.meshes[instances.groups[group as usize].kind.mesh as usize];
            // Of a mesh that holds levels never all is drawn.
            if r.level == 0 && r.count == mesh.whole {
                continue;
            }
            let end = (r.first as usize).saturating_add(r.count as usize).min(v.triangles.len());
            let triangles = v.triangles.get(r.first as usize..end).unwrap_or_default();
            let drawable = mesh.triangles(0, u32::MAX).end;
            let start = self.picked.len() as u32;
            self.picked.extend(triangles.iter().copied().filter(|&t| t < drawable));
            let range = start..self.picked.len() as u32;
            self.picks.push((group, range.clone()));
            let what = What::Picked(range);
            self.partial.push(Item { group, entries: entry..entry + 1, what });
        }
    }

    /// Makes items of what is whole, between those of what is not.
    fn collect(&mut self, geometry: &Geometry, instances: &Instances) {
        self.items.clear();
        // Each group's are in order already, and stay so.
        self.partial.sort_by_key(|item| (item.group, item.entries.start));
        let mut partial = self.partial.drain(..).peekable();
        for (number, group) in instances.groups.iter().enumerate() {
            let number = number as u32;
            let whole = What::Triangles(0..geometry.meshes[group.kind.mesh as usize].whole);
            let end = group.first + self.used[number as usize];
            let mut next = group.first;
            while let Some(item) = partial.next_if(|p| p.group == number) {
                let entry = item.entries.start;
                if next < entry {
                    let entries = next..entry;
                    self.items.push(Item { group: number, entries, what: whole.clone() });
                }
                next = entry + 1;
                match self.items.last_mut() {
                    // Neighbours that show the same are one call.
                    Some(last)
                        if last.group == number
                            && last.entries.end == entry
                            && last.what == item.what =>
                    {
                        last.entries.end = entry + 1;
                    }
                    _ => self.items.push(item),
                }
            }
            if next < end {
                self.items.push(Item { group: number, entries: next..end, what: whole });
            }
        }
    }

    /// The picked triangles, in their order, with the mesh that each run of them is of.
    pub(super) fn picked_meshes<'a>(
        &'a self,
        instances: &'a Instances,
    ) -> impl Iterator<Item = (u32, &'a [u32])> {
        self.picks.iter().map(|(group, range)| {
            let mesh = instances.groups[*group as usize].kind.mesh;
            (mesh, &self.picked[range.start as usize..range.end as usize])
        })
    }

    /// The ranges of entries that changed since the last call.
    pub(super) fn take_dirty(&mut self, mut upload: impl FnMut(Range<usize>, &[u32])) {
        let mut at = 0;
        while at < self.dirty.len() {
            if !self.dirty[at] {
                at += 1;
                continue;
            }
            let first = at;
            while at < self.dirty.len() && self.dirty[at] {
                self.dirty[at] = false;
                at += 1;
            }
            let range = first * BLOCK..(at * BLOCK).min(self.entries.len());
            upload(range.clone(), &self.entries[range]);
        }
    }
}

/// Whether two results draw the same.
fn same(a: &Visible, b: &Visible) -> bool {
    a.whole == b.whole
        && a.partial == b.partial
        && a.triangle_ranges == b.triangle_ranges
        && a.triangles == b.triangles
}

#[cfg(test)]
mod tests {
    use cullet::lod::Lod;
    use cullet::{
        Camera, Culler, Depth, Instance, Output, Projection, Scene, Transform, View, ViewState,
    };
    use cullet_io::Model;
    use cullet_testkit::steps::Balls;

    use super::super::geometry::Room;
    use super::*;

    fn everything(geometry: &Geometry, instances: &Instances, list: &DrawList) -> Vec<(u32, u32)> {
        let mut all = Vec::new();
        for item in &list.items {
            let mesh = instances.groups[item.group as usize].kind.mesh as usize;
            assert!(!item.entries.is_empty() && mesh < geometry.meshes.len());
            for entry in item.entries.clone() {
                let slot = list.entries[entry as usize];
                match &item.what {
                    What::Triangles(r) => all.extend(r.clone().map(|t| (slot, t))),
                    What::Picked(r) => {
                        let picked = &list.picked[r.start as usize..r.end as usize];
                        all.extend(picked.iter().map(|&t| (slot, t)));
                    }
                }
            }
        }
        all.sort_unstable();
        all
    }

    /// The slow way: what a result says, triangle by triangle.
    fn expand_ref(scene: &Scene, visible: &Visible) -> Vec<(u32, u32)> {
        let mut all = Vec::new();
        if !visible.triangle_ranges.is_empty() {
            for r in &visible.triangle_ranges {
                let own = &visible.triangles[r.first as usize..(r.first + r.count) as usize];
                all.extend(own.iter().map(|&t| (r.slot, t)));
            }
        } else {
            let mut clusters = |slot: u32, range: Range<u32>| {
                for c in range {
                    let cluster = scene.mesh(slot).clusters()[c as usize];
                    all.extend(cluster.triangles().map(|t| (slot, t)));
                }
            };
            for r in &visible.whole {
                for slot in r.first..r.first + r.count {
                    clusters(slot, 0..scene.mesh(slot).cluster_count());
                }
            }
            for r in &visible.partial {
                clusters(r.slot, r.first_cluster..r.first_cluster + r.cluster_count);
            }
        }
        all.sort_unstable();
        all
    }

    #[test]
    fn lists_say_what_results_say_as_the_eye_moves() {
        let model = cullet_scenes::build("city:cells=6,objects=300,sub=5").unwrap();
        let geometry = Geometry::new(&model, Room { buffer: 1 << 28, side: 8192 }).unwrap();
        let instances = Instances::new(&model.scene);
        let mut list = DrawList::default();
        list.reset(&instances);
        let mut device = vec![u32::MAX; list.entries.len()];
        let (mut state, mut visible) = (ViewState::default(), Visible::default());
        let mut partial = 0;
        for step in 0..24 {
            let output =
                [Output::Instances, Output::Clusters, Output::Triangles][step as usize / 3 % 3];
            let angle = f64::from(step) * 0.5;
            let projection =
                Projection::Perspective { fov_y_radians: 0.9, aspect: 1.5, near: 0.1, far: 1e4 };
            let target = [angle.cos() * 10.0, 2.0, angle.sin() * 10.0];
            let camera = Camera::look_at([0.0, 5.0, 0.0], target, projection);
            let view = View::new(&camera, Depth::Standard, [300, 200]).unwrap();
            let culler = Culler::default().with_output(output);
            culler.cull_one(&model.scene, &view, &mut state, &mut visible);
            list.update(&geometry, &instances, Some(&visible), view.layers);
            list.take_dirty(|range, entries| device[range].copy_from_slice(entries));
            assert_eq!(device, list.entries);
            let all = everything(&geometry, &instances, &list);
            assert!(!all.is_empty());
            assert_eq!(all, expand_ref(&model.scene, &visible), "step {step}");
            assert_eq!(all.len() as u64, visible.triangle_count);
            partial += visible.partial.len();
            assert!(!list.update(&geometry, &instances, Some(&visible), view.layers));
        }
        assert!(partial > 0);
        assert!(list.update(&geometry, &instances, None, 1));
        let drawn: u32 = model
            .scene
            .slots()
            .map(|s| model.scene.mesh(s).triangle_count() - model.scene.mesh(s).degenerate_count())
            .sum();
        assert_eq!(everything(&geometry, &instances, &list).len(), drawn as usize);
        assert!(list.update(&geometry, &instances, None, 0) && list.items.is_empty());
    }

    #[test]
    fn levels_of_detail_are_drawn_from_the_meshes_that_hold_them() {
        let mut scene = Scene::new();
        let mesh = Balls::new(&[32, 16, 8], 1.0).add_to(&mut scene);
        let block = scene.add_mesh(cullet_testkit::meshes::block([-1.0; 3], [1.0; 3]));
        for k in 0..24 {
            let place =
                Transform::from_translation([f64::from(k % 4) - 2.0, 0.0, -4.0 * f64::from(k)]);
            scene.add(Instance::new(if k % 5 == 0 { block } else { mesh }, place)).unwrap();
        }
        scene.commit(&Culler::default());
        let model = Model { scene, ..cullet_scenes::build("solids").unwrap() };
        let geometry = Geometry::new(&model, Room { buffer: 1 << 28, side: 8192 }).unwrap();
        let instances = Instances::new(&model.scene);
        let mut list = DrawList::default();
        list.reset(&instances);
        let (mut seen, mut state) = ([0; 2], ViewState::default());
        for step in 0..16 {
            let output =
                [Output::Instances, Output::Clusters, Output::Triangles][step as usize % 3];
            let projection =
                Projection::Perspective { fov_y_radians: 0.9, aspect: 1.5, near: 0.1, far: 1e4 };
            let eye = [0.3, 0.4, 9.0 - 4.0 * f64::from(step)];
            let camera = Camera::look_at(eye, [0.0, 0.0, -200.0], projection);
            let view = View::new(&camera, Depth::Standard, [300, 200]).unwrap();
            let lod = Some(Lod::default().with_pixels(0.7));
            let culler = Culler::default().with_output(output).with_lod(lod);
            let mut visible = Visible::default();
            culler.cull_one(&model.scene, &view, &mut state, &mut visible);
            list.update(&geometry, &instances, Some(&visible), view.layers);
            let mut drawn = Vec::new();
            for item in &list.items {
                let mesh = instances.groups[item.group as usize].kind.mesh;
                for entry in item.entries.clone() {
                    let slot = list.entries[entry as usize];
                    let mut add = |t: u32| drawn.push((slot, mesh, t));
                    match &item.what {
                        What::Triangles(r) => r.clone().for_each(&mut add),
                        What::Picked(r) => {
                            let own = &list.picked[r.start as usize..r.end as usize];
                            own.iter().copied().for_each(&mut add);
                        }
                    }
                }
            }
            drawn.sort_unstable();
            assert_eq!(drawn.len() as u64, visible.triangle_count, "{output:?}");
            assert_eq!(drawn, expand_levels_ref(&model.scene, &visible), "{output:?}");
            for (slot, mesh, _) in drawn {
                seen[usize::from(mesh != model.scene.mesh_id(slot))] += 1;
            }
        }
        assert!(seen[0] > 0 && seen[1] > 0, "{seen:?}");
    }

    /// Expands like [`expand_ref`], with the mesh of each triangle.
    fn expand_levels_ref(scene: &Scene, visible: &Visible) -> Vec<(u32, u32, u32)> {
        let mut all = Vec::new();
        for r in &visible.triangle_ranges {
            let own = &visible.triangles[r.first as usize..(r.first + r.count) as usize];
            all.extend(own.iter().map(|&t| (r.slot, scene.mesh_id_at(r.slot, r.level), t)));
        }
        if visible.triangle_ranges.is_empty() {
            for slot in visible.whole.iter().flat_map(|r| r.first..r.first + r.count) {
                all.extend(
                    (0..scene.mesh(slot).triangle_count()).map(|t| (slot, scene.mesh_id(slot), t)),
                );
            }
            for r in &visible.partial {
                let mesh = scene.mesh_id_at(r.slot, r.level);
                let clusters =
                    &scene.meshes()[mesh as usize].clusters()[r.first_cluster as usize..];
                for cluster in &clusters[..r.cluster_count as usize] {
                    all.extend(cluster.triangles().map(|t| (r.slot, mesh, t)));
                }
            }
        }
        all.sort_unstable();
        all
    }

    #[test]
    fn results_of_another_scene_do_no_harm() {
        let model = cullet_scenes::build("solids").unwrap();
        let geometry = Geometry::new(&model, Room { buffer: 1 << 28, side: 8192 }).unwrap();
        let instances = Instances::new(&model.scene);
        let mut list = DrawList::default();
        list.reset(&instances);
        let range = |first, count| cullet::draw::SlotRange { first, count };
        let partial = |slot, first_cluster, cluster_count| cullet::draw::DrawRange {
            slot,
            level: 0,
            first_cluster,
            cluster_count,
        };
        let slots = model.scene.slot_count();
        let visible = Visible {
            whole: vec![range(0, slots), range(0, slots), range(slots - 1, 9)],
            partial: vec![partial(0, 0, 9), partial(3, u32::MAX, u32::MAX), partial(1 << 30, 0, 1)],
            ..Visible::default()
        };
        list.update(&geometry, &instances, Some(&visible), 1);
        assert!(list.items.iter().all(|i| i.entries.end as usize <= list.entries.len()));
        let ranges =
            vec![cullet::draw::TriangleRange { slot: 0, level: 0, first: 1, count: u32::MAX }];
        let visible = Visible {
            triangle_ranges: ranges,
            triangles: vec![0, u32::MAX, 1 << 20],
            ..Visible::default()
        };
        list.update(&geometry, &instances, Some(&visible), 1);
        assert!(list.picked.is_empty(), "no triangle of these exists: {:?}", list.picked);
    }
}
