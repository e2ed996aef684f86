//! `ViewVisibility`: which entities some view sees.
//!
//! Bevy clears the mark of each entity in each frame, each view sets it again for all that it
//! lists, and what nobody has marked in the end is hidden. The same here, but that what cameras
//! list is one bit an entity from frame to frame: the marks are set again in one pass over the
//! tables, and only what comes is looked up.

use std::sync::Mutex;

use bevy_camera::visibility::{NoCpuCulling, SetViewVisibility, ViewVisibility};
use bevy_ecs::prelude::*;

use crate::bits::{slots, slots_of};
use crate::ticks::{MANY, ROWS};

/// Entities that cameras list.
#[derive(Debug, Resource)]
pub(crate) struct Marks {
    /// One bit an index of an entity: an active camera lists it.
    listed: Vec<u64>,
    /// How many bits are set.
    count: usize,
    /// Entities that were seen in the last frame, and not yet in this one.
    leaving: Vec<Entity>,
    scratch: Vec<u64>,
    /// One bit an index of an entity: a shadow map lists it.
    cast: Vec<u64>,
    cast_count: usize,
    /// Mark that Bevy gives a visible entity when a frame begins.
    was_visible: ViewVisibility,
}

impl Marks {
    pub(crate) fn new(was_visible: ViewVisibility) -> Self {
        Self {
            listed: Vec::new(),
            count: 0,
            leaving: Vec::new(),
            scratch: Vec::new(),
            cast: Vec::new(),
            cast_count: 0,
            was_visible,
        }
    }
}

/// All that have marks which are set and cleared here.
pub(crate) type Marked<'w, 's> =
    Query<'w, 's, (Entity, &'static mut ViewVisibility), Without<NoCpuCulling>>;

impl Marks {
    /// Takes over other lists, and marks what was in none before: `of_index` tells the entity of an
    /// index.
    pub(crate) fn list<'a>(
        &mut self,
        lists: impl Iterator<Item = &'a [Entity]>,
        of_index: impl Fn(usize) -> Option<Entity>,
        all: &mut Marked,
    ) {
        let entities = lists.flatten().copied();
        self.count = take(&mut self.listed, &mut self.scratch, entities, of_index, all);
    }

    /// The same for what shadow maps list.
    pub(crate) fn list_casters(
        &mut self,
        entities: impl Iterator<Item = Entity>,
        of_index: impl Fn(usize) -> Option<Entity>,
        all: &mut Marked,
    ) {
        self.cast_count = take(&mut self.cast, &mut self.scratch, entities, of_index, all);
    }

    /// Marks all that is listed, and notes what else was seen in the last frame. `false` where a
    /// mark is not as it was left: then those of all lists are to be set one by one.
    pub(crate) fn set(&mut self, all: &mut Marked) -> bool {
        set(&self.listed, &mut self.leaving, self.was_visible, all) == self.count
    }

    /// Marks all that shadow maps list: after [`set`](Self::set).
    pub(crate) fn cast(&mut self, of_index: impl Fn(usize) -> Option<Entity>, all: &mut Marked) {
        if self.cast_count == 0 {
            return;
        }
        if set(&self.cast, &mut self.leaving, self.was_visible, all) != self.cast_count {
            for entity in slots(&self.cast).filter_map(|index| of_index(index as usize)) {
                if let Ok((_, mut mark)) = all.get_mut(entity) {
                    mark.set_visible();
                }
            }
        }
    }
}

fn has(bits: &[u64], entity: Entity) -> bool {
    let at = entity.index_u32() as usize;
    bits.get(at / 64).is_some_and(|word| word >> (at % 64) & 1 == 1)
}

/// Makes `bits` those of other lists, and marks what is new in them. Returns how many there are.
fn take(
    bits: &mut Vec<u64>,
    scratch: &mut Vec<u64>,
    entities: impl Iterator<Item = Entity>,
    of_index: impl Fn(usize) -> Option<Entity>,
    all: &mut Marked,
) -> usize {
    scratch.clear();
    scratch.resize(bits.len(), 0);
    for entity in entities {
        let at = entity.index_u32() as usize;
        if scratch.len() <= at / 64 {
            scratch.resize(at / 64 + 1, 0);
        }
        scratch[at / 64] |= 1 << (at % 64);
    }
    bits.resize(scratch.len(), 0);
    let mut count = 0;
    for (word, (new, old)) in scratch.iter().zip(&*bits).enumerate() {
        count += new.count_ones() as usize;
        for index in slots_of(word, new & !old) {
            let entity = of_index(index as usize);
            if let Some((_, mut mark)) = entity.and_then(|entity| all.get_mut(entity).ok()) {
                mark.set_visible();
            }
        }
    }
    std::mem::swap(bits, scratch);
    count
}

