//! Settings of a culler, one at a time, and what they need of meshes.

use super::{Backface, Culler, Output};
use crate::Simd;
use crate::costs::Costs;
use crate::cull::detail::Detail;
use crate::cull::occlusion::Occlusion;
use crate::funnel::Stage;
use crate::lod::Lod;
use crate::prepared::Preparation;

/// New fields may come, so that a culler is made of a preset and these.
///
/// ```
/// use cullet::cull::occlusion::Occlusion;
/// use cullet::{Culler, Output};
///
/// let culler = Culler::exact().with_output(Output::Triangles).with_occlusion(None);
/// let wide = Culler::default().with_occlusion(Occlusion::default().with_width(1280));
/// assert!(culler.occlusion.is_none() && wide.occlusion.is_some());
/// ```
impl Culler {
    /// These settings with [`frustum`](Self::frustum) culling on or off.
    #[must_use]
    pub fn with_frustum(self, frustum: bool) -> Self {
        Self { frustum, ..self }
    }

    /// These settings with the [exact test](Self::frustum_exact) of boxes that straddle on or off.
    #[must_use]
    pub fn with_frustum_exact(self, frustum_exact: bool) -> Self {
        Self { frustum_exact, ..self }
    }

    /// These settings with [masks of candidates and visible sets](Self::pvs) on or off.
    #[must_use]
    pub fn with_pvs(self, pvs: bool) -> Self {
        Self { pvs, ..self }
    }

    /// These settings with [portals](Self::portal) on or off.
    #[must_use]
    pub fn with_portal(self, portal: bool) -> Self {
        Self { portal, ..self }
    }

    /// These settings with another way to cull [back faces](Self::backface).
    #[must_use]
    pub fn with_backface(self, backface: Backface) -> Self {
        Self { backface, ..self }
    }

    /// These settings with [triangles without area](Self::degenerate) culled or not.
    #[must_use]
    pub fn with_degenerate(self, degenerate: bool) -> Self {
        Self { degenerate, ..self }
    }

    /// These settings with [small-object culling](Self::detail), or without.
    #[cfg(feature = "lossy")]
    #[must_use]
    pub fn with_detail(self, detail: impl Into<Option<Detail>>) -> Self {
        Self { detail: detail.into(), ..self }
    }

    /// These settings with [levels of detail](Self::lod), or without.
    #[cfg(feature = "lossy")]
    #[must_use]
    pub fn with_lod(self, lod: impl Into<Option<Lod>>) -> Self {
        Self { lod: lod.into(), ..self }
    }

    /// These settings with [occlusion culling](Self::occlusion), or without.
    #[must_use]
    pub fn with_occlusion(self, occlusion: impl Into<Option<Occlusion>>) -> Self {
        Self { occlusion: occlusion.into(), ..self }
    }

    /// These settings with other [costs](Self::costs).
    #[must_use]
    pub fn with_costs(self, costs: Costs) -> Self {
        Self { costs, ..self }
    }

    /// These settings with another [depth of the answer](Self::output).
    #[must_use]
    pub fn with_output(self, output: Output) -> Self {
        Self { output, ..self }
    }

    /// These settings with [reasons](Self::reasons) given or not.
    #[must_use]
    pub fn with_reasons(self, reasons: bool) -> Self {
        Self { reasons, ..self }
    }

    /// These settings with [dropped triangles](Self::dropped) listed or not.
    #[must_use]
    pub fn with_dropped(self, dropped: bool) -> Self {
        Self { dropped, ..self }
    }

    /// These settings at another [SIMD level](Self::simd).
    #[must_use]
    pub fn with_simd(self, simd: Simd) -> Self {
        Self { simd, ..self }
    }

    /// These settings with a [clock](Self::clock), or without.
    #[must_use]
    pub fn with_clock(self, clock: Option<fn() -> u64>) -> Self {
        Self { clock, ..self }
    }

    /// Whether a stage runs.
    #[must_use]
    pub fn runs(&self, stage: Stage) -> bool {
        match stage {
            Stage::Layer => true,
            Stage::Frustum => self.frustum,
            Stage::Pvs => self.pvs,
            Stage::Portal => self.portal,
            Stage::Detail => self.detail_settings().is_some(),
            Stage::Occlusion => self.occlusion.is_some(),
            Stage::Backface => self.backface != Backface::Off,
            Stage::Degenerate => self.degenerate,
            Stage::Lod => self.lod_settings().is_some(),
        }
    }

    /// The field [`detail`](Self::detail); `None` without the feature that has it, so that nothing
    /// of the stage is linked.
    pub(crate) fn detail_settings(&self) -> Option<Detail> {
        #[cfg(feature = "lossy")]
        {
            self.detail
        }
        #[cfg(not(feature = "lossy"))]
        {
            None
        }
    }

    /// The field [`lod`](Self::lod), in the same way.
    pub(crate) fn lod_settings(&self) -> Option<Lod> {
        #[cfg(feature = "lossy")]
        {
            self.lod
        }
        #[cfg(not(feature = "lossy"))]
        {
            None
        }
    }
}

impl From<&Culler> for Preparation {
    /// Takes what the stages of a culler use, for views that cull back faces.
    fn from(culler: &Culler) -> Self {
        let backfaces = culler.backface == Backface::Fast;
        Self { backfaces, frontfaces: false, occluder: culler.occlusion.is_some() }
    }
}
