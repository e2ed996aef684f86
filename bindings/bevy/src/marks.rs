//! `ViewVisibility`: which entities some view sees.
//!
//! Bevy clears the mark of each entity in each frame, and each view sets it again for all that it lists. Here the marks of
//! what cameras list stay from frame to frame, and only what comes and goes is touched. Whoever else marks entities
//! (shadow casters of lights, systems of the user's) does so as under Bevy, in each frame anew: their marks are cleared.

use std::sync::Mutex;

use bevy_app::{App, PostUpdate};
use bevy_camera::visibility::VisibilitySystems::{
    CalculateBounds, CheckVisibility, MarkNewlyHiddenEntitiesInvisible, VisibilityPropagate,
};
use bevy_camera::visibility::{
    NoCpuCulling, SetViewVisibility, ViewVisibility, VisibilityPlugin, VisibilitySystems,
};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{
    InternedSystemSet, ScheduleCleanupPolicy, Schedules,
};

use crate::ticks::{MANY, ROWS};

/// The marks that stay.
#[derive(Debug, Resource)]
pub(crate) struct Marks {
    /// One bit an index of an entity: a camera lists it.
    kept: Vec<u64>,
    /// How many bits are set.
    count: usize,
    /// Entities that are seen no more, unless someone marks them yet.
    leaving: Vec<Entity>,
    /// A mark that should have stayed is not there: all are to be set again.
    pub(crate) is_broken: bool,
    scratch: Vec<u64>,
    /// What Bevy makes of the mark of a visible entity when a frame begins.
    was_visible: ViewVisibility,
}

impl Marks {
    fn is_kept(&self, entity: Entity) -> bool {
        let at = entity.index_u32() as usize;
        self.kept.get(at / 64).is_some_and(|word| word >> (at % 64) & 1 == 1)
    }

    /// Takes note that no camera can list an entity any more. Its mark is cleared, as if a frame began.
    pub(crate) fn drop_one(&mut self, entity: Entity, mark: Option<Mut<'_, ViewVisibility>>) {
        if !self.is_kept(entity) {
            return;
        }
        let at = entity.index_u32() as usize;
        self.kept[at / 64] &= !(1 << (at % 64));
        self.count -= 1;
        self.leave(entity, mark);
    }

    fn leave(&mut self, entity: Entity, mark: Option<Mut<'_, ViewVisibility>>) {
        if let Some(mut mark) = mark.filter(|mark| mark.get()) {
            *mark.bypass_change_detection() = self.was_visible;
            self.leaving.push(entity);
        }
    }

    /// Marks what the lists hold now, and no more what they held: `entity` tells the entity of an index.
    pub(crate) fn keep<'a>(
        &mut self,
        lists: impl Iterator<Item = &'a [Entity]>,
        entity: impl Fn(usize) -> Option<Entity>,
        marks: &mut Query<&mut ViewVisibility, crate::seen::OfMesh>,
    ) {
        let mut next = std::mem::take(&mut self.scratch);
        next.clear();
        next.resize(self.kept.len(), 0);
        for list in lists {
            // Sorted by index, so that most of its words are asked for many times in a row.
            for entity in list {
                let at = entity.index_u32() as usize;
                if next.len() <= at / 64 {
                    next.resize(at / 64 + 1, 0);
                }
                next[at / 64] |= 1 << (at % 64);
            }
        }
        self.kept.resize(next.len(), 0);
        self.count = 0;
        for (word, &new) in next.iter().enumerate() {
            self.count += new.count_ones() as usize;
            let mut differ = new ^ self.kept[word];
            while differ != 0 {
                let bit = differ.trailing_zeros();
                differ &= differ - 1;
                let Some(entity) = entity(word * 64 + bit as usize) else { continue };
                let mark = marks.get_mut(entity).ok();
                if new >> bit & 1 == 0 {
                    self.leave(entity, mark);
                } else if let Some(mut mark) = mark {
                    mark.set_visible();
                }
            }
        }
        self.scratch = std::mem::replace(&mut self.kept, next);
    }
}

