//! Spheres.

use alloc::vec::Vec;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::aabb::round_up;
use super::plane::ROUNDING;
use super::{Aabb, Plane, Side};
use crate::array::Each;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// A ball: all points no farther than `radius` from `center`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Sphere {
    /// The centre.
    pub center: [f32; 3],
    /// The radius; negative means empty.
    pub radius: f32,
}

impl Sphere {
    /// The sphere of nothing: joining it with another gives the other.
    pub const EMPTY: Self = Self { center: [0.0; 3], radius: -1.0 };
    /// The whole of space; what stands for missing or non-finite bounds.
    pub const EVERYTHING: Self = Self { center: [0.0; 3], radius: f32::INFINITY };

    /// The sphere of this centre and radius, taken as they are.
    #[must_use]
    pub const fn new(center: [f32; 3], radius: f32) -> Self {
        Self { center, radius }
    }

    /// A smallest sphere around `points`: every point is in it in exact arithmetic, and the radius
    /// exceeds the least possible only by what rounding the centre and itself to f32 costs.
    ///
    /// No point gives [`Sphere::EMPTY`]; a point that is not finite gives [`Sphere::EVERYTHING`].
    /// O(points) for each of some 5 to 20 passes.
    ///
    /// (Gärtner, *Fast and Robust Smallest Enclosing Balls*, 1999: the farthest point joins the
    /// basis.)
    #[must_use]
    pub fn from_points(points: &[[f32; 3]]) -> Self {
        let b = Aabb::from_points(points);
        if b.is_empty() {
            return Self::EMPTY;
        }
        if !b.is_finite() {
            return Self::EVERYTHING;
        }
        let middle = DVec3::from(b.center());
        // In units of the box: the squares and products below must not overflow.
        let unit = DVec3::from(b.half_extent()).max_element();
        if unit == 0.0 {
            return Self { center: points[0], radius: 0.0 };
        }
        let at = |p: &[f32; 3]| (DVec3::from(p.each(f64::from)) - middle) / unit;
        // Smaller than any ball of a point, which grows it.
        let mut ball = Ball { center: DVec3::ZERO, square: -1.0 };
        let mut basis = Vec::with_capacity(5);
        for _ in 0..MAX_PASSES {
            let (mut far, mut square) = (DVec3::ZERO, -1.0);
            for p in points {
                let p = at(p);
                let s = p.distance_squared(ball.center);
                if s > square {
                    (far, square) = (p, s);
                }
            }
            if square <= ball.square * (1.0 + 1e-9) || basis.contains(&far) {
                break;
            }
            basis.push(far);
            match smallest_of_few(&basis) {
                // The basis of a ball has four points at most; the rest have done their work.
                Some((next, support)) if next.square > ball.square => {
                    (ball, basis) = (next, support);
                }
                _ => break,
            }
        }
        let found = Self::at_center(ball.center * unit + middle, points);
        let simple = Self::at_center(middle, points);
        if found.radius <= simple.radius { found } else { simple }
    }

    /// The sphere around `points` with its centre at `center`, rounded to f32.
    pub(super) fn at_center(center: DVec3, points: &[[f32; 3]]) -> Self {
        let center = center.to_array().each(|v| v as f32);
        let c = DVec3::from(center.each(f64::from));
        let square = points
            .iter()
            .map(|p| DVec3::from(p.each(f64::from)).distance_squared(c))
            .fold(0.0, f64::max);
        Self { center, radius: grown(square.sqrt()) }
    }

