//! The command line of `cullet picture`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use cullet_command::args::InputArgs;

/// End of `cullet picture --help`.
pub(crate) const HELP: &str = "\
kinds   the scene from outside, cut open above the eye where something covers what that sees: each
        triangle in the colour of the kind of culling that took it
shaded  the view itself
depth   how often each pixel is covered
map     from above: the frustum, and every instance coloured by what became of it
hierarchy
        from above, level by level: what the walk of the hierarchy dropped, kept whole, tested further

Of levels of detail, with --lod PX:
levels            each triangle that is drawn in the colour of its level
levels-difference the view in full, as it is drawn, and where they differ
impostor *        the impostor of the largest mesh beside it, from two sides and at four sizes: the one that
                  the file has, or else one that is made now; no view

Of occlusion culling:
occlusion-buffer  the true depth, what is proved pixel by pixel and tile by tile, and the difference
occluders         what each occluder that was drawn covers
hidden            what is hidden, as ghosts behind what hides it
coverage *        when a pixel counts as covered, and what a buffer of samples does not see; no scene

Of portals, in scenes with cells:
portals           what the view sees of each portal, in the order of the walk; shut doors; a plan with the chain
cells             the cells from above, cut where the eye is: portals, what is reached, what is in sight
pvs-matrix *      which cells see each other, proven or kept; of a .prt, a .bsp, a .cpvs, or a scene

To teach back-face culling *: normal-mask, normal-partition, conservative-set, culling-volume, clusters, cones, back-regions
To teach clipping *: outcodes, clip-polygon, clip-w, pipeline

* is drawn by cullet-lab, which this program starts: cullet-lab picture --help says more of it.

Examples
  cullet picture kinds --out kinds.png
  cullet picture occlusion-buffer plant --path walk --views 8 --view 2
  cullet picture levels castle.glb --lod 1
  cullet picture portals office --path walk --views 8 --view 3
  cullet picture pvs-matrix lqdm1.bsp
  cullet picture map city:seed=3 --path walk --view 2 --views 4";

/// `cullet picture`
#[derive(Debug, Args)]
pub struct PictureArgs {
    /// The kind of picture
    #[arg(value_enum)]
    pub(crate) kind: PictureKind,
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// View of the path, from 0
    #[arg(long = "view", value_name = "INDEX", default_value_t = 0)]
    pub(crate) index: u32,
    /// The PNG to write [default: KIND.png]
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) out: Option<PathBuf>,
}

/// Kind of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PictureKind {
    /// Each triangle in the colour of the kind of culling that took it
    Kinds,
    /// The view itself
    Shaded,
    /// How often each pixel is covered
    Depth,
    /// From above, with the frustum
    Map,
    /// The walk of the scene's hierarchy, level by level, from above
    Hierarchy,
    /// Each triangle in the colour of its level of detail
    Levels,
    /// The view in full, with levels of detail, and where those differ
    LevelsDifference,
    /// The true depth, the occlusion buffer by pixels and by tiles, and what they differ by
    OcclusionBuffer,
    /// The area that each drawn occluder covers
    Occluders,
    /// The occluded instances, as ghosts
    Hidden,
    /// View through each portal, one through the other
    Portals,
    /// The cells from above, and which are reached
    Cells,
}

impl PictureKind {
    /// Its name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Kinds => "kinds",
            Self::Shaded => "shaded",
            Self::Depth => "depth",
            Self::Map => "map",
            Self::Hierarchy => "hierarchy",
            Self::Levels => "levels",
            Self::LevelsDifference => "levels-difference",
            Self::OcclusionBuffer => "occlusion-buffer",
            Self::Occluders => "occluders",
            Self::Hidden => "hidden",
            Self::Portals => "portals",
            Self::Cells => "cells",
        }
    }
}
