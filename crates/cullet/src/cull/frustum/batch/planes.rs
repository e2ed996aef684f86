//! The planes of a frustum, prepared for the tests of batches.

use glam::DVec3;

use crate::array::Each;
use crate::bounds::{Aabb, Block, Boxes, Plane, Side, Sphere};
use crate::view::{Frustum, FrustumPlane};

/// One plane for boxes, scaled so that its coefficient on the axis of the first row is 1.
///
/// The corner of a box nearest to the inside has n·x = −(y₀ + b·y₁ + c·y₂) with y from these rows of a
/// block (−min where n > 0, max elsewhere): the box is outside iff that sum plus `d` is negative. The
/// opposite corner, of rows (r + 3) mod 6, has n·x = z₀ + b·z₁ + c·z₂.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::cull::frustum) struct BoxPlane {
    pub(in crate::cull::frustum) rows: [usize; 3],
    pub(in crate::cull::frustum) b: f32,
    pub(in crate::cull::frustum) c: f32,
    /// The offset, rounded up: +∞ where the plane may reject nothing.
    pub(in crate::cull::frustum) d: f32,
    /// The offset, rounded down: −∞ where nothing may be called inside.
    pub(in crate::cull::frustum) inside: f32,
    pub(in crate::cull::frustum) number: u8,
}

/// One plane for spheres: outside iff n·c − r > d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpherePlane {
    pub(super) n: [f32; 3],
    pub(super) d: f32,
    pub(super) inside: f32,
    pub(super) number: u8,
}

/// Beyond this a plane's offset says nothing about items within [`Boxes::LIMIT`].
const FAR_OFF: f64 = Boxes::LIMIT as f64 / 2.0;

/// Largest contribution of a coefficient flushed to zero, within [`Boxes::LIMIT`].
const FLUSHED: f64 = f32::MIN_POSITIVE as f64 * Boxes::LIMIT as f64 * 4.0;

/// Offsets of a plane whose exact offset is `d`, give or take `slack`: rounded up, and down.
fn offsets(d: f64, slack: f64) -> (f32, f32) {
    use crate::bounds::{round_down, round_up};
    // A few units of f64 for the arithmetic that made d.
    let slack = slack + d.abs() * 1e-15;
    let outside = if d > -FAR_OFF { round_up(d + slack) } else { f32::INFINITY };
    let inside =
        if d > -FAR_OFF { round_down((d - slack).min(FAR_OFF)) } else { f32::NEG_INFINITY };
    // + 0.0: a sum with −0 could be −0, whose sign bit is set though it is not negative.
    (outside + 0.0, inside + 0.0)
}

impl BoxPlane {
    /// A plane that rejects nothing.
    fn never() -> Self {
        let (d, inside) = (f32::INFINITY, f32::INFINITY);
        Self { rows: [0, 1, 2], b: 0.0, c: 0.0, d, inside, number: u8::MAX }
    }

    fn new(number: usize, plane: &Plane) -> Self {
        let n = plane.normal;
        let axes = axes_by_size(plane);
        let unit = n[axes[0]].abs();
        let rows = axes.each(|a| if n[a] < 0.0 { a + 3 } else { a });
        let usable = plane.normal.iter().all(|v| v.is_finite()) && unit > 0.0;
        if !usable || plane.d.is_nan() {
            let inside = f32::NEG_INFINITY;
            return Self { number: number as u8, inside, ..Self::never() };
        }
        let mut slack = 0.0;
        let mut coefficient = |axis: usize| {
            let v = n[axis].abs() / unit;
            if v != 0.0 && v < f64::from(f32::MIN_POSITIVE) {
                slack += FLUSHED;
                return 0.0;
            }
            v as f32
        };
        let (b, c) = (coefficient(axes[1]), coefficient(axes[2]));
        let (d, inside) = offsets(plane.d / unit, slack);
        Self { rows, b, c, d, inside, number: number as u8 }
    }

    /// Whether the plane rejects the box in `lane` of a block: the very arithmetic of the fast paths.
    pub(super) fn rejects(&self, block: &[[f32; 16]; 6], lane: usize) -> bool {
        let y = self.rows.each(|r| block[r][lane]);
        y[0] + (y[1] * self.b + y[2] * self.c) + self.d < 0.0
    }

    /// Whether the box is on the inner side of the plane.
    pub(super) fn contains(&self, block: &[[f32; 16]; 6], lane: usize) -> bool {
        let z = self.rows.each(|r| block[(r + 3) % 6][lane]);
        z[0] + (z[1] * self.b + z[2] * self.c) <= self.inside
    }
}

