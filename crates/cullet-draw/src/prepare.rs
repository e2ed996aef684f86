//! Items to be drawn: meshes cut into blocks, and the blocks of the instances that a view may show.

use std::ops::Range;

use cullet::mesh::{Alpha, Part};
use cullet::{Mesh, MeshId, Scene, Visible};
use cullet_mesh::Impostor;

use crate::bounds::{Extent, ScreenBounds, screen_bounds};
use crate::frame::Selection;
use crate::geometry::{Lens, ObjectLens, is_flat};
use crate::impostor::Tracer;
use crate::parallel;
use crate::sample::{Rect, Samples};
use crate::sort;

/// Triangles of a block at the most: few enough that a block hidden or off the screen is skipped
/// whole, many enough that skipping costs nothing beside drawing.
const BLOCK_TRIANGLES: u32 = 256;
/// Slots, or ranges of triangles, that one task looks at.
const TASK: usize = 1024;

/// Some triangles of one part, successive in the mesh's order.
#[derive(Clone, Copy, Debug)]
struct Block {
    first: u32,
    count: u32,
    two_sided: bool,
    opaque: bool,
    extent: Extent,
}

/// A mesh as the renderer needs it.
#[derive(Debug, Default)]
struct Prepared {
    blocks: Vec<Block>,
    extent: Option<Extent>,
    /// Tracer that is drawn in place of the triangles, where the mesh is the box of an impostor.
    impostor: Option<Tracer>,
}

/// The meshes of a scene, made ready once for any number of frames.
#[derive(Debug)]
pub(crate) struct Stage<'a> {
    pub(crate) scene: &'a Scene,
    meshes: Vec<Prepared>,
}

/// Some triangles of one instance and one part, drawn together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Item {
    pub(crate) slot: u32,
    /// The mesh that its triangles are of.
    pub(crate) mesh: MeshId,
    pub(crate) two_sided: bool,
    /// First triangle of the mesh's order, or first entry of the visible set's list.
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) screen_bounds: ScreenBounds,
}

/// All that a view draws.
#[derive(Debug, Default)]
pub(crate) struct Items {
    /// From near to far.
    pub(crate) opaque: Vec<Item>,
    pub(crate) blended: Vec<Item>,
}

impl<'a> Stage<'a> {
    /// Cuts the meshes that instances use into blocks. O(triangles of those meshes).
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let mut used = vec![false; scene.meshes().len()];
        for slot in scene.slots().chain(scene.stand_in_slots()) {
            let own = scene.mesh_id(slot);
            used[own as usize] = true;
            scene.levels(own).iter().for_each(|levels| used[levels.mesh as usize] = true);
        }
        let mut meshes = parallel::map(used.len(), &|i| match used[i] {
            true => prepare(&scene.meshes()[i]),
            false => Prepared::default(),
        });
        for levels in (0..meshes.len() as u32).flat_map(|mesh| scene.levels(mesh)) {
            if let Some(impostor) = Impostor::of(levels) {
                meshes[levels.mesh as usize].impostor = Some(Tracer::new(impostor.clone()));
            }
        }
        Self { scene, meshes }
    }

    /// Returns the tracer that is drawn in place of the triangles of a mesh that is the box of an
    /// impostor.
    pub(crate) fn impostor(&self, mesh: MeshId) -> Option<&Tracer> {
        self.meshes[mesh as usize].impostor.as_ref()
    }

    /// Whether an instance is in the view's scene and can be drawn at all.
    pub(crate) fn is_drawn(&self, slot: u32, layers: u32) -> bool {
        self.scene.layers(slot) & layers != 0 && self.has_place(slot)
    }

    /// Whether a slot has an instance that is somewhere.
    fn has_place(&self, slot: u32) -> bool {
        let transform = self.scene.transform(slot);
        !self.scene.is_removed(slot) && transform.is_finite() && !is_flat(transform)
    }

    /// Whether an instance that is in a visible set is drawn: one that stands for others is in no
    /// layer of its own.
    fn is_listed(&self, slot: u32, layers: u32) -> bool {
        slot < self.scene.slot_count()
            && (self.is_drawn(slot, layers) || self.scene.is_stand_in(slot) && self.has_place(slot))
    }

    /// Screen bounds of an instance; `None` where it covers no sample.
    pub(crate) fn screen_bounds(
        &self,
        lens: &Lens,
        slot: u32,
        samples: &Samples,
    ) -> Option<ScreenBounds> {
        if !self.is_drawn(slot, lens.layers) {
            return None;
        }
        let extent = self.meshes[self.scene.mesh_id(slot) as usize].extent?;
        screen_bounds(lens, &lens.object(self.scene.transform(slot)), &extent, samples)
    }

    /// The blocks of a selection that may cover a sample.
    pub(crate) fn items(&self, lens: &Lens, samples: &Samples, selection: Selection) -> Items {
        let count = match selection {
            Selection::All => self.scene.slot_count() as usize,
            Selection::Visible(visible) => visible.triangle_ranges.len(),
        };
        let found = parallel::tasks(count, TASK, &|range| {
            let mut out = Vec::new();
            for i in range {
                match selection {
                    Selection::All => self.whole(lens, samples, i as u32, &mut out),
                    Selection::Visible(visible) => {
                        self.listed(lens, samples, visible, i, &mut out);
                    }
                }
            }
            out
        });
        let mut items = Items::default();
        for &(opaque, item) in found.iter().flatten() {
            if opaque { &mut items.opaque } else { &mut items.blended }.push(item);
        }
        let distance = |item: &Item| sort::bits(item.screen_bounds.distance);
        items.opaque = sort::sorted_by(&items.opaque, distance);
        items
    }

    fn whole(&self, lens: &Lens, samples: &Samples, slot: u32, out: &mut Vec<(bool, Item)>) {
        let Some(whole) = self.screen_bounds(lens, slot, samples) else { return };
        let mesh = self.scene.mesh_id(slot);
        let blocks = &self.meshes[mesh as usize].blocks;
        let object = lens.object(self.scene.transform(slot));
        for b in blocks {
            let place = match blocks.len() {
                1 => Some(whole),
                _ => screen_bounds(lens, &object, &b.extent, samples),
            };
            if let Some(place) = place {
                out.push(self.item((slot, mesh), b, b.first, b.count, place));
            }
        }
    }

    fn listed(
        &self,
        lens: &Lens,
        samples: &Samples,
        visible: &Visible,
        range: usize,
        out: &mut Vec<(bool, Item)>,
    ) {
        let range = visible.triangle_ranges[range];
        if !self.is_listed(range.slot, lens.layers) {
            return;
        }
        let mesh = self.scene.mesh_id_at(range.slot, range.level);
        let blocks = &self.meshes[mesh as usize].blocks;
        let object: ObjectLens = lens.object(self.scene.transform(range.slot));
        let end = (range.first as usize + range.count as usize).min(visible.triangles.len());
        let mut at = range.first as usize;
        while at < end {
            // The longest run within one block.
            let t = visible.triangles[at];
            let i = blocks.partition_point(|b| b.first + b.count <= t);
            let first = at;
            at += 1;
            let Some(b) = blocks.get(i) else { continue };
            let inside = |t: u32| b.first <= t && t - b.first < b.count;
            while at < end && inside(visible.triangles[at]) {
                at += 1;
            }
            if let Some(place) = screen_bounds(lens, &object, &b.extent, samples) {
                let count = (at - first) as u32;
                out.push(self.item((range.slot, mesh), b, first as u32, count, place));
            }
        }
    }

    fn item(
        &self,
        (slot, mesh): (u32, MeshId),
        b: &Block,
        first: u32,
        count: u32,
        screen_bounds: ScreenBounds,
    ) -> (bool, Item) {
        let flags = self.scene.flags(slot);
        let two_sided = b.two_sided || flags.double_sided;
        (
            b.opaque && !flags.transparent,
            Item { slot, mesh, two_sided, first, count, screen_bounds },
        )
    }
}

