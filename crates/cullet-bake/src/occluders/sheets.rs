//! Triangles of the mesh itself, where neither boxes nor polygons stand for them: slopes, round
//! walls, open shells.

use glam::DVec3;

use super::surface::{Surface, Triangle, normal};
use super::{OccluderPolygon, OccluderSheet};

/// A triangle of which boxes hide all but this share is left to them.
const LEAST_OPEN: f64 = 0.05;
/// Polygons do alone where they leave less than this share of what boxes leave: they are cheaper
/// than triangles.
const LEFT_BY_POLYGONS: f64 = 0.05;
/// Where not all triangles fit, one must have this part of what a polygon must add: smaller ones
/// hide little once their edges are drawn in.
const SMALLEST: f64 = 1.0 / 16.0;

/// Triangles that were chosen.
#[derive(Debug, Default)]
pub(super) struct Chosen {
    pub(super) sheets: Vec<OccluderSheet>,
    /// The share of the surface's area that they show where nothing stands for it.
    pub(super) gain: f64,
    /// Whether they show all that boxes leave, so that polygons add nothing.
    pub(super) all: bool,
}

/// A triangle, and the area of it that nothing stands for.
type Open = (u32, f64);

/// Triangles of the surface, at most `most`: all that boxes leave, if they are so few and polygons
/// do not do; else the largest that neither leaves.
pub(super) fn sheets(
    surface: &Surface,
    polygons: &[OccluderPolygon],
    most: usize,
    min_gain: f64,
    backed: impl Fn(DVec3, DVec3) -> bool,
) -> Chosen {
    let area = surface.area();
    if most == 0 || area <= 0.0 {
        return Chosen::default();
    }
    let planes: Vec<Plane> =
        polygons.iter().filter(|p| p.tolerance == 0.0).filter_map(Plane::new).collect();
    let near = surface.reach * f64::from(f32::EPSILON) * 4.0;
    // Triangles that boxes leave open, and of those the ones that polygons leave open.
    let (mut left, mut bare): (Vec<Open>, Vec<Open>) = (Vec::new(), Vec::new());
    for (number, triangle) in (0u32..).zip(&surface.triangles) {
        let corners = surface.corners(triangle);
        let across = normal(&corners);
        let whole = across.length() * 0.5;
        let Some(facing) = across.try_normalize() else { continue };
        let (mut boxes, mut both) = (0, 0);
        for p in spread(&corners) {
            if !backed(p, facing) {
                boxes += 1;
                both += u32::from(!planes.iter().any(|q| q.covers(p, facing, triangle, near)));
            }
        }
        let share = |count: u32| f64::from(count) / POINTS as f64;
        if share(boxes) > LEAST_OPEN {
            left.push((number, whole * share(boxes)));
        }
        if share(both) > LEAST_OPEN {
            bare.push((number, whole * share(both)));
        }
    }
    let sum = |of: &[Open]| of.iter().map(|o| o.1).sum::<f64>();
    let (uncovered, open) = (sum(&bare), sum(&left));
    if uncovered < min_gain * area || uncovered < LEFT_BY_POLYGONS * open {
        return Chosen::default();
    }
    if left.len() <= most {
        // Side by side with polygons they would leave a seam.
        return Chosen { sheets: gather(surface, &left), gain: open / area, all: true };
    }
    bare.retain(|o| o.1 >= min_gain * SMALLEST * area);
    bare.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    bare.truncate(most);
    let gain = sum(&bare) / area;
    if gain < min_gain {
        return Chosen::default();
    }
    bare.sort_by_key(|o| o.0);
    Chosen { sheets: gather(surface, &bare), gain, all: false }
}

fn gather(surface: &Surface, chosen: &[Open]) -> Vec<OccluderSheet> {
    let of = |two_sided: bool| OccluderSheet {
        triangles: chosen
            .iter()
            .map(|&(t, _)| &surface.triangles[t as usize])
            .filter(|t| t.two_sided == two_sided)
            // Made of f32, and not computed with since.
            .map(|t| surface.corners(t).map(|p| p.to_array().map(|v| v as f32)))
            .collect(),
        two_sided,
    };
    [of(false), of(true)].into_iter().filter(|s| !s.triangles.is_empty()).collect()
}

/// Points by which a triangle is judged.
const POINTS: usize = 16;

/// The middles of the sixteen parts that quarters of its sides cut a triangle into.
fn spread(&[a, b, c]: &[DVec3; 3]) -> impl Iterator<Item = DVec3> {
    let at = move |s: f64, t: f64| a + (b - a) * (s / 12.0) + (c - a) * (t / 12.0);
    let upright = (0..4).flat_map(move |i| (0..4 - i).map(move |k| (3 * i + 1, 3 * k + 1)));
    let turned = (0..3).flat_map(move |i| (0..3 - i).map(move |k| (3 * i + 2, 3 * k + 2)));
    upright.chain(turned).map(move |(s, t)| at(f64::from(s), f64::from(t)))
}

/// A polygon, to test what it covers.
#[derive(Debug)]
struct Plane {
    points: Vec<DVec3>,
    normal: DVec3,
    two_sided: bool,
}

impl Plane {
    fn new(polygon: &OccluderPolygon) -> Option<Self> {
        let points: Vec<DVec3> =
            polygon.points.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
        let &first = points.first()?;
        let normal: DVec3 =
            points.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum::<DVec3>();
        Some(Self { normal: normal.try_normalize()?, points, two_sided: polygon.two_sided })
    }

    /// Whether a point of a triangle is within the polygon, and blocked by it as by the triangle.
    fn covers(&self, p: DVec3, facing: DVec3, triangle: &Triangle, near: f64) -> bool {
        let along = facing.dot(self.normal);
        let n = self.points.len();
        self.two_sided == triangle.two_sided
            && (along > 0.99 || self.two_sided && along < -0.99)
            && (p - self.points[0]).dot(self.normal).abs() <= near
            && (0..n).all(|i| {
                let (a, b) = (self.points[i], self.points[(i + 1) % n]);
                (b - a).cross(p - a).dot(self.normal) >= 0.0
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_points_are_spread_over_a_triangle() {
        let t = [DVec3::ZERO, DVec3::X * 12.0, DVec3::Y * 12.0];
        let points: Vec<DVec3> = spread(&t).collect();
        assert_eq!(points.len(), POINTS);
        assert!(points.iter().all(|p| p.x > 0.0 && p.y > 0.0 && p.x + p.y < 12.0));
        let middle = points.iter().sum::<DVec3>() / POINTS as f64;
        assert!((middle - DVec3::new(4.0, 4.0, 0.0)).length() < 1e-9, "{middle}");
    }
}
