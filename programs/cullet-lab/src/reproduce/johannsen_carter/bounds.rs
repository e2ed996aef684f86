//! Bounds of clusters: the share that each culls, and the cost of its test.

use std::hint::black_box;
use std::time::{Duration, Instant};

use crate::methods::Bulk;
use crate::methods::cluster::{
    Bound, ClusterBounds, EllipticConeQuantised, NormalBox, NormalBoxAtOrigin, NormalBoxTurned,
    NormalCone, NormalConeCentre, Pyramid,
};
use cullet::bounds::Sphere;
use cullet::cull::backface::{ClusterPlanes, EllipticCone};
use cullet::{Mesh, Simd};
use cullet_command::console::Progress;
use cullet_command::exit::Failure;
use cullet_mesh::{MaskGrid, NormalMask, ViewCone};
use serde::Serialize;

use crate::reproduce::model::Subject;
use crate::shapes::fibonacci;

/// Distances of the views, in radii.
pub(super) const DISTANCES: [f64; 5] = [1.1, 1.5, 3.0, 6.0, 20.0];
/// Index of the distance that the tables are for.
pub(super) const MAIN: usize = 2;

/// Cluster count of a large scene; its clusters lie in the second cache.
const TIMED: usize = 16_384;
/// Eyes that a timed pass looks from.
const TIMED_EYES: usize = 8;
/// The passes of one bound; the fastest counts.
const PATIENCE: Duration = Duration::from_millis(100);
/// Cells along an edge of the cube of normals, for the masks.
const CELLS: u32 = 16;

/// One bound, from the main distance.
#[derive(Clone, Debug, Serialize)]
pub(super) struct BoundRow {
    pub(super) name: &'static str,
    /// Description for people.
    pub(super) what: &'static str,
    /// Bytes of one cluster; where clusters differ, in the mean.
    pub(super) bytes: u64,
    pub(super) ns_per_cluster: f64,
    pub(super) culled_percent: f64,
    /// Absent where the ideal culls nothing.
    pub(super) share_of_ideal_percent: Option<f64>,
    /// The same from each of the distances.
    pub(super) culled_percent_by_distance: Vec<f64>,
}

/// The clusters of a mesh, ready to be bounded.
pub(super) struct Clusters<'a> {
    mesh: &'a Mesh,
    planes: Vec<ClusterPlanes>,
    /// Triangles of each.
    sizes: Vec<u32>,
    triangles: u64,
}

/// Clusters that can be culled from one eye at most.
struct Seen {
    eye: [f64; 4],
    /// Clusters that the eye is behind, by the ideal test.
    ideal: Vec<u64>,
}

/// The eyes at all distances.
pub(super) struct Views {
    /// Views at each distance.
    seen: Vec<Vec<Seen>>,
    /// Shares of all triangles, by distance.
    pub(super) exact_percent: Vec<f64>,
    pub(super) ideal_percent: Vec<f64>,
}

/// Counts of wrong results; all must be zero.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Wrong {
    /// Clusters that a bound culled, and that were not proved to face away.
    pub(super) culls: u64,
    /// Answers of a batch that are not those of single tests.
    pub(super) batches: u64,
}

fn bit(bits: &[u64], i: usize) -> bool {
    bits[i / 64] >> (i % 64) & 1 == 1
}

fn bits(len: usize, mut holds: impl FnMut(usize) -> bool) -> Vec<u64> {
    let mut bits = vec![0; len.div_ceil(64)];
    (0..len).for_each(|i| bits[i / 64] |= u64::from(holds(i)) << (i % 64));
    bits
}

fn percent(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole * 100.0 } else { 0.0 }
}

impl<'a> Clusters<'a> {
    pub(super) fn new(mesh: &'a Mesh) -> Self {
        let corners = |i: usize| {
            let c = mesh.clusters()[i];
            (c.first_triangle..c.first_triangle + c.triangle_count).map(|t| mesh.corners(t))
        };
        let planes = (0..mesh.clusters().len()).map(|i| ClusterPlanes::new(corners(i))).collect();
        let sizes: Vec<u32> = mesh.clusters().iter().map(|c| c.triangle_count).collect();
        let triangles = sizes.iter().map(|n| u64::from(*n)).sum();
        Self { mesh, planes, sizes, triangles }
    }

    pub(super) fn len(&self) -> usize {
        self.planes.len()
    }

    pub(super) fn planes(&self) -> &[ClusterPlanes] {
        &self.planes
    }

    fn corners(&self, cluster: usize) -> impl Iterator<Item = [[f32; 3]; 3]> {
        let c = self.mesh.clusters()[cluster];
        (c.first_triangle..c.first_triangle + c.triangle_count).map(|t| self.mesh.corners(t))
    }

    /// The triangles of some clusters.
    fn triangles_of(&self, clusters: &[u64]) -> u64 {
        let sizes = self.sizes.iter().enumerate().filter(|(i, _)| bit(clusters, *i));
        sizes.map(|(_, n)| u64::from(*n)).sum()
    }

