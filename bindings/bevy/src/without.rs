//! Entities that throw no shadow.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_light::{DirectionalLight, NotShadowCaster};

/// Filter of what Bevy lists as no caster.
type Without = Or<(With<NotShadowCaster>, With<DirectionalLight>)>;

/// Entities that throw no shadow, kept from frame to frame.
#[derive(SystemParam)]
pub(crate) struct WithoutShadows<'w, 's> {
    known: Local<'s, Known>,
    added: Query<'w, 's, Entity, Or<(Added<NotShadowCaster>, Added<DirectionalLight>)>>,
    gone: RemovedComponents<'w, 's, NotShadowCaster>,
    gone_suns: RemovedComponents<'w, 's, DirectionalLight>,
    all: Query<'w, 's, (), Without>,
}

#[derive(Debug, Default)]
pub(crate) struct Known {
    /// One bit an index of an entity.
    bits: Vec<u64>,
    count: usize,
    /// Rises with each change.
    pub(crate) version: u64,
}

impl Known {
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    pub(crate) fn has(&self, entity: Entity) -> bool {
        let at = entity.index_u32() as usize;
        self.bits.get(at / 64).is_some_and(|word| word >> (at % 64) & 1 == 1)
    }

    fn set(&mut self, entity: Entity, is_without: bool) {
        let at = entity.index_u32() as usize;
        if self.bits.len() <= at / 64 {
            self.bits.resize(at / 64 + 1, 0);
        }
        let bit = 1 << (at % 64);
        let word = &mut self.bits[at / 64];
        let new = if is_without { *word | bit } else { *word & !bit };
        if new != *word {
            self.version += 1;
            self.count = if is_without { self.count + 1 } else { self.count - 1 };
        }
        *word = new;
    }
}

impl WithoutShadows<'_, '_> {
    /// Takes over what changed.
    pub(crate) fn follow(&mut self) -> &Known {
        for entity in self.gone.read().chain(self.gone_suns.read()) {
            self.known.set(entity, self.all.contains(entity));
        }
        // After those that went, whose indices they may have.
        for entity in &self.added {
            self.known.set(entity, true);
        }
        &self.known
    }
}
