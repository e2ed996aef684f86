//! Results of a culler: visible instances, clusters and triangles, reasons of the rest, and counts
//! of each stage.

mod draws;
mod eyes;

pub use draws::{Draw, DrawCommand, DrawKey, DrawList, DrawState, InstanceNumbers, MeshPlace};

use alloc::vec::Vec;

use crate::funnel::{Funnel, Reason, Stage, Unit};
use crate::scene::{Scene, SceneError, SceneVersion};

/// A range of slots whose instances are drawn whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct SlotRange {
    /// First slot.
    pub first: u32,
    /// Number of slots. All of them have visible instances.
    pub count: u32,
}

/// A range of clusters of one instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct DrawRange {
    /// The instance's slot.
    pub slot: u32,
    /// The level of detail its clusters belong to: 0 for the mesh of the instance, else the number
    /// of one of its [levels](crate::Scene::levels). One instance has ranges of one level.
    pub level: u32,
    /// First cluster of the mesh.
    pub first_cluster: u32,
    /// Number of clusters.
    pub cluster_count: u32,
}

/// Triangles of one instance, as a range of [`Visible::triangles`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct TriangleRange {
    /// The instance's slot.
    pub slot: u32,
    /// The level of detail that its triangles belong to, as in a [`DrawRange`].
    pub level: u32,
    /// First entry.
    pub first: u32,
    /// Number of entries.
    pub count: u32,
}

/// Triangles of one instance that a stage took, while others of its triangles were still there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct DroppedRange {
    /// The instance's slot.
    pub slot: u32,
    /// The level of detail that its triangles belong to, as in a [`DrawRange`].
    pub level: u32,
    /// First triangle, in the order of the mesh [of the level](crate::Scene::mesh_at).
    pub first_triangle: u32,
    /// Number of triangles.
    pub triangle_count: u32,
    /// The stage that took them.
    pub stage: Stage,
    /// Whether it took whole clusters of them, or single triangles.
    pub unit: Unit,
}

/// Visible set of one view: a superset of what is truly visible. Ascending by slot; reused from
/// frame to frame without allocation once it has grown.
///
/// Two results are equal if they list and count the same, whichever [`version`](Self::version) they
/// are of, and whatever work and time it took.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Visible {
    /// Versions of the scene that was culled. Only while they are [its own](Scene::version) do
    /// slots and clusters have the numbers that are listed here. They hold within one process: a
    /// result that was read from elsewhere is of no scene.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub version: SceneVersion,
    /// Slots whose instances are drawn whole.
    pub whole: Vec<SlotRange>,
    /// Clusters of instances that are drawn in part, ascending by slot and cluster; no slot is both
    /// here and in `whole`.
    pub partial: Vec<DrawRange>,
    /// Triangles of every visible instance, whole ones included. Filled if the output is triangles.
    pub triangle_ranges: Vec<TriangleRange>,
    /// Triangle numbers in the order of the mesh [of the level](crate::Scene::mesh_at), for
    /// `triangle_ranges`.
    pub triangles: Vec<u32>,
    /// Reason for each slot; `None` for visible instances and empty slots. Filled if reasons are
    /// recorded.
    pub reasons: Vec<Option<Reason>>,
    /// Triangles that were culled individually or with their cluster, ascending by slot and
    /// triangle, without overlap. Filled if drops are recorded. An instance that was dropped as a
    /// whole has only a reason, and no entry here.
    pub dropped: Vec<DroppedRange>,
    /// Counts of each stage.
    pub funnel: Funnel,
    /// Triangles that will be drawn.
    pub triangle_count: u64,
    /// Instances of which any part will be drawn.
    pub instance_count: u64,
    /// Number of pixels by which the drawn surface may be off, which a budget may have raised.
    /// `None` if no [levels of detail](crate::Culler::lod) were chosen.
    pub lod_pixels: Option<f64>,
}

