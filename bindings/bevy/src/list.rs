//! A sorted list of entities that follows a set of slots.

use bevy_ecs::prelude::*;

use crate::bits::{slots, slots_of};
use crate::mirror::CulletScene;

/// Some of the scene, as bits of slots and as a list.
#[derive(Debug, Default)]
pub(crate) struct Listed {
    /// One bit a slot.
    pub(crate) seen: Vec<u64>,
    /// The entities of `seen`, sorted.
    pub(crate) list: Vec<Entity>,
    scratch: Vec<Entity>,
}

impl Listed {
    /// Takes over other bits, and brings the list after them: sorted anew where slots were, else by
    /// what came and went. Tells whether it changed.
    pub(crate) fn take(
        &mut self,
        mirror: &CulletScene,
        same_order: bool,
        next: &mut Vec<u64>,
    ) -> bool {
        let entity = |slot| Entity::from_bits(mirror.scene.user_data(slot));
        if !same_order || self.seen.len() > next.len() {
            self.list.clear();
            self.list.extend(slots(next).map(entity));
            self.list.sort_unstable();
            std::mem::swap(&mut self.seen, next);
            return true;
        }
        self.seen.resize(next.len(), 0);
        let mut changed = Vec::new();
        for (word, (old, new)) in self.seen.iter().zip(&*next).enumerate() {
            let differ = old ^ new;
            changed.extend(slots_of(word, differ).map(entity));
        }
        if changed.is_empty() {
            return false;
        }
        // An entity is in the old list or among the new ones, never in both: those that are in both
        // lists went.
        changed.sort_unstable();
        merge(&self.list, &changed, &mut self.scratch);
        std::mem::swap(&mut self.list, &mut self.scratch);
        std::mem::swap(&mut self.seen, next);
        true
    }
}

/// Writes the entities that are in exactly one of two sorted lists.
fn merge(a: &[Entity], b: &[Entity], out: &mut Vec<Entity>) {
    out.clear();
    out.reserve(a.len() + b.len());
    let mut rest = a;
    for &entity in b {
        let at = rest.partition_point(|&e| e < entity);
        out.extend_from_slice(&rest[..at]);
        rest = &rest[at..];
        if rest.first() == Some(&entity) {
            rest = &rest[1..];
        } else {
            out.push(entity);
        }
    }
    out.extend_from_slice(rest);
}
