//! The fewest triangles within a bound: simplify, measure, allow less where it was too far, and
//! repeat.

use super::collapse::{Collapser, Points, Task};
use cullet_draw::surface::SurfaceTree;

/// How much less of the limit is allowed next to where a result was beyond the bound.
const TIGHTER: f32 = 0.7;

/// Triangles with the points of the original that each stands for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Carrying {
    pub(crate) indices: Vec<u32>,
    points: Points,
}

/// A point of the original: the triangle that stands for it, how far it is from there, its place.
pub(crate) type Carried = (u32, f32, [f32; 3]);

impl Carrying {
    pub(crate) fn new(indices: Vec<u32>, mut all: Vec<Carried>) -> Self {
        all.sort_by_key(|p| p.0);
        let mut points = Points { counts: vec![0; indices.len() / 3], ..Points::default() };
        for (triangle, distance, point) in all {
            points.points.push(point);
            points.distances.push(distance);
            points.counts[triangle as usize] += 1;
        }
        Self { indices, points }
    }
}

/// Bound that a result has to keep.
pub(crate) struct Bound<'a> {
    /// Vertices, and for each the first at its position.
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) place: &'a [u32],
    pub(crate) original: &'a SurfaceTree,
    pub(crate) bound: f32,
    /// The shares of the bound that the simplifier is given in turn: it measures at fewer points
    /// than who looks at the result.
    pub(crate) shares: &'a [f32],
    /// How often less is allowed where it was too far, and all simplified again, for each share.
    pub(crate) rounds: u32,
    pub(crate) fewer_than: usize,
}

impl Bound<'_> {
    /// The fewest triangles within the bound, made of `from`, which becomes them; returns how far
    /// they were found to be off. `measure` tests points besides those that triangles carry, in one
    /// surface or the other.
    pub(crate) fn fewest(
        &self,
        from: &mut Carrying,
        measure: impl Fn(&mut Far, &SurfaceTree, &[u32]),
    ) -> Option<f32> {
        let mut collapser = Collapser::default();
        let mut shares = vec![1.0; self.positions.len()];
        for &share in self.shares {
            shares.fill(1.0);
            for _ in 0..self.rounds {
                let made = collapser.run(&Task {
                    positions: self.positions,
                    place: self.place,
                    indices: &from.indices,
                    locks: &[],
                    shares: &shares,
                    carried: &from.points,
                    triangles: 0,
                    free: 0.0,
                    limit: self.bound * share,
                    original: Some(self.original),
                });
                // Smaller shares leave more.
                if made.indices.len() / 3 >= self.fewer_than || made.indices.is_empty() {
                    return None;
                }
                let tree = SurfaceTree::new(self.positions, &made.indices);
                let mut far = Far::new(self.bound);
                for (point, distance) in made.from.iter().flat_map(|&t| collapser.points_of(t)) {
                    // No triangle is farther than the one that it is carried by.
                    if distance > far.error {
                        far.test(&tree, point);
                    }
                }
                measure(&mut far, &tree, &made.indices);
                if far.beyond.is_empty() {
                    from.indices = made.indices;
                    from.points = Points::default();
                    for &t in &made.from {
                        from.points.add(collapser.points_of(t), usize::MAX);
                    }
                    return Some(far.error);
                }
                self.tighten(&tree, &made.indices, &far.beyond, &mut shares);
            }
        }
        None
    }

    /// Lets less of the limit be used next to the triangles that are nearest to points beyond it.
    fn tighten(
        &self,
        tree: &SurfaceTree,
        indices: &[u32],
        points: &[[f32; 3]],
        shares: &mut [f32],
    ) {
        let mut places: Vec<u32> = points
            .iter()
            .filter_map(|p| tree.nearest(*p, f32::INFINITY))
            .flat_map(|(_, t)| &indices[t as usize * 3..][..3])
            .map(|&v| self.place[v as usize])
            .collect();
        places.sort_unstable();
        places.dedup();
        places.iter().for_each(|&p| shares[p as usize] *= TIGHTER);
    }
}

/// The largest distance of points that are tested, and those beyond a bound.
pub(crate) struct Far {
    pub(crate) bound: f32,
    pub(crate) error: f32,
    pub(crate) beyond: Vec<[f32; 3]>,
    /// Where something near was found the last time.
    last: u32,
}

impl Far {
    fn new(bound: f32) -> Self {
        Self { bound, error: 0.0, beyond: Vec::new(), last: 0 }
    }

    #[inline]
    pub(crate) fn test(&mut self, tree: &SurfaceTree, point: [f32; 3]) {
        // Once something is too far, how far the rest is does not matter.
        let near = if self.beyond.is_empty() { self.error } else { self.bound };
        let Some(distance) = tree.farther(point, near, &mut self.last) else { return };
        if distance <= self.bound {
            self.error = self.error.max(distance);
        } else {
            self.beyond.push(point);
        }
    }
}
