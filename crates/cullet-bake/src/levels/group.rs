//! One group of clusters: merged, simplified, cut into clusters again, and measured.

use super::collapse::{Collapser, Points, Task};
use super::cut::{ClusterSize, cut_into_clusters};
use super::measure::{Back, Carried, back};
use super::options::{ErrorSource, HierarchyOptions};
use super::sphere::{Ball, around};
use cullet_draw::surface::{SurfaceTree, inner_points};

/// A group is given up where less than this share of its triangles would go.
const LEAST_GAIN: f64 = 0.15;

/// A cluster that waits to be simplified.
#[derive(Clone, Debug)]
pub(super) struct Pending {
    /// Its number among the clusters of its part.
    pub(super) number: u32,
    /// Corners of its triangles, as vertices of the part.
    pub(super) indices: Vec<u32>,
    /// The part of the original that it stands for.
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
    /// How often the surface was simplified before.
    pub(super) depth: u32,
}

/// Result of simplifying a group.
#[derive(Debug, Default)]
pub(super) struct Made {
    /// Around what it stands for.
    pub(super) ball: Option<Ball>,
    pub(super) error: f32,
    /// Corners of the triangles of each new cluster; none where the group could not be simplified.
    pub(super) clusters: Vec<(Vec<u32>, Points)>,
}

/// Memory of a thread. Numbers of a part's vertices within a group are as many as the part has
/// vertices.
#[derive(Debug)]
pub(super) struct Scratch {
    local: Vec<u32>,
    /// First vertex of the group at each position, by the first of the whole mesh there.
    place: Vec<u32>,
    collapser: Collapser,
}

impl Scratch {
    pub(super) fn new(vertices: usize) -> Self {
        let none = vec![u32::MAX; vertices];
        Self { local: none.clone(), place: none, collapser: Collapser::default() }
    }
}

/// The most points that a triangle carries: coarse ones are few, and stand for much.
fn most_carried(depth: u32) -> usize {
    (8 << (depth / 2)).min(64)
}

/// The wanted sizes of clusters.
pub(super) fn cluster_size(options: &HierarchyOptions) -> ClusterSize {
    ClusterSize { vertices: 64, triangles: options.cluster_triangles as usize }
}

/// The vertices of a group, each once, in the order of their first use.
#[derive(Debug, Default)]
struct Vertices {
    /// Vertices of the part.
    of_part: Vec<u32>,
    positions: Vec<[f32; 3]>,
    /// For each the group's first at its position, and whether it stays.
    place: Vec<u32>,
    locks: Vec<bool>,
    /// Corners of the triangles of all members.
    indices: Vec<u32>,
}

impl Vertices {
    fn new(level: &Level<'_>, scratch: &mut Scratch, members: &[Pending]) -> Self {
        let surface = level.surface;
        let mut all = Self::default();
        all.indices.reserve(members.iter().map(|m| m.indices.len()).sum());
        for &v in members.iter().flat_map(|m| &m.indices) {
            let local = &mut scratch.local[v as usize];
            if *local == u32::MAX {
                *local = all.of_part.len() as u32;
                let at = surface.position[v as usize] as usize;
                let place = &mut scratch.place[at];
                if *place == u32::MAX {
                    *place = *local;
                }
                all.of_part.push(v);
                all.positions.push(surface.positions[v as usize]);
                all.place.push(*place);
                all.locks.push(level.locked[at]);
            }
            all.indices.push(*local);
        }
        for &v in &all.of_part {
            scratch.local[v as usize] = u32::MAX;
            scratch.place[surface.position[v as usize] as usize] = u32::MAX;
        }
        all
    }

    /// Points that the triangles stand for: of original ones some at random. Their places come to them
    /// when they are collapsed.
    fn carried(&self, level: &Level<'_>, members: &[Pending]) -> Points {
        let is_measured = level.options.errors == ErrorSource::Measured;
        let count = if is_measured { level.options.points } else { 0 };
        let mut points = Points::default();
        let mut triangles = self.indices.as_chunks::<3>().0.iter();
        for member in members {
            let own = triangles.by_ref().take(member.indices.len() / 3);
            match &member.carried {
                Carried::Points(all) => {
                    own.for_each(drop);
                    points.extend(all);
                }
                Carried::Original(first) => {
                    for (t, corners) in (*first..).zip(own) {
                        let places = corners.map(|v| self.positions[v as usize]);
                        let inner = inner_points(places, level.seed, t, count);
                        points.add(inner.map(|point| (point, 0.0)), usize::MAX);
                    }
                }
            }
        }
        points
    }
}

/// Simplifies a group to half, and further where that costs nothing.
pub(super) fn make(
    level: &Level<'_>,
    scratch: &mut Scratch,
    members: &[Pending],
    key: u32,
) -> Made {
    let Level { surface, options, .. } = level;
    let all = Vertices::new(level, scratch, members);
    let floor = members.iter().fold(0.0_f32, |e, m| e.max(m.error));
    let measured = options.errors == ErrorSource::Measured;
    let carried = all.carried(level, members);
    let made = scratch.collapser.run(&Task {
        positions: &all.positions,
        place: &all.place,
        indices: &all.indices,
        locks: &all.locks,
        shares: &[],
        carried: &carried,
        triangles: all.indices.len() / 6,
        free: if measured { floor } else { 0.0 },
        limit: f32::INFINITY,
        original: measured.then_some(surface.original),
    });
    let most = all.indices.len() as f64 * (1.0 - LEAST_GAIN);
    if made.indices.is_empty() || made.indices.len() as f64 > most {
        return Made::default();
    }
    let cut = cut_into_clusters(&all.positions, &made.indices, cluster_size(options));
    let mut error = if measured { made.error } else { floor.max(made.estimate) };
    let mut clusters = Vec::with_capacity(cut.counts.len());
    let mut order = cut.order.iter();
    for &count in &cut.counts {
        let mut indices = Vec::with_capacity(count as usize * 3);
        let mut own = Points::default();
        for &t in order.by_ref().take(count as usize) {
            let corners = &made.indices[t as usize * 3..][..3];
            indices.extend(corners.iter().map(|&v| all.of_part[v as usize]));
            let points = scratch.collapser.points_of(made.from[t as usize]);
            own.add(points, most_carried(level.depth));
        }
        clusters.push((indices, own));
    }
    if measured {
        let task = Back {
            positions: &all.positions,
            before: &all.indices,
            after: &made.indices,
            original: surface.original,
            points: options.reverse_points,
            seed: level.seed ^ u64::from(key) << 32,
        };
        error = back(&task, error);
    }
    let balls: Vec<Ball> = members.iter().map(|m| m.ball).collect();
    Made { ball: Some(around(&balls)), error, clusters }
}
