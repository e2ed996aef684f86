//! Occluders made from a mesh: boxes inside of it, and convex polygons in its surface.
//!
//! An occluder must never hide what the mesh itself lets through. So a box is taken only where it
//! is *proved* to lie within what the mesh seals off, and a polygon only where it lies in the
//! surface:
//!
//! 1. Triangles that are blended or alpha-masked are left out, equal positions welded, and
//!    triangles with a free edge taken away again and again. What remains closed is a *shell*.
//!    Winding numbers, where it is consistently wound, or the parity of crossings, where it is
//!    drawn from both sides, tell what it seals: every path from outside to there crosses the shell
//!    where it is drawn.
//! 2. Each shell is put into a grid. Cells that no triangle of it comes near, and whose region
//!    three rays agree to be sealed, are solid. Cells inside of any shell count, so shells that
//!    overlap act as one.
//! 3. Boxes of solid cells are grown to the largest and chosen greedily by the area they newly
//!    hide. They overlap, since between boxes that only touch a strict rasteriser leaves seams
//!    (compare Darnell, *Automated Occluders for GPU Culling*, 2011, who grows boxes from the
//!    densest voxel). Then each side is pushed out to the surface, and rounded inward.
//! 4. Where walls are thinner than cells, where the mesh is open, and on slopes: triangles joined
//!    by edges that lie in one plane make a region; convex polygons within it are chosen in the
//!    same way, where no box is behind them.
//! 5. Where those leave much (slopes, round walls, open shells), triangles of the mesh stand for
//!    themselves; and so they do for eyes so near that the boxes do not serve them.
//!
//! ```
//! use cullet::mesh::Part;
//! use cullet::{Mesh, MeshData};
//! use cullet_bake::occluders::{OccluderOptions, occluders, validate};
//!
//! // A cube, wound outward.
//! let data = MeshData {
//!     positions: (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|v| v as f32)).collect(),
//!     indices: [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
//!         .iter()
//!         .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
//!         .collect(),
//!     parts: vec![Part { triangle_count: 12, ..Part::default() }],
//!     ..MeshData::default()
//! };
//! let mesh = Mesh::new(data)?;
//! let (made, report) = occluders(&mesh, &OccluderOptions::default())?;
//! assert_eq!((made.boxes.len(), made.polygons.len()), (1, 0));
//! assert!(made.boxes[0].min[0] < 1e-6 && report.efficiency() > 0.99);
//! assert!(validate(&mesh, &made, 64).is_valid());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod blocks;
mod flat;
mod grow;
mod sheets;
mod surface;
mod validate;
mod views;
mod voxels;

use cullet::Mesh;
use cullet::bounds::Aabb;
use glam::DVec3;
use thiserror::Error;

pub use cullet_io::baked::{OccluderPolygon, OccluderSheet, Occluders};
pub use validate::{Escape, Validation, validate};
pub use views::HiddenFrom;

use surface::Surface;
use voxels::Voxels;

/// How occluders are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OccluderOptions {
    /// Boxes at the most. Each costs a view its six sides.
    pub max_boxes: u32,
    /// Polygons at the most.
    pub max_polygons: u32,
    /// Triangles of the mesh itself at the most. They are taken where boxes and polygons leave more
    /// than a twentieth of the surface that boxes leave. Each costs a view about what a box does.
    pub max_triangles: u32,
    /// Triangles of the mesh at the most for eyes so near that its boxes do not serve them: who
    /// stands on a terrain, or in a house. Only such a view has them.
    pub max_near: u32,
    /// A box must add at least this share of what solid cells hide, and a polygon this share of the
    /// area of the surface: 0 to 1. Lower makes more occluders that each hide less.
    pub min_gain: f64,
    /// Cells along the longest side, 4 to [`MAX_RESOLUTION`](Self::MAX_RESOLUTION). Walls thinner
    /// than some two cells get no box. Time and memory grow by its cube, to 30 bytes a cell.
    pub resolution: u32,
    /// Directions from which the report compares, at most [`MAX_DIRECTIONS`](Self::MAX_DIRECTIONS);
    /// each costs a picture of the mesh. 0 leaves that out.
    pub directions: u32,
}

impl OccluderOptions {
    /// The largest resolution: 7.3 million cells, some 220 MB.
    pub const MAX_RESOLUTION: u32 = 192;
    /// The most directions.
    pub const MAX_DIRECTIONS: u32 = 4096;
}

impl Default for OccluderOptions {
    fn default() -> Self {
        Self {
            max_boxes: 16,
            max_polygons: 16,
            max_triangles: 256,
            max_near: 8192,
            min_gain: 0.01,
            resolution: 64,
            directions: 16,
        }
    }
}