/// Marks what has a bit and was seen in the last frame, and lists what was seen and has none.
/// Returns how many have a bit and a mark.
fn set(bits: &[u64], leaving: &mut Vec<Entity>, was: ViewVisibility, all: &mut Marked) -> usize {
    let found = Mutex::new((0, std::mem::take(leaving)));
    if let Ok(mut found) = found.lock() {
        found.1.clear();
    }
    let set = |entities: &[Entity], rows: &mut [ViewVisibility]| {
        let (mut count, mut leaving) = (0, Vec::new());
        for (entities, rows) in entities.chunks(ROWS).zip(rows.chunks_mut(ROWS)) {
            let seen = bits_of(rows, |mark| mark != ViewVisibility::HIDDEN);
            for row in slots_of(0, seen).map(|row| row as usize) {
                let is_listed = has(bits, entities[row]);
                count += usize::from(is_listed);
                if is_listed && rows[row] == was {
                    rows[row] = ViewVisibility::VISIBLE;
                } else if rows[row] == was {
                    leaving.push(entities[row]);
                }
            }
        }
        // Locked once for each part of a table.
        if let Ok(mut found) = found.lock() {
            found.0 += count;
            found.1.append(&mut leaving);
        }
    };
    if !is_large(all) {
        let tables = all.contiguous_iter_mut().into_iter().flatten();
        tables.for_each(|(entities, mut rows)| set(entities, rows.bypass_change_detection()));
    } else if let Ok(tables) = all.contiguous_par_iter_mut() {
        tables.for_each(|(entities, mut rows)| set(entities, rows.bypass_change_detection()));
    }
    let (count, found) = found.into_inner().unwrap_or_default();
    *leaving = found;
    count
}

fn is_large(all: &Marked) -> bool {
    all.contiguous_iter().into_iter().flatten().any(|(entities, _)| entities.len() >= MANY)
}

/// One bit a row.
fn bits_of(rows: &[ViewVisibility], is: impl Fn(ViewVisibility) -> bool) -> u64 {
    let mut bytes = [0u8; ROWS];
    bytes.iter_mut().zip(rows).for_each(|(byte, &mark)| *byte = u8::from(is(mark)));
    bytes.as_chunks().0.iter().enumerate().fold(0, |bits, (part, eight)| {
        let eight = u64::from_le_bytes(*eight);
        // Each byte is 0 or 1: the product has them side by side in its highest byte.
        bits | (eight.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (part * 8)
    })
}

/// Begins a frame: nobody is marked, but what was is known.
pub(crate) fn reset(marks: Res<Marks>, mut all: Query<&mut ViewVisibility, Without<NoCpuCulling>>) {
    let was = marks.was_visible;
    for mut rows in all.contiguous_iter_mut().into_iter().flatten() {
        for mark in rows.bypass_change_detection() {
            *mark = if mark.get() { was } else { ViewVisibility::HIDDEN };
        }
    }
}

/// Whether [`hide`] has something to do.
pub(crate) fn is_any_leaving(marks: Res<Marks>) -> bool {
    !marks.leaving.is_empty()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_row_has_its_bit() {
        for pattern in [0, 1, 1 << 63, 0x8000_0001_0180_5a00, u64::MAX, 0x0123_4567_89ab_cdef] {
            let of = |row: usize| match pattern >> row & 1 {
                1 => ViewVisibility::VISIBLE,
                _ => ViewVisibility::HIDDEN,
            };
            for len in [0, 1, 9, 63, 64] {
                let rows: Vec<_> = (0..len).map(of).collect();
                let all = if len == 64 { u64::MAX } else { (1 << len) - 1 };
                assert_eq!(bits_of(&rows, ViewVisibility::get), pattern & all);
            }
        }
    }
}
