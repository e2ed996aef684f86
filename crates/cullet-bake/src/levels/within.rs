//! The fewest triangles within a bound that is measured: simplify, allow less where it was too far,
//! and repeat.

use cullet::MeshData;
use cullet::mesh::Part;

use super::error::LevelsError;
use super::original::Original;
use super::peaks::Peaks;
use super::tighten::{Bound, Carrying, Far};
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
        let bound = Bound {
            positions: &self.positions,
            place: &self.place,
            original: &self.tree,
            bound,
            shares: &[options.shares, &LAST_SHARES].concat(),
            rounds: options.rounds,
            fewer_than,
        };
        let error = bound.fewest(from, |far, tree, indices| self.measure(far, tree, indices))?;
        Some(Found { indices: from.indices.clone(), error })
    }

    /// The original with its points.
    pub(super) fn carrying(&self) -> Carrying {
        let points = self.points.iter().map(|p| (p.triangle, 0.0, p.point)).collect();
        Carrying::new(self.indices.clone(), points)
    }

    /// Tests points of a result, and the points by which it is confirmed.
    fn measure(&self, far: &mut Far, tree: &SurfaceTree, indices: &[u32]) {
        for &SurfacePoint { point, .. } in &self.points_back(indices) {
            far.test(&self.tree, point);
        }
        if far.beyond.is_empty() {
            // Few are beyond the bound where none of the others was.
            far.bound *= CONFIRMED;
            self.confirm(far, tree, &self.indices);
            self.confirm(far, &self.tree, indices);
        }
    }

    /// Tests many points of a surface, and the tops that are reached from the highest of them.
    fn confirm(&self, far: &mut Far, tree: &SurfaceTree, indices: &[u32]) {
        let mut peaks = Peaks::default();
        for of in self.confirming_points(indices) {
            let distance = peaks.add(tree, of, far.error);
            if distance.is_some_and(|distance| distance > far.error) {
                far.test(tree, of.point);
            }
        }
        for top in peaks.climb(tree, |t| self.corners(indices, t)) {
            far.test(tree, top.point);
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
