//! Quality and expected cost of a clustering.

use cullet::MeshData;
use cullet::cull::backface::ClusterPlanes;
use cullet::mesh::Clustering;
use glam::DVec3;

use crate::sample::fibonacci;

/// How much of a mesh a clustering culls at a distance, at best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Share of all triangles in clusters that are in clusters whose every triangle faces away:
    /// what the ideal test culls.
    pub ideal: f64,
    /// The share of single triangles that face away: no clustering culls more.
    pub exact: f64,
}

impl Quality {
    /// The mean over 200 directions, seen from `distance` radii of the sphere around the middle of
    /// the mesh's box; an infinite distance is a parallel view. Both shares are 0 for a mesh
    /// without triangles; clusters and triangles that the mesh does not have are passed over, and a
    /// distance of NaN culls nothing. Sides are not looked at: a two-sided part is judged as if it
    /// were one-sided. Some 4 µs a triangle.
    #[must_use]
    pub fn of(data: &MeshData, clustering: &Clustering, distance: f64) -> Self {
        const VIEWS: usize = 200;
        let corners = |t: u32| -> Option<[[f32; 3]; 3]> {
            let i = t as usize * 3;
            let c = data.indices.get(i..i + 3)?;
            let at = |k: usize| data.positions.get(c[k] as usize).copied();
            Some([at(0)?, at(1)?, at(2)?])
        };
        let points = || {
            let of = clustering.order.iter().filter_map(|&t| corners(t));
            of.flatten().map(|p| DVec3::from(p.map(f64::from)))
        };
        let (low, high) =
            points().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let centre = (low + high) * 0.5;
        let radius = points().map(|p| p.distance(centre)).fold(0.0, f64::max);
        let eyes: Vec<[f64; 4]> = (0..VIEWS)
            .map(|i| {
                let d = fibonacci(i, VIEWS);
                let eye = if distance == f64::INFINITY {
                    d.extend(0.0)
                } else {
                    (centre + d * (distance * radius)).extend(1.0)
                };
                eye.to_array()
            })
            .collect();
        let (mut ideal, mut exact, mut all) = (0usize, 0usize, 0usize);
        for c in &clustering.clusters {
            let (first, count) = (c.first_triangle as usize, c.triangle_count as usize);
            let Some(range) = clustering.order.get(first..first + count) else { continue };
            let mut behind = [true; VIEWS];
            let mut complete = true;
            for &t in range {
                let planes = ClusterPlanes::new(corners(t));
                // Slivers without a certain normal are never proved to face away.
                complete &= planes.is_complete();
                if planes.is_empty() {
                    continue;
                }
                for (b, eye) in behind.iter_mut().zip(&eyes) {
                    let away = planes.is_behind(*eye);
                    exact += usize::from(away);
                    *b &= away;
                }
            }
            ideal += behind.iter().filter(|b| **b && complete).count() * count;
            all += count;
        }
        let share = |n: usize| n as f64 / (all.max(1) * VIEWS) as f64;
        Self { ideal: share(ideal), exact: share(exact) }
    }
}

/// Counts of a clustering, and its expected cost.
///
/// Costs are in triangles drawn, for each triangle of the mesh that is not degenerate: 1 is to draw
/// everything without a test.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Triangles in clusters.
    pub triangles: u32,
    /// Degenerate triangles, left out.
    pub degenerate: u32,
    /// Clusters.
    pub clusters: u32,
    /// Clusters of one-sided parts that are culled too seldom to pay for a test of each: the last
    /// of their part.
    pub never_culled: u32,
    /// Triangles in those.
    pub never_culled_triangles: u32,
    /// Clusters of two-sided parts, which no back-face test may touch.
    pub two_sided: u32,
    /// Triangles in those.
    pub two_sided_triangles: u32,
    /// Vertices of all clusters together, over vertices that are used: 1 is none twice.
    pub vertex_duplication: f64,
    /// Share of the triangles of one-sided parts that the ideal test of clusters culls, over the
    /// sampled view points.
    pub ideal_share: f64,
    /// The same share of single triangles.
    pub exact_share: f64,
    /// The expected cost T = Σ t + (1 − P) n r, with the clusters that are never culled drawn
    /// untested.
    pub expected_cost: f64,
    /// The clusters that one material instead of several would give; `None` unless
    /// [`measure_parts`](super::ClusterOptions::measure_parts) is set, and where there are fewer
    /// than two one-sided parts.
    pub as_one_part: Option<OnePart>,
    /// False if the caller stopped it: the clusters are valid, but not what they might be.
    pub complete: bool,
}

/// Clusters and cost as they would be if clusters could cross materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnePart {
    /// Clusters of one-sided parts, as they are.
    pub clusters_split: u32,
    /// How many there would be.
    pub clusters: u32,
    /// The expected cost of one-sided parts as they are.
    pub expected_cost_split: f64,
    /// The expected cost there would be.
    pub expected_cost: f64,
}

impl Report {
    /// Triangles a cluster; 0 without clusters.
    #[must_use]
    pub fn triangles_per_cluster(&self) -> f64 {
        f64::from(self.triangles) / f64::from(self.clusters.max(1))
    }
}
