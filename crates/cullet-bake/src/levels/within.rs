//! The fewest triangles within a bound that is measured: simplify, allow less where it was too far,
//! and repeat.

use cullet::MeshData;
use cullet::mesh::Part;

use super::collapse::{Collapser, Task};
use super::error::LevelsError;
use super::original::Original;
use super::peaks::Peaks;
use cullet_draw::surface::SurfacePoint;
use cullet_draw::surface::SurfaceTree;

/// How hard fewer triangles are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WithinOptions<'a> {
    /// For each vertex the number of one that it is the same as, in position and all else that must
    /// be kept (normals, texture coordinates); empty for equal positions. Vertices at one position
    /// that are not the same are a seam: it is kept, and simplified along itself.
    pub same: &'a [u32],
    /// How often what is too far is allowed less and all simplified again, for each share. Default 5.
    pub rounds: u32,
    /// The shares of the bound that the simplifier is given in turn, until one is found to be within
    /// the bound: it measures at fewer points than who looks at the result. Default 0.95 and 0.8.
    pub shares: &'a [f32],
}

impl Default for WithinOptions<'_> {
    fn default() -> Self {
        Self { same: &[], rounds: 5, shares: &[0.95, 0.8] }
    }
}

/// A mesh of fewer triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Within {
    /// Three indices a triangle, of vertices of the mesh that was given.
    pub indices: Vec<u32>,
    /// Its parts, as many as that mesh has.
    pub parts: Vec<Part>,
    /// The largest distance that was measured, either way: at most 1.08 of the bound.
    pub error: f32,
}

/// The shares that are tried where none of those wanted is within the bound.
const LAST_SHARES: [f32; 4] = [0.5, 0.25, 0.06, 0.01];

/// How far beyond the bound the points may be that confirm a result. With none allowed beyond it,
/// armadillo has a fifth to a half more triangles at 0.1 and 0.3 % of its radius.
const CONFIRMED: f32 = 1.08;

/// Simplifies a mesh to few triangles, which deviate by no more than `bound` from the mesh, nor the
/// mesh from them: no corner does, nor any of the random points, one and more of each triangle.
/// Some four to sixteen points a triangle confirm that, and the tops that are reached uphill from
/// the farthest of them; none may be farther than 1.08 of the bound. That is measured, unlike the
/// simplifier's own error, which is no bound. Of other points fewer than one in a thousand is
/// beyond the bound, and none was found beyond 1.2 of it.
///
/// Vertices keep their places and numbers, so that their attributes go on to be right. Parts stay
/// apart: the line between two is simplified like an edge. Open borders are, too. Triangles with
/// corners in one place are left out. What cannot be simplified comes back as it is, with an error
/// of 0.
///
/// Edges are collapsed while points of the original that each triangle carries stay within a share of
/// the bound. Next to what is found to be farther away than the bound less is allowed, and that is
/// repeated. The same on every run and on every target.
///
/// # Errors
/// If the mesh is invalid or extends too far, the bound or an option is out of range.
pub fn simplify_within(
    data: &MeshData,
    bound: f32,
    options: &WithinOptions<'_>,
) -> Result<Within, LevelsError> {
    check(bound, options)?;
    let original = Original::new(data, options.same)?;
    let all = original.triangle_count();
    let found = original.fewest_within(&mut original.carrying(), bound, all, options);
    Ok(match found {
        Some(found) => original.as_given(&found.indices, found.error),
        None => original.as_given(&original.indices, 0.0),
    })
}

/// Whether a bound and options are in range.
pub(super) fn check(bound: f32, options: &WithinOptions<'_>) -> Result<(), LevelsError> {
    let refused = |what, value: f64, allowed| Err(LevelsError::Value { what, value, allowed });
    if !(bound >= 0.0 && bound.is_finite()) {
        return refused("bound", f64::from(bound), "a finite number from 0");
    }
    if !(1..=100).contains(&options.rounds) {
        return refused("rounds", f64::from(options.rounds), "1 to 100");
    }
    match options.shares.iter().find(|s| !(**s > 0.0 && **s <= 10.0)) {
        Some(&share) => refused("shares", f64::from(share), "numbers above 0, to 10"),
        None => Ok(()),
    }
}