impl Items {
    /// Keeps what may cover a pixel for which `wanted` holds somewhere in its rectangle.
    pub(crate) fn within(&self, wanted: &(dyn Fn(&Rect) -> bool + Sync)) -> Self {
        let keep = |items: &[Item]| {
            let some = |range: Range<usize>| -> Vec<Item> {
                items[range].iter().filter(|i| wanted(&i.screen_bounds.rect)).copied().collect()
            };
            parallel::tasks(items.len(), TASK, &some).concat()
        };
        Self { opaque: keep(&self.opaque), blended: keep(&self.blended) }
    }
}

/// The part of an original triangle. Parts are in order and without gap.
pub(crate) fn part_of(mesh: &Mesh, original: u32) -> Part {
    let parts = mesh.parts();
    let i = parts.partition_point(|p| p.first_triangle + p.triangle_count <= original);
    parts.get(i).copied().unwrap_or_default()
}

fn prepare(mesh: &Mesh) -> Prepared {
    let original = mesh.original_triangle();
    let blocks = |i: usize| {
        let start = i as u32 * BLOCK_TRIANGLES;
        let end = (start + BLOCK_TRIANGLES).min(mesh.triangle_count());
        let mut blocks: Vec<Block> = Vec::with_capacity(1);
        let mut current: Option<Part> = None;
        for t in start..end {
            let o = original[t as usize];
            let within = |p: &Part| o.wrapping_sub(p.first_triangle) < p.triangle_count;
            if !current.as_ref().is_some_and(within) {
                let part = part_of(mesh, o);
                current = Some(part);
                blocks.push(Block {
                    first: t,
                    count: 0,
                    two_sided: part.two_sided,
                    opaque: part.alpha == Alpha::Opaque,
                    extent: Extent::EMPTY,
                });
            }
            if let Some(b) = blocks.last_mut() {
                b.count += 1;
                mesh.corners(t).into_iter().for_each(|p| b.extent.add(p));
            }
        }
        blocks
    };
    let count = mesh.triangle_count().div_ceil(BLOCK_TRIANGLES) as usize;
    let blocks = parallel::map(count, &blocks).concat();
    let extent = blocks.iter().map(|b| b.extent).reduce(|mut a, b| {
        a.join(&b);
        a
    });
    Prepared { blocks, extent, impostor: None }
}
