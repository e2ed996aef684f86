//! The ways to narrow the lines of sight that a mask must hold for: groups of triangles with a
//! viewing cone each, and sectors of the frustum. One copy of the model, N = 16.

use std::time::{Duration, Instant};

use crate::methods::sectors::{MaskUse, corner_directions, mask_of_sectors};
use crate::methods::{Bulk, Groups};
use cullet::{Camera, Depth, Projection, Simd, View};
use cullet_command::console::Progress;
use cullet_command::exit::Failure;
use cullet_mesh::{MaskGrid, NormalMasks, ViewCone};

use super::culling::{keep_exactly, ones};
use super::drawing::internal;
use super::record::{GroupRow, SectorRow};
use crate::reproduce::model::Subject;
use crate::shapes::fibonacci;

/// Cells along an edge of the cube of normals.
const N: u32 = 16;
/// Into how many groups the triangles are split.
const GROUPS: [usize; 6] = [1, 4, 16, 64, 256, 1024];
/// How far from the middle of the copy, in its radii.
pub(super) const DISTANCES: [f64; 3] = [1.5, 3.0, 6.0];
/// Sectors along a side of the window.
pub(super) const SECTORS: [usize; 4] = [1, 2, 4, 8];
/// Vertical fields of view, in degrees, of a square window.
const FIELDS: [f64; 4] = [15.0, 30.0, 60.0, 90.0];
/// Steps of both tables.
pub(super) const STEPS: u64 = (GROUPS.len() + FIELDS.len()) as u64;
/// Times are those of the fastest of so many sweeps over the views.
const SWEEPS: usize = 3;
/// Sectors are measured from so many views at the most.
const SECTOR_VIEWS: u32 = 50;

/// All counts of groups at all distances.
pub(super) fn groups(
    subject: &Subject,
    directions: u32,
    progress: &mut Progress,
) -> Result<Vec<GroupRow>, Failure> {
    let (mesh, level) = (&subject.mesh, Simd::best());
    let grid = MaskGrid::new(N).ok_or_else(|| internal("a grid of too many cells"))?;
    let exact = DISTANCES.map(|d| exact_percent(subject, d, directions));
    let mut rows = Vec::new();
    for count in GROUPS {
        progress.step();
        let groups = Groups::kd(mesh.positions(), mesh.indices(), count);
        // A group has a triangle at least: a small model has no more groups than triangles.
        if rows.last().is_some_and(|r: &GroupRow| r.groups == groups.len()) {
            continue;
        }
        let mut masks = NormalMasks::default();
        let ordered = groups.reorder(mesh.indices());
        grid.encode_triangles(mesh.positions(), &ordered, &mut masks);
        for (distance_copy_radii, exact_percent) in DISTANCES.into_iter().zip(exact) {
            let mut words = Vec::new();
            let (culled, time) = sweep(directions, |direction| {
                let eye = subject.eye(direction, distance_copy_radii);
                let start = Instant::now();
                groups.cull(level, &grid, &masks, eye, &mut words);
                let time = start.elapsed();
                (ones(words.iter().copied()), time)
            });
            rows.push(GroupRow {
                groups: groups.len(),
                distance_copy_radii,
                culled_percent: percent(subject, culled, directions),
                exact_percent,
                us_per_frame: time,
            });
        }
    }
    Ok(rows)
}