/// A list of triangles of an original's vertices, and how far it was measured to be off.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) indices: Vec<u32>,
    pub(super) error: f32,
}

/// Triangles of an original's vertices, with the points of the original that each stands for.
#[derive(Clone, Debug, Default)]
pub(super) struct Carrying {
    indices: Vec<u32>,
    points: Vec<[f32; 3]>,
    /// How far each point is off.
    distances: Vec<f32>,
    /// How many points each triangle has.
    counts: Vec<u32>,
}

/// What came of simplifying towards a share of a bound.
enum Outcome {
    Found(Found, Carrying),
    TooMany,
    NotWithin,
}

impl Original {
    /// The fewest triangles within a bound, if they are fewer than `fewer_than`; made of `from`,
    /// which becomes them.
    pub(super) fn fewest_within(
        &self,
        from: &mut Carrying,
        bound: f32,
        fewer_than: usize,
        options: &WithinOptions<'_>,
    ) -> Option<Found> {
        for &share in options.shares.iter().chain(&LAST_SHARES) {
            match self.locked_within(from, bound, share, fewer_than, options.rounds) {
                Outcome::Found(found, carrying) => {
                    *from = carrying;
                    return Some(found);
                }
                // Smaller shares leave more.
                Outcome::TooMany => return None,
                Outcome::NotWithin => {}
            }
        }
        None
    }

    /// Simplifies towards a share of the bound, with less and less of it where that was too much,
    /// until all is within.
    fn locked_within(
        &self,
        from: &Carrying,
        bound: f32,
        share: f32,
        fewer_than: usize,
        rounds: u32,
    ) -> Outcome {
        let locks = vec![false; self.positions.len()];
        let mut shares = vec![1.0; self.positions.len()];
        let mut collapser = Collapser::default();
        for _ in 0..rounds {
            let made = collapser.run(&Task {
                positions: &self.positions,
                place: &self.place,
                indices: &from.indices,
                locks: &locks,
                shares: &shares,
                points: &from.points,
                distances: &from.distances,
                counts: &from.counts,
                triangles: 0,
                free: 0.0,
                limit: bound * share,
                original: Some(&self.tree),
            });
            if made.indices.len() / 3 >= fewer_than {
                return Outcome::TooMany;
            }
            match self.measure(&made.indices, bound) {
                Measured::Within(error) => {
                    let mut carrying = Carrying::default();
                    for &t in &made.from {
                        let before = carrying.points.len();
                        for (point, distance) in collapser.points_of(t) {
                            carrying.points.push(point);
                            carrying.distances.push(distance);
                        }
                        carrying.counts.push((carrying.points.len() - before) as u32);
                    }
                    carrying.indices.clone_from(&made.indices);
                    return Outcome::Found(Found { indices: made.indices, error }, carrying);
                }
                Measured::Beyond(points) => {
                    let tree = SurfaceTree::new(&self.positions, &made.indices);
                    tighten(&tree, &made.indices, &self.place, &points, &mut shares);
                }
            }
        }
        Outcome::NotWithin
    }

    /// The original with its points.
    pub(super) fn carrying(&self) -> Carrying {
        let mut all = self.points.clone();
        all.sort_by_key(|p| p.triangle);
        let mut counts = vec![0; self.triangle_count()];
        all.iter().for_each(|p| counts[p.triangle as usize] += 1);
        Carrying {
            indices: self.indices.clone(),
            points: all.iter().map(|p| p.point).collect(),
            distances: vec![0.0; all.len()],
            counts,
        }
    }