/// One bit a row: it is marked.
fn marked(rows: &[ViewVisibility]) -> u64 {
    let mut bytes = [0u8; ROWS];
    bytes.iter_mut().zip(rows).for_each(|(byte, mark)| *byte = u8::from(mark.get()));
    bytes.chunks_exact(8).enumerate().fold(0, |bits, (part, eight)| {
        let eight = eight.try_into().map_or(0, u64::from_le_bytes);
        // Each byte is 0 or 1: the product has them side by side in its highest byte.
        bits | (eight.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (part * 8)
    })
}

/// Clears the marks that do not stay, as Bevy clears all.
pub(crate) fn reset(
    marks: ResMut<Marks>,
    mut all: Query<(Entity, &mut ViewVisibility), Without<NoCpuCulling>>,
) {
    let marks = marks.into_inner();
    let mut most = 0;
    let Ok(tables) = all.contiguous_iter() else { return };
    tables.for_each(|(entities, _)| most = most.max(entities.len()));
    let (kept, was) = (&*marks, marks.was_visible);
    let found = Mutex::new((0, Vec::new()));
    let clear = |entities: &[Entity], rows: &mut [ViewVisibility]| {
        let (mut count, mut others) = (0, Vec::new());
        for (entities, rows) in entities.chunks(ROWS).zip(rows.chunks_mut(ROWS)) {
            let mut bits = marked(rows);
            while bits != 0 {
                let row = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                if kept.is_kept(entities[row]) {
                    count += 1;
                } else {
                    rows[row] = was;
                    others.push(entities[row]);
                }
            }
        }
        // Locked once for each part of a table.
        if let Ok(mut found) = found.lock() {
            found.0 += count;
            found.1.append(&mut others);
        }
    };
    if most < MANY {
        let tables = all.contiguous_iter_mut().into_iter().flatten();
        tables.for_each(|(entities, mut rows)| clear(entities, rows.bypass_change_detection()));
    } else if let Ok(tables) = all.contiguous_par_iter_mut() {
        tables.for_each(|(entities, mut rows)| clear(entities, rows.bypass_change_detection()));
    }
    let (count, mut others) = found.into_inner().unwrap_or_default();
    marks.is_broken = count != marks.count;
    marks.leaving.clear();
    marks.leaving.append(&mut others);
}

/// Marks as hidden what was seen in the last frame, and in this one by nobody.
pub(crate) fn hide(
    mut marks: ResMut<Marks>,
    mut all: Query<&mut ViewVisibility, Without<NoCpuCulling>>,
) {
    let marks = &mut *marks;
    for entity in marks.leaving.drain(..) {
        if let Ok(mut mark) = all.get_mut(entity)
            && *mark == marks.was_visible
        {
            *mark = ViewVisibility::HIDDEN;
        }
    }
}

/// Bevy's private systems that [`reset`], [`hide`] and [`inherit`](crate::inherit::inherit) stand for, by their types.
#[derive(Debug)]
pub(crate) struct Replaced {
    pub(crate) systems: Vec<InternedSystemSet>,
    was_visible: ViewVisibility,
}

impl Replaced {
    /// Found in an app of its own, where nobody else's systems are in the same sets.
    pub(crate) fn find() -> Self {
        let mut app = App::new();
        app.add_plugins(VisibilityPlugin);
        let mut systems = systems_of(&mut app, VisibilityPropagate);
        systems.append(&mut systems_of(&mut app, MarkNewlyHiddenEntitiesInvisible));
        // What the systems that begin a frame make of a mark, they are asked themselves.
        for set in [CalculateBounds, CheckVisibility, MarkNewlyHiddenEntitiesInvisible] {
            remove(&mut app, set);
        }
        let world = app.world_mut();
        let entity = world.spawn(ViewVisibility::VISIBLE).id();
        world.run_schedule(PostUpdate);
        let mark = world.get::<ViewVisibility>(entity).copied();
        Self { systems, was_visible: mark.unwrap_or(ViewVisibility::HIDDEN) }
    }

    pub(crate) fn marks(&self) -> Marks {
        Marks {
            kept: Vec::new(),
            count: 0,
            leaving: Vec::new(),
            is_broken: false,
            scratch: Vec::new(),
            was_visible: self.was_visible,
        }
    }
}

/// Takes systems out of the schedule after the frame's transforms. Not an error where there are none: an app without Bevy's
/// cameras has nothing to take out.
pub(crate) fn remove(app: &mut App, set: impl SystemSet) {
    let _ = app.remove_systems_in_set(PostUpdate, set, ScheduleCleanupPolicy::RemoveSystemsOnly);
}

/// The sets of one system each of those in a set.
fn systems_of(app: &mut App, set: VisibilitySystems) -> Vec<InternedSystemSet> {
    let found = app.world_mut().try_schedule_scope(PostUpdate, |world, schedule| {
        schedule.initialize(world).ok()?;
        let keys = schedule.graph().systems_in_set(set.intern()).ok()?;
        let of_set = schedule.systems().ok()?.filter(|(key, _)| keys.contains(key));
        let sets = of_set.flat_map(|(_, system)| system.default_system_sets());
        Some(sets.filter(|set| set.system_type().is_some()).collect())
    });
    found.ok().flatten().unwrap_or_default()
}
