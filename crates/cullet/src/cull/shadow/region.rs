//! The region in which a caster can matter.

use glam::DVec3;

use super::body::{Body, Vertex};
use super::light::{Apex, Light, Reach};
use crate::array::{self, Each};
use crate::bounds::{Aabb, Plane, ROUNDING, unit};
use crate::view::corners;
use crate::view::{Frustum, FrustumPlane};

/// Why a caster cannot matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum CasterReason {
    /// The light lights nothing that the view sees: no caster matters.
    NoReceiver,
    /// It is farther from the light than the light reaches.
    BeyondRange,
    /// It is outside the spot's cone.
    OutsideCone,
    /// It is outside the view that the shadow map is drawn with.
    OutsideMap,
    /// It is outside this plane of [`CasterRegion::frustum`]: its shadow falls beside what the view
    /// sees, or it is behind that, seen from the light. [`u8::MAX`] for an empty box, and where the
    /// parts of a caster are outside different planes.
    OutsideSweep(u8),
}

impl CasterReason {
    const NO_RECEIVER: u8 = 64;
    const BEYOND_RANGE: u8 = 65;
    const OUTSIDE_CONE: u8 = 66;
    const OUTSIDE_MAP: u8 = 67;

    /// A short name, as reports print it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoReceiver => "no-receiver",
            Self::BeyondRange => "beyond-range",
            Self::OutsideCone => "outside-cone",
            Self::OutsideMap => "outside-map",
            Self::OutsideSweep(_) => "outside-sweep",
        }
    }

    /// The reason in one byte.
    pub(crate) const fn detail(self) -> u8 {
        match self {
            Self::NoReceiver => Self::NO_RECEIVER,
            Self::BeyondRange => Self::BEYOND_RANGE,
            Self::OutsideCone => Self::OUTSIDE_CONE,
            Self::OutsideMap => Self::OUTSIDE_MAP,
            Self::OutsideSweep(plane) => plane,
        }
    }

    /// The reason that the frustum stage gave for a caster, by the detail that it wrote.
    pub(crate) const fn from_detail(detail: u8) -> Self {
        match detail {
            Self::NO_RECEIVER => Self::NoReceiver,
            Self::BEYOND_RANGE => Self::BeyondRange,
            Self::OUTSIDE_CONE => Self::OutsideCone,
            Self::OUTSIDE_MAP => Self::OutsideMap,
            plane => Self::OutsideSweep(plane),
        }
    }
}

/// All points from which a shadow can fall on what a view sees: the hull of the lit part of the
/// view and the light, as up to 32 planes. Made once per light and view, without allocation; see
/// [`CasterRegion::new`].
#[derive(Clone, Debug)]
pub struct CasterRegion {
    /// No caster matters.
    is_nothing: bool,
    frustum: Frustum,
    /// Bit i: plane i is the light's own, or its map's.
    of_range: u32,
    of_cone: u32,
    of_map: u32,
    /// The light and how far it reaches, where that is a sphere.
    sphere: Option<(DVec3, f64)>,
}