/// Options that cannot be followed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OccluderError {
    /// Too few cells to have any inside, or more than memory is set aside for.
    #[error("a resolution of {0} is not within 4 to {max}; try 64", max = OccluderOptions::MAX_RESOLUTION)]
    Resolution(u32),
    /// No share.
    #[error("a gain of {0} is not within 0 to 1; try 0.01")]
    MinGain(f64),
    /// More than any use.
    #[error("{0} directions exceed the limit of {max}; try 16", max = OccluderOptions::MAX_DIRECTIONS)]
    Directions(u32),
}

/// Why a mesh has no boxes, or no polygons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoOccluders {
    /// The options allow none.
    #[error("none requested")]
    NotRequested,
    /// Its vertices may move.
    #[error("it deforms")]
    Deformable,
    /// It has no triangle of any area.
    #[error("it is empty")]
    Empty,
    /// All of it is blended or alpha-masked.
    #[error("it is transparent")]
    Transparent,
    /// Nothing in it is closed, so that a view reaches all space around it.
    #[error("open shell")]
    Open,
    /// The space that it seals off is thinner than the cells.
    #[error("thin")]
    Thin,
    /// Nothing hides as much as the options require.
    #[error("too little each")]
    Little,
    /// Triangles of the mesh stand for all that polygons would.
    #[error("its triangles serve")]
    Triangles,
}

/// Counts of the occluders that were made, and the areas that they hide.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OccluderReport {
    /// The share of what solid cells hide along the axes that each box adds, in the order of the
    /// boxes.
    pub box_gains: Vec<f64>,
    /// The share of the surface's area that each polygon adds to what boxes and polygons before it
    /// hide.
    pub polygon_gains: Vec<f64>,
    /// The share of the surface's area that triangles add to what boxes hide, and where they are
    /// not all that boxes leave, to what polygons do.
    pub triangle_gain: f64,
    /// Why there are no boxes.
    pub no_boxes: Option<NoOccluders>,
    /// Why there are no polygons.
    pub no_polygons: Option<NoOccluders>,
    /// Closed shells that can be proved to seal a space.
    pub shells: u32,
    /// Number of these shells that were skipped to bound the time.
    pub skipped_shells: u32,
    /// Triangles left out because they are blended or alpha-masked.
    pub transparent_triangles: u32,
    /// The area of the opaque triangles, in squared units of the mesh; a two-sided one counts once.
    pub area: f64,
    /// The volume of the solid cells, in cubed units of the mesh.
    pub solid_volume: f64,
    /// Hidden areas, from each of a number of directions.
    pub hidden: Vec<HiddenFrom>,
}

impl OccluderReport {
    /// The area that the occluders hide over that which the mesh hides, over all directions: 1 is
    /// perfect, 0 where the mesh hides nothing or the options have no directions. An estimate from
    /// samples.
    #[must_use]
    pub fn efficiency(&self) -> f64 {
        let sum = |of: fn(&HiddenFrom) -> f64| self.hidden.iter().map(of).sum::<f64>();
        let mesh = sum(|h| h.mesh);
        if mesh > 0.0 { sum(|h| h.occluders) / mesh } else { 0.0 }
    }
}

/// Boxes around what is sealed, at most: enough to follow a ring of walls around a yard.
const MOST_SEALED: usize = 16;

