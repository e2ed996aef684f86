//! In whose place an instance is drawn that stands for others.

use cullet::lod::{LevelEye, Lod, PixelScale, Selection};
use cullet::{Scene, Simd, View, Visible, draw::TriangleRange};

use crate::sort;

/// For each slot of a scene the slot that is drawn in its place: that of who stands for it in a
/// visible set, or its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Places {
    /// Empty where nobody stands for anybody.
    by: Vec<u32>,
    /// Instances that are drawn in the place of others, ascending.
    stand_ins: Vec<u32>,
}

impl Places {
    /// Finds the places of a visible set. O(slots) where the scene has stand-ins.
    pub(crate) fn of(scene: &Scene, visible: &Visible) -> Self {
        if scene.stand_in_slots().next().is_none() {
            return Self::default();
        }
        let mut by: Vec<u32> = (0..scene.slot_count()).collect();
        let mut stand_ins = Vec::new();
        let reasons = &visible.reasons;
        for slot in scene.stand_in_slots() {
            // Drawn, or dropped for another reason than that nobody wanted it.
            let reason = reasons.get(slot as usize).copied().flatten();
            let is_wanted = match reasons.is_empty() {
                true => visible.slots().any(|s| s == slot),
                false => reason.is_none_or(|r| r.stage != cullet::Stage::Layer),
            };
            if is_wanted {
                stand_ins.push(slot);
                for below in scene.stood_for_by(slot) {
                    by[below as usize] = slot;
                }
            }
        }
        let stand_ins = sort::sorted_by(&stand_ins, |&slot| slot.into());
        Self { by, stand_ins }
    }

    /// The slot that is drawn in the place of another.
    pub(crate) fn of_slot(&self, slot: u32) -> u32 {
        self.by.get(slot as usize).copied().unwrap_or(slot)
    }

    /// Returns what levels alone draw, with triangles, given the `cut` of every instance by itself:
    /// stand-ins are drawn with the levels that `result` has of them, in full, and without what
    /// they stand for.
    pub(crate) fn put_in(
        &self,
        scene: &Scene,
        view: &View,
        lod: &Lod,
        cut: &Visible,
        result: &Visible,
    ) -> Visible {
        let mut out = Visible { lod_pixels: cut.lod_pixels, ..Visible::default() };
        let scale = PixelScale::of(view, lod.at_corners);
        let own = cut.triangle_ranges.iter().filter(|r| self.of_slot(r.slot) == r.slot);
        let stands =
            self.stand_ins.iter().map(|&slot| TriangleRange { slot, level: 0, first: 0, count: 0 });
        let ranges: Vec<TriangleRange> = own.copied().chain(stands).collect();
        for range in sort::sorted_by(&ranges, |r| r.slot.into()) {
            let first = out.triangles.len() as u32;
            let mut level = range.level;
            if self.stand_ins.binary_search(&range.slot).is_ok() {
                let own = result.triangle_ranges.binary_search_by_key(&range.slot, |r| r.slot);
                level = own.map_or(1, |at| result.triangle_ranges[at].level);
                let eye = LevelEye::new(lod, &scale, scene.transform(range.slot), view.eyes);
                let levels = scene.levels(scene.mesh_id(range.slot)).get(level as usize - 1);
                let mut selection = Selection::default();
                if let Some(levels) = levels
                    && levels.levels.select(Simd::best(), &eye, &mut selection)
                {
                    let clusters = scene.meshes()[levels.mesh as usize].clusters();
                    let chosen = selection.ranges().flatten();
                    out.triangles.extend(chosen.flat_map(|c| clusters[c as usize].triangles()));
                }
            } else {
                let from = range.first as usize;
                out.triangles.extend(&cut.triangles[from..from + range.count as usize]);
            }
            let count = out.triangles.len() as u32 - first;
            out.triangle_ranges.push(TriangleRange { slot: range.slot, level, first, count });
        }
        out.triangle_count = out.triangles.len() as u64;
        out.instance_count = out.triangle_ranges.len() as u64;
        out
    }
}
