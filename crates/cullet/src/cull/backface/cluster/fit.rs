//! What the apex bounds have in common: an axis, an apex, and the normals projected along the axis.

use glam::{DVec2, DVec3};

use super::NoRegion;
use super::pyramid::convex_hull;
use crate::exact::is_collinear;

/// The planes of a cluster's triangles. Triangles without area, and slivers whose normal is not
/// certain, have none: see [`ClusterPlanes::is_complete`].
#[derive(Clone, Debug, Default)]
pub struct ClusterPlanes {
    normals: Vec<DVec3>,
    offsets: Vec<f64>,
    /// Half of what coordinates span, by axis and as a diagonal, and the largest of them: what rounding
    /// is relative to.
    pub(super) half: DVec3,
    radius: f64,
    largest: f64,
    centre: DVec3,
    complete: bool,
}

/// A triangle whose area is below this share of the product of its edges has a normal too uncertain:
/// the rounding of its cross product, at most 4 × 2⁻⁵³ of that product, turns it by up to 4.5e-7.
const SLIVER: f64 = 1e-9;
/// The largest coordinate of an eye or a cluster: the squares of what the tests add up stay below 3e38.
pub(super) const LARGEST: f64 = 1e14;
/// The smallest cluster: far above the smallest number of f32.
const SMALLEST: f64 = 1e-30;