/// The six planes of a view in the form that shares work between opposite sides, for spheres.
///
/// With p = f·c (f the far plane's normal), a pair of sides with normals n₁, n₂ has
/// max(n₁·c − d₁, n₂·c − d₂) = |h·c − m| − k·p − o, where h is half the difference of the normals, their
/// half sum is −k·f, and m and o are half the difference and half the sum of the offsets.
#[derive(Clone, Copy, Debug)]
pub(super) struct SharedSides {
    pub(super) f: [f32; 3],
    /// Far: p − far > r is outside. +∞ where there is none.
    pub(super) far: f32,
    /// Near: near − p > r is outside.
    pub(super) near: f32,
    /// Left with right, bottom with top.
    pub(super) pairs: [SidePair; 2],
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SidePair {
    pub(super) h: [f32; 3],
    pub(super) m: f32,
    pub(super) k: f32,
    pub(super) o: f32,
}

/// A frustum made ready for the tests of batches: its planes in f32, scaled and sorted.
///
/// Made once a view, from a frustum in the coordinates of the batch (see
/// [`Frustum::relative_to`]). Offsets are rounded towards keep. A plane with a NaN or no direction
/// rejects nothing, and nothing is inside it.
#[derive(Clone, Debug)]
pub struct Planes {
    pub(super) for_boxes: [BoxPlane; Frustum::MAX_PLANES],
    pub(super) for_spheres: [SpherePlane; Frustum::MAX_PLANES],
    pub(super) count: usize,
    pub(super) shared: Option<SharedSides>,
    frustum: Frustum,
}

impl Planes {
    /// Prepares the planes of `frustum`. Cost: about a microsecond.
    #[must_use]
    pub fn new(frustum: &Frustum) -> Self {
        let mut for_boxes = [BoxPlane::never(); Frustum::MAX_PLANES];
        let zero =
            SpherePlane { n: [0.0; 3], d: f32::INFINITY, inside: f32::INFINITY, number: u8::MAX };
        let mut for_spheres = [zero; Frustum::MAX_PLANES];
        let mut count = 0;
        for (number, plane) in frustum.planes() {
            for_boxes[count] = BoxPlane::new(number, plane);
            for_spheres[count] = sphere_plane(number, plane);
            count += 1;
        }
        let mut planes =
            Self { for_boxes, for_spheres, count, shared: None, frustum: frustum.clone() };
        if frustum.present() >> 6 == 0 && count > 0 {
            planes.shared = shared(frustum);
        }
        planes
    }

    /// How many planes there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is no plane, so that everything is inside.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The frustum that was prepared.
    #[must_use]
    pub fn frustum(&self) -> &Frustum {
        &self.frustum
    }

    /// Where one box lies, by the arithmetic of the batch tests: one box gets here the answer that it
    /// gets in a batch.
    #[must_use]
    pub fn classify_box(&self, b: &Aabb) -> Side {
        let mut block = bytemuck::Zeroable::zeroed();
        crate::bounds::BoxBlock::set(&mut block, 0, b);
        self.boxes(&block.0, 0)
    }

    /// Where one sphere lies, by the arithmetic of the batch tests.
    #[must_use]
    pub fn classify_sphere(&self, s: &Sphere) -> Side {
        let mut block = bytemuck::Zeroable::zeroed();
        crate::bounds::SphereBlock::set(&mut block, 0, s);
        self.spheres(&block.0, 0)
    }

    /// The number of the first plane that rejects box `index` of a batch, or
    /// [`VISIBLE`](super::VISIBLE).
    ///
    /// # Panics
    /// If `index` is not below the batch's length.
    #[must_use]
    pub(crate) fn first_rejecting(&self, boxes: &Boxes, index: usize) -> u8 {
        self.rejecting_box(&boxes.blocks()[index / 16].0, index % 16)
    }

    /// Where box `index` of a batch lies.
    ///
    /// # Panics
    /// If `index` is not below the batch's length.
    #[must_use]
    pub(crate) fn classify_stored(&self, boxes: &Boxes, index: usize) -> Side {
        self.boxes(&boxes.blocks()[index / 16].0, index % 16)
    }

    pub(in crate::cull::frustum) fn box_planes(&self) -> &[BoxPlane] {
        &self.for_boxes[..self.count]
    }

    pub(super) fn sphere_planes(&self) -> &[SpherePlane] {
        &self.for_spheres[..self.count]
    }

    /// Where the box in `lane` of a block lies.
    pub(in crate::cull::frustum) fn boxes(&self, block: &[[f32; 16]; 6], lane: usize) -> Side {
        if self.box_planes().iter().any(|p| p.rejects(block, lane)) {
            Side::Outside
        } else if self.box_planes().iter().all(|p| p.contains(block, lane)) {
            Side::Inside
        } else {
            Side::Straddling
        }
    }

    /// Where the sphere in `lane` of a block lies.
    pub(super) fn spheres(&self, block: &[[f32; 16]; 4], lane: usize) -> Side {
        let [x, y, z, r] = [0, 1, 2, 3].each(|row: usize| block[row][lane]);
        let dot = |n: &[f32; 3]| x * n[0] + (y * n[1] + z * n[2]);
        let outside = match &self.shared {
            Some(s) => {
                let p = dot(&s.f);
                let side = |q: &SidePair| ((dot(&q.h) - q.m).abs() - p * q.k) - q.o;
                let [a, b] = &s.pairs;
                side(a) > r || side(b) > r || p - s.far > r || s.near - p > r
            }
            None => self.sphere_planes().iter().any(|q| dot(&q.n) - r > q.d),
        };
        if outside {
            Side::Outside
        } else if self.sphere_planes().iter().all(|q| dot(&q.n) + r <= q.inside) {
            Side::Inside
        } else {
            Side::Straddling
        }
    }

