//! The record: the figures that the paper prints, and those measured, as they are written.

use serde::Serialize;

use cullet_command::machine::Machine;

/// Cells along an edge of the cube, and what the paper prints for them: per cent culled,
/// milliseconds a frame.
pub const PAPER: [(u32, f64, f64); 9] = [
    (2, 27.5, 469.5),
    (4, 35.1, 425.1),
    (6, 38.2, 396.3),
    (8, 39.9, 388.3),
    (10, 40.9, 391.3),
    (12, 41.6, 393.8),
    (14, 42.2, 386.2),
    (16, 42.6, 378.6),
    (18, 43.0, 371.9),
];

/// Triangles in the paper's frames.
pub(super) const PAPER_TRIANGLES: f64 = 138_901.0;

/// All that the command finds.
#[derive(Debug, Serialize)]
pub(super) struct ZhangHoffRecord {
    pub(super) schema: u32,
    pub(super) model: CopiesRecord,
    /// Views that the shares are means over.
    pub(super) directions: u32,
    /// The fitted distance, in radii of the sphere around all copies.
    pub(super) distance_radii: f64,
    /// Ours less the paper's at that distance, over N ≥ 6, where it is largest.
    pub(super) worst_difference_points: f64,
    /// Triangles that a mask culled and the exact test does not; 0, or something is very wrong.
    pub(super) front_faces_lost: u64,
    pub(super) renderer: String,
    pub(super) machine: Machine,
    /// Views drawn.
    pub(super) frames: u32,
    /// Whether each was drawn the same with masks as without, pixel for pixel.
    pub(super) images_agree: bool,
    /// A frame without masks: the renderer finds the back faces itself.
    pub(super) baseline_ms: Option<f64>,
    /// Time of a frame without triangles, a part of the whole that no culling saves.
    pub(super) empty_ms: Option<f64>,
    pub(super) rows: Vec<TableRow>,
    /// The engine's own test of triangles at the same views, for comparison.
    pub(super) planes8: Option<Drawn>,
    pub(super) other_distances: Vec<Distance>,
    pub(super) groups: Vec<GroupRow>,
    pub(super) sectors: Vec<SectorRow>,
    /// False where Ctrl-C stopped the command early.
    pub(super) complete: bool,
}

#[derive(Debug, Serialize)]
pub(super) struct CopiesRecord {
    pub(super) name: String,
    pub(super) copies: u32,
    /// Triangles of all copies.
    pub(super) triangles: u64,
    /// Why it is no solid, where it is taken for one all the same.
    pub(super) defect: Option<String>,
}

/// A row of Table 1. Counts are of all copies, means over the directions.
#[derive(Clone, Debug, Serialize)]
pub(super) struct TableRow {
    pub(super) n: u32,
    pub(super) classes: u32,
    /// Triangles that the masks keep; the paper's word for them is front-facing.
    pub(super) front: u64,
    pub(super) back: u64,
    pub(super) culled_percent: f64,
    pub(super) paper_percent: f64,
    pub(super) exact_percent: f64,
    pub(super) ms_per_frame: Option<f64>,
    pub(super) speedup: Option<f64>,
    /// The speed-up if a frame's time depended on its triangles alone, each costing the same.
    pub(super) even_speedup: f64,
    pub(super) paper_ms: f64,
}

/// Frames drawn from a list.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Drawn {
    pub(super) culled_percent: f64,
    pub(super) ms_per_frame: f64,
    pub(super) speedup: f64,
}

/// The shares at another distance.
#[derive(Debug, Serialize)]
pub(super) struct Distance {
    pub(super) distance_radii: f64,
    pub(super) rows: Vec<ShareRow>,
}

/// The share that a grid culls of all copies, a mean over the directions.
#[derive(Debug, Serialize)]
pub struct ShareRow {
    /// Cells along an edge of the cube.
    pub n: u32,
    /// Classes of normals.
    pub classes: u32,
    /// Triangles that the masks keep.
    pub front: u64,
    /// Triangles that they cull.
    pub back: u64,
    /// Share culled by the masks.
    pub culled_percent: f64,
    /// Share that the exact test culls.
    pub exact_percent: f64,
}

/// The share culled with a viewing cone for each group.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct GroupRow {
    pub(super) groups: usize,
    /// In radii of the one copy.
    pub(super) distance_copy_radii: f64,
    pub(super) culled_percent: f64,
    pub(super) exact_percent: f64,
    /// Microseconds a frame, for all masks and all tests.
    pub(super) us_per_frame: f64,
}

/// The share culled with a mask for each of k × k sectors of a square window that the model just
/// fits.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct SectorRow {
    pub(super) fov_degrees: f64,
    /// In radii of the one copy: where it just fits.
    pub(super) distance_copy_radii: f64,
    pub(super) k: usize,
    pub(super) culled_percent: f64,
    /// Percent with one mask, by the cone around the window's corners.
    pub(super) frustum_cone_percent: f64,
    /// Percent with one mask, by the cone around the model's sphere.
    pub(super) sphere_cone_percent: f64,
    pub(super) exact_percent: f64,
    /// Microseconds a frame, for the masks of all sectors, finding the sectors of each cluster, and
    /// all tests.
    pub(super) us_per_frame: f64,
}