impl CasterRegion {
    /// The region of a view, by its frustum, and a light.
    ///
    /// `receivers` is a box around all on which the view can see a shadow: the union of the bounds
    /// of what frustum culling left. The tighter it is, the more is dropped. `None` is any place in
    /// the frustum. A box that is not finite counts as `None`; an empty one leaves no receiver, so
    /// that every caster is dropped.
    ///
    /// Conservative: a caster that is dropped has, in exact arithmetic, no point between the light
    /// and a point of the frustum, in the box, within the light's range and cone. Planes that find
    /// no room, or that rounding makes doubtful, are left out. A frustum whose corners are not
    /// known (see [`Frustum::corners`]) and that has neither receivers nor a range to end it keeps
    /// those of its planes that the light is inside of.
    ///
    /// The light is a point or a direction; shadows with soft edges, and filters that read around a
    /// pixel, are what `margin_world` of [`with_margin`](Self::with_margin) is for.
    ///
    /// Cost: constant, whatever the number of casters.
    #[must_use]
    pub fn new(frustum: &Frustum, receivers: Option<&Aabb>, light: &Light) -> Self {
        if receivers.is_some_and(Aabb::is_empty) {
            return Self::nothing();
        }
        let (apex, range, cone) = match light.reach() {
            Reach::Nothing => return Self::nothing(),
            Reach::Unknown => return Self::of(&Sweep::new(0.0), None),
            Reach::Lit(lit) => (lit.apex, lit.range, lit.cone()),
        };
        let sphere = (!apex.at_infinity && range.is_finite()).then_some((apex.point, range));
        let corners = frustum.corners_with_error();
        let own = FrustumPlane::ALL.each(|which| frustum.plane(which).copied());
        let mut body;
        let mut of_range = 0;
        if let Some(start) = finite_box(corners.as_ref(), receivers, sphere) {
            if start.min.cmpgt(start.max).any() {
                return Self::nothing();
            }
            body = Body::in_box(start.min, start.max);
            of_range = start.of_range;
            for (_, plane) in frustum.planes() {
                body.cut(plane);
            }
        } else if let Some(corners) = &corners {
            body = Body::of_corners(own, corners);
        } else {
            let mut sweep = Sweep::new(0.0);
            sweep.add_cone(cone.iter().flatten());
            for (_, plane) in frustum.planes() {
                sweep.add_if_inside(plane, &apex);
            }
            return Self::of(&sweep, sphere);
        }
        let mut of_cone = 0_u64;
        let endless = body.vertices().iter().any(|v| v.at_infinity);
        for plane in cone.iter().flatten().filter(|_| !endless) {
            of_cone |= body.cut(plane).map_or(0, |number| 1 << number);
        }
        if body.is_empty() {
            return Self::nothing();
        }
        let mut sweep = Sweep::new(size_of(&body, &apex));
        sweep.add_cone(cone.iter().flatten().filter(|_| endless));
        sweep.add_hull(&body, &apex, [of_range, of_cone]);
        Self::of(&sweep, sphere)
    }

    fn nothing() -> Self {
        Self { is_nothing: true, ..Self::of(&Sweep::new(0.0), None) }
    }

    fn of(sweep: &Sweep, sphere: Option<(DVec3, f64)>) -> Self {
        let planes = sweep.planes();
        let first: [Option<Plane>; 6] = array::from_fn(|i| planes.get(i).copied());
        let mut frustum = Frustum::from_planes(first);
        for plane in planes.iter().skip(6) {
            // A plane that is refused is one fewer to reject by.
            let _ = frustum.push(*plane);
        }
        let of =
            |which| (0..planes.len()).fold(0, |b, i| b | u32::from(sweep.label[i] == which) << i);
        Self {
            is_nothing: false,
            frustum,
            of_range: of(Label::Range),
            of_cone: of(Label::Cone),
            of_map: of(Label::Map),
            sphere,
        }
    }

    /// The region grown by `margin_world` to every side, in world units: for shadows that are
    /// blurred by so much, or whose maps are read so far around a point. A margin that is not above
    /// zero changes nothing; one that is infinite keeps every caster.
    #[must_use]
    pub fn with_margin(self, margin_world: f64) -> Self {
        if self.is_nothing || margin_world.is_nan() || margin_world <= 0.0 {
            return self;
        }
        let mut sweep = Sweep::new(0.0);
        for (number, plane) in self.frustum.planes() {
            let d = plane.d + margin_world;
            let label = self.label(number as u8);
            sweep.push(Plane { d: d + d.abs() * ROUNDING, ..*plane }, label);
        }
        Self::of(&sweep, self.sphere.map(|(p, range)| (p, range + margin_world)))
    }

    /// The region cut by the planes of the view that the shadow map is drawn with: what is outside
    /// of that is not in the map. Planes for which there is no room are left out.
    #[must_use]
    pub fn within_map(mut self, map: &Frustum) -> Self {
        for (_, plane) in map.planes() {
            match self.frustum.push(*plane) {
                Ok(number) => self.of_map |= 1 << number,
                Err(_) => break,
            }
        }
        self
    }

