//! Common parts of the apex bounds: an axis, an apex, and the normals projected along the axis.

use alloc::vec::Vec;

use glam::{DVec2, DVec3};

use crate::array::Each;
use crate::exact::is_collinear;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::sort::{of_f64, sort_by_key};

/// The planes of a cluster's triangles. Triangles without area, and slivers whose normal is not
/// certain, have none: see [`ClusterPlanes::is_complete`].
#[derive(Clone, Debug, Default)]
pub struct ClusterPlanes {
    normals: Vec<DVec3>,
    offsets: Vec<f64>,
    /// Half of what coordinates span, by axis and as a diagonal, and the largest of them: what
    /// rounding is relative to.
    half: DVec3,
    radius: f64,
    largest: f64,
    centre: DVec3,
    complete: bool,
}

/// A triangle whose area is below this share of the product of its edges has a normal too
/// uncertain: the rounding of its cross product, at most 4 × 2⁻⁵³ of that product, turns it by up
/// to 4.5e-7.
const SLIVER: f64 = 1e-9;

impl ClusterPlanes {
    /// The largest coordinate of a cluster or an eye that has bounds: the squares of what their
    /// tests add up stay below 3e38.
    pub const LARGEST: f64 = 1e14;
    /// The smallest [`radius`](Self::radius) of a cluster that has bounds: far above the smallest
    /// number of f32.
    pub const SMALLEST: f64 = 1e-30;

    /// The planes of triangles given by their corners, counter-clockwise fronts. Triangles of no
    /// area at all are left out.
    pub fn new(triangles: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Self {
        let mut planes = Self { complete: true, ..Self::default() };
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corners in triangles {
            let [a, b, c] = corners.each(|p| DVec3::from(p.each(f64::from)));
            let (u, v) = (b - a, c - a);
            let n = u.cross(v);
            // A product that rounds to zero is no proof of having no area.
            if n == DVec3::ZERO && is_collinear(&corners) {
                continue;
            }
            for p in [a, b, c] {
                (low, high) = (low.min(p), high.max(p));
            }
            if n.length() > u.length() * v.length() * SLIVER {
                let n = n.normalize();
                planes.normals.push(n);
                // The corner farthest behind, so that rounding of the normal leaves all on the
                // plane's back.
                planes.offsets.push(n.dot(a).min(n.dot(b)).min(n.dot(c)));
            } else {
                planes.complete = false;
            }
        }
        if !planes.normals.is_empty() {
            planes.set_extent(low, high);
        }
        planes
    }

    /// Planes that are not those of triangles, as (n, d) with unit n, of a surface within a box;
    /// `complete` says whether what is behind them all is behind the surface.
    pub fn of_planes(
        planes: impl IntoIterator<Item = ([f64; 3], f64)>,
        [low, high]: [[f64; 3]; 2],
        complete: bool,
    ) -> Self {
        let (normals, offsets) = planes.into_iter().map(|(n, d)| (DVec3::from(n), d)).unzip();
        let mut planes = Self { normals, offsets, complete, ..Self::default() };
        if !planes.normals.is_empty() {
            planes.set_extent(low.into(), high.into());
        }
        planes
    }

    fn set_extent(&mut self, low: DVec3, high: DVec3) {
        self.centre = (low + high) * 0.5;
        self.half = (high - low) * 0.5;
        self.radius = self.half.length();
        self.largest = low.abs().max(high.abs()).max_element();
    }

    /// How many planes there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.normals.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.normals.is_empty()
    }

    /// Whether every triangle with an area has its plane here. If not, no eye is proved behind them
    /// all.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// The same planes seen from the other side.
    #[must_use]
    pub fn flipped(&self) -> Self {
        Self {
            normals: self.normals.iter().map(|n| -n).collect(),
            offsets: self.offsets.iter().map(|d| -d).collect(),
            ..self.clone()
        }
    }

