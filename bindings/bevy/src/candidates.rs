//! Candidates: what a camera may list, as the app knows from elsewhere.

use bevy_ecs::prelude::*;

use crate::bits::slots;
use crate::mirror::CulletScene;

/// Entities that a camera leaves out: rooms behind closed doors, what the fog of war covers, what is too
/// far away, what an editor does not show.
///
/// Put it on a camera and change it in systems that run before
/// [`CulletSystems::Check`](crate::CulletSystems::Check): everything in `Update` does. It stays as it is until
/// you change it. An entity that is left out is not drawn by this camera and hides nothing from it, and no light is
/// kept for its sake. It still throws shadows: give it a `NotShadowCaster` where it should not.
///
/// Leaving out and putting back take some nanoseconds each; a camera with a changed list is checked anew.
///
/// ```
/// use bevy_cullet::CulletCandidates;
/// use bevy_ecs::prelude::*;
/// # #[derive(Component)]
/// # struct Covered;
///
/// fn fog_of_war(mut cameras: Query<&mut CulletCandidates>, covered: Query<Entity, With<Covered>>) {
///     for mut candidates in &mut cameras {
///         candidates.clear();
///         covered.iter().for_each(|entity| candidates.leave_out(entity));
///     }
/// }
/// ```
#[derive(Clone, Component, Debug, Default)]
pub struct CulletCandidates {
    /// One bit for each index of an entity.
    bits: Vec<u64>,
    /// One entity for each index; of those with a bit it is the one that is left out, for indices are given again.
    entities: Vec<Entity>,
}

impl CulletCandidates {
    /// Leaves an entity out.
    pub fn leave_out(&mut self, entity: Entity) {
        let index = entity.index_u32() as usize;
        if self.entities.len() <= index {
            self.entities.resize(index + 1, entity);
            self.bits.resize(index / 64 + 1, 0);
        }
        self.entities[index] = entity;
        self.bits[index / 64] |= 1 << (index % 64);
    }

    /// Makes an entity a candidate again. Does nothing where it was one.
    pub fn put_back(&mut self, entity: Entity) {
        if self.is_left_out(entity) {
            let index = entity.index_u32() as usize;
            self.bits[index / 64] &= !(1 << (index % 64));
        }
    }

    /// Makes all entities candidates again.
    pub fn clear(&mut self) {
        self.bits.fill(0);
    }

    /// Whether an entity is left out.
    #[must_use]
    pub fn is_left_out(&self, entity: Entity) -> bool {
        let index = entity.index_u32() as usize;
        let has_bit = self.bits.get(index / 64).is_some_and(|word| word >> (index % 64) & 1 != 0);
        has_bit && self.entities[index] == entity
    }

    /// Returns the entities that are left out, despawned ones among them.
    pub fn left_out(&self) -> impl Iterator<Item = Entity> + '_ {
        slots(&self.bits).map(|index| self.entities[index as usize])
    }

    /// Clears the bits of what is left out, one a slot. Tells whether something among it may hide others all
    /// the same: the engine keeps what is exempt from culling.
    pub(crate) fn take_out(&self, mirror: &CulletScene, seen: &mut [u64]) -> bool {
        let exempt = mirror.scene.exempt();
        let mut may_hide = false;
        for entity in self.left_out() {
            let slot = mirror.handle(entity).and_then(|handle| mirror.scene.slot(handle).ok());
            let Some(slot) = slot else { continue };
            let (word, bit) = (slot as usize / 64, 1 << (slot % 64));
            seen[word] &= !bit;
            may_hide |= exempt[word] & bit != 0;
        }
        may_hide
    }
}

impl Extend<Entity> for CulletCandidates {
    /// Leaves entities out.
    fn extend<I: IntoIterator<Item = Entity>>(&mut self, entities: I) {
        entities.into_iter().for_each(|entity| self.leave_out(entity));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_that_is_given_again_is_another_entity() {
        let [old, new] = [1, 2].map(|life: u64| Entity::from_bits(u64::from(!7_u32) | life << 32));
        let mut candidates = CulletCandidates::default();
        assert!(old.index() == new.index() && old != new);
        candidates.leave_out(old);
        candidates.put_back(new);
        assert!(candidates.is_left_out(old) && !candidates.is_left_out(new));
        candidates.leave_out(new);
        assert_eq!(candidates.left_out().collect::<Vec<_>>(), [new]);
        candidates.clear();
        assert_eq!(candidates.left_out().count(), 0);
    }
}