impl ClusterPlanes {
    /// The planes of triangles given by their corners, counter-clockwise fronts. Triangles of no area at
    /// all are left out.
    pub fn new(triangles: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Self {
        let mut planes = Self { complete: true, ..Self::default() };
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corners in triangles {
            let [a, b, c] = corners.map(|p| DVec3::from(p.map(f64::from)));
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
                // The corner farthest behind, so that rounding of the normal leaves all on the plane's
                // back.
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

    /// Planes with unit normals that are not those of triangles, of a surface within a box; `complete`
    /// says whether what is behind them all is behind the surface.
    pub(in crate::cull::backface) fn of_surface(
        planes: impl IntoIterator<Item = (DVec3, f64)>,
        [low, high]: [DVec3; 2],
        complete: bool,
    ) -> Self {
        let (normals, offsets): (Vec<_>, Vec<_>) = planes.into_iter().unzip();
        let mut planes = Self { normals, offsets, complete, ..Self::default() };
        planes.set_extent(low, high);
        planes
    }

    fn set_extent(&mut self, low: DVec3, high: DVec3) {
        self.centre = (low + high) * 0.5;
        self.half = (high - low) * 0.5;
        self.radius = self.half.length();
        self.largest = low.abs().max(high.abs()).max_element();
    }

    /// The planes of several clusters as those of one: what a bound of a group of clusters is fitted to.
    #[must_use]
    pub fn join<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut all = Self { complete: true, ..Self::default() };
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for part in parts {
            all.complete &= part.complete;
            if part.is_empty() {
                continue;
            }
            all.normals.extend(&part.normals);
            all.offsets.extend(&part.offsets);
            low = low.min(part.centre - part.half);
            high = high.max(part.centre + part.half);
            all.largest = all.largest.max(part.largest);
        }
        if !all.normals.is_empty() {
            all.centre = (low + high) * 0.5;
            // The corners of each part are known from its middle, give or take the rounding of a sum.
            all.half = (high - low) * 0.5 + all.largest * (4.0 * f64::EPSILON);
            all.radius = all.half.length();
        }
        all
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

    /// Whether every triangle with an area has its plane here. If not, no eye is proved behind them all.
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

    /// The ideal test, and the oracle of all others: whether the homogeneous eye is behind every plane,
    /// by more than f64 rounding. False for a negative weight and for what is not finite.
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

    /// The half-spaces n·x ≤ d behind the planes, as (n, d) with unit n; their intersection holds every
    /// eye that sees all triangles from behind.
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

    /// The planes as unit normals and their distance from a point.
    pub(super) fn around(&self, origin: DVec3) -> impl Iterator<Item = (DVec3, f64)> {
        self.normals.iter().zip(&self.offsets).map(move |(n, d)| (*n, d - n.dot(origin)))
    }

    /// Whether an apex bound (a cone or a pyramid) of these planes has a region, or the reason why no
    /// eye is proved behind them all. Costs as a fit without its shape; the bounds
    /// themselves say no more than `None`.
    ///
    /// A box of normals ([`NormalBox`](super::NormalBox)) needs no apex, and may have a region where
    /// this is [`NoRegion::Hemisphere`] or [`NoRegion::NoApex`].
    ///
    /// # Errors
    /// The reason.
    pub fn region(&self) -> Result<(), NoRegion> {
        ApexFit::new(self).map(|_| ())
    }

    /// Whether a bound can be made: a plane for each triangle, of a size that f32 can square.
    pub(super) fn usable(&self) -> Result<(), NoRegion> {
        // Where all triangles are in doubt, that is what is amiss.
        if !self.complete {
            Err(NoRegion::NotCertain)
        } else if self.is_empty() {
            Err(NoRegion::Empty)
        } else if self.largest > LARGEST {
            Err(NoRegion::TooLarge { largest: self.largest, limit: LARGEST })
        } else if self.radius < SMALLEST {
            Err(NoRegion::TooSmall { radius: self.radius, limit: SMALLEST })
        } else {
            Ok(())
        }
    }

    /// How far a point at `distance` from the cluster's middle may be wrongly called behind a plane
    /// for all reasons but the rounding of the test itself: that point's and the eye's coordinates as
    /// f32, and a normal that a thin triangle leaves uncertain by up to 4.5e-7 (see [`SLIVER`]).
    pub(super) fn position_slack(&self, point: DVec3) -> f64 {
        let size = point.abs().max_element() + self.largest;
        let reach = self.radius + point.distance(self.centre);
        size * f64::from(f32::EPSILON) * 2.0 + reach * 1e-6
    }
}

/// An apex behind all planes, and the normals projected to the plane at distance 1 along an axis.
#[derive(Clone, Debug)]
pub(super) struct ApexFit {
    /// The unit axis; every normal has a positive part along it.
    pub axis: DVec3,
    /// Two unit directions across it.
    pub across: [DVec3; 2],
    /// Behind every plane, by the slack that it and the eye need as f32.
    pub apex: DVec3,
    /// The corners of the hull of the projected normals, counter-clockwise.
    pub hull: Vec<DVec2>,
}

/// What is added to every shape, as an angle or relative to its size. It covers the rounding of the
/// bound's numbers to f32 (1e-7) and of its test (4e-7), and the normals' own doubt (4.5e-7, see
/// [`SLIVER`]).
pub(super) const ANGULAR_SLACK: f64 = 1e-5;

impl ApexFit {
    pub(super) fn new(planes: &ClusterPlanes) -> Result<Self, NoRegion> {
        Self::doubting(planes, 0.0)
    }

    /// With an apex that stays behind all planes though they turn by `doubt` radians around the nearest
    /// point of the cluster's ball.
    pub(super) fn doubting(planes: &ClusterPlanes, doubt: f64) -> Result<Self, NoRegion> {
        planes.usable()?;
        let axis = narrowest_cone_axis(&planes.normals).ok_or(NoRegion::Hemisphere)?;
        let u = axis.any_orthonormal_vector();
        let across = [u, axis.cross(u)];
        let points: Vec<DVec2> = planes
            .normals
            .iter()
            .map(|n| DVec2::new(n.dot(across[0]), n.dot(across[1])) / n.dot(axis))
            .collect();
        let highest =
            highest_behind(planes, axis, planes.radius * APEX_REACH).ok_or(NoRegion::NoApex)?;
        // Along the axis a step of 1 is one of n·axis along a normal.
        let longest =
            points.iter().map(|p| p.length_squared()).fold(0.0, f64::max).sqrt().hypot(1.0);
        let slack = planes.position_slack(highest)
            + doubt * (planes.radius + highest.distance(planes.centre));
        let apex = highest - axis * (slack * longest);
        Ok(Self { axis, across, apex, hull: convex_hull(&points) })
    }

    /// The point at distance 1 along the axis with these coordinates.
    pub(super) fn lift(&self, p: DVec2) -> DVec3 {
        self.axis + self.across[0] * p.x + self.across[1] * p.y
    }
}

/// How far from a cluster's middle its apex may be, in radii: parallel planes have no highest point.
const APEX_REACH: f64 = 16.0;
/// Normals must be at least this far from the equator: 4.6 degrees. Wider clusters have hardly a region.
const NARROWEST: f64 = 0.08;

/// Steps towards the axis: the last one moves it by a fiftieth of the cone.
const AXIS_STEPS: u32 = 50;

/// The axis of the narrowest cone around unit normals; `None` where they do not fit into an open
/// hemisphere by [`NARROWEST`].
///
/// Up to a hemisphere it is the direction of the centre of the smallest ball around them (here by the
/// core-set iteration of Bădoiu & Clarkson, *Smaller Core-Sets for Balls*, 2003: the centre moves
/// towards the farthest point by ever smaller steps). Any axis is right; a better one is tighter.
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
/// cluster's middle: a linear programme of three variables, by adding one plane after the other (Seidel,
/// *Small-dimensional linear programming and convex hulls made easy*, 1991).
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
