//! Settings of a bake by sampled lines.

use super::SampledError;

/// Settings of a bake by sampled lines. Results are a function of these, the scene and the cells,
/// and of nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SampledSettings {
    /// Seed of the lines. Default: 1.
    pub seed: u64,
    /// The bake ends after about so many rays, each traced to its first hit; at least 1. A round
    /// that was begun is ended. Time grows with it. Default: 100,000,000.
    pub rays: u64,
    /// The bake ends earlier where the mean over the cells of what is
    /// [estimated](super::ScenePvs::missing) to be missing is at most this share, 0 to 1. Less
    /// takes longer and misses less; 0 uses all rays. Default: 0.00002.
    pub missing: f64,
    /// Whatever could appear wider than this from some point of a cell is kept there, whether a
    /// line found it or not: in radians, above 0 to π, of the ball around its bounds. Less keeps
    /// more of what stands near a cell. Default: π, only what the cell may touch.
    pub keep_angle: f64,
    /// Cells get what cells within this distance see, in units of the world, from 0: those that
    /// touch. It hides what lines missed, and keeps more. Default: none, each cell has its own.
    pub union_radius: Option<f64>,
}

impl Default for SampledSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            rays: 100_000_000,
            missing: 2e-5,
            keep_angle: std::f64::consts::PI,
            union_radius: None,
        }
    }
}

impl SampledSettings {
    /// Returns a copy with `seed`.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Returns a copy with `rays`.
    #[must_use]
    pub fn with_rays(self, rays: u64) -> Self {
        Self { rays, ..self }
    }

    /// Returns a copy with `missing`, the share that may be missing.
    #[must_use]
    pub fn with_missing(self, missing: f64) -> Self {
        Self { missing, ..self }
    }

    /// Returns a copy with `keep_angle`, the angle from which on nothing is hidden.
    #[must_use]
    pub fn with_keep_angle(self, keep_angle: f64) -> Self {
        Self { keep_angle, ..self }
    }

    /// Returns a copy that joins the sets of cells within `union_radius`.
    #[must_use]
    pub fn with_union_radius(self, union_radius: Option<f64>) -> Self {
        Self { union_radius, ..self }
    }

    /// Says which setting is out of its range.
    pub(super) fn check(&self) -> Result<(), SampledError> {
        let refuse = |name, value, range| -> Result<(), SampledError> {
            Err(SampledError::Setting { name, value, range })
        };
        if self.rays == 0 {
            return refuse("rays", 0.0, "at least 1");
        }
        if !(0.0..=1.0).contains(&self.missing) {
            return refuse("missing", self.missing, "a share of 0 to 1");
        }
        if !(self.keep_angle > 0.0 && self.keep_angle <= std::f64::consts::PI) {
            return refuse("keep_angle", self.keep_angle, "radians above 0, at most 3.14159 (π)");
        }
        match self.union_radius {
            Some(r) if !(r >= 0.0 && r.is_finite()) => {
                refuse("union_radius", r, "a distance from 0 in units of the world, or none")
            }
            _ => Ok(()),
        }
    }
}
