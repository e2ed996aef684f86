//! Options that choose the kinds of culling.

use clap::{Args, ValueEnum};
use cullet::cull::detail::Measure;
use cullet::lod::Lod;
use cullet::{Culler, Stage};

use crate::parse;

/// Options that choose the kinds of culling.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Culling")]
pub struct CullArgs {
    /// How much is looked for; the options below change single settings of it
    #[arg(long, value_parser = parse::choice(PRESETS), default_value = "balanced")]
    pub preset: Preset,
    /// Also drop what stays under PX pixels on the screen (lossy: may cost visible pixels); 0 drops
    /// nothing
    #[arg(long, value_name = "PX", value_parser = parse::pixels)]
    pub detail: Option<f64>,
    /// How --detail measures: both sides of the screen box, its area in square pixels, or its
    /// diagonal
    #[arg(long, value_parser = parse::choice(MEASURES), default_value = "sides")]
    pub detail_by: Measure,
    /// Let --detail drop clusters of larger instances, too: where these are made of small clusters,
    /// they get holes
    #[arg(long, requires = "detail")]
    pub detail_clusters: bool,
    /// Draw levels of detail that are off by up to PX pixels at the image's centre (lossy); 0 draws
    /// all in full. A scene without levels gets some from the baker, once
    #[arg(long, value_name = "PX", value_parser = parse::lod_pixels, allow_hyphen_values = true)]
    pub lod: Option<f64>,
    /// Let --lod hold in the image's corners too, where a pixel is a smaller angle
    #[arg(long, requires = "lod")]
    pub lod_corners: bool,
    /// Draw levels of detail of no more than N triangles, as little off as that allows, and by no
    /// less than --lod where it is given. What is counted is what culling of whole instances leaves
    #[arg(long, value_name = "N", value_parser = parse::budget)]
    pub lod_triangles: Option<u64>,
    /// Choose levels for a ball of eyes of this radius, in units of the scene; views stay in the
    /// ball of an earlier one as long as their eye does, so that nothing changes from one to the
    /// next
    #[arg(long, value_name = "R", value_parser = parse::ball)]
    pub lod_ball: Option<f64>,
    /// Run one stage alone
    #[arg(long, value_parser = parse::choice(ALONE), value_name = "STAGE", conflicts_with_all = ["no_frustum", "no_pvs", "no_portal", "no_backface", "no_degenerate", "no_occlusion"])]
    pub only: Option<Stage>,
    /// Keep what is outside the frustum
    #[arg(long)]
    pub no_frustum: bool,
    /// Keep what is not in the potentially visible set of the eye's cell
    #[arg(long)]
    pub no_pvs: bool,
    /// Keep what is in cells that are not seen through portals
    #[arg(long)]
    pub no_portal: bool,
    /// Keep back faces
    #[arg(long)]
    pub no_backface: bool,
    /// Keep degenerate triangles, which have no area
    #[arg(long)]
    pub no_degenerate: bool,
    /// Keep occluded instances and clusters
    #[arg(long)]
    pub no_occlusion: bool,
    /// Pixels across the occlusion buffer; never more than the view has [default: the preset's]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub occlusion_width: Option<u32>,
    /// Budget for drawing occluders, per view, in modelled microseconds [default: the preset's]
    #[arg(long, value_name = "US", value_parser = parse::microseconds)]
    pub occlusion_budget: Option<f32>,
    /// Look for what is hidden only as far as it pays: at first no more than this share of what
    /// drawing all that is left costs. The library's preset has 0.015 [default: look, whatever it
    /// costs]
    #[arg(long, value_name = "SHARE", value_parser = parse::share)]
    pub occlusion_risk: Option<f32>,
    /// Occluders: each mesh itself, boxes and polygons baked from it first, or the cheaper of the
    /// two
    #[arg(long, value_enum, default_value_t = OccluderKind::Mesh)]
    pub occluders: OccluderKind,
    /// Test big boxes at the frustum's corners exactly
    #[arg(long)]
    pub exact_frustum: bool,
}

impl CullArgs {
    /// Returns the levels of detail that are drawn; none where all is drawn in full.
    #[must_use]
    pub fn levels(&self) -> Option<Lod> {
        let alone = self.only == Some(Stage::Lod);
        let triangles = self.lod_triangles;
        // A budget alone takes the finest levels that it can.
        let by_default = || alone.then(|| Lod::default().pixels);
        let pixels = self.lod.or(triangles.map(|_| 0.0)).or_else(by_default)?;
        let runs = (pixels > 0.0 || triangles.is_some()) && (self.only.is_none() || alone);
        runs.then_some(
            Lod::default()
                .with_pixels(pixels)
                .with_at_corners(self.lod_corners)
                .with_triangles(triangles),
        )
    }
}

/// A preset of the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// [`Culler::exact`]
    Exact,
    /// [`Culler::balanced`]
    Balanced,
    /// [`Culler::fast`]
    Fast,
}

impl Preset {
    /// Its culler.
    #[must_use]
    pub fn culler(self) -> Culler {
        match self {
            Self::Exact => Culler::exact(),
            Self::Balanced => Culler::balanced(),
            Self::Fast => Culler::fast(),
        }
    }
}

/// The presets of the engine.
pub const PRESETS: &[(&str, Preset, &str)] = &[
    ("exact", Preset::Exact, "All that can be proved invisible, whatever it takes"),
    ("balanced", Preset::Balanced, "What pays in most frames: the engine's own settings"),
    ("fast", Preset::Fast, "What is found soonest: a narrow buffer, and few occluders"),
];

/// The stages that can be run alone.
const ALONE: &[(&str, Stage, &str)] = &[
    ("frustum", Stage::Frustum, "Instances, clusters and triangles outside the frustum"),
    (
        "pvs",
        Stage::Pvs,
        "Instances not in the potentially visible set of the eye's cell, in scenes with such sets",
    ),
    (
        "portal",
        Stage::Portal,
        "Instances and clusters not seen through any portal, in scenes with cells",
    ),
    (
        "detail",
        Stage::Detail,
        "Small instances on the screen (lossy; --detail sets the threshold, else a pixel)",
    ),
    ("occlusion", Stage::Occlusion, "Occluded instances and clusters"),
    ("backface", Stage::Backface, "Back-facing clusters and triangles"),
    ("degenerate", Stage::Degenerate, "Degenerate triangles, without area"),
    ("lod", Stage::Lod, "Levels of detail (lossy; --lod sets the threshold, else a pixel)"),
];

/// How detail culling measures.
const MEASURES: &[(&str, Measure, &str)] = &[
    ("sides", Measure::WidthAndHeight, "Width and height both under the threshold"),
    ("area", Measure::Area, "Area under the threshold"),
    ("diameter", Measure::Diameter, "Diagonal under the threshold"),
];

/// Proxy that is drawn for a mesh into the occlusion buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OccluderKind {
    /// Proxies where they cover nearly as much at half the modelled cost, else the mesh
    Auto,
    /// The mesh itself
    Mesh,
    /// Boxes and polygons made from it, and some of its triangles where those leave much; nothing
    /// where none do
    Baked,
}
