//! One group of clusters: merged, simplified, cut into clusters again, and measured.

use super::error::LevelsError;
use super::measure::{Carried, Measured, Task, measure};
use super::options::{ErrorSource, HierarchyOptions};
use super::simplifier::{Attributes, ClusterSize, Clusters, Target, cut_into_clusters, simplify};
use super::sphere::{Ball, around};
use cullet::math;
use cullet_draw::surface::SurfaceTree;

/// A group is given up where less than this share of its triangles would go.
const LEAST_GAIN: f64 = 0.15;

/// A cluster that waits to be simplified.
#[derive(Clone, Debug)]
pub(super) struct Pending {
    /// Its number among the clusters of its part.
    pub(super) number: u32,
    /// Corners of its triangles, as vertices of the part.
    pub(super) indices: Vec<u32>,
    /// Sample points of the original that it stands for.
    pub(super) carried: Carried,
    /// Around all that it stands for.
    pub(super) ball: Ball,
    /// Error of the group that it was made from.
    pub(super) error: f32,
    /// How often no group could simplify it.
    pub(super) stuck: u8,
}

/// The surface of a part, as all its groups see it.
pub(super) struct Surface<'a> {
    pub(super) positions: &'a [[f32; 3]],
    /// So many a vertex as there are weights.
    pub(super) attributes: &'a [f32],
    pub(super) weights: &'a [f32],
    /// For each vertex the first at its position.
    pub(super) position: &'a [u32],
    pub(super) original: &'a SurfaceTree,
}

/// Data that is the same for all groups of a level.
pub(super) struct Level<'a> {
    pub(super) surface: &'a Surface<'a>,
    pub(super) options: &'a HierarchyOptions,
    /// For each vertex whether it must stay, by the first at its position.
    pub(super) locked: &'a [bool],
    pub(super) seed: u64,
}

/// Result of simplifying a group.
#[derive(Debug, Default)]
pub(super) struct Made {
    /// Around what it stands for.
    pub(super) ball: Option<Ball>,
    pub(super) error: f32,
    /// Corners of the triangles of each new cluster; none where the group could not be simplified.
    pub(super) clusters: Vec<(Vec<u32>, Carried)>,
}

/// Numbers of a part's vertices within a group; each thread has its own, as long as the part.
#[derive(Debug)]
pub(super) struct Scratch {
    local: Vec<u32>,
}

impl Scratch {
    pub(super) fn new(vertices: usize) -> Self {
        Self { local: vec![u32::MAX; vertices] }
    }
}

/// The wanted sizes of clusters.
pub(super) fn cluster_size(options: &HierarchyOptions) -> ClusterSize {
    let most = options.cluster_triangles as usize;
    // As in meshoptimizer's own hierarchy: a third full, where more would extend too far.
    let least = (most / 3).max(4) & !3;
    ClusterSize { vertices: 64, least, most, split_factor: 2.0 }
}

