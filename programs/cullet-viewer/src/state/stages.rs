//! The culler's settings as the switches have them.

use cullet::cull::detail::{Detail, Measure};
use cullet::cull::occlusion::Occlusion;
use cullet::lod::Lod;
use cullet::{Backface, Culler, Output};
use serde::{Deserialize, Serialize};

/// Settings of a [`Culler`], and whether it runs at all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Stages {
    /// Whether anything is culled; off draws all.
    pub on: bool,
    /// See [`Culler::frustum`].
    pub frustum: bool,
    /// See [`Culler::frustum_exact`].
    pub frustum_exact: bool,
    /// Whether what is seen through no portal is culled, in scenes with cells; see
    /// [`Culler::portal`].
    pub portal: bool,
    /// See [`Culler::backface`].
    pub backface: Backface,
    /// See [`Culler::degenerate`].
    pub degenerate: bool,
    /// The size in pixels under which instances are culled; 0 culls none.
    pub detail_px: f64,
    /// How that size is measured.
    pub detail_by: Measure,
    /// How much above that size what is left begins to fade, as a share of it; 0 fades nothing. See
    /// [`Detail::fade`].
    pub detail_fade: f64,
    /// Pixels by which levels of detail may be off; 0 draws all in full. See [`Culler::lod`].
    pub lod_px: f64,
    /// Whether that holds in the image's corners too.
    pub lod_corners: bool,
    /// The most triangles that are drawn with levels of detail; 0 is no budget. See
    /// [`Lod::triangles`].
    pub lod_triangles: u64,
    /// Whether levels are chosen for a ball of eyes, and stay while the eye is in it.
    pub lod_steady: bool,
    /// The radius of that ball, as a share of the distance from what the camera turns around.
    pub lod_ball: f64,
    /// How many seconds the levels of an instance take to fade into those that follow; 0 has them
    /// change at once.
    pub lod_fade: f64,
    /// Whether impostors are among the levels; see [`Lod::impostors`].
    pub lod_impostors: bool,
    /// Whether occluded instances and clusters are culled; see [`Culler::occlusion`].
    pub occlusion: bool,
    /// See [`Occlusion::width`].
    pub occlusion_width: u32,
    /// See [`Occlusion::budget`].
    pub occlusion_budget: f32,
    /// How deep the answer goes.
    pub depth: Output,
}

impl Default for Stages {
    fn default() -> Self {
        Self::of(&Culler::balanced())
    }
}

impl Stages {
    /// The settings of a culler, which runs.
    #[must_use]
    pub fn of(culler: &Culler) -> Self {
        let detail = culler.detail.unwrap_or(Detail::default().with_threshold_px(0.0));
        let occlusion = culler.occlusion.unwrap_or_default();
        Self {
            on: true,
            frustum: culler.frustum,
            frustum_exact: culler.frustum_exact,
            portal: culler.portal,
            backface: culler.backface,
            degenerate: culler.degenerate,
            detail_px: detail.threshold_px,
            detail_by: detail.measure,
            detail_fade: detail.fade,
            lod_px: culler.lod.map_or(0.0, |lod| lod.pixels),
            lod_corners: culler.lod.is_some_and(|lod| lod.at_corners),
            lod_triangles: culler.lod.and_then(|lod| lod.triangles).unwrap_or(0),
            lod_steady: false,
            lod_ball: 0.05,
            lod_fade: 0.0,
            lod_impostors: culler.lod.is_none_or(|lod| lod.impostors),
            occlusion: culler.occlusion.is_some(),
            occlusion_width: occlusion.width,
            occlusion_budget: occlusion.budget,
            depth: culler.output,
        }
    }

    /// Nothing is culled.
    #[must_use]
    pub fn none() -> Self {
        Self {
            on: false,
            frustum: false,
            portal: false,
            backface: Backface::Off,
            degenerate: false,
            occlusion: false,
            ..Self::default()
        }
    }

    /// Frustum culling of whole instances alone, the first kind in most engines.
    #[must_use]
    pub fn frustum_only() -> Self {
        Self {
            portal: false,
            backface: Backface::Off,
            degenerate: false,
            occlusion: false,
            depth: Output::Instances,
            ..Self::default()
        }
    }

    /// Every stage, down to triangles, with detail culling under two pixels, which is lossy.
    #[must_use]
    pub fn all() -> Self {
        Self { frustum_exact: true, detail_px: 2.0, depth: Output::Triangles, ..Self::default() }
    }

    /// The default stages but occlusion.
    #[must_use]
    pub fn without_occlusion() -> Self {
        Self { occlusion: false, ..Self::default() }
    }

    /// The culler with these settings, with reasons, timed by `clock`.
    #[must_use]
    pub fn culler(&self, clock: fn() -> u64) -> Culler {
        let on = self.on;
        Culler::default()
            .with_frustum(on && self.frustum)
            .with_frustum_exact(on && self.frustum_exact)
            .with_portal(on && self.portal)
            .with_backface(if on { self.backface } else { Backface::Off })
            .with_degenerate(on && self.degenerate)
            .with_detail(
                (on && self.detail_px > 0.0).then_some(
                    Detail::default()
                        .with_measure(self.detail_by)
                        .with_threshold_px(self.detail_px)
                        .with_fade(self.detail_fade),
                ),
            )
            .with_lod(
                (on && self.lod_px > 0.0).then_some(
                    Lod::default()
                        .with_pixels(self.lod_px)
                        .with_at_corners(self.lod_corners)
                        .with_triangles((self.lod_triangles > 0).then_some(self.lod_triangles))
                        .with_impostors(self.lod_impostors),
                ),
            )
            .with_occlusion(
                (on && self.occlusion).then_some(
                    Occlusion::default()
                        .with_width(self.occlusion_width)
                        .with_budget(self.occlusion_budget),
                ),
            )
            .with_output(self.depth)
            .with_reasons(true)
            .with_clock(Some(clock))
    }
}
