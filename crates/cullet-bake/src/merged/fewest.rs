//! The fewest triangles of a surface within a bound that is measured against another: the instances
//! in full.

use super::MEASURED;
use crate::gather::Surface;
use crate::levels::tighten::{Bound, Carrying, Far};
use cullet_draw::surface::{SurfaceTree, inner_points, surface_points};

/// Shares of the bound that the simplifier is given in turn.
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

/// A surface to be simplified, and the triangles that are left.
pub(super) struct Start {
    surface: Surface,
    place: Vec<u32>,
    carrying: Carrying,
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

    /// A surface, with each point of the instances by the triangle that is nearest.
    pub(super) fn start(&self, surface: Surface) -> Start {
        let nearest = SurfaceTree::new(&surface.positions, &surface.indices);
        let points = self.points.iter().filter_map(|&point| {
            nearest.nearest(point, f32::INFINITY).map(|(distance, t)| (t, distance, point))
        });
        let carrying = Carrying::new(surface.indices.clone(), points.collect());
        Start { place: cullet::mesh::weld(&surface.positions), surface, carrying }
    }

    /// The fewest triangles of what is left of `from` that are within a bound of the instances, if
    /// they are fewer than `fewer_than`; and how far they were found to be off at the most.
    pub(super) fn fewest(
        &self,
        from: &mut Start,
        bound: f32,
        fewer_than: u64,
    ) -> Option<(Surface, f32)> {
        let Start { surface, place, carrying } = from;
        let bound = Bound {
            positions: &surface.positions,
            place,
            original: &self.tree,
            bound,
            shares: &SHARES,
            rounds: ROUNDS,
            fewer_than: fewer_than as usize,
        };
        let error = bound.fewest(carrying, |far, _, indices| self.back(far, surface, indices))?;
        Some((surface.with_triangles(&carrying.indices), error))
    }

    /// Tests points of a result.
    fn back(&self, far: &mut Far, input: &Surface, indices: &[u32]) {
        for (t, corners) in (0..).zip(indices.as_chunks::<3>().0) {
            let places = corners.map(|v| input.positions[v as usize]);
            let inner = inner_points(places, MEASURED.seed, t, MEASURED.reverse_points);
            inner.for_each(|point| far.test(&self.tree, point));
        }
        let count = (indices.len() / 3 * 8).clamp(5_000, MOST_POINTS);
        for p in surface_points(&input.positions, indices, count, MEASURED.seed + 1) {
            far.test(&self.tree, p.point);
        }
    }
}