    /// The share of the triangles that the ideal test of clusters culls, over some eyes.
    pub(super) fn ideal_percent(&self, eyes: &[[f64; 4]]) -> f64 {
        let culled = |eye: &[f64; 4]| {
            let behind = self.planes.iter().zip(&self.sizes).filter(|(p, _)| p.is_behind(*eye));
            behind.map(|(_, n)| u64::from(*n)).sum::<u64>()
        };
        let culled: u64 = eyes.iter().map(culled).sum();
        percent(culled as f64, self.triangles as f64 * eyes.len() as f64)
    }

    /// Shares that the exact and the ideal test cull, from every eye.
    pub(super) fn views(&self, subject: &Subject, directions: u32, bar: &mut Progress) -> Views {
        let triangles: Vec<ClusterPlanes> = (0..self.len())
            .flat_map(|c| self.corners(c))
            .map(|t| ClusterPlanes::new([t]))
            .collect();
        let mut views = Views { seen: vec![], exact_percent: vec![], ideal_percent: vec![] };
        for radii in DISTANCES {
            let (mut exact, mut ideal) = (0, 0);
            let mut seen = Vec::new();
            for eye in eyes(subject, directions, radii) {
                exact += triangles.iter().filter(|t| t.is_behind(eye)).count();
                let clusters = bits(self.len(), |c| self.planes[c].is_behind(eye));
                ideal += self.triangles_of(&clusters);
                seen.push(Seen { eye, ideal: clusters });
                bar.step();
            }
            let all = self.triangles as f64 * f64::from(directions);
            views.exact_percent.push(percent(exact as f64, all));
            views.ideal_percent.push(percent(ideal as f64, all));
            views.seen.push(seen);
        }
        views
    }

    /// The share of triangles that a test culls, by distance; adds to `wrong` what it should not
    /// have.
    fn shares(
        &self,
        views: &Views,
        wrong: &mut Wrong,
        mut cull: impl FnMut([f64; 4], &mut Vec<u64>),
    ) -> Vec<f64> {
        let mut culled = Vec::new();
        let share = |seen: &Vec<Seen>| {
            let mut sum = 0;
            for s in seen {
                cull(s.eye, &mut culled);
                sum += self.triangles_of(&culled);
                let more = culled.iter().zip(&s.ideal).map(|(c, i)| (c & !i).count_ones());
                wrong.culls += u64::from(more.sum::<u32>());
            }
            percent(sum as f64, self.triangles as f64 * seen.len() as f64)
        };
        views.seen.iter().map(share).collect()
    }

    fn row<B: Bound>(
        &self,
        (name, what): (&'static str, &'static str),
        views: &Views,
        wrong: &mut Wrong,
        fit: impl Fn(usize) -> Option<B>,
    ) -> BoundRow {
        let level = Simd::best();
        let fits: Vec<Option<B>> = (0..self.len()).map(fit).collect();
        let batch: ClusterBounds<B> = fits.iter().copied().collect();
        let by_distance = self.shares(views, wrong, |eye, out| batch.cull(level, eye, out));
        let timed: Vec<[f64; 4]> = views.timed();
        let mut culled = Vec::new();
        for &eye in &timed {
            batch.cull(level, eye, &mut culled);
            let single = bits(fits.len(), |i| fits[i].as_ref().is_some_and(|b| b.is_behind(eye)));
            let differ = culled.iter().zip(&single).map(|(a, b)| (a ^ b).count_ones());
            wrong.batches += u64::from(differ.sum::<u32>());
        }
        let many = fits.len().max(TIMED);
        let batch: ClusterBounds<B> = fits.iter().copied().cycle().take(many).collect();
        let ns = fastest(|| {
            for &eye in &timed {
                batch.cull(level, eye, &mut culled);
                black_box(&culled);
            }
        });
        record((name, what), B::BYTES as u64, ns / (many * timed.len()) as f64, by_distance, views)
    }

    /// All bounds, in the order of the tables.
    pub(super) fn bounds(
        &self,
        views: &Views,
        wrong: &mut Wrong,
        mut step: impl FnMut(),
    ) -> Result<Vec<BoundRow>, Failure> {
        let p = &self.planes;
        let mut rows = vec![self.row(
            ("johannsen_carter", "normals in a box, c in the middle"),
            views,
            wrong,
            |i| NormalBox::fit(&p[i]),
        )];
        step();
        rows.push(
            self.row(("cone_apex", "circular cone, apex"), views, wrong, |i| {
                NormalCone::fit(&p[i])
            }),
        );
        step();
        rows.push(self.row(
            ("cone_centre", "circular cone, centre and radius"),
            views,
            wrong,
            |i| {
                let cone = NormalCone::fit(&p[i])?;
                let corners: Vec<[f32; 3]> = self.corners(i).flatten().collect();
                let sphere = Sphere::from_points(&corners);
                Some(NormalConeCentre::new(&cone, sphere.center, sphere.radius))
            },
        ));
        step();
        rows.push(
            self.row(("elliptic", "elliptic cone"), views, wrong, |i| EllipticCone::fit(&p[i])),
        );
        step();
        rows.push(self.row(("elliptic_quantised", "elliptic cone in bytes"), views, wrong, |i| {
            EllipticConeQuantised::fit(&p[i])
        }));
        step();
        rows.push(self.row(("pyramid6", "6 planes through an apex"), views, wrong, |i| {
            Pyramid::<6>::fit(&p[i])
        }));
        step();
        rows.push(self.row(("pyramid8", "8 planes through an apex"), views, wrong, |i| {
            Pyramid::<8>::fit(&p[i])
        }));
        step();
        rows.push(self.masks(views, wrong)?);
        step();
        Ok(rows)
    }