    /// The number of the first plane that rejects the box in `lane`, which some plane does.
    pub(super) fn rejecting_box(&self, block: &[[f32; 16]; 6], lane: usize) -> u8 {
        let first = self.box_planes().iter().find(|p| p.rejects(block, lane));
        first.map_or(super::VISIBLE, |p| p.number)
    }

    /// The number of the first plane that rejects the sphere in `lane`, which some plane does. In f64:
    /// the test knows only that one of two opposite planes rejects.
    pub(super) fn rejecting_sphere(&self, block: &[[f32; 16]; 4], lane: usize) -> u8 {
        let [x, y, z, r] = [0, 1, 2, 3].each(|row: usize| f64::from(block[row][lane]));
        let excess =
            |p: &Plane| p.normalized().map_or(f64::NEG_INFINITY, |p| p.distance([x, y, z])) - r;
        let first = self.frustum.planes().find(|(_, p)| excess(p) > 0.0);
        // Where the stored radius hides the rejection in f64's sight, the plane most exceeded it is.
        let most = || self.frustum.planes().max_by(|a, b| excess(a.1).total_cmp(&excess(b.1)));
        first.or_else(most).map_or(super::VISIBLE, |(number, _)| number as u8)
    }
}

fn axes_by_size(plane: &Plane) -> [usize; 3] {
    let size = |a: usize| plane.normal[a].abs();
    let unit = (0..3).fold(0, |best, a| if size(a) > size(best) { a } else { best });
    [[0, 1, 2], [1, 0, 2], [2, 0, 1]][unit]
}

fn sphere_plane(number: usize, plane: &Plane) -> SpherePlane {
    let never = SpherePlane {
        n: [0.0; 3],
        d: f32::INFINITY,
        inside: f32::NEG_INFINITY,
        number: number as u8,
    };
    let Some(p) = plane.normalized().filter(|p| !p.d.is_nan()) else { return never };
    // Tiny coefficients may round to zero or lose digits: their contribution is in FLUSHED.
    let (d, inside) = offsets(p.d, FLUSHED);
    SpherePlane { n: p.normal.each(|v| v as f32), d, inside, number: number as u8 }
}

/// A plane with finite numbers and a direction.
fn good(frustum: &Frustum, which: FrustumPlane) -> Option<Plane> {
    frustum.plane(which).and_then(|p| p.normalized()).filter(|p| p.d.is_finite())
}

/// How far a direction of the shared form may be from that of the frustum: 2u.
const SAME: f64 = 2.0 / (1 << 24) as f64;

fn shared(frustum: &Frustum) -> Option<SharedSides> {
    use FrustumPlane::{Bottom, Far, Left, Near, Right, Top};
    let [left, right, bottom, top, near] =
        [Left, Right, Bottom, Top, Near].each(|w| good(frustum, w));
    let far = good(frustum, Far);
    if far.is_none() && frustum.plane(Far).is_some() {
        return None;
    }
    let near = near?;
    let reach = |p: &Plane| p.d.abs() < FAR_OFF / 16.0;
    let f = DVec3::from(far.map_or((-DVec3::from(near.normal)).into(), |p| p.normal));
    let f32s = |v: DVec3| v.to_array().each(|x| x as f32);
    let back = |v: [f32; 3]| DVec3::from(v.each(f64::from));
    let f_rounded = f32s(f);
    if (back(f_rounded) + DVec3::from(near.normal)).abs().max_element() > SAME {
        return None;
    }
    let pair = |a: Option<Plane>, b: Option<Plane>| {
        let (a, b) = (a?, b?);
        let (na, nb) = (DVec3::from(a.normal), DVec3::from(b.normal));
        let h = (nb - na) * 0.5;
        let k = -((na + nb) * 0.5).dot(f);
        let k_rounded = k as f32;
        let rest = (na + nb) * 0.5 + back(f_rounded) * f64::from(k_rounded);
        if !(rest.abs().max_element() <= SAME && reach(&a) && reach(&b)) {
            return None;
        }
        let (m, o) = ((b.d - a.d) * 0.5, (a.d + b.d) * 0.5);
        // The differences with m and o are rounded too; that error is relative to m and o (8 u), not to
        // the sphere, whose radius pays for all others.
        let slack = (m.abs() + o.abs()) * (8.0 / (1 << 24) as f64) + FLUSHED;
        Some(SidePair { h: f32s(h), m: m as f32, k: k_rounded, o: offsets(o, slack).0 })
    };
    if !reach(&near) || far.is_some_and(|p| !reach(&p)) {
        return None;
    }
    Some(SharedSides {
        f: f_rounded,
        far: far.map_or(f32::INFINITY, |p| offsets(p.d, FLUSHED).0),
        near: -offsets(near.d, FLUSHED).0,
        pairs: [pair(left, right)?, pair(bottom, top)?],
    })
}
