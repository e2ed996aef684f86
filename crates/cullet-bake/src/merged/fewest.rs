//! The fewest triangles of a surface within a bound that is measured against another: the instances
//! in full.

use super::MEASURED;
use crate::gather::Surface;
use crate::levels::collapse::{Collapser, Task};
use crate::levels::tighten;
use cullet_draw::surface::{SurfaceTree, inner_points, surface_points};

/// Shares of the bound that the simplifier is given in turn: it measures at fewer points than who
/// looks at the result.
const SHARES: [f32; 3] = [0.95, 0.8, 0.5];
/// How often all is simplified again, with less allowed where it was too far, for each share.
const ROUNDS: u32 = 6;
/// The most points of a surface that are measured.
const MOST_POINTS: usize = 1_000_000;

/// Reference that levels of a group are measured against.
pub(super) struct Measure {
    tree: SurfaceTree,
    points: Vec<[f32; 3]>,
}

impl Measure {
    /// Measures against all instances of a group: by their vertices, and twice as many points of
    /// their surface.
    pub(super) fn new(original: &Surface) -> Self {
        let Surface { positions, indices, .. } = original;
        let count = (indices.len() / 3 * MEASURED.points as usize).clamp(10_000, MOST_POINTS);
        let mut points: Vec<[f32; 3]> = surface_points(positions, indices, count, MEASURED.seed)
            .iter()
            .map(|p| p.point)
            .collect();
        let step = positions.len().div_ceil(MOST_POINTS).max(1);
        points.extend(positions.iter().step_by(step));
        Self { tree: SurfaceTree::new(positions, indices), points }
    }

    /// The fewest triangles of `input` that are within a bound of the instances, if they are fewer
    /// than `fewer_than`; and how far they were found to be off at the most.
    pub(super) fn fewest(
        &self,
        input: &Surface,
        bound: f32,
        fewer_than: u64,
    ) -> Option<(Surface, f32)> {
        let nearest = SurfaceTree::new(&input.positions, &input.indices);
        let place = cullet::mesh::weld(&input.positions);
        let (points, distances, counts) = self.carried(input, &nearest);
        let mut collapser = Collapser::default();
        let locks = vec![false; input.positions.len()];
        for share in SHARES {
            let mut shares = vec![1.0; input.positions.len()];
            for _ in 0..ROUNDS {
                let made = collapser.run(&Task {
                    positions: &input.positions,
                    place: &place,
                    indices: &input.indices,
                    locks: &locks,
                    shares: &shares,
                    points: &points,
                    distances: &distances,
                    counts: &counts,
                    triangles: 0,
                    free: 0.0,
                    limit: bound * share,
                    original: Some(&self.tree),
                });
                // Smaller shares only add triangles.
                if (made.indices.len() / 3) as u64 >= fewer_than || made.indices.is_empty() {
                    return None;
                }
                match self.test(input, &made.indices, bound) {
                    Tested::Within(error) => {
                        return Some((input.with_triangles(&made.indices), error));
                    }
                    Tested::Beyond(points) => {
                        let tree = SurfaceTree::new(&input.positions, &made.indices);
                        tighten(&tree, &made.indices, &place, &points, &mut shares);
                    }
                }
            }
        }
        None
    }

    /// Points of the instances by the triangles of the input that are nearest, how far they are
    /// from there, and how many each triangle has.
    fn carried(
        &self,
        input: &Surface,
        nearest: &SurfaceTree,
    ) -> (Vec<[f32; 3]>, Vec<f32>, Vec<u32>) {
        let mut all: Vec<(u32, f32, [f32; 3])> = Vec::with_capacity(self.points.len());
        for &point in &self.points {
            if let Some((distance, t)) = nearest.nearest(point, f32::INFINITY) {
                all.push((t, distance, point));
            }
        }
        all.sort_by_key(|p| p.0);
        let mut counts = vec![0; input.indices.len() / 3];
        all.iter().for_each(|p| counts[p.0 as usize] += 1);
        let points = all.iter().map(|p| p.2).collect();
        (points, all.iter().map(|p| p.1).collect(), counts)
    }

    /// Whether all points are within a bound; else those that are not.
    fn test(&self, input: &Surface, indices: &[u32], bound: f32) -> Tested {
        let tree = SurfaceTree::new(&input.positions, indices);
        let (mut error, mut beyond) = (0.0_f32, Vec::new());
        let mut test = |tree: &SurfaceTree, point: [f32; 3]| {
            // Once something is too far, how far the rest is does not matter.
            let near = if beyond.is_empty() { error } else { bound };
            if tree.within(point, near).is_some() {
                return;
            }
            let distance = tree.nearest(point, f32::INFINITY).map_or(f32::INFINITY, |n| n.0);
            if distance <= bound {
                error = error.max(distance);
            } else {
                beyond.push(point);
            }
        };
        self.points.iter().for_each(|&point| test(&tree, point));
        for (t, corners) in (0..).zip(indices.as_chunks::<3>().0) {
            let places = corners.map(|v| input.positions[v as usize]);
            let inner = inner_points(places, MEASURED.seed, t, MEASURED.reverse_points);
            inner.for_each(|point| test(&self.tree, point));
        }
        let count = (indices.len() / 3 * 8).clamp(5_000, MOST_POINTS);
        for p in surface_points(&input.positions, indices, count, MEASURED.seed + 1) {
            test(&self.tree, p.point);
        }
        if beyond.is_empty() { Tested::Within(error) } else { Tested::Beyond(beyond) }
    }
}

enum Tested {
    /// All is within the bound; the largest distance.
    Within(f32),
    /// Points that are not.
    Beyond(Vec<[f32; 3]>),
}