/// Simplifies a group to half. Where what comes out is off by much more than the simplifier thinks,
/// the vertices that it is far from are locked and it is done again; the attempt that is worth most
/// is kept. Locking within groups ruins nothing: locked for good, in all levels, vertices of the
/// finest ones took armadillo from 2,346 triangles to 8,135 at 20 radii.
pub(super) fn make(
    level: &Level<'_>,
    scratch: &mut Scratch,
    members: &[Pending],
    key: u32,
) -> Result<Made, LevelsError> {
    let Level { surface, options, .. } = level;
    // The group's own vertices, in the order of their first use.
    let mut vertices: Vec<u32> = Vec::new();
    let mut before = Vec::with_capacity(members.iter().map(|m| m.indices.len()).sum());
    for &v in members.iter().flat_map(|m| &m.indices) {
        let local = &mut scratch.local[v as usize];
        if *local == u32::MAX {
            *local = vertices.len() as u32;
            vertices.push(v);
        }
        before.push(*local);
    }
    vertices.iter().for_each(|&v| scratch.local[v as usize] = u32::MAX);
    let positions: Vec<[f32; 3]> =
        vertices.iter().map(|&v| surface.positions[v as usize]).collect();
    let mut locks: Vec<bool> =
        vertices.iter().map(|&v| level.locked[surface.position[v as usize] as usize]).collect();
    let count = surface.weights.len();
    let values: Vec<f32> = vertices
        .iter()
        .flat_map(|&v| &surface.attributes[v as usize * count..][..count])
        .copied()
        .collect();
    let attributes =
        (count > 0).then_some(Attributes { values: &values, weights: surface.weights });
    let floor = members.iter().fold(0.0_f32, |e, m| e.max(m.error));
    let carried: Vec<&Carried> = members.iter().map(|m| &m.carried).collect();
    let balls: Vec<Ball> = members.iter().map(|m| m.ball).collect();
    let ball = around(&balls);
    let mut best: Option<(f64, Clusters, Measured)> = None;
    for attempt in 0..=options.lock_rounds {
        let target = Target { triangles: before.len() / 6, ..Target::default() };
        let simplified = simplify(&positions, &before, &locks, attributes, target)?;
        let most = before.len() as f64 * (1.0 - LEAST_GAIN);
        if simplified.indices.is_empty() || simplified.indices.len() as f64 > most {
            break;
        }
        let cut = cut_into_clusters(&positions, &simplified.indices, cluster_size(options))?;
        if options.errors == ErrorSource::Returned {
            let counts = vec![0; cut.indices.len() / 3];
            let carried = Carried { points: Vec::new(), counts };
            let error = simplified.error.max(floor);
            best = Some((0.0, cut, Measured { error, carried, offenders: Vec::new() }));
            break;
        }
        let measured = measure(&Task {
            positions: &positions,
            before: &before,
            carried: &carried,
            after: &cut.indices,
            original: surface.original,
            floor,
            offends: (attempt < options.lock_rounds)
                .then_some((simplified.error * options.lock_beyond).max(floor)),
            reverse_points: options.reverse_points,
            share: options.share_over,
            excess: options.most_over,
            seed: level.seed ^ u64::from(key) << 32,
        });
        let mut locked = 0;
        for &v in &measured.offenders {
            locked += u32::from(!std::mem::replace(&mut locks[v as usize], true));
        }
        let left = cut.indices.len() as f64 / before.len() as f64;
        let worth = worth(left, measured.error, ball.radius);
        if best.as_ref().is_none_or(|b| worth > b.0) {
            best = Some((worth, cut, measured));
        }
        if locked == 0 {
            break;
        }
    }
    let Some((_, cut, measured)) = best else { return Ok(Made::default()) };
    let mut clusters = Vec::with_capacity(cut.counts.len());
    let mut triangles = cut.indices.chunks_exact(3);
    let (mut counts, mut points) = (measured.carried.counts.iter(), measured.carried.points.iter());
    for &n in &cut.counts {
        let n = n as usize;
        let corners = triangles.by_ref().take(n).flatten();
        let corners: Vec<u32> = corners.map(|&v| vertices[v as usize]).collect();
        let counts: Vec<u32> = counts.by_ref().take(n).copied().collect();
        let total: u32 = counts.iter().sum();
        let points = points.by_ref().take(total as usize).copied().collect();
        clusters.push((corners, Carried { points, counts }));
    }
    Ok(Made { ball: Some(ball), error: measured.error, clusters })
}

/// Returns what an attempt is worth: the share of triangles that it saves, over all octaves of
/// distances from which it is drawn, up to where the whole group is as small as its error may be.
fn worth(left: f64, error: f32, radius: f32) -> f64 {
    let octaves =
        math::log2(f64::from(radius) / f64::from(error).max(f64::from(f32::MIN_POSITIVE)));
    (1.0 - left) * octaves.clamp(1e-3, 100.0)
}
