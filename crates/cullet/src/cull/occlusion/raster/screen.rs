//! Places in the buffer: pixels, and how near they are.

use glam::{DMat4, DVec3, DVec4};

use super::steps::Scale;
use crate::array::{self, Each};
use crate::transform::Transform;
use crate::view::{Depth, View};

/// Beyond this many units in the last place of f64 no chain of operations here is off.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// The map from world space, relative to an origin, to the pixels of a buffer and to *nearness*.
///
/// Nearness is larger the nearer a point is, above zero, and affine on the screen, in perspective
/// and in orthographic views alike: 1 / w where lines of sight meet (whatever the depth range,
/// reversed and infinite ones included), and how far a point is from the far plane, as a share of
/// the depth range, where they are parallel. So a plane of the world is a plane over the screen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Screen {
    /// Take a point to x·w, y·w (pixels, down from the top left corner), nearness·w, height over
    /// the near plane, w.
    rows: [DVec4; 5],
    /// How far each row is off for either eye of a stereo view; zeros for one eye.
    apart: [f64; 5],
    pub(crate) size: [u32; 2],
    /// Whether outward windings look clockwise where they face the eye.
    pub(crate) mirrored: bool,
    pub(crate) perspective: bool,
    pub(crate) scale: Scale,
}

/// A point in the buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Spot {
    /// Pixels from the left and the top.
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) nearness: f64,
}

/// A point before the divide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Clip {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) nearness: f64,
    /// At most zero where the point is cut off.
    pub(crate) near: f64,
    pub(crate) w: f64,
}

impl Spot {
    pub(crate) fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.nearness.is_finite()
    }
}

impl Clip {
    pub(crate) const NONE: Self = Self { x: 0.0, y: 0.0, nearness: 0.0, near: 0.0, w: 0.0 };

    pub(crate) fn height(&self) -> f64 {
        self.near
    }

    pub(crate) fn is_finite(&self) -> bool {
        [self.x, self.y, self.nearness, self.near, self.w].iter().all(|v| v.is_finite())
    }

    /// Whether the point is this side of the near plane, with digits to spare.
    pub(crate) fn is_in_front(&self) -> bool {
        self.near >= 0.0 && self.w > 0.0
    }

    /// The place of a point that is in front.
    pub(crate) fn spot(&self) -> Spot {
        let inverse = 1.0 / self.w;
        Spot { x: self.x * inverse, y: self.y * inverse, nearness: self.nearness * inverse }
    }

    /// Where the line to a point of the other side of the near plane meets it.
    pub(crate) fn meet_near(&self, other: &Self) -> Self {
        Self { near: 0.0, ..self.mix(other, self.near / (self.near - other.near)) }
    }

    /// The point at the share `t` of the way to another.
    pub(crate) fn mix(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Self {
            x: mix(self.x, other.x),
            y: mix(self.y, other.y),
            nearness: mix(self.nearness, other.nearness),
            near: mix(self.near, other.near),
            w: mix(self.w, other.w),
        }
    }
}

impl Screen {
    /// The screen of a view in a buffer of `size` pixels, for points relative to `origin`.
    pub(crate) fn new(view: &View, origin: [f64; 3], size: [u32; 2]) -> Self {
        let [x, y, z] = origin;
        let m = DMat4::from_cols_array(&view.clip_from_world())
            * DMat4::from_translation([x, y, z].into());
        let perspective = !view.is_orthographic();
        // So that w is the distance along the line of view, or 1: a matrix may be times any factor.
        let unit = if perspective { m.row(3).truncate().length() } else { m.row(3).w };
        let [x, y, z, w] = array::from_fn(|i| m.row(i) / unit);
        let [width, height] = size.each(f64::from);
        let (near, nearness) = match view.depth() {
            Depth::Standard => (z, w - z),
            Depth::Reversed => (w - z, z),
        };
        let scale =
            if perspective { Scale::perspective(near_w(near, w)) } else { Scale::parallel() };
        let nearness = if perspective { DVec4::W } else { nearness };
        let mut rows = [(x + w) * (0.5 * width), (w - y) * (0.5 * height), nearness, near, w];
        // An eye that is elsewhere by `half` sees a point as the middle sees it moved the other
        // way.
        let half = DVec3::from(view.eyes_apart());
        let mut apart = rows.each(|row| row.truncate().dot(half).abs() * (1.0 + ROUNDING));
        // Occluders count from the farther of the two near planes on, boxes from the nearer.
        let cut = apart[3] + near.truncate().length() * view.near_depth();
        rows[3].w -= cut;
        apart[3] = 2.0 * cut;
        Self { rows, apart, size, mirrored: view.is_mirrored(), perspective, scale }
    }

