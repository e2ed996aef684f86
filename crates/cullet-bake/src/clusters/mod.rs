//! Clusters that are culled often.
//!
//! A cluster is culled where the eye is behind every one of its triangles, so what counts is which
//! triangles are together. [`build`] makes clusters in three steps, for each part of the mesh:
//!
//! 1. Greedy merging. From single triangles, the two neighbours are merged that lower the expected
//!    cost T = t + (1 − P) n r most, where t is the cost of a test, r that of drawing a triangle,
//!    and P the share of view points behind all n triangles (Johannsen & Carter, *Clustered
//!    Backface Culling*, 1998). P of two clusters together is an AND and a population count of two
//!    bit sets.
//! 2. Filling. Limited to 64 vertices, greedy merging stops at some 62 triangles a cluster. So
//!    clusters are dissolved where their neighbours have room and the test saved is more than what
//!    is lost, and triangles change sides at borders, at first at random, then only for the better.
//! 3. Clusters whose culling does not pay for a test, and small connected components, are merged by
//!    where they lie; clusters that are never culled come last in their part.
//!
//! Parts that are drawn from both sides are never culled by facing; their clusters are only
//! compact.
//!
//! ```
//! use cullet::{Mesh, MeshData};
//! use cullet_bake::clusters::{ClusterOptions, build};
//!
//! // A square sheet of 32 × 32 quads.
//! let at = |i: u32, j: u32| i * 33 + j;
//! let data = MeshData {
//!     positions: (0..33 * 33).map(|i| [(i % 33) as f32, (i / 33) as f32, 0.0]).collect(),
//!     indices: (0..32 * 32)
//!         .map(|q| (q / 32, q % 32))
//!         .flat_map(|(i, j)| {
//!             let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
//!             [a, b, c, a, c, d]
//!         })
//!         .collect(),
//!     ..MeshData::default()
//! };
//! let clustering = build(&data, &ClusterOptions::default())?;
//! let mesh = Mesh::with_clusters(data, &clustering)?;
//! assert_eq!(mesh.triangle_count(), 2048);
//! assert!(mesh.clusters().len() < 32);
//! # Ok::<(), cullet_bake::clusters::ClusterError>(())
//! ```

mod merge;
mod options;
mod part;
mod refine;
mod report;
mod spatial;
mod surface;
mod views;
mod volume;

use std::ops::ControlFlow;

use cullet::MeshData;
use cullet::mesh::{Cluster, Clustering, Part, is_degenerate, weld};

pub use options::{ClusterError, ClusterOptions, Probability};
pub use report::{OnePart, Quality, Report};

use part::{Made, Task};
use surface::{Frame, PartSurface};

/// How far [`build_reported`] has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The part at work, from 0.
    pub part: u32,
    /// How many parts there are.
    pub parts: u32,
    /// The share of all work that is done, 0 to 1; it only grows.
    pub share: f32,
}

/// Makes clusters for [`Mesh::with_clusters`](cullet::Mesh::with_clusters).
///
/// Every triangle that is not degenerate is in just one cluster, within the limits of `options` and
/// of one part; degenerate triangles are left out unless the mesh is deformable (its clusters are
/// then made for the pose at hand). The same input gives the same clusters, whatever the machine's
/// speed or number of cores. An empty mesh has no clusters. O(n log n); some 10 µs a triangle by
/// default.
///
/// # Errors
/// If the mesh is invalid, as [`Mesh::new`](cullet::Mesh::new) has it, or an option is out of
/// range.
pub fn build(data: &MeshData, options: &ClusterOptions) -> Result<Clustering, ClusterError> {
    Ok(build_reported(data, options, |_| ControlFlow::Continue(()))?.0)
}

