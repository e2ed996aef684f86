//! Candidates: instances that may be visible, as the caller knows from elsewhere.

use alloc::vec::Vec;

use super::{CullError, Culler, Evidence};
use crate::funnel::Stage;
use crate::scene::Scene;
use crate::view::{Frustum, View};

/// A cull that is under way, as [`Candidates`] see it.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// Settings of the cull.
    pub culler: &'a Culler,
    /// The scene.
    pub scene: &'a Scene,
    /// The view that is culled for.
    pub view: &'a View,
}

/// Instances that may be visible for all that the caller knows: by visible sets, cells and portals,
/// streaming, fog of war or what an editor isolates.
///
/// [`Culler::cull_among`] drops all others after the frustum stage. [Exempt](Scene::exempt)
/// instances stay.
///
/// A vector or slice of words is a mask of candidates: bit s mod 64 of word s / 64 is that of slot
/// s. It holds until slots are permuted; see [`Scene::order_version`]. What it drops is in the row
/// of [`Stage::Pvs`]. The crate `cullet-cells` has candidates by cells, portals and visible sets.
pub trait Candidates {
    /// Refuses a scene that the candidates are not of.
    ///
    /// # Errors
    /// [`CullError::Candidates`] for a mask of the wrong length, [`CullError::Order`] for
    /// candidates of an earlier order.
    fn check(&self, scene: &Scene) -> Result<(), CullError>;

    /// Returns the stages by which candidates are told from others: [`Stage::Pvs`],
    /// [`Stage::Portal`] or both. Each that the culler [runs](Culler::runs) has a row in the
    /// funnel.
    fn stages(&self) -> &[Stage] {
        &[Stage::Pvs]
    }

    /// Looks from a view, once for each stage of a cull. `alive` has one bit for each slot that is
    /// left, and `live` lists the words of it that are not zero.
    fn look(&self, stage: Stage, look: &Look<'_>, alive: &[u64], live: &[u32]) {
        let _ = (stage, look, alive, live);
    }

    /// Returns one bit for each slot of `word`: its instance may be visible by `stage`.
    fn word(&self, stage: Stage, word: usize) -> u64;

    /// Returns the [detail](crate::Reason::detail) of the reason for which `stage` drops the
    /// instance of `slot`.
    fn detail(&self, stage: Stage, slot: u32) -> u8 {
        let _ = (stage, slot);
        0
    }

    /// Returns one bit for each slot of `word`: only a part of its instance may be visible, that
    /// within [`frusta`](Self::frusta).
    fn straddling(&self, word: usize) -> u64 {
        let _ = word;
        0
    }

    /// Calls `each` with the frusta, in world space, one of which holds what may be visible of the
    /// instance of `slot`.
    fn frusta(&self, scene: &Scene, slot: u32, each: &mut dyn FnMut(&Frustum)) {
        let _ = (scene, slot, each);
    }

    /// Returns the numbers for which `stage` keeps or drops the instance of `slot`.
    fn explain(&self, stage: Stage, scene: &Scene, slot: u32) -> Evidence {
        let _ = (stage, scene, slot);
        Evidence::None
    }
}

impl Candidates for &[u64] {
    fn check(&self, scene: &Scene) -> Result<(), CullError> {
        let (words, expected) = (self.len(), scene.slot_count().div_ceil(64) as usize);
        if words == expected {
            return Ok(());
        }
        Err(CullError::Candidates { words, expected, slots: scene.slot_count() })
    }

    fn word(&self, _: Stage, word: usize) -> u64 {
        self[word]
    }
}

impl Candidates for Vec<u64> {
    fn check(&self, scene: &Scene) -> Result<(), CullError> {
        self.as_slice().check(scene)
    }

    fn word(&self, _: Stage, word: usize) -> u64 {
        self[word]
    }
}