impl Clone for Visible {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Allocates nothing where there is room.
    fn clone_from(&mut self, source: &Self) {
        self.version = source.version;
        self.whole.clone_from(&source.whole);
        self.partial.clone_from(&source.partial);
        self.triangle_ranges.clone_from(&source.triangle_ranges);
        self.triangles.clone_from(&source.triangles);
        self.reasons.clone_from(&source.reasons);
        self.dropped.clone_from(&source.dropped);
        self.funnel.rows.clone_from(&source.funnel.rows);
        self.funnel.frustum = source.funnel.frustum;
        self.funnel.occlusion = source.funnel.occlusion;
        self.triangle_count = source.triangle_count;
        self.instance_count = source.instance_count;
        self.lod_pixels = source.lod_pixels;
    }
}

impl PartialEq for Visible {
    fn eq(&self, other: &Self) -> bool {
        let Self {
            version: _,
            whole,
            partial,
            triangle_ranges,
            triangles,
            reasons,
            dropped,
            funnel,
            triangle_count,
            instance_count,
            lod_pixels,
        } = self;
        (whole, partial) == (&other.whole, &other.partial)
            && (triangle_ranges, triangles) == (&other.triangle_ranges, &other.triangles)
            && (reasons, dropped) == (&other.reasons, &other.dropped)
            && funnel.same_counts(&other.funnel)
            && (triangle_count, instance_count, lod_pixels)
                == (&other.triangle_count, &other.instance_count, &other.lod_pixels)
    }
}

impl Visible {
    /// Refuses where the result is not of the scene as it is.
    pub(crate) fn check(&self, scene: &Scene) -> Result<(), SceneError> {
        let (result, scene) = (self.version, scene.version());
        if result == scene { Ok(()) } else { Err(SceneError::Stale { result, scene }) }
    }

    /// The stage that took a triangle, given in the order of its instance's mesh; `None` for one
    /// that is drawn. Needs [`reasons`](Self::reasons) and [`dropped`](Self::dropped). O(log of
    /// what is in `dropped`).
    #[must_use]
    pub fn stage_of(&self, slot: u32, triangle: u32) -> Option<Stage> {
        let after =
            self.dropped.partition_point(|d| (d.slot, d.first_triangle) <= (slot, triangle));
        let range = after.checked_sub(1).map(|at| &self.dropped[at]);
        let own = range.filter(|d| d.slot == slot);
        match own {
            Some(d) if triangle - d.first_triangle < d.triangle_count => Some(d.stage),
            // Some of its triangles went one by one, so all did that went.
            _ if self.went_in_parts(slot) => None,
            _ => self.reasons.get(slot as usize).copied().flatten().map(|r| r.stage),
        }
    }

    /// Whether some triangles of an instance went on their own or with their cluster; then each of
    /// its triangles has [its own stage](Self::stage_of), also where none is left. Needs
    /// [`dropped`](Self::dropped).
    #[must_use]
    pub fn went_in_parts(&self, slot: u32) -> bool {
        let first = self.dropped.partition_point(|d| d.slot < slot);
        self.dropped.get(first).is_some_and(|d| d.slot == slot)
    }

    /// The slots of which something is drawn, ascending.
    pub fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        let mut whole = self.whole.iter().flat_map(|r| r.first..r.first + r.count).peekable();
        let partial = self.partial.chunk_by(|a, b| a.slot == b.slot);
        let mut partial = partial.map(|ranges| ranges[0].slot).peekable();
        // No slot is in both.
        core::iter::from_fn(move || match (whole.peek(), partial.peek()) {
            (Some(a), Some(b)) if b < a => partial.next(),
            (Some(_), _) => whole.next(),
            (None, _) => partial.next(),
        })
    }

    /// Lists the slots of which something is drawn now and was not in `earlier`, and those that
    /// went, both ascending. Both results must be of one order of the scene's slots (see
    /// [`Scene::order_version`](crate::Scene::order_version)). The lists are cleared first. The
    /// cost is that of what is visible.
    pub fn changes_since(&self, earlier: &Self, added: &mut Vec<u32>, removed: &mut Vec<u32>) {
        added.clear();
        removed.clear();
        let (mut now, mut then) = (self.slots().peekable(), earlier.slots().peekable());
        loop {
            match (now.peek(), then.peek()) {
                (Some(a), Some(b)) if a == b => {
                    now.next();
                    then.next();
                }
                (Some(a), Some(b)) if a > b => removed.extend(then.next()),
                (Some(_), _) => added.extend(now.next()),
                (None, Some(_)) => removed.extend(then.next()),
                (None, None) => return,
            }
        }
    }
}