    /// Its planes, pointing out: whatever a frustum can be tested with, this can, and what is
    /// outside is no caster that matters. Without a plane if every caster is kept, and also if
    /// [`no_receiver`](Self::no_receiver): test that first.
    #[must_use]
    pub fn frustum(&self) -> &Frustum {
        &self.frustum
    }

    /// Whether the light lights nothing that the view sees, so that it needs no shadows at all.
    #[must_use]
    pub fn no_receiver(&self) -> bool {
        self.is_nothing
    }

    /// Whether there is a range to be [beyond](Self::is_beyond_range).
    #[must_use]
    pub fn has_range(&self) -> bool {
        self.sphere.is_some()
    }

    /// Whether a box is proved to be farther from the light than it reaches, which the planes can
    /// only say of the box around the light's sphere. NaN is not beyond.
    #[must_use]
    pub fn is_beyond_range(&self, b: &Aabb) -> bool {
        let Some((light, range)) = self.sphere else { return false };
        let (mut apart, mut size) = (DVec3::ZERO, range);
        for axis in 0..3 {
            let (min, max, p) = (f64::from(b.min[axis]), f64::from(b.max[axis]), light[axis]);
            size += min.abs() + max.abs() + p.abs();
            apart[axis] = (min - p).max(p - max).max(0.0);
        }
        apart.length() > range + size * ROUNDING
    }

    /// Why a caster with these bounds does not matter; `None` if it may. `plane` is the number of
    /// the first plane of [`frustum`](Self::frustum) that rejects them, by whatever test the caller
    /// has for boxes and planes.
    #[must_use]
    pub fn reason(&self, b: &Aabb, plane: Option<u8>) -> Option<CasterReason> {
        if self.no_receiver() {
            return Some(CasterReason::NoReceiver);
        }
        if !b.is_empty() && self.is_beyond_range(b) {
            return Some(CasterReason::BeyondRange);
        }
        let plane = plane?;
        if b.is_empty() {
            return Some(CasterReason::OutsideSweep(u8::MAX));
        }
        Some(match self.label(plane) {
            Label::Range => CasterReason::BeyondRange,
            Label::Cone => CasterReason::OutsideCone,
            Label::Map => CasterReason::OutsideMap,
            Label::Sweep => CasterReason::OutsideSweep(plane),
        })
    }

    fn label(&self, plane: u8) -> Label {
        let is = |bits: u32| bits.checked_shr(plane.into()).unwrap_or(0) & 1 == 1;
        match (is(self.of_range), is(self.of_cone), is(self.of_map)) {
            (true, ..) => Label::Range,
            (_, true, _) => Label::Cone,
            (.., true) => Label::Map,
            _ => Label::Sweep,
        }
    }
}

/// Whose a plane is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Label {
    Sweep,
    Range,
    Cone,
    Map,
}

/// A box, and the bits of those of its faces (low x, high x and so on) that are the light's range.
struct Start {
    min: DVec3,
    max: DVec3,
    of_range: u64,
}

/// The smallest box that all that is finite allows; `None` if nothing is.
fn finite_box(
    corners: Option<&[corners::Corner; 8]>,
    receivers: Option<&Aabb>,
    sphere: Option<(DVec3, f64)>,
) -> Option<Start> {
    let (low, high) = (DVec3::splat(f64::NEG_INFINITY), DVec3::splat(f64::INFINITY));
    let mut start = Start { min: low, max: high, of_range: 0 };
    if let Some(b) = receivers.filter(|b| b.is_finite()) {
        start.min = DVec3::from(b.min.each(f64::from));
        start.max = DVec3::from(b.max.each(f64::from));
    }
    if let Some(corners) = corners.filter(|c| c.iter().all(|c| !c.at_infinity)) {
        let slack = |c: &corners::Corner| DVec3::splat(c.error) + c.point.abs() * ROUNDING;
        let min = corners.iter().fold(high, |m, c| m.min(c.point - slack(c)));
        let max = corners.iter().fold(low, |m, c| m.max(c.point + slack(c)));
        (start.min, start.max) = (start.min.max(min), start.max.min(max));
    }
    if let Some((p, range)) = sphere {
        let reach = DVec3::splat(range) + (p.abs() + range) * ROUNDING;
        for axis in 0..3 {
            if p[axis] - reach[axis] > start.min[axis] {
                start.min[axis] = p[axis] - reach[axis];
                start.of_range |= 1 << (2 * axis);
            }
            if p[axis] + reach[axis] < start.max[axis] {
                start.max[axis] = p[axis] + reach[axis];
                start.of_range |= 2 << (2 * axis);
            }
        }
    }
    (start.min.is_finite() && start.max.is_finite()).then_some(start)
}