    /// Whether there is no point in the sphere.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !self.has_nan() && self.radius < 0.0
    }

    /// Whether all four numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.center.iter().all(|v| v.is_finite()) && self.radius.is_finite()
    }

    pub(crate) fn has_nan(&self) -> bool {
        self.center.iter().any(|v| v.is_nan()) || self.radius.is_nan()
    }

    /// Whether `point` is in the sphere, its surface included, by f64 arithmetic.
    #[must_use]
    pub fn contains(&self, point: [f32; 3]) -> bool {
        let c = DVec3::from(self.center.each(f64::from));
        let r = f64::from(self.radius);
        r >= 0.0 && DVec3::from(point.each(f64::from)).distance_squared(c) <= r * r
    }

    /// The smallest sphere around both, rounded outward; [`Sphere::EVERYTHING`] where either is not
    /// finite.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        if self.has_nan() || other.has_nan() {
            return Self::EVERYTHING;
        }
        if self.is_empty() || other.is_empty() {
            return if self.is_empty() { *other } else { *self };
        }
        if !(self.is_finite() && other.is_finite()) {
            return Self::EVERYTHING;
        }
        let [a, b] = [self, other].each(|s| DVec3::from(s.center.each(f64::from)));
        let [r, s] = [self, other].each(|s| f64::from(s.radius));
        let distance = a.distance(b);
        if distance + s <= r * (1.0 - ROUNDING) {
            return *self;
        }
        if distance + r <= s * (1.0 - ROUNDING) {
            return *other;
        }
        // On the line of the centres, as far from a as half of what sticks out beyond it.
        let t = if distance > 0.0 {
            (0.5 * (distance + s - r) / distance).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let center = (a + (b - a) * t).to_array().each(|v| v as f32);
        let c = DVec3::from(center.each(f64::from));
        Self { center, radius: grown((c.distance(a) + r).max(c.distance(b) + s)) }
    }

    /// The lowest and the highest n·x − d over the sphere, each rounded outward so that the true
    /// values lie between them. The normal need not be of unit length.
    ///
    /// Empty gives `[∞, −∞]`; a number that is NaN, or an infinite one, gives `[−∞, ∞]`.
    #[must_use]
    pub fn span(&self, plane: &Plane) -> [f64; 2] {
        if self.is_empty() {
            return [f64::INFINITY, f64::NEG_INFINITY];
        }
        if !self.is_finite() {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let n = DVec3::from(plane.normal);
        let c = DVec3::from(self.center.each(f64::from));
        let middle = n.dot(c) - plane.d;
        let reach = f64::from(self.radius) * n.length();
        let size = n.abs().dot(c.abs()) + plane.d.abs() + reach;
        let slack = size * ROUNDING + f64::MIN_POSITIVE;
        [middle - reach - slack, middle + reach + slack]
    }

    /// Where the sphere lies: each of the two certain answers is proved, rounding included. Empty
    /// is [`Side::Outside`] (there is nothing to see), NaN or infinite is [`Side::Straddling`].
    #[must_use]
    pub fn side(&self, plane: &Plane) -> Side {
        Side::from_span(self.span(plane))
    }
}

/// Passes over the points before the ball found so far must do. Each pass with a new farthest point
/// grows the ball, and twenty are rare.
const MAX_PASSES: usize = 64;

/// A length that was computed in f64, rounded to an f32 not below the true one.
pub(super) fn grown(length: f64) -> f32 {
    round_up(length * (1.0 + ROUNDING))
}

#[derive(Clone, Copy, Debug)]
struct Ball {
    center: DVec3,
    square: f64,
}

/// The smallest ball of at most five points, and those that lie on it: every subset of up to four
/// is tried. `None` where rounding leaves no ball around all.
fn smallest_of_few(points: &[DVec3]) -> Option<(Ball, Vec<DVec3>)> {
    let mut best: Option<(Ball, u32)> = None;
    for subset in 1..1u32 << points.len() {
        if subset.count_ones() > 4 {
            continue;
        }
        let mut chosen = [DVec3::ZERO; 4];
        let mut count = 0;
        for (i, p) in points.iter().enumerate() {
            if subset >> i & 1 == 1 {
                chosen[count] = *p;
                count += 1;
            }
        }
        let Some(ball) = through(&chosen[..count]) else { continue };
        let holds = |p: &DVec3| p.distance_squared(ball.center) <= ball.square * (1.0 + 1e-10);
        if best.is_none_or(|(b, _)| ball.square < b.square) && points.iter().all(holds) {
            best = Some((ball, subset));
        }
    }
    best.map(|(ball, subset)| {
        let chosen = points.iter().enumerate().filter(|(i, _)| subset >> i & 1 == 1);
        (ball, chosen.map(|(_, p)| *p).collect())
    })
}