/// All fields of view with all numbers of sectors. Clusters are what is sorted into sectors: a
/// cluster in several is culled by what they have in common.
pub(super) fn sectors(
    subject: &Subject,
    directions: u32,
    progress: &mut Progress,
) -> Result<Vec<SectorRow>, Failure> {
    let (mesh, level, views) = (&subject.mesh, Simd::best(), directions.min(SECTOR_VIEWS));
    let grid = MaskGrid::new(N).ok_or_else(|| internal("a grid of too many cells"))?;
    let ranges: Vec<_> = mesh
        .clusters()
        .iter()
        .map(|c| c.first_triangle..c.first_triangle + c.triangle_count)
        .collect();
    let clusters = Groups::of_ranges(mesh.positions(), mesh.indices(), &ranges);
    let encode = |indices: &[u32]| {
        let mut masks = NormalMasks::default();
        grid.encode_triangles(mesh.positions(), indices, &mut masks);
        masks
    };
    let all = encode(mesh.indices());
    let of_clusters: Vec<NormalMasks> = ranges
        .iter()
        .map(|r| encode(&mesh.indices()[r.start as usize * 3..r.end as usize * 3]))
        .collect();
    let mut rows = Vec::new();
    for fov_degrees in FIELDS {
        let half = fov_degrees.to_radians() * 0.5;
        let distance_copy_radii = half.sin().recip();
        let exact_percent = exact_percent(subject, distance_copy_radii, views);
        let one_mask = |cone: &dyn Fn([f64; 3], [f64; 4]) -> Option<ViewCone>| {
            let (culled, _) = sweep(views, |direction| {
                let eye = subject.eye(direction, distance_copy_radii);
                let mask = grid.mask(level, cone(direction, eye).as_ref());
                (all.count(level, &mask), Duration::ZERO)
            });
            percent(subject, culled, views)
        };
        // To a corner of the square window, not to the middle of a side.
        let corner = (half.tan() * 2.0_f64.sqrt()).atan();
        let frustum_cone_percent =
            one_mask(&|direction, _| ViewCone::around(direction.map(|v| -v), corner));
        let sphere_cone_percent = one_mask(&|_, eye| ViewCone::to_sphere(eye, &subject.sphere));
        for k in SECTORS {
            let mut failure = None;
            let (culled, us_per_frame) = sweep(views, |direction| {
                let eye = subject.eye(direction, distance_copy_radii);
                let start = Instant::now();
                let culled = square(subject, eye, fov_degrees).and_then(|corners| {
                    let sectors = mask_of_sectors(&grid, level, &corners, k, MaskUse::Camera);
                    let sectors = sectors.map_err(internal)?;
                    let eye = [eye[0], eye[1], eye[2]];
                    let each = clusters.spheres().iter().zip(&of_clusters);
                    Ok(each
                        .filter_map(|(sphere, masks)| {
                            Some(masks.count(level, &sectors.for_sphere(eye, sphere)?))
                        })
                        .sum())
                });
                let time = start.elapsed();
                (
                    culled.unwrap_or_else(|e| {
                        failure = Some(e);
                        0
                    }),
                    time,
                )
            });
            if let Some(failure) = failure {
                return Err(failure);
            }
            rows.push(SectorRow {
                fov_degrees,
                distance_copy_radii,
                k,
                culled_percent: percent(subject, culled, views),
                frustum_cone_percent,
                sphere_cone_percent,
                exact_percent,
                us_per_frame,
            });
        }
        progress.step();
    }
    Ok(rows)
}

/// The lines of sight at the corners of a square window that looks at the model.
fn square(subject: &Subject, eye: [f64; 4], fov_degrees: f64) -> Result<[[f64; 3]; 4], Failure> {
    let projection = Projection::Perspective {
        fov_y_radians: fov_degrees.to_radians(),
        aspect: 1.0,
        near: subject.radius() * 1e-3,
        far: f64::INFINITY,
    };
    let camera = Camera::look_at([eye[0], eye[1], eye[2]], subject.centre(), projection);
    let view = View::new(&camera, Depth::Reversed, [512, 512]).map_err(internal)?;
    corner_directions(&view.frustum()).ok_or_else(|| internal("a frustum without corners"))
}

/// Sums over the views of what `cull` culls, and the mean of its times in the fastest sweep, in
/// microseconds.
fn sweep(views: u32, mut cull: impl FnMut([f64; 3]) -> (u64, Duration)) -> (u64, f64) {
    let (mut culled, mut fastest) = (0, Duration::MAX);
    for _ in 0..SWEEPS {
        let mut time = Duration::ZERO;
        culled = 0;
        for i in 0..views as usize {
            let (n, took) = cull(fibonacci(i, views as usize));
            culled += n;
            time += took;
        }
        fastest = fastest.min(time);
    }
    (culled, fastest.as_secs_f64() * 1e6 / f64::from(views))
}

fn exact_percent(subject: &Subject, radii: f64, views: u32) -> f64 {
    let mut kept = Vec::new();
    let culled = (0..views as usize).map(|i| {
        keep_exactly(subject, subject.eye(fibonacci(i, views as usize), radii), &mut kept)
    });
    let culled: u64 = culled.sum();
    percent(subject, culled, views)
}

fn percent(subject: &Subject, culled: u64, views: u32) -> f64 {
    culled as f64 * 100.0 / (f64::from(subject.mesh.triangle_count()) * f64::from(views))
}