    /// The ideal test, and the oracle of all others: whether the homogeneous eye is behind every
    /// plane, by more than f64 rounding. False for a negative weight and for what is not finite.
    #[must_use]
    pub fn is_behind(&self, eye: [f64; 4]) -> bool {
        let e = DVec3::new(eye[0], eye[1], eye[2]);
        let tolerance = (e.length() + self.largest * eye[3]) * 1e-14;
        // Written so that NaN is not behind.
        eye[3] >= 0.0 && self.height(eye) < -tolerance
    }

    /// How far the eye is in front of the farthest plane it is in front of, in the cluster's units;
    /// negative behind all of them. Infinite where no eye is proved behind. In plain f64.
    ///
    /// For a position it changes by no more than the position does.
    #[must_use]
    pub fn height(&self, eye: [f64; 4]) -> f64 {
        if !self.complete || self.is_empty() {
            return f64::INFINITY;
        }
        let e = DVec3::new(eye[0], eye[1], eye[2]);
        self.normals
            .iter()
            .zip(&self.offsets)
            .map(|(n, d)| n.dot(e) - d * eye[3])
            // f64::max would lose a NaN.
            .fold(f64::NEG_INFINITY, |a, b| if b <= a { a } else { b })
    }

    /// The half-spaces n·x ≤ d behind the planes, as (n, d) with unit n; their intersection holds
    /// every eye that sees all triangles from behind.
    pub fn half_spaces(&self) -> impl Iterator<Item = ([f64; 3], f64)> {
        self.normals.iter().zip(&self.offsets).map(|(n, d)| ((*n).into(), *d))
    }

    /// The middle of the triangles' box.
    #[must_use]
    pub fn centre(&self) -> [f64; 3] {
        self.centre.into()
    }

    /// Half the diagonal of the triangles' box: no corner is farther from the middle.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Half of what the triangles' box spans along each axis.
    #[must_use]
    pub fn half_extent(&self) -> [f64; 3] {
        self.half.into()
    }

    /// The largest coordinate, without its sign.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// Whether a bound can be made: a plane for each triangle, of a size that f32 can square.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        // Written so that NaN is refused.
        self.complete
            && !self.is_empty()
            && self.largest <= Self::LARGEST
            && self.radius >= Self::SMALLEST
    }

    /// How far a point may be wrongly called behind a plane for all reasons but the rounding of the
    /// test itself: that point's and the eye's coordinates as f32, and a normal that a thin
    /// triangle leaves uncertain by up to 4.5e-7 radians.
    #[must_use]
    pub fn slack(&self, point: [f64; 3]) -> f64 {
        let point = DVec3::from(point);
        let size = point.abs().max_element() + self.largest;
        let reach = self.radius + point.distance(self.centre);
        size * f64::from(f32::EPSILON) * 2.0 + reach * 1e-6
    }

    /// The unit axis of the narrowest cone around the normals, nearly; `None` where they span half
    /// of space or nearly so (4.6 degrees less), and for no normals.
    #[must_use]
    pub fn axis(&self) -> Option<[f64; 3]> {
        narrowest_cone_axis(&self.normals).map(Into::into)
    }

    /// Input that a cone or a pyramid is fitted to: an apex that stays behind all planes though
    /// they turn by `doubt` radians around the nearest point of the cluster's ball, and the normals
    /// around their axis.
    ///
    /// `None` where the planes are not [usable](Self::is_usable), have no [axis](Self::axis), or no
    /// point within 16 radii that is behind them all.
    #[must_use]
    pub fn apex(&self, doubt: f64) -> Option<Apex> {
        if !self.is_usable() {
            return None;
        }
        let axis = narrowest_cone_axis(&self.normals)?;
        let u = axis.any_orthonormal_vector();
        let across = [u, axis.cross(u)];
        let points: Vec<DVec2> = self
            .normals
            .iter()
            .map(|n| DVec2::new(n.dot(across[0]), n.dot(across[1])) / n.dot(axis))
            .collect();
        let highest = highest_behind(self, axis, self.radius * APEX_REACH)?;
        // Along the axis a step of 1 is one of n·axis along a normal.
        let longest = (points.iter().map(|p| p.length_squared()).fold(0.0, f64::max) + 1.0).sqrt();
        let slack =
            self.slack(highest.into()) + doubt * (self.radius + highest.distance(self.centre));
        let point = highest - axis * (slack * longest);
        let hull = convex_hull(points).into_iter().map(Into::into).collect();
        Some(Apex { axis: axis.into(), across: across.each(Into::into), point: point.into(), hull })
    }
}