/// Builds like [`build`], and reports what was made. `progress` is called many times a second;
/// where it breaks off, what was made so far is completed in the quickest way, and
/// [`Report::complete`] is false.
///
/// # Errors
/// As [`build`].
pub fn build_reported(
    data: &MeshData,
    options: &ClusterOptions,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<(Clustering, Report), ClusterError> {
    options.check()?;
    let parts = checked_parts(data)?;
    let welded = weld(&data.positions);
    let surfaces: Vec<PartSurface> = parts
        .iter()
        .map(|p| {
            let all = p.first_triangle..p.first_triangle + p.triangle_count;
            PartSurface::new(&data.positions, &data.indices, &welded, drawn(data, all))
        })
        .collect();
    let frame = Frame::around(&data.positions, &surfaces);
    let one_sided = parts.iter().zip(&surfaces).filter(|(p, s)| !p.two_sided && s.len() > 0);
    let joint = options.measure_parts && one_sided.count() > 1;
    let total: usize = surfaces.iter().map(PartSurface::len).sum();
    let work = if joint { total * 2 } else { total }.max(1);
    let mut stopped = false;
    let mut before = 0;
    let mut made = Vec::with_capacity(parts.len());
    for (number, (part, surface)) in parts.iter().zip(&surfaces).enumerate() {
        let mut step = |share: f32| {
            let share = (before as f32 + share * surface.len() as f32) / work as f32;
            let (part, parts) = (number as u32, parts.len() as u32);
            stopped = stopped || progress(Progress { part, parts, share }).is_break();
            !stopped
        };
        let task = Task { data, surface, frame: &frame, options, two_sided: part.two_sided };
        made.push(task.run(&mut step));
        before += surface.len();
    }
    let (clustering, mut report) = assemble(data, &parts, &surfaces, &made, options);
    if joint && !stopped {
        let sources = parts.iter().zip(&surfaces).filter(|(p, _)| !p.two_sided);
        let source: Vec<u32> = sources.flat_map(|(_, s)| s.source.iter().copied()).collect();
        let surface = PartSurface::new(&data.positions, &data.indices, &welded, source);
        let task = Task { data, surface: &surface, frame: &frame, options, two_sided: false };
        let last = parts.len() as u32 - 1;
        let whole = task.run(&mut |share| {
            let share = (total as f32 + share * surface.len() as f32) / work as f32;
            let at = Progress { part: last, parts: last + 1, share };
            stopped = stopped || progress(at).is_break();
            !stopped
        });
        let split: f64 =
            parts.iter().zip(&made).filter(|(p, _)| !p.two_sided).map(|m| m.1.cost).sum();
        report.as_one_part = (!stopped).then(|| OnePart {
            clusters_split: report.clusters - report.two_sided,
            clusters: whole.never.len() as u32,
            expected_cost_split: split / surface.len() as f64,
            expected_cost: whole.cost / surface.len() as f64,
        });
    }
    report.complete = !stopped;
    Ok((clustering, report))
}

/// The parts of a mesh that was checked; one that names none has one.
fn checked_parts(data: &MeshData) -> Result<Vec<Part>, ClusterError> {
    // The simple clustering checks all that a mesh is checked for, in a hundredth of the time of
    // ours.
    Clustering::spatial(data)?;
    if !data.parts.is_empty() {
        return Ok(data.parts.clone());
    }
    let triangle_count = (data.indices.len() / 3) as u32;
    Ok(vec![Part { triangle_count, two_sided: true, ..Part::default() }])
}

/// Returns the triangles of a range that go into clusters.
fn drawn(data: &MeshData, range: std::ops::Range<u32>) -> Vec<u32> {
    let corners = |t: u32| std::array::from_fn(|k| data.indices[t as usize * 3 + k]);
    range.filter(|&t| data.deformable || !is_degenerate(corners(t), &data.positions)).collect()
}

/// Puts the clusters of all parts in order: those that are culled along a curve through space, then
/// those that never are.
fn assemble(
    data: &MeshData,
    parts: &[Part],
    surfaces: &[PartSurface],
    made: &[Made],
    options: &ClusterOptions,
) -> (Clustering, Report) {
    let mut result = Clustering::default();
    let mut report = Report::default();
    let (mut ideal, mut exact, mut one_sided, mut cost) = (0.0, 0.0, 0usize, 0.0);
    let mut uses = 0;
    let mut vertices = Vec::new();
    let mut used = vec![false; data.positions.len()];
    for (number, ((part, surface), made)) in parts.iter().zip(surfaces).zip(made).enumerate() {
        let clusters = made.never.len();
        let mut members = vec![Vec::new(); clusters];
        for (t, &c) in made.of.iter().enumerate() {
            members[c as usize].push(t);
        }
        let mut order = crate::sample::curve(&spatial::boxes(surface, &made.of, clusters));
        order.sort_by_key(|&c| made.never[c as usize]);
        for c in order {
            let members = &members[c as usize];
            let first_triangle = result.order.len() as u32;
            result.order.extend(members.iter().map(|&t| surface.source[t]));
            let triangle_count = members.len() as u32;
            result.clusters.push(Cluster { first_triangle, triangle_count, part: number as u32 });
            vertices.clear();
            vertices.extend(members.iter().flat_map(|&t| surface.corners[t]));
            vertices.sort_unstable();
            vertices.dedup();
            uses += vertices.len();
            vertices.iter().for_each(|&v| used[v as usize] = true);
            debug_assert!(
                members.len() <= options.max_triangles as usize
                    && vertices.len() <= options.max_vertices as usize
            );
            if part.two_sided {
                report.two_sided += 1;
                report.two_sided_triangles += triangle_count;
            } else if made.never[c as usize] {
                report.never_culled += 1;
                report.never_culled_triangles += triangle_count;
            }
        }
        cost += made.cost;
        if !part.two_sided {
            ideal += made.ideal;
            exact += made.exact;
            one_sided += surface.len();
        }
    }
    let used = used.iter().filter(|u| **u).count().max(1);
    report.triangles = result.order.len() as u32;
    report.degenerate = (data.indices.len() / 3) as u32 - report.triangles;
    report.clusters = result.clusters.len() as u32;
    report.vertex_duplication = uses as f64 / used as f64;
    report.ideal_share = ideal / one_sided.max(1) as f64;
    report.exact_share = exact / one_sided.max(1) as f64;
    report.expected_cost = cost / f64::from(report.triangles.max(1));
    (result, report)
}
