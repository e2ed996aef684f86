//! The command line of `cullet picture`.

use std::path::PathBuf;

use crate::calibrate::ClusterArgs;
use clap::{Args, ValueEnum};
use cullet_command::args::InputArgs;

/// End of `cullet picture --help`.
pub(crate) const HELP: &str = "\
impostor          the impostor of the largest mesh beside it, from two sides and at four sizes: the one that
                  the file has, or else one that is made now; no view
coverage          when a pixel counts as covered, and what a buffer of samples does not see; no scene
pvs-matrix        which cells see each other, proven or kept; of a .prt, a .bsp, a .cpvs, or a scene

To teach back-face culling:
normal-mask       the cube of directions in 216 and 1536 classes, those that face away in pink
normal-partition  the same in the plane: the circle of normals
conservative-set  how the set of back-facing normals grows as the view is cut into sectors
culling-volume    a cluster, and the eyes from which all of it faces away (--cluster N)
clusters          the model in the colours of its clusters
cones             the clusters with their cones of normals
back-regions      the connected regions that face away from the view's eye, counted
The first three read no scene: --eye and --target give the direction of sight, --fov the angle.
Clusters of two-sided meshes are never culled, and made otherwise: give --one-sided for scans with
holes.

To teach clipping; these draw no scene:
outcodes          the nine regions around a window; lines and triangles by their codes
clip-polygon      Sutherland & Hodgman, one side after another
clip-w            a segment behind the eye, divided before it is clipped, and after
pipeline          the spaces of the pipeline, the tests in each, and their cost on this machine

Examples
  cullet picture pvs-matrix lqdm1.bsp
  cullet picture normal-mask --eye 3,2,5 --target 0,0,0 --fov 20
  cullet picture back-regions knobs --views 8 --view 1
  cullet picture culling-volume bunny.ply --one-sided --cluster 17";

/// `cullet picture`
#[derive(Debug, Args)]
pub struct PictureArgs {
    /// The kind of picture
    #[arg(value_enum)]
    pub(crate) kind: PictureKind,
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// culling-volume: which cluster of the first instance, from 0 [default: the widest with a
    /// volume, of the first instance that has one]
    #[arg(long, value_name = "N")]
    pub(crate) cluster: Option<u32>,
    #[command(flatten)]
    pub(crate) clusters: ClusterArgs,
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
    /// A mesh, its impostor, and where they differ
    Impostor,
    /// When a pixel counts as covered
    Coverage,
    /// Cells that see each other
    PvsMatrix,
    /// The cube of directions and its classes that face away
    NormalMask,
    /// The circle of normals and its classes that face away
    NormalPartition,
    /// The conservative set of normals against the number of sectors
    ConservativeSet,
    /// A cluster and the eyes from which all of it faces away
    CullingVolume,
    /// The model in the colours of its clusters
    Clusters,
    /// The clusters with their cones of normals
    Cones,
    /// The connected regions that face away
    BackRegions,
    /// The nine regions of outcodes, with lines and triangles
    Outcodes,
    /// A polygon clipped side by side
    ClipPolygon,
    /// A segment behind the eye, divided and then clipped, and the other way round
    ClipW,
    /// The spaces of the pipeline and the tests in each
    Pipeline,
}

impl PictureKind {
    /// Its name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Impostor => "impostor",
            Self::Coverage => "coverage",
            Self::PvsMatrix => "pvs-matrix",
            Self::NormalMask => "normal-mask",
            Self::NormalPartition => "normal-partition",
            Self::ConservativeSet => "conservative-set",
            Self::CullingVolume => "culling-volume",
            Self::Clusters => "clusters",
            Self::Cones => "cones",
            Self::BackRegions => "back-regions",
            Self::Outcodes => "outcodes",
            Self::ClipPolygon => "clip-polygon",
            Self::ClipW => "clip-w",
            Self::Pipeline => "pipeline",
        }
    }
}