    /// Whether all points are within a bound; else those that are not.
    fn measure(&self, indices: &[u32], bound: f32) -> Measured {
        let tree = SurfaceTree::new(&self.positions, indices);
        let mut state = State { bound, error: 0.0, beyond: Vec::new() };
        for &point in &self.positions {
            state.test(&tree, point);
        }
        for &SurfacePoint { point, .. } in &self.points {
            state.test(&tree, point);
        }
        for &SurfacePoint { point, .. } in &self.points_back(indices) {
            state.test(&self.tree, point);
        }
        if state.beyond.is_empty() {
            // Few are beyond the bound where none of the others was.
            state.bound = bound * CONFIRMED;
            let mut peaks = Peaks::default();
            for of in self.confirming_points(&self.indices) {
                state.test_high(&tree, of, &mut peaks);
            }
            for top in peaks.climb(&tree, |t| self.corners(&self.indices, t)) {
                state.test(&tree, top.point);
            }
            let mut peaks = Peaks::default();
            for of in self.confirming_points(indices) {
                state.test_high(&self.tree, of, &mut peaks);
            }
            for top in peaks.climb(&self.tree, |t| self.corners(indices, t)) {
                state.test(&self.tree, top.point);
            }
        }
        match state.beyond.is_empty() {
            true => Measured::Within(state.error),
            false => Measured::Beyond(state.beyond),
        }
    }

    /// Triangles as vertices of the mesh that was given, part by part.
    pub(super) fn as_given(&self, indices: &[u32], error: f32) -> Within {
        let mut of_parts = vec![Vec::new(); self.parts.len()];
        for corners in indices.chunks_exact(3) {
            // All corners are of one part.
            let of = &mut of_parts[self.part[corners[0] as usize] as usize];
            of.extend(corners.iter().map(|&v| self.vertex[v as usize]));
        }
        let mut first_triangle = 0;
        let parts = self.parts.iter().zip(&of_parts).map(|(part, of)| {
            let part = Part { first_triangle, triangle_count: (of.len() / 3) as u32, ..*part };
            first_triangle += part.triangle_count;
            part
        });
        let parts = parts.collect();
        Within { indices: of_parts.concat(), parts, error }
    }
}

enum Measured {
    /// All is within the bound; the largest distance.
    Within(f32),
    /// Points that are not.
    Beyond(Vec<[f32; 3]>),
}

struct State {
    bound: f32,
    error: f32,
    beyond: Vec<[f32; 3]>,
}

impl State {
    /// Tests a point, and remembers it where it is high.
    #[inline]
    fn test_high(&mut self, tree: &SurfaceTree, of: SurfacePoint, peaks: &mut Peaks) {
        if peaks.add(tree, of, self.error).is_some_and(|distance| distance > self.error) {
            self.test(tree, of.point);
        }
    }

    #[inline]
    fn test(&mut self, tree: &SurfaceTree, point: [f32; 3]) {
        // Once something is too far, how far the rest is does not matter.
        let near = if self.beyond.is_empty() { self.error } else { self.bound };
        if tree.within(point, near).is_some() {
            return;
        }
        let distance = tree.nearest(point, f32::INFINITY).map_or(f32::INFINITY, |n| n.0);
        if distance <= self.bound {
            self.error = self.error.max(distance);
        } else {
            self.beyond.push(point);
        }
    }
}

/// How much less of the limit is allowed next to where a result was beyond the bound.
const TIGHTER: f32 = 0.7;

/// Lets less of the limit be used next to the triangles that are nearest to points beyond a bound.
pub(crate) fn tighten(
    tree: &SurfaceTree,
    indices: &[u32],
    place: &[u32],
    points: &[[f32; 3]],
    shares: &mut [f32],
) {
    let mut places: Vec<u32> = points
        .iter()
        .filter_map(|p| tree.nearest(*p, f32::INFINITY))
        .flat_map(|(_, t)| &indices[t as usize * 3..][..3])
        .map(|&v| place[v as usize])
        .collect();
    places.sort_unstable();
    places.dedup();
    places.iter().for_each(|&p| shares[p as usize] *= TIGHTER);
}
