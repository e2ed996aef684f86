//! Fate of each triangle of a scene in a view.

use cullet::{Scene, Visible};
use glam::DVec3;

use super::map::{Fate, Tally, fates};
use super::shaded::linear;
use super::space::Surfaces;
use crate::frame::PixelId;
use crate::parallel;

/// Slots that one task counts.
const TASK: usize = 64;

/// Fates of all triangles of a scene in a view.
pub(super) struct SceneFates<'a> {
    scene: &'a Scene,
    of_slots: Vec<Option<Fate>>,
    triangles: TriangleFates<'a>,
}

impl<'a> SceneFates<'a> {
    /// `visible` has reasons and triangles, `seen` is the exact visible set, and `surfaces` knows
    /// all of the scene.
    pub(super) fn new(
        scene: &'a Scene,
        visible: &'a Visible,
        seen: &'a [PixelId],
        surfaces: &'a Surfaces<'a>,
    ) -> Self {
        let of_slots = fates(scene, visible, seen);
        let triangles = TriangleFates::new(visible, seen, surfaces);
        Self { scene, of_slots, triangles }
    }

    /// Returns the fate of an instance as a whole.
    pub(super) fn of_slot(&self, slot: u32) -> Fate {
        self.of_slots.get(slot as usize).copied().flatten().unwrap_or(Fate::Dropped(None))
    }

    /// Returns the fate of an original triangle.
    pub(super) fn of(&self, id: PixelId) -> Fate {
        self.of_whole(id.slot).unwrap_or_else(|| self.triangles.of(id))
    }

    /// The colour of that of a triangle, in linear light.
    pub(super) fn color_of(&self, id: PixelId) -> DVec3 {
        DVec3::from(self.of(id).color().map(linear))
    }

    /// Returns the fate of an instance that was dropped at once; `None` where its triangles differ.
    fn of_whole(&self, slot: u32) -> Option<Fate> {
        let fate = self.of_slot(slot);
        let dropped = matches!(fate, Fate::Dropped(_));
        (dropped && !self.triangles.visible.went_in_parts(slot)).then_some(fate)
    }

    /// How many triangles of the scene there are of each fate that occurs, in the order of a
    /// legend.
    pub(super) fn counts(&self) -> Vec<(Fate, u64)> {
        let slots: Vec<u32> = self.scene.slots().collect();
        let tallies = parallel::tasks(slots.len(), TASK, &|range| {
            let mut tally = Tally::default();
            for &slot in &slots[range] {
                let count = self.scene.mesh(slot).triangle_count();
                match self.of_whole(slot) {
                    Some(dropped) => tally.add(dropped, count.into()),
                    None => (0..count)
                        .for_each(|triangle| tally.add(self.of(PixelId { slot, triangle }), 1)),
                }
            }
            tally
        });
        let mut sum = Tally::default();
        tallies.iter().for_each(|tally| sum.join(tally));
        sum.entries()
    }
}

/// Fates of the triangles of instances that are kept.
struct TriangleFates<'a> {
    visible: &'a Visible,
    seen: &'a [PixelId],
    surfaces: &'a Surfaces<'a>,
}

impl<'a> TriangleFates<'a> {
    fn new(visible: &'a Visible, seen: &'a [PixelId], surfaces: &'a Surfaces<'a>) -> Self {
        Self { visible, seen, surfaces }
    }

    fn of(&self, id: PixelId) -> Fate {
        if self.seen.binary_search(&id).is_ok() {
            return Fate::Seen;
        }
        let Some(t) = self.surfaces.triangle(id) else { return Fate::Dropped(None) };
        let ranges = &self.visible.triangle_ranges;
        let i = ranges.partition_point(|r| r.slot < id.slot);
        let listed = ranges.get(i).filter(|r| r.slot == id.slot).is_some_and(|r| {
            let entries = r.first as usize..r.first as usize + r.count as usize;
            self.visible.triangles.get(entries).is_some_and(|t_of| t_of.binary_search(&t).is_ok())
        });
        // Without triangles, the instance speaks for them.
        if listed || self.visible.triangle_ranges.is_empty() {
            return Fate::Unseen;
        }
        Fate::Dropped(self.visible.stage_of(id.slot, t))
    }
}
