//! A view that stands in a scene that stands: the answer of its last frame is still right.
//!
//! That is told by versions, matrices and settings alone. The first frame that is like the one
//! before it is culled once more and kept; from the next on it is copied. Keeping each frame's
//! answer would cost a copy in every frame of a view that moves.

use alloc::boxed::Box;

use super::Culler;
#[cfg(feature = "shadows")]
use super::shadow::ShadowView;
use crate::scene::Scene;
use crate::view::View;
use crate::visible::Visible;

/// The last frame of a view, and its answer once that was worth keeping.
#[derive(Clone, Debug, Default)]
pub(super) struct Standing {
    frame: Option<Box<Question>>,
    answer: Box<Visible>,
    is_kept: bool,
}

/// All that an answer depends on.
#[derive(Clone, Debug, PartialEq)]
struct Question {
    /// Versions of the scene.
    versions: [u64; 4],
    culler: Culler,
    looks: Looks,
}

/// Who looks.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a box would be allocated in each frame")]
pub(super) enum Looks {
    Camera(View),
    #[cfg(feature = "shadows")]
    Light(ShadowView),
}

impl Standing {
    /// Fills `result` as `cull` would, which is called where the last frame was another. A clock
    /// wants the times of stages, so that with one they run.
    pub(super) fn answer(
        &mut self,
        (culler, scene): (&Culler, &Scene),
        looks: Looks,
        result: &mut Visible,
        cull: impl FnOnce(&mut Visible),
    ) {
        if culler.clock.is_some() {
            self.forget();
            return cull(result);
        }
        let question = Question { versions: scene.versions(), culler: culler.clone(), looks };
        let is_same = self.frame.as_deref() == Some(&question);
        if is_same && self.is_kept {
            result.clone_from(self.answer.as_ref());
            return;
        }
        cull(result);
        self.is_kept = is_same;
        if is_same {
            self.answer.as_mut().clone_from(result);
        } else {
            match &mut self.frame {
                Some(frame) => **frame = question,
                None => self.frame = Some(Box::new(question)),
            }
        }
    }

    /// Forgets the last frame: the next is culled.
    pub(super) fn forget(&mut self) {
        (self.frame, self.is_kept) = (None, false);
    }
}

impl PartialEq for Culler {
    /// Compares all that an answer depends on, and so no clocks.
    fn eq(&self, other: &Self) -> bool {
        let Self {
            frustum,
            frustum_exact,
            pvs,
            portal,
            backface,
            degenerate,
            #[cfg(feature = "lossy")]
                detail: _,
            #[cfg(feature = "lossy")]
                lod: _,
            occlusion,
            costs,
            output,
            reasons,
            dropped,
            simd,
            clock: _,
        } = self;
        (frustum, frustum_exact, pvs, portal)
            == (&other.frustum, &other.frustum_exact, &other.pvs, &other.portal)
            && (backface, degenerate) == (&other.backface, &other.degenerate)
            && self.detail_settings() == other.detail_settings()
            && self.lod_settings() == other.lod_settings()
            && (occlusion, costs, output) == (&other.occlusion, &other.costs, &other.output)
            && (reasons, dropped, simd) == (&other.reasons, &other.dropped, &other.simd)
    }
}