/// The length over which a body and its light spread, for telling planes that touch them from those
/// that do not.
fn size_of(body: &Body, apex: &Apex) -> f64 {
    let finite = body.vertices().iter().filter(|v| !v.at_infinity).map(|v| v.point);
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in finite.chain((!apex.at_infinity).then_some(apex.point)) {
        (min, max) = (min.min(p), max.max(p));
    }
    (max - min).length() + body.error
}

/// Planes of a hull, gathered one by one.
struct Sweep {
    planes: [Plane; Frustum::MAX_PLANES],
    label: [Label; Frustum::MAX_PLANES],
    count: usize,
    size: f64,
}

/// A plane farther than this from what it should touch, as a part of the size of all, is no face of
/// the hull but merely holds it; its room is better left to others.
const TOUCHES: f64 = 1e-7;

/// Two normals whose cosine differs from 1 by less are one: 1.4e-6 radians.
const SAME: f64 = 1e-12;

impl Sweep {
    fn new(size: f64) -> Self {
        let planes = [Plane::default(); Frustum::MAX_PLANES];
        Self { planes, label: [Label::Sweep; Frustum::MAX_PLANES], count: 0, size }
    }

    fn planes(&self) -> &[Plane] {
        &self.planes[..self.count]
    }

    /// Takes a plane unless it is there or nothing is free.
    fn push(&mut self, plane: Plane, label: Label) {
        let n = DVec3::from(plane.normal);
        let there = self.planes().iter().any(|p| n.dot(DVec3::from(p.normal)) > 1.0 - SAME);
        if !there && plane.is_finite() && self.count < self.planes.len() {
            self.planes[self.count] = plane;
            self.label[self.count] = label;
            self.count += 1;
        }
    }

    /// All that a spot lights, and so all ways to it, lie in the cone.
    fn add_cone<'a>(&mut self, cone: impl Iterator<Item = &'a Plane>) {
        cone.for_each(|plane| self.push(*plane, Label::Cone));
    }

    /// Takes a half-space that holds the body if it is sure to hold the light.
    fn add_if_inside(&mut self, plane: &Plane, apex: &Apex) {
        let n = DVec3::from(plane.normal);
        let inside = if apex.at_infinity {
            n.dot(apex.point) < -ROUNDING
        } else {
            n.dot(apex.point) + n.abs().dot(apex.point.abs()) * ROUNDING < plane.d
        };
        if inside {
            self.push(*plane, Label::Sweep);
        }
    }

    /// The faces of the hull of a body and a light.
    ///
    /// Directions for them come from the faces of the body, and from its edges with the light; how
    /// far the hull reaches in a direction comes from all corners. So each plane holds the hull
    /// whatever the directions are, and a direction that is missed, or is not a face's, costs
    /// tightness and no more.
    fn add_hull(&mut self, body: &Body, apex: &Apex, [of_range, of_cone]: [u64; 2]) {
        let hull = Hull::new(body, apex);
        let touches = self.size * TOUCHES;
        // The light's own first, so that they are named where one of them and the sweep agree.
        let order = |number: usize| match (of_cone >> number & 1, of_range >> number & 1) {
            (1, _) => Label::Cone,
            (_, 1) => Label::Range,
            _ => Label::Sweep,
        };
        for label in [Label::Cone, Label::Range, Label::Sweep] {
            for (number, plane) in body.planes().filter(|(i, _)| order(*i) == label) {
                let on = |v: &&Vertex| v.planes >> number & 1 == 1 && !v.at_infinity;
                let Some(corner) = body.vertices().iter().find(on) else { continue };
                let touching = hull.supporting(DVec3::from(plane.normal));
                if let Some(found) = touching.filter(|p| -p.distance(corner.point) <= touches) {
                    self.push(found, label);
                }
            }
        }
        for (a, b) in body.edges() {
            let all = [
                (a.point, a.at_infinity),
                (b.point, b.at_infinity),
                (apex.point, apex.at_infinity),
            ];
            let Some(&(base, _)) = all.iter().find(|p| !p.1) else { continue };
            let ways = all.iter().filter(|p| p.0 != base || p.1);
            let mut ways = ways.filter_map(|&(p, far)| if far { Some(p) } else { unit(p - base) });
            let (Some(u), Some(v)) = (ways.next(), ways.next()) else { continue };
            let across = u.cross(v);
            // An edge that points at the light spans no plane with it.
            if across.length() < 1e-9 {
                continue;
            }
            let Some(n) = unit(across) else { continue };
            // Mostly the plane runs through the body, and need not be looked at closer.
            let (mut below, mut above) = (false, false);
            for v in body.vertices().iter().filter(|v| !v.at_infinity) {
                let side = n.dot(v.point - base);
                below |= side < -touches;
                above |= side > touches;
            }
            for (n, free) in [(n, !above), (-n, !below)] {
                let found = free.then(|| hull.supporting(n)).flatten();
                if let Some(found) = found.filter(|p| -p.distance(base) <= touches) {
                    self.push(found, Label::Sweep);
                }
            }
        }
        // A box beside a slanting edge of the hull is outside no face of it, but may be beyond its
        // end.
        for axis in DVec3::AXES {
            for n in [axis, -axis] {
                if let Some(found) = hull.supporting(n) {
                    self.push(found, Label::Sweep);
                }
            }
        }
    }
}