/// An apex behind all planes of a cluster, and their normals projected to the plane at distance 1
/// along an axis: what every cone and pyramid with an apex is fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct Apex {
    /// The unit axis; every normal has a positive part along it.
    pub axis: [f64; 3],
    /// Two unit directions across it.
    pub across: [[f64; 3]; 2],
    /// Behind every plane, by the slack that it and the eye need as f32.
    pub point: [f64; 3],
    /// The corners of the convex hull of the projected normals, counter-clockwise, along `across`.
    pub hull: Vec<[f64; 2]>,
}

impl Apex {
    /// The normal, not of unit length, of a point of the plane at distance 1 along the axis.
    #[must_use]
    pub fn lift(&self, p: [f64; 2]) -> [f64; 3] {
        let [u, v] = self.across.each(DVec3::from);
        (DVec3::from(self.axis) + u * p[0] + v * p[1]).into()
    }

    /// Fits the hull around squares of side `2 * by` instead of points. `by` must not be negative.
    #[must_use]
    pub fn widened(&self, by: f64) -> Self {
        let corners = [[by, by], [-by, by], [-by, -by], [by, -by]].each(DVec2::from);
        let moved = |p: &[f64; 2]| corners.each(|c| DVec2::from(*p) + c);
        let hull = convex_hull(self.hull.iter().flat_map(moved).collect());
        Self { hull: hull.into_iter().map(Into::into).collect(), ..self.clone() }
    }
}

/// How far from a cluster's middle its apex may be, in radii: parallel planes have no highest
/// point.
const APEX_REACH: f64 = 16.0;
/// Normals must be at least this far from the equator: 4.6 degrees. Wider clusters have hardly a
/// region.
const NARROWEST: f64 = 0.08;

/// Steps towards the axis: the last one moves it by a fiftieth of the cone.
const AXIS_STEPS: u32 = 50;

/// The axis of the narrowest cone around unit normals; `None` where they do not fit into an open
/// hemisphere by [`NARROWEST`].
///
/// Up to a hemisphere it is the direction of the centre of the smallest ball around them (here by
/// the core-set iteration of Bădoiu & Clarkson, *Smaller Core-Sets for Balls*, 2003: the centre
/// moves towards the farthest point by ever smaller steps). Any axis is right; a better one is
/// tighter.
fn narrowest_cone_axis(normals: &[DVec3]) -> Option<DVec3> {
    let mut centre = normals.iter().sum::<DVec3>() / normals.len() as f64;
    for step in 1..=AXIS_STEPS {
        // The farthest of unit vectors is the one with the least product.
        let mut far = (f64::INFINITY, centre);
        for n in normals {
            let along = n.dot(centre);
            if along < far.0 {
                far = (along, *n);
            }
        }
        centre += (far.1 - centre) / f64::from(step + 1);
    }
    let axis = centre.try_normalize()?;
    normals.iter().all(|n| n.dot(axis) > NARROWEST).then_some(axis)
}

/// The point that is highest along `axis` among those behind all planes and within `reach` of the
/// cluster's middle: a linear programme of three variables, by adding one plane after the other
/// (Seidel, *Small-dimensional linear programming and convex hulls made easy*, 1991).
fn highest_behind(planes: &ClusterPlanes, axis: DVec3, reach: f64) -> Option<DVec3> {
    // In coordinates around the middle, in units of the reach: the box is ±1.
    let rows: Vec<(DVec3, f64)> = planes
        .normals
        .iter()
        .zip(&planes.offsets)
        .map(|(n, d)| (*n, (d - n.dot(planes.centre)) / reach))
        .collect();
    let mut best = DVec3::new(axis.x.signum(), axis.y.signum(), axis.z.signum());
    for i in 0..rows.len() {
        let (n, d) = rows[i];
        if n.dot(best) > d + 1e-12 {
            best = on_plane(&rows[..i], n, d, axis)?;
        }
    }
    let q = planes.centre + best * reach;
    // Checked, and lowered by what rounding left above a plane.
    let above = planes
        .normals
        .iter()
        .zip(&planes.offsets)
        .map(|(n, d)| (n.dot(q) - d) / n.dot(axis))
        .fold(0.0, f64::max);
    (above <= reach * 1e-6).then(|| q - axis * (above + reach * 1e-12))
}

