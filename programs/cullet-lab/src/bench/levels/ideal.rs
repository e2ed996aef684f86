//! How few triangles could do: each place of the surface at the coarsest level that is near enough
//! for its distance, whether its neighbours are at the same one or not.
//!
//! No renderer can draw that, for it has cracks; so it is what a choice of levels is held against.
//! Twice: by the error of each level as a whole, which is what a level's error is, and by that of
//! each of its triangles, which takes of every level the triangles that happen to lie well. No
//! surface comes near the second.

use cullet::lod::PixelScale;
use cullet_draw::surface::SurfacePoint;
use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::surface_points;
use serde::Serialize;

use super::kept::{EYES, RADII};
use super::models::{Whole, apart, directions};
use super::plain::simplify;

/// Each level has so many of the triangles of the one before.
const STEP: f64 = 0.7;
/// Points of the surface, for each of its triangles; and points of each triangle of a level.
const POINTS: usize = 3;
const POINTS_BACK: usize = 2;
/// The coarsest level has more triangles than this.
const LEAST: usize = 50;

/// At one distance.
#[derive(Clone, Debug, Serialize)]
pub(super) struct IdealRow {
    pub(super) radii: f64,
    /// Triangles by the errors of levels, in the mean of the eyes.
    pub(super) triangles: f64,
    /// Triangles by the errors of each level's triangles.
    pub(super) by_place: f64,
}

/// Levels with the measured error of each of their triangles.
pub(super) struct Ideal<'a> {
    whole: &'a Whole,
    points: Vec<[f32; 3]>,
    /// From the original up.
    levels: Vec<Level>,
}

/// One level.
struct Level {
    /// The triangle of each point, the nearest.
    triangle: Vec<u32>,
    /// How far it is off at most.
    whole: f32,
    /// Largest distance of the points of each triangle, and the points of which it is the nearest.
    error: Vec<f32>,
    /// How many of those there are.
    points: Vec<u32>,
}

impl<'a> Ideal<'a> {
    /// Makes the levels, each from the original, and measures them both ways. Stops early where
    /// `go_on` says so.
    pub(super) fn new(
        whole: &'a Whole,
        mut go_on: impl FnMut() -> bool,
    ) -> Result<Self, meshopt::Error> {
        const SEED: u64 = 0x0069_6465_616c;
        let (positions, indices) = (&whole.positions, &whole.indices);
        let mut sampled = surface_points(positions, indices, whole.triangles() * POINTS, SEED);
        // The middle of each as well: by area alone, of the castle's 139,619 triangles 11,913 had a
        // point.
        sampled.extend((0..).zip(indices.as_chunks().0).map(|(triangle, corners)| {
            let [a, b, c] = corners.map(|v: u32| positions[v as usize]);
            SurfacePoint { point: [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0), triangle }
        }));
        let original = SurfaceTree::new(positions, indices);
        let mut first = Level::new(whole.triangles(), sampled.len());
        sampled.iter().for_each(|p| first.add(p.triangle, 0.0));
        let points = sampled.into_iter().map(|p| p.point).collect();
        let mut made = Self { whole, points, levels: vec![first] };
        let mut triangles = whole.triangles();
        while triangles > LEAST && go_on() {
            triangles = (triangles as f64 * STEP) as usize;
            let coarse = simplify(positions, indices, triangles)?;
            let count = coarse.len() / 3;
            let tree = SurfaceTree::new(positions, &coarse);
            let mut level = Level::new(count, made.points.len());
            for &point in &made.points {
                // Nothing is left, or nothing that is finite: no place can be drawn so.
                let Some((off, nearest)) = tree.nearest(point, f32::INFINITY) else {
                    return Ok(made);
                };
                level.add(nearest, off);
                level.whole = level.whole.max(off);
            }
            for p in surface_points(positions, &coarse, count * POINTS_BACK, SEED ^ 1) {
                let off = original.nearest(p.point, f32::INFINITY).map_or(f32::INFINITY, |n| n.0);
                let error = &mut level.error[p.triangle as usize];
                *error = error.max(off);
                level.whole = level.whole.max(off);
            }
            made.levels.push(level);
            // The simplifier gets no further.
            if count > triangles * 3 / 2 {
                break;
            }
        }
        Ok(made)
    }

    /// A row for each distance.
    pub(super) fn rows(&self) -> Vec<IdealRow> {
        let row = |&radii: &f64| {
            let eyes = directions(EYES).map(|direction| self.whole.seen(direction, radii));
            let mut row = IdealRow { radii, triangles: 0.0, by_place: 0.0 };
            for view in eyes {
                row.triangles += self.triangles(&view, |level, _| level.whole) / f64::from(EYES);
                let own = |level: &Level, at: usize| level.error[level.triangle[at] as usize];
                row.by_place += self.triangles(&view, own) / f64::from(EYES);
            }
            row
        };
        RADII.iter().map(row).collect()
    }

    /// Triangles at one pixel: of each that share of which its points are drawn at its level.
    /// `error` is that of a level at a point.
    fn triangles(&self, view: &PixelScale, error: impl Fn(&Level, usize) -> f32) -> f64 {
        let eye = view.eye.unwrap_or_default();
        let mut sum = 0.0;
        for (at, p) in self.points.iter().enumerate() {
            let pixel = apart(p.map(f64::from), eye).max(view.near) / view.pixels;
            let within = |level: &&Level| f64::from(error(level, at)) <= pixel;
            // The original is within any bound.
            if let Some(level) = self.levels.iter().rev().find(within) {
                sum += 1.0 / f64::from(level.points[level.triangle[at] as usize]);
            }
        }
        sum
    }
}

impl Level {
    fn new(triangles: usize, points: usize) -> Self {
        Self {
            triangle: Vec::with_capacity(points),
            whole: 0.0,
            error: vec![0.0; triangles],
            points: vec![0; triangles],
        }
    }

    /// The next point: its nearest triangle, and how far off that is.
    fn add(&mut self, triangle: u32, off: f32) {
        let t = triangle as usize;
        self.triangle.push(triangle);
        self.error[t] = self.error[t].max(off);
        self.points[t] += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_square_takes_two_triangles_and_a_ball_more_the_nearer_it_is() {
        // 40 x 40 squares of two triangles each.
        let n = 40_u32;
        let at = |i: u32| [(i % (n + 1)) as f32, (i / (n + 1)) as f32, 0.0];
        let positions: Vec<[f32; 3]> = (0..(n + 1) * (n + 1)).map(at).collect();
        let square = |s: u32| {
            let a = s / n * (n + 1) + s % n;
            [a, a + 1, a + n + 2, a, a + n + 2, a + n + 1]
        };
        let corners: Vec<u32> = (0..n * n).flat_map(square).collect();
        let flat = Whole::of("flat".to_owned(), positions, &corners);
        let ideal = Ideal::new(&flat, || true).unwrap();
        for row in ideal.rows() {
            assert!(row.triangles < f64::from(n * n) * 0.1, "{row:?}");
            assert!(row.by_place <= row.triangles * 1.001, "{row:?}");
        }
        let (positions, indices) = cullet_testkit::soups::ball(48, 96);
        let ball = Whole::of("ball".to_owned(), positions, &indices);
        let rows = Ideal::new(&ball, || true).unwrap().rows();
        assert!(rows.is_sorted_by(|a, b| a.triangles >= b.triangles), "{rows:?}");
        let all = ball.triangles() as f64;
        assert!(rows[0].triangles > all * 0.2 && rows[0].triangles <= all, "{rows:?}");
        assert!(rows[5].triangles < all * 0.1, "{rows:?}");
    }
}