/// The corners of a body and a light, for finding how far their hull reaches.
struct Hull<'a> {
    body: &'a Body,
    apex: &'a Apex,
    /// Subtracted from every normal. A plane along the light's rays is found to lean out a little
    /// by rounding as often as in, and leaning out it would cut a ray far away. So all lean in by
    /// more than the rounding.
    lean: DVec3,
}

impl<'a> Hull<'a> {
    fn new(body: &'a Body, apex: &'a Apex) -> Self {
        let mut hull = Self { body, apex, lean: DVec3::ZERO };
        let middle = unit(hull.directions().fold(DVec3::ZERO, |sum, d| sum + d));
        if let Some(middle) = middle {
            let least = hull.directions().map(|d| d.dot(middle)).fold(1.0, f64::min);
            // Directions almost opposite have no side that all of them lean to: no plane will hold
            // them.
            if least > 1e-3 {
                hull.lean = middle * (4.0 * hull.direction_slack() / least);
            }
        }
        hull
    }

    /// The directions in which the hull has no end.
    fn directions(&self) -> impl Iterator<Item = DVec3> {
        let body = self.body.vertices().iter().filter(|v| v.at_infinity).map(|v| v.point);
        body.chain(self.apex.at_infinity.then_some(self.apex.point))
    }

    /// Error bound of n·direction.
    fn direction_slack(&self) -> f64 {
        2.0 * (self.body.direction_error + ROUNDING)
    }

    /// The half-space with (almost) this unit normal that just holds the hull; `None` where the
    /// hull has no end that way.
    fn supporting(&self, n: DVec3) -> Option<Plane> {
        let n = n - self.lean;
        let slack = self.direction_slack();
        if self.directions().any(|d| n.dot(d) + slack > 0.0) {
            return None;
        }
        let reach = |p: DVec3| n.dot(p) + n.abs().dot(p.abs()) * (2.0 * ROUNDING);
        let points = self.body.vertices().iter().filter(|v| !v.at_infinity);
        let body = points.map(|v| reach(v.point)).fold(f64::NEG_INFINITY, f64::max);
        let mut d = body + self.body.error * 2.0;
        if !self.apex.at_infinity {
            d = d.max(reach(self.apex.point));
        }
        d.is_finite().then(|| Plane { normal: n.into(), d })
    }
}
