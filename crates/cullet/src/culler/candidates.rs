//! Candidates: instances that may be visible, as the caller knows from elsewhere.

use super::CullError;
use crate::scene::Scene;

/// Instances that may be visible for all that the caller knows: by visible sets, streaming, fog of war or what an editor
/// isolates.
///
/// [`Culler::cull_among`](super::Culler::cull_among) drops all others after the frustum stage, in the row and with the reason of
/// [`Stage::Pvs`](crate::Stage::Pvs). [Exempt](Scene::exempt) instances stay.
///
/// A vector or slice of words is a mask of candidates: bit s mod 64 of word s / 64 is that of slot s. It holds until slots are
/// permuted; see [`Scene::order_version`].
pub trait Candidates {
    /// Refuses a scene that the candidates are not of.
    ///
    /// # Errors
    /// [`CullError::Candidates`] for a mask of the wrong length.
    fn check(&self, scene: &Scene) -> Result<(), CullError>;

    /// Returns one bit for each slot of `word`: its instance may be visible.
    fn word(&self, word: usize) -> u64;
}

impl Candidates for &[u64] {
    fn check(&self, scene: &Scene) -> Result<(), CullError> {
        let (words, expected) = (self.len(), scene.slot_count().div_ceil(64) as usize);
        if words == expected {
            return Ok(());
        }
        Err(CullError::Candidates { words, expected, slots: scene.slot_count() })
    }

    fn word(&self, word: usize) -> u64 {
        self[word]
    }
}

impl Candidates for Vec<u64> {
    fn check(&self, scene: &Scene) -> Result<(), CullError> {
        self.as_slice().check(scene)
    }

    fn word(&self, word: usize) -> u64 {
        self[word]
    }
}