/// Makes occluders for a mesh: what they block, the mesh blocks, for the eyes that
/// [`Occluders::boxes_hold`] and [`OccluderPolygon::holds_from`] allow.
///
/// Never from blended or alpha-masked parts, nor from a mesh that deforms; the report says why
/// there are none. Sides are those that the mesh declares. Deterministic. About 0.1 s for a mesh of
/// some thousand triangles at the default resolution.
///
/// # Errors
/// If an option is out of its range.
pub fn occluders(
    mesh: &Mesh,
    options: &OccluderOptions,
) -> Result<(Occluders, OccluderReport), OccluderError> {
    check(options)?;
    let mut made = Occluders::default();
    let mut report = OccluderReport::default();
    if mesh.is_deformable() {
        report.no_boxes = Some(NoOccluders::Deformable);
        report.no_polygons = Some(NoOccluders::Deformable);
        return Ok((made, report));
    }
    let surface = Surface::of(mesh);
    report.transparent_triangles = surface.transparent;
    report.area = surface.area();
    if report.area <= 0.0 {
        let why = match surface.transparent {
            0 => NoOccluders::Empty,
            _ => NoOccluders::Transparent,
        };
        report.no_boxes = Some(why);
        report.no_polygons = Some(why);
        return Ok((made, report));
    }
    let cell = boxes(&surface, options, &mut made, &mut report);
    let backed = |p: DVec3, normal: DVec3| {
        // A box so near behind the surface hides about what the polygon would.
        let depths = [0.0, 0.02, 0.1, 0.5, 1.0, 2.0];
        depths.iter().flat_map(|d| [d * cell, -d * cell]).any(|d| {
            let q = p - normal * d;
            made.boxes
                .iter()
                .any(|b| (0..3).all(|a| q[a] >= f64::from(b.min[a]) && q[a] <= f64::from(b.max[a])))
        })
    };
    let polygons =
        flat::polygons(&surface, options.max_polygons as usize, options.min_gain, backed);
    (made.polygons, report.polygon_gains) = polygons.into_iter().unzip();
    let most = options.max_triangles as usize;
    let chosen = sheets::sheets(&surface, &made.polygons, most, options.min_gain, backed);
    if chosen.all {
        made.polygons.clear();
        report.polygon_gains.clear();
    }
    (made.sheets, report.triangle_gain) = (chosen.sheets, chosen.gain);
    if !made.boxes.is_empty() {
        let most = options.max_near as usize;
        let bare = sheets::sheets(&surface, &made.polygons, most, options.min_gain, |_, _| false);
        made.near = bare.sheets;
    }
    if made.polygons.is_empty() {
        report.no_polygons = Some(match (options.max_polygons, chosen.all) {
            (0, _) => NoOccluders::NotRequested,
            (_, true) => NoOccluders::Triangles,
            _ => NoOccluders::Little,
        });
    }
    report.hidden = views::hidden(&surface, &made, options.directions as usize);
    made.efficiency = report.efficiency();
    Ok((made, report))
}

/// Makes the boxes; returns the length of a cell.
fn boxes(
    surface: &Surface,
    options: &OccluderOptions,
    made: &mut Occluders,
    report: &mut OccluderReport,
) -> f64 {
    let shells = surface.shells();
    let voxels = Voxels::new(surface, &shells, options.resolution);
    let grid = &voxels.grid;
    let margin = surface.margin();
    report.shells = shells.len() as u32;
    report.skipped_shells = voxels.skipped;
    let solid = voxels.solid.iter().filter(|s| **s).count();
    report.solid_volume = solid as f64 * grid.cell.element_product();
    let [x, y, z] = grid.cell.to_array();
    // In proportion to the area of a cell's side; divided, since tiny meshes have tiny squares.
    let weight = [1.0 / x, 1.0 / y, 1.0 / z].map(|w| w * grid.cell.min_element());
    let chosen =
        blocks::choose(grid, &voxels.solid, weight, options.max_boxes as usize, options.min_gain);
    let triangles: Vec<[DVec3; 3]> = shells.iter().flat_map(|s| &s.triangles).copied().collect();
    for (block, gain) in &chosen {
        let [low, high] = grid.bounds(block);
        let [low, high] = grow::push_out(low, high, grid.cell * 2.0, margin, &triangles);
        if let Some(b) = grow::rounded_in(low, high) {
            made.boxes.push(b);
            report.box_gains.push(*gain);
        }
    }
    if made.boxes.is_empty() {
        report.no_boxes = Some(match (options.max_boxes, shells.len(), solid) {
            (0, ..) => NoOccluders::NotRequested,
            (_, 0, _) => NoOccluders::Open,
            (_, _, 0) => NoOccluders::Thin,
            _ => NoOccluders::Little,
        });
    } else {
        made.sealed = voxels::cover(grid, &voxels.within, MOST_SEALED)
            .iter()
            .map(|block| grid.bounds(block))
            .map(|[low, high]| {
                let margin = DVec3::splat(margin);
                Aabb::rounded_out((low - margin).into(), (high + margin).into())
            })
            .collect();
    }
    grid.cell.max_element()
}

fn check(options: &OccluderOptions) -> Result<(), OccluderError> {
    let OccluderOptions { min_gain, resolution, directions, .. } = *options;
    if !(4..=OccluderOptions::MAX_RESOLUTION).contains(&resolution) {
        return Err(OccluderError::Resolution(resolution));
    }
    if !(0.0..=1.0).contains(&min_gain) {
        return Err(OccluderError::MinGain(min_gain));
    }
    if directions > OccluderOptions::MAX_DIRECTIONS {
        return Err(OccluderError::Directions(directions));
    }
    Ok(())
}