    /// The same screen for the points of an object.
    pub(crate) fn of_object(&self, transform: &Transform, origin: [f64; 3]) -> ObjectScreen {
        let [x, y, z] = transform.linear.each(|c| c.each(f64::from));
        let t: [f64; 3] = array::from_fn(|a| transform.translation[a] - origin[a]);
        // Row vectors times the matrix.
        let dot = |r: &DVec4, c: [f64; 3]| r.x * c[0] + r.y * c[1] + r.z * c[2];
        let of = |r: DVec4, [x, y, z, t]: [[f64; 3]; 4]| {
            DVec4::new(dot(&r, x), dot(&r, y), dot(&r, z), dot(&r, t) + r.w)
        };
        let columns = [x, y, z, t];
        let sizes = columns.each(|c| c.each(f64::abs));
        ObjectScreen {
            rows: self.rows.each(|r| of(r, columns)),
            apart: self.apart,
            sizes: self.rows.each(|r| of(r.abs(), sizes)),
            mirrored: self.mirrored ^ (transform.determinant() < 0.0),
            perspective: self.perspective,
        }
    }

    /// The rows that take a point to x·w, y·w, nearness·w, height over the near plane and w.
    pub(crate) fn rows(&self) -> [[f64; 4]; 5] {
        self.rows.each(Into::into)
    }

    /// How far each row is off for either eye of a stereo view.
    pub(crate) fn apart(&self) -> [f64; 5] {
        self.apart
    }
}

/// The map from an object's own space.
#[derive(Clone, Debug)]
pub(crate) struct ObjectScreen {
    rows: [DVec4; 5],
    /// How far each row is off for either eye of a stereo view.
    pub(crate) apart: [f64; 5],
    /// Sums of the sizes of the terms that each number of the rows was summed from.
    pub(crate) sizes: [DVec4; 5],
    /// Whether outward windings look clockwise on a screen whose y grows upward.
    pub(crate) mirrored: bool,
    pub(crate) perspective: bool,
}

/// The w of the points of a near plane, of which a row is the height and another w; NaN where that
/// differs too much.
fn near_w(near: DVec4, w: DVec4) -> f64 {
    let (n, k) = (near.truncate(), w.truncate());
    let share = n.dot(k) / k.length_squared();
    let is_level = (n - k * share).length() <= share.abs() * 0.5;
    if is_level { (w.w * share - near.w) / share } else { f64::NAN }
}

impl ObjectScreen {
    /// The rows that take a point to x·w, y·w, nearness·w, height over the near plane and w.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[DVec4; 5] {
        &self.rows
    }

    pub(crate) fn clip(&self, p: [f32; 3]) -> Clip {
        let [x, y, z] = p.each(f64::from);
        let [x, y, nearness, near, w] = self.rows.each(|r| r.x * x + r.y * y + r.z * z + r.w);
        Clip { x, y, nearness, near, w }
    }

    /// How far each number of [`clip`](Self::clip) may be off, for points within `reach` of the
    /// object's origin along each axis.
    #[inline(always)]
    pub(crate) fn error(&self, reach: [f32; 3]) -> Clip {
        let [x, y, z] = [f64::from(reach[0]), f64::from(reach[1]), f64::from(reach[2])];
        let reach = DVec4::new(x, y, z, 1.0);
        let [rx, ry, rn, near, w] = &self.rows;
        let [ax, ay, an, anear, aw] = self.apart;
        Clip {
            x: rx.abs().dot(reach) * ROUNDING + ax,
            y: ry.abs().dot(reach) * ROUNDING + ay,
            nearness: rn.abs().dot(reach) * ROUNDING + an,
            near: near.abs().dot(reach) * ROUNDING + anear,
            w: w.abs().dot(reach) * ROUNDING + aw,
        }
    }
}