    /// Johannsen & Carter's bound with its origin in several places.
    pub(super) fn origins(
        &self,
        views: &Views,
        wrong: &mut Wrong,
        mut step: impl FnMut(),
    ) -> Vec<BoundRow> {
        let p = &self.planes;
        let mut rows =
            vec![self.row(("global", "one origin for all clusters"), views, wrong, |i| {
                NormalBoxAtOrigin::fit(&p[i])
            })];
        step();
        rows.push(
            self.row(("box_centre", "middle of the box"), views, wrong, |i| NormalBox::fit(&p[i])),
        );
        step();
        rows.push(self.row(("best_of_nine", "best of middle and corners"), views, wrong, |i| {
            NormalBox::fit_best(&p[i])
        }));
        step();
        rows.push(self.row(("rotated", "axes of its own, c at the apex"), views, wrong, |i| {
            NormalBoxTurned::fit(&p[i])
        }));
        step();
        rows
    }

    /// The AND of the triangles' normal masks, each cluster with the viewing cone to its own
    /// sphere.
    fn masks(&self, views: &Views, wrong: &mut Wrong) -> Result<BoundRow, Failure> {
        let grid = MaskGrid::new(CELLS)
            .ok_or_else(|| Failure::input(format!("{CELLS} cells along an edge of a cube")))?;
        let level = Simd::best();
        let clusters: Vec<(Sphere, Vec<NormalMask>)> = (0..self.len())
            .map(|c| {
                let corners: Vec<[f32; 3]> = self.corners(c).flatten().collect();
                let masks = self.corners(c).map(|t| grid.encode_triangle(t)).collect();
                (Sphere::from_points(&corners), masks)
            })
            .collect();
        let mut cull = |eye: [f64; 4], out: &mut Vec<u64>| {
            out.clear();
            out.extend(bits(clusters.len(), |c| {
                let (sphere, masks) = &clusters[c];
                let mask = grid.mask(level, ViewCone::to_sphere(eye, sphere).as_ref());
                masks.iter().all(|m| mask.culls(*m))
            }));
        };
        let by_distance = self.shares(views, wrong, &mut cull);
        let timed = views.timed();
        let mut culled = Vec::new();
        let ns = fastest(|| {
            for &eye in &timed {
                cull(eye, &mut culled);
                black_box(&culled);
            }
        });
        // Two bytes a triangle, and a sphere.
        let bytes = (2 * self.triangles / self.len() as u64) + size_of::<Sphere>() as u64;
        let names = ("mask", "normal masks, N = 16, a cone each");
        let ns = ns / (self.len() * timed.len()) as f64;
        Ok(record(names, bytes, ns, by_distance, views))
    }
}

impl Views {
    /// The eyes that times are taken from.
    fn timed(&self) -> Vec<[f64; 4]> {
        let seen = &self.seen[MAIN];
        let step = (seen.len() / TIMED_EYES).max(1);
        seen.iter().step_by(step).take(TIMED_EYES).map(|s| s.eye).collect()
    }
}

/// The eyes at one distance.
pub(super) fn eyes(subject: &Subject, directions: u32, radii: f64) -> Vec<[f64; 4]> {
    let n = directions as usize;
    (0..n).map(|i| subject.eye(fibonacci(i, n), radii)).collect()
}

/// The fastest of several passes, in nanoseconds.
pub(super) fn fastest(mut pass: impl FnMut()) -> f64 {
    let begin = Instant::now();
    let mut best = Duration::MAX;
    let mut passes = 0;
    while passes < 3 || begin.elapsed() < PATIENCE {
        let start = Instant::now();
        pass();
        best = best.min(start.elapsed());
        passes += 1;
    }
    best.as_nanos() as f64
}

fn record(
    (name, what): (&'static str, &'static str),
    bytes: u64,
    ns_per_cluster: f64,
    culled_percent_by_distance: Vec<f64>,
    views: &Views,
) -> BoundRow {
    let (culled_percent, ideal) = (culled_percent_by_distance[MAIN], views.ideal_percent[MAIN]);
    BoundRow {
        name,
        what,
        bytes,
        ns_per_cluster,
        culled_percent,
        share_of_ideal_percent: (ideal > 0.0).then(|| culled_percent / ideal * 100.0),
        culled_percent_by_distance,
    }
}
