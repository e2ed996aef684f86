//! The fewest triangles within a bound that is measured: simplify, lock what is too far, and
//! repeat.

use cullet::MeshData;
use cullet::mesh::Part;

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
    /// How often what is too far is locked and all simplified again, for each share. Default 10.
    pub rounds: u32,
    /// The shares of the bound that the simplifier is given, whose own estimate of the error is too
    /// small more often than not. Each that is tried costs up to as many rounds, and the best is
    /// kept. Default 1, 0.7, 0.5 and 0.35.
    pub shares: &'a [f32],
}

impl Default for WithinOptions<'_> {
    fn default() -> Self {
        Self { same: &[], rounds: 10, shares: &[1.0, 0.9] }
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
const LAST_SHARES: [f32; 5] = [0.25, 0.125, 0.06, 0.03, 0.01];

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
/// Simplifies towards shares of the bound; vertices of triangles that are farther away than the
/// bound are locked, and that is repeated. Costs some ten to forty simplifications and
/// measurements. The same on every run and, where the
/// compiler of C++ fuses no multiplication with an addition, on every target.
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
    let found = original.fewest_within(bound, original.triangle_count(), options)?;
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
    /// The fewest triangles within a bound, if they are fewer than `fewer_than`.
    pub(super) fn fewest_within(
        &self,
        bound: f32,
        fewer_than: usize,
        options: &WithinOptions<'_>,
    ) -> Result<Option<Found>, LevelsError> {
        let mut best: Option<Found> = None;
        let mut most = fewer_than;
        for &share in options.shares {
            if let Some(found) = self.locked_within(bound, share, most, options.rounds)? {
                most = found.indices.len() / 3;
                best = Some(found);
            }
        }
        if best.is_none() {
            for share in LAST_SHARES {
                best = self.locked_within(bound, share, most, options.rounds)?;
                if best.is_some() {
                    break;
                }
            }
        }
        Ok(best)
    }

    /// Simplifies towards a share of the bound, with more and more locked, until all is within;
    /// nothing if that does not happen with fewer triangles than `fewer_than`.
    fn locked_within(
        &self,
        bound: f32,
        share: f32,
        fewer_than: usize,
        rounds: u32,
    ) -> Result<Option<Found>, LevelsError> {
        let mut locks = vec![false; self.positions.len()];
        let place = cullet::mesh::weld(&self.positions);
        let (points, counts) = self.carried(&place);
        let mut collapser = super::collapse::Collapser::default();
        for round in 0..rounds {
            let mut of_places = vec![false; place.len()];
            locks.iter().zip(&place).for_each(|(lock, &p)| of_places[p as usize] |= lock);
            let t0 = std::time::Instant::now();
            let made = collapser.run(&super::collapse::Task {
                positions: &self.positions,
                place: &place,
                indices: &self.indices,
                locks: &of_places,
                points: &points,
                distances: &vec![0.0; points.len()],
                counts: &counts,
                triangles: 0,
                free: 0.0,
                limit: bound * share,
                original: Some(&self.tree),
            });
            if std::env::var_os("LEVDBG").is_some() {
                eprintln!("within {bound} {share}: round {round}: {} {:?} {:?}", made.indices.len() / 3, t0.elapsed(), collapser.stats);
            }
            // Locks only add triangles.
            if made.indices.len() / 3 >= fewer_than {
                return Ok(None);
            }
            match self.measure(&made.indices, bound, &mut locks) {
                Measured::Within(error) => return Ok(Some(Found { indices: made.indices, error })),
                Measured::Locked(0) => return Ok(None),
                Measured::Locked(_) => {}
            }
        }
        Ok(None)
    }

    /// Points triangle by triangle, and how many each has: corners with the first triangle there.
    fn carried(&self, place: &[u32]) -> (Vec<[f32; 3]>, Vec<u32>) {
        let mut all: Vec<SurfacePoint> = Vec::with_capacity(self.points.len() + place.len());
        let mut seen = vec![false; place.len()];
        for (t, corners) in (0..).zip(self.indices.as_chunks::<3>().0) {
            for &v in corners {
                let p = place[v as usize] as usize;
                if !std::mem::replace(&mut seen[p], true) {
                    all.push(SurfacePoint { point: self.positions[p], triangle: t });
                }
            }
        }
        all.extend(&self.points);
        all.sort_by_key(|p| p.triangle);
        let mut counts = vec![0; self.triangle_count()];
        all.iter().for_each(|p| counts[p.triangle as usize] += 1);
        (all.iter().map(|p| p.point).collect(), counts)
    }

    /// Whether all points are within a bound; else locks the vertices of original triangles where
    /// they are not.
    fn measure(&self, indices: &[u32], bound: f32, locks: &mut [bool]) -> Measured {
        let tree = SurfaceTree::new(&self.positions, indices);
        let mut state = State { bound, error: 0.0, exceeded: false, newly: 0, locks };
        for (v, &point) in self.positions.iter().enumerate() {
            state.test(&tree, point, |_| [v; 3]);
        }
        let corners = |t: u32| {
            let at = t as usize * 3;
            [0, 1, 2].map(|k| self.indices[at + k] as usize)
        };
        for &SurfacePoint { point, triangle } in &self.points {
            state.test(&tree, point, |_| corners(triangle));
        }
        for &SurfacePoint { point, .. } in &self.points_back(indices) {
            state.test(&self.tree, point, corners);
        }
        if !state.exceeded {
            // Few are beyond the bound where none of the others was.
            state.bound = bound * CONFIRMED;
            let mut peaks = Peaks::default();
            for of in self.confirming_points(&self.indices) {
                state.test_high(&tree, of, &mut peaks, |_| corners(of.triangle));
            }
            for top in peaks.climb(&tree, |t| self.corners(&self.indices, t)) {
                state.test(&tree, top.point, |_| corners(top.triangle));
            }
            let mut peaks = Peaks::default();
            for of in self.confirming_points(indices) {
                state.test_high(&self.tree, of, &mut peaks, corners);
            }
            for top in peaks.climb(&self.tree, |t| self.corners(indices, t)) {
                state.test(&self.tree, top.point, corners);
            }
        }
        if state.exceeded { Measured::Locked(state.newly) } else { Measured::Within(state.error) }
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
    /// How many vertices were locked that were not before.
    Locked(usize),
}

struct State<'a> {
    bound: f32,
    error: f32,
    exceeded: bool,
    newly: usize,
    locks: &'a mut [bool],
}