/// The highest point along `axis` on the plane (n, d), behind `rows` and in the box ±1.
fn on_plane(rows: &[(DVec3, f64)], n: DVec3, d: f64, axis: DVec3) -> Option<DVec3> {
    let (u, v) = n.any_orthonormal_pair();
    let origin = n * d;
    let mut walls: Vec<(DVec2, f64)> = Vec::with_capacity(rows.len() + 6);
    for k in 0..3 {
        for sign in [1.0, -1.0] {
            let side = DVec3::AXES[k] * sign;
            walls.push((DVec2::new(side.dot(u), side.dot(v)), 1.0 - side.dot(origin)));
        }
    }
    walls.extend(rows.iter().map(|(m, e)| (DVec2::new(m.dot(u), m.dot(v)), e - m.dot(origin))));
    let goal = DVec2::new(axis.dot(u), axis.dot(v));
    // A point that satisfies no wall yet: far along the goal, to be pulled back by each.
    let mut best = goal.normalize_or(DVec2::X) * 4.0;
    for i in 0..walls.len() {
        let (m, e) = walls[i];
        if m.dot(best) <= e + 1e-12 {
            continue;
        }
        let length = m.length_squared();
        if length < 1e-24 {
            return None;
        }
        // Along the line m·x = e, between the walls so far.
        let (foot, along) = (m * (e / length), m.perp() / length.sqrt());
        let (mut low, mut high) = (-8.0, 8.0);
        for (k, f) in &walls[..i] {
            let (rate, room) = (k.dot(along), f - k.dot(foot));
            if rate > 1e-12 {
                high = f64::min(high, room / rate);
            } else if rate < -1e-12 {
                low = f64::max(low, room / rate);
            } else if room < -1e-9 {
                return None;
            }
        }
        if low > high + 1e-9 {
            return None;
        }
        best = foot + along * if goal.dot(along) > 0.0 { high } else { low };
    }
    Some(origin + u * best.x + v * best.y)
}

/// The corners of the convex hull, counter-clockwise (Andrew, *Another efficient algorithm for
/// convex hulls in two dimensions*, 1979).
fn convex_hull(points: Vec<DVec2>) -> Vec<DVec2> {
    // total_cmp puts −0 before 0, which no product of differences would agree with: points between
    // two ends of one x were lost.
    let mut sorted: Vec<DVec2> = points.into_iter().map(|p| p + DVec2::ZERO).collect();
    sort_by_key(&mut sorted, |p| of_f64(p.y).into());
    sort_by_key(&mut sorted, |p| of_f64(p.x).into());
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull: Vec<DVec2> = Vec::with_capacity(sorted.len() + 1);
    for pass in 0..2 {
        let base = hull.len();
        for i in 0..sorted.len() {
            let p = if pass == 0 { sorted[i] } else { sorted[sorted.len() - 1 - i] };
            while hull.len() >= base + 2 {
                let (a, b) = (hull[hull.len() - 2], hull[hull.len() - 1]);
                if (b - a).perp_dot(p - b) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guards against a past fault: one of the two faces at an edge was lost where the x of their
    /// normals were zeros of both signs.
    #[test]
    fn zeros_of_both_signs_are_one() {
        let points = [[-0.0, 1.0], [0.0, -1.0], [0.0, 1.0], [-0.0, -1.0], [0.0, 1.5]];
        let hull = convex_hull(points.map(DVec2::from).to_vec());
        assert_eq!(hull, [DVec2::new(0.0, -1.0), DVec2::new(0.0, 1.5)]);
    }
}