/// Largest absolute coordinate along each axis, which bounds what rounding does to any of the
/// points.
pub(crate) fn reach(points: &[[f32; 3]]) -> [f32; 3] {
    points.iter().fold([0.0; 3], |r, p| array::from_fn(|a| r[a].max(p[a].abs())))
}

/// How far corners on the screen may be off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doubt {
    pub(crate) pixels: f64,
    pub(crate) nearness: f64,
}

impl Doubt {
    /// Returns the error bound of the points `clips`, which lie in front of the near plane, given
    /// numbers that may be off by `error`.
    pub(crate) fn of<'a>(error: &Clip, clips: impl Iterator<Item = &'a Clip>) -> Self {
        let (mut w, mut x, mut nearness) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        for c in clips {
            w = w.min(c.w);
            x = x.max(c.x.abs().max(c.y.abs()) / c.w);
            nearness = nearness.max(c.nearness / c.w);
        }
        Self::within(error, w, x, nearness)
    }

    /// Returns the error bound of points whose numbers may be off by `error`. Their w is at least
    /// `w`, they lie no farther than `x` pixels from the top left corner along either axis, and
    /// they are no nearer than `nearness`.
    pub(crate) fn within(error: &Clip, w: f64, x: f64, nearness: f64) -> Self {
        let over = 1.0 / (w - error.w).max(1e-300);
        let of = |error: f64, value: f64, of_w: f64| (error + value * of_w) * over;
        Self {
            pixels: of(error.x.max(error.y), x, error.w) + x * 6.0 * f64::EPSILON,
            nearness: of(error.nearness, nearness, error.w) + nearness * 6.0 * f64::EPSILON,
        }
    }

    /// Error of the double of an area.
    pub(crate) fn area(&self, [a, b, c]: [Spot; 3]) -> f64 {
        let [x, y] = [(b.x - a.x).abs() + (c.x - a.x).abs(), (b.y - a.y).abs() + (c.y - a.y).abs()];
        self.area_within([0.5 * x, 0.5 * y])
    }

    /// The same for any three spots in a rectangle so wide and high.
    pub(crate) fn area_within(&self, span: [f64; 2]) -> f64 {
        let size = 2.0 * (span[0] + span[1]);
        size * (4.0 * self.pixels + size * 8.0 * f64::EPSILON) + 8.0 * self.pixels * self.pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubt_covers_what_the_errors_do() {
        let clip = |w: f64| Clip { x: 60.0, y: 40.0, nearness: 4.0, near: 1.0, w };
        let error = Clip { w: 0.1, ..Clip::NONE };
        let doubt = Doubt::of(&error, [clip(2.0), clip(8.0)].iter());
        assert!(doubt.nearness >= 4.0 / 1.9 - 2.0 && doubt.nearness < 0.11, "{}", doubt.nearness);
        assert!(doubt.pixels >= 60.0 / 1.9 - 30.0 && doubt.pixels < 1.6, "{}", doubt.pixels);
    }

    /// Corners of a triangle that move by a hundredth of a pixel, wherever on the screen it is.
    #[test]
    fn the_doubt_of_an_area_is_that_of_its_edges() {
        for [x, y] in [[0.0, 0.0], [1000.0, 500.0]] {
            let spot = |dx: f64, dy: f64| Spot { x: x + dx, y: y + dy, nearness: 1.0 };
            let doubt = Doubt { pixels: 0.01, nearness: 0.0 };
            let area = doubt.area([spot(0.0, 0.0), spot(1.0, 0.0), spot(0.0, 1.0)]);
            assert!((1.02 * 1.02 - 1.0..0.1).contains(&area), "{area}");
        }
    }
}