/// The smallest ball with all of one to four points on its surface; `None` where they are
/// dependent.
fn through(points: &[DVec3]) -> Option<Ball> {
    let ball = |o: DVec3, to_center: DVec3| Ball {
        center: o + to_center,
        square: to_center.length_squared(),
    };
    let ball = match *points {
        [o] => ball(o, DVec3::ZERO),
        [o, p] => ball(o, (p - o) * 0.5),
        [o, p, q] => {
            let (p, q) = (p - o, q - o);
            let n = p.cross(q);
            let to = (n.cross(p) * q.length_squared() + q.cross(n) * p.length_squared())
                / (2.0 * n.length_squared());
            ball(o, to)
        }
        [o, p, q, r] => {
            let (p, q, r) = (p - o, q - o, r - o);
            let to = (q.cross(r) * p.length_squared()
                + r.cross(p) * q.length_squared()
                + p.cross(q) * r.length_squared())
                / (2.0 * p.dot(q.cross(r)));
            ball(o, to)
        }
        _ => return None,
    };
    (ball.center.is_finite() && ball.square.is_finite()).then_some(ball)
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Plane = Plane::new([1.0, 0.0, 0.0], 0.0);

    #[test]
    fn three_answers_and_their_edges() {
        let at = |x: f32| Sphere::new([x, 5.0, 0.0], 1.0).side(&X);
        assert_eq!(at(2.0), Side::Outside);
        assert_eq!(at(-2.0), Side::Inside);
        assert_eq!(at(0.5), Side::Straddling);
        assert_eq!(at(1.0), Side::Straddling, "touching is kept");
        assert_eq!(at(1.000_001), Side::Outside);
    }

    #[test]
    fn empty_nan_and_infinite_spheres() {
        assert_eq!(Sphere::EMPTY.side(&X), Side::Outside);
        assert_eq!(Sphere::EVERYTHING.side(&X), Side::Straddling);
        assert_eq!(Sphere::new([9.0, f32::NAN, 0.0], 1.0).side(&X), Side::Straddling);
        assert_eq!(Sphere::new([9.0; 3], f32::NAN).side(&X), Side::Straddling);
        assert_eq!(Sphere::from_points(&[]), Sphere::EMPTY);
        assert_eq!(Sphere::from_points(&[[f32::NAN, 0.0, 0.0]]), Sphere::EVERYTHING);
        assert_eq!(Sphere::from_points(&[[3.0, 4.0, 5.0]; 3]), Sphere::new([3.0, 4.0, 5.0], 0.0));
    }

    #[test]
    fn a_normal_need_not_be_of_unit_length() {
        let s = Sphere::new([3.0, 0.0, 0.0], 1.0);
        let [low, high] = s.span(&Plane::new([10.0, 0.0, 0.0], 10.0));
        assert!((low - 10.0).abs() < 1e-12 && (high - 30.0).abs() < 1e-12);
    }

    #[test]
    fn known_smallest_spheres() {
        // A regular tetrahedron, a cube, and a right triangle, whose ball has two points on it.
        let t = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let s = Sphere::from_points(&t);
        assert!((f64::from(s.radius) - 3f64.sqrt()).abs() < 1e-6, "{s:?}");
        let cube = Aabb::new([0.0; 3], [2.0; 3]).corners();
        let s = Sphere::from_points(&cube);
        assert!((f64::from(s.radius) - 3f64.sqrt()).abs() < 1e-6, "{s:?}");
        let s = Sphere::from_points(&[[0.0; 3], [6.0, 0.0, 0.0], [0.0, 8.0, 0.0], [1.0, 1.0, 0.0]]);
        assert!((s.radius - 5.0).abs() < 1e-5 && s.center == [3.0, 4.0, 0.0], "{s:?}");
    }

    #[test]
    fn a_sphere_in_another_joins_to_the_outer() {
        let outer = Sphere::new([0.0; 3], 5.0);
        let inner = Sphere::new([1.0, 0.0, 0.0], 1.0);
        assert_eq!(outer.union(&inner), outer);
        assert_eq!(inner.union(&outer), outer);
        assert_eq!(Sphere::EMPTY.union(&inner), inner);
        assert_eq!(inner.union(&Sphere::EVERYTHING), Sphere::EVERYTHING);
    }
}
