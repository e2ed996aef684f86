//! The fewest triangles of a surface within a bound that is measured against another: the instances
//! in full.

use super::MEASURED;
use crate::gather::Surface;
use crate::levels::collapse::{Collapser, Task};
use cullet_draw::surface::{SurfaceTree, inner_points, surface_points};

use crate::levels::LevelsError;

/// Shares of the bound that the simplifier is given, whose own estimate is too small more often
/// than not.
const SHARES: [f32; 2] = [0.95, 0.7];
/// How often what is too far is locked and all simplified again, for each share.
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
    ) -> Result<Option<(Surface, f32)>, LevelsError> {
        let nearest = SurfaceTree::new(&input.positions, &input.indices);
        let place = cullet::mesh::weld(&input.positions);
        let (points, distances, counts) = self.carried(input, &nearest);
        let mut collapser = Collapser::default();
        let mut best: Option<(Vec<u32>, f32)> = None;
        let mut most = fewer_than;
        for share in SHARES {
            let mut locks = vec![false; input.positions.len()];
            for round in 0..ROUNDS {
                let mut of_places = vec![false; place.len()];
                locks.iter().zip(&place).for_each(|(lock, &p)| of_places[p as usize] |= lock);
                let made = collapser.run(&Task {
                    positions: &input.positions,
                    place: &place,
                    indices: &input.indices,
                    locks: &of_places,
                    points: &points,
                    distances: &distances,
                    counts: &counts,
                    triangles: 0,
                    free: 0.0,
                    limit: bound * share,
                    original: Some(&self.tree),
                });
                if std::env::var_os("LEVDBG").is_some() {
                    eprintln!("merged {} {bound} {share}: round {round}: {} of {most}", input.indices.len() / 3, made.indices.len() / 3);
                }
                // Locks only add triangles.
                if (made.indices.len() / 3) as u64 >= most || made.indices.is_empty() {
                    break;
                }
                match self.test(input, &nearest, &made.indices, bound, &mut locks) {
                    Tested::Within(error) => {
                        most = (made.indices.len() / 3) as u64;
                        best = Some((made.indices, error));
                        break;
                    }
                    Tested::Locked(0) => break,
                    Tested::Locked(_) => {}
                }
            }
        }
        Ok(best.map(|(indices, error)| (input.with_triangles(&indices), error)))
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

    /// Whether all points are within a bound; else locks vertices of the input where they are not.
    fn test(
        &self,
        input: &Surface,
        nearest: &SurfaceTree,
        indices: &[u32],
        bound: f32,
        locks: &mut [bool],
    ) -> Tested {
        let tree = SurfaceTree::new(&input.positions, indices);
        let (mut error, mut exceeded, mut newly) = (0.0_f32, false, 0);
        let mut test =
            |tree: &SurfaceTree, point: [f32; 3], lock: &dyn Fn() -> Option<[u32; 3]>| {
                // Once something is too far, how far the rest is does not matter.
                let near = if exceeded { bound } else { error };
                if tree.within(point, near).is_some() {
                    return;
                }
                let distance = tree.nearest(point, f32::INFINITY).map_or(f32::INFINITY, |n| n.0);
                if distance <= bound {
                    error = error.max(distance);
                    return;
                }
                exceeded = true;
                for v in lock().into_iter().flatten() {
                    newly += usize::from(!locks[v as usize]);
                    locks[v as usize] = true;
                }
            };
        let corners = |list: &[u32], t: u32| {
            let at = t as usize * 3;
            [list[at], list[at + 1], list[at + 2]]
        };
        for &point in &self.points {
            let lock = || {
                let (_, t) = nearest.nearest(point, f32::INFINITY)?;
                Some(corners(&input.indices, t))
            };
            test(&tree, point, &lock);
        }
        for t in 0..(indices.len() / 3) as u32 {
            let three = corners(indices, t);
            let places = three.map(|v| input.positions[v as usize]);
            for point in inner_points(places, MEASURED.seed, t, MEASURED.reverse_points) {
                test(&self.tree, point, &|| Some(three));
            }
        }
        let count = (indices.len() / 3 * 8).clamp(5_000, MOST_POINTS);
        for p in surface_points(&input.positions, indices, count, MEASURED.seed + 1) {
            test(&self.tree, p.point, &|| Some(corners(indices, p.triangle)));
        }
        if exceeded { Tested::Locked(newly) } else { Tested::Within(error) }
    }
}

enum Tested {
    /// All is within the bound; the largest distance.
    Within(f32),
    /// How many vertices were locked that were not before.
    Locked(usize),
}