impl State<'_> {
    /// Tests a point, and remembers it where it is high.
    #[inline]
    fn test_high(
        &mut self,
        tree: &SurfaceTree,
        of: SurfacePoint,
        peaks: &mut Peaks,
        vertices: impl Fn(u32) -> [usize; 3],
    ) {
        if peaks.add(tree, of, self.error).is_some_and(|distance| distance > self.error) {
            self.test(tree, of.point, vertices);
        }
    }

    /// Tests a point; `vertices` of the triangle that is nearest are locked if it is too far.
    #[inline]
    fn test(&mut self, tree: &SurfaceTree, point: [f32; 3], vertices: impl Fn(u32) -> [usize; 3]) {
        // Once something is too far, how far the rest is does not matter.
        let near = if self.exceeded { self.bound } else { self.error };
        if tree.within(point, near).is_some() {
            return;
        }
        let nearest = tree.nearest(point, f32::INFINITY);
        let distance = nearest.map_or(f32::INFINITY, |n| n.0);
        if distance <= self.bound {
            self.error = self.error.max(distance);
            return;
        }
        self.exceeded = true;
        for v in vertices(nearest.map_or(0, |n| n.1)) {
            self.newly += usize::from(!self.locks[v]);
            self.locks[v] = true;
        }
    }
}
