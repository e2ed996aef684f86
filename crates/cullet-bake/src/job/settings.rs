//! Settings of a bake, as plans carry them.

use crate::pvs::{PvsPreset, PvsSettings};
use crate::sampled::{Granularity, RayTree, Region, SampledError, SampledSettings, ViewCells};
use serde::{Deserialize, Serialize};

/// Settings of sets: of cells that a file has, and of view cells of a scene. What concerns the
/// other kind has no effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Seed of the sampled lines. Default: 1.
    pub seed: u64,
    /// Whether cells of a file are found only by floods through whole portals. Default: no.
    pub fast: bool,
    /// Width of a slit that counts as closed in a file's cells, as a share of the diagonal.
    /// Default: 1e-6.
    pub tolerance: f64,
    /// Settings of view cells of a scene.
    pub scene: SceneSettings,
}

/// View cells of a scene, and the lines from them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneSettings {
    /// How many cells to make. Default: 500.
    pub view_cells: Option<u32>,
    /// Boxes to make cells in. Default: the scene's bounds.
    pub regions: Vec<Region>,
    /// Cells only so far above the scene's lowest point, in place of boxes.
    pub heights: Option<[f64; 2]>,
    /// Cut one box into equal cells, so many along each axis.
    pub grid: Option<[u32; 3]>,
    /// Sets of clusters of triangles instead of whole instances.
    pub clusters: bool,
    /// See [`SampledSettings::rays`].
    pub rays: Option<u64>,
    /// See [`SampledSettings::missing`].
    pub missing: Option<f64>,
    /// See [`SampledSettings::keep_angle`]; here in degrees.
    pub keep_angle: Option<f64>,
    /// See [`SampledSettings::union_radius`].
    pub join: Option<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        let PvsSettings { seed, tolerance, .. } = PvsSettings::default();
        Self { seed, fast: false, tolerance, scene: SceneSettings::default() }
    }
}

impl Settings {
    /// Returns the settings of the bake of a file's cells.
    #[must_use]
    pub fn of_cells(&self) -> PvsSettings {
        let preset = if self.fast { PvsPreset::Fast } else { PvsPreset::Full };
        let mut settings = PvsSettings::default().with_preset(preset).with_seed(self.seed);
        settings.tolerance = self.tolerance;
        settings
    }

    /// Returns the settings of the bake of view cells.
    #[must_use]
    pub fn sampled(&self) -> SampledSettings {
        let (default, scene) = (SampledSettings::default(), &self.scene);
        let angle = scene.keep_angle.map(|a| a.to_radians().min(std::f64::consts::PI));
        default
            .with_seed(self.seed)
            .with_rays(scene.rays.unwrap_or(default.rays))
            .with_missing(scene.missing.unwrap_or(default.missing))
            .with_keep_angle(angle.unwrap_or(default.keep_angle))
            .with_union_radius(scene.join)
    }

    /// The view cells of a scene.
    ///
    /// # Errors
    /// If a region is no box, or so many cells cannot be made.
    pub fn view_cells(&self, tree: &RayTree<'_>) -> Result<ViewCells, SampledError> {
        let scene = &self.scene;
        let mut whole = tree.bounds();
        // A flat scene has no room to stand in, but on it.
        let size = (0..3).map(|a| whole[1][a] - whole[0][a]).fold(0.0, f64::max);
        for a in 0..3 {
            if whole[1][a] - whole[0][a] < size * 1e-3 {
                whole[0][a] -= size * 0.01;
                whole[1][a] += size * 0.01;
            }
        }
        if let Some([low, high]) = scene.heights {
            let floor = whole[0][1];
            (whole[0][1], whole[1][1]) = (floor + low, floor + high);
        }
        let regions = if scene.regions.is_empty() { vec![whole] } else { scene.regions.clone() };
        match (scene.grid, &regions[..]) {
            (Some(counts), &[region]) => ViewCells::grid(region, counts),
            (Some([x, y, z]), _) => Err(SampledError::Cells {
                cells: u64::from(x) * u64::from(y) * u64::from(z),
                limit: 1 << 24,
            }),
            (None, _) => {
                let count = scene.view_cells.unwrap_or(CELLS);
                ViewCells::adaptive(tree, &regions, count, self.seed)
            }
        }
    }
}

/// Where nothing else was said.
const CELLS: u32 = 500;

impl SceneSettings {
    /// Returns the kind of item that sets tell apart.
    #[must_use]
    pub fn granularity(&self) -> Granularity {
        if self.clusters { Granularity::Cluster } else { Granularity::Instance }
    }

    /// Whether view cells are asked for, also where the scene has cells of its own.
    #[must_use]
    pub fn wants_view_cells(&self) -> bool {
        self.view_cells.is_some()
            || self.grid.is_some()
            || !self.regions.is_empty()
            || self.heights.is_some()
    }
}
