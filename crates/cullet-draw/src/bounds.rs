//! Where on the screen a box may be seen: the renderer's own rejects, in f64.

use crate::clip::{Clipper, HalfSpace, Region};
use crate::geometry::{Clip, Lens, ObjectLens, Surface};
use crate::sample::{Rect, Samples};

/// A box in the space of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    pub(crate) low: [f32; 3],
    pub(crate) high: [f32; 3],
}

impl Extent {
    pub(crate) const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    pub(crate) fn add(&mut self, p: [f32; 3]) {
        for a in 0..3 {
            self.low[a] = self.low[a].min(p[a]);
            self.high[a] = self.high[a].max(p[a]);
        }
    }

    pub(crate) fn join(&mut self, other: &Self) {
        for a in 0..3 {
            self.low[a] = self.low[a].min(other.low[a]);
            self.high[a] = self.high[a].max(other.high[a]);
        }
    }
}

/// Screen bounds of a box, and its least depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScreenBounds {
    /// Pixels that hold all its samples.
    pub(crate) rect: Rect,
    /// No sample of it is nearer than this inner depth.
    pub(crate) nearest: f64,
    /// Grows with the distance from the eye: for drawing front to back, so its rounding is no
    /// matter.
    pub(crate) distance: f64,
}

/// Bound on the rounding error of a coordinate as a share of all its terms, with ample room: a
/// vertex is four products and three sums, so a handful of units of 1.1e-16.
const SLACK: f64 = 1e-12;

/// Bounds of the samples that the triangles in a box may cover; `None` where they cover none.
///
/// A box is outside a half-space a·x ≥ 0 of clip space where its centre is farther out than its
/// reach. One with a corner beside or behind the eye has no rectangle, so it gets the whole screen.
pub(crate) fn screen_bounds(
    lens: &Lens,
    object: &ObjectLens,
    b: &Extent,
    samples: &Samples,
) -> Option<ScreenBounds> {
    let middle: [f64; 3] =
        std::array::from_fn(|a| (f64::from(b.low[a]) + f64::from(b.high[a])) * 0.5);
    let half: [f64; 3] =
        std::array::from_fn(|a| (f64::from(b.high[a]) - f64::from(b.low[a])) * 0.5);
    if !(half[0] >= 0.0 && half[1] >= 0.0 && half[2] >= 0.0) {
        return None;
    }
    let [x, y, z, w] = object.rows.map(|r| Axis::new(r, middle, half));
    let [low, high] = lens.range;
    // Each is positive inside: x + w, w − x, y + w, w − y, z − low·w, high·w − z.
    let outside = x.below(&w, 1.0, 1.0)
        || x.below(&w, -1.0, 1.0)
        || y.below(&w, 1.0, 1.0)
        || y.below(&w, -1.0, 1.0)
        || z.below(&w, 1.0, -low)
        || z.below(&w, -1.0, high);
    if outside {
        return None;
    }
    let w_low = w.middle - w.reach();
    let everything = ScreenBounds {
        rect: samples.everything(),
        nearest: f64::NEG_INFINITY,
        distance: if lens.parallel { z.middle - z.reach() } else { w_low.max(0.0) },
    };
    // NaN is no distance in front of the eye either.
    if w_low <= w.size * SLACK || w_low.is_nan() {
        return Some(everything);
    }
    let mut rect = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    let mut nearest = f64::INFINITY;
    for corner in 0..8 {
        let [x, y, z, w] = [&x, &y, &z, &w].map(|a| a.corner(corner));
        let inverse = 1.0 / w;
        let at = [x * inverse, y * inverse];
        for a in 0..2 {
            rect[0][a] = rect[0][a].min(at[a]);
            rect[1][a] = rect[1][a].max(at[a]);
        }
        nearest = nearest.min(z * inverse);
    }
    let slack = |a: &Axis, value: f64| (a.size + w.size * value.abs()) * SLACK / w_low;
    let widened = |a: &Axis, i: usize| {
        let s = slack(a, rect[0][i].abs().max(rect[1][i].abs()));
        [rect[0][i] - s, rect[1][i] + s]
    };
    let ([x0, x1], [y0, y1]) = (widened(&x, 0), widened(&y, 1));
    let rect = samples.rect([x0, y0], [x1, y1])?;
    // The slack of a depth: that of the corners, and the rounding error of a weighted mean.
    nearest -= slack(&z, nearest) + nearest.abs() * SLACK;
    let nearest = if nearest.is_nan() { f64::NEG_INFINITY } else { nearest };
    Some(ScreenBounds { rect, nearest, ..everything })
}

/// One coordinate of clip space over a box.
struct Axis {
    middle: f64,
    /// Change of the coordinate over half a side of the box, for each side.
    sides: [f64; 3],
    /// All terms of any vertex in the box, without their signs.
    size: f64,
}

impl Axis {
    fn new(row: [f64; 4], middle: [f64; 3], half: [f64; 3]) -> Self {
        let at = |i: usize| row[i] * middle[i];
        let sides: [f64; 3] = std::array::from_fn(|i| row[i] * half[i]);
        let size: f64 = (0..3).map(|i| at(i).abs() + sides[i].abs()).sum();
        Self { middle: at(0) + at(1) + at(2) + row[3], sides, size: size + row[3].abs() }
    }

    fn reach(&self) -> f64 {
        self.sides[0].abs() + self.sides[1].abs() + self.sides[2].abs()
    }

    fn corner(&self, i: usize) -> f64 {
        let side = |a: usize| if i >> a & 1 == 1 { self.sides[a] } else { -self.sides[a] };
        self.middle + side(0) + side(1) + side(2)
    }

    /// Whether p·self + q·w is below zero over the whole box. False for NaN.
    fn below(&self, w: &Self, p: f64, q: f64) -> bool {
        let middle = p * self.middle + q * w.middle;
        let reach: f64 = (0..3).map(|a| (p * self.sides[a] + q * w.sides[a]).abs()).sum();
        middle + reach < -SLACK * (p.abs() * self.size + q.abs() * w.size)
    }
}

/// The pixels that hold all samples that a triangle covers; `None` where it covers none.
#[inline]
pub(crate) fn triangle_rect(lens: &Lens, corners: &[Clip; 3], samples: &Samples) -> Option<Rect> {
    let [a, b, c] = corners;
    if !(a[3] > 0.0 && b[3] > 0.0 && c[3] > 0.0) {
        return crossing_rect(lens, corners, samples);
    }
    // All are in front of the eye: the depth of a sample lies between those of the corners, but for
    // some units of rounding.
    let [low, high] = lens.range;
    let nearer = |p: &Clip| p[2] - low * p[3] < -1e-14 * (p[2].abs() + p[3]);
    let farther = |p: &Clip| p[2] - high * p[3] > 1e-14 * (p[2].abs() + p[3]);
    if (nearer(a) && nearer(b) && nearer(c)) || (farther(a) && farther(b) && farther(c)) {
        return None;
    }
    let inverse = [1.0 / a[3], 1.0 / b[3], 1.0 / c[3]];
    let bounds = |i: usize| {
        let v = [a[i] * inverse[0], b[i] * inverse[1], c[i] * inverse[2]];
        (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]))
    };
    let ((x0, x1), (y0, y1)) = (bounds(0), bounds(1));
    samples.rect([x0, y0], [x1, y1])
}

/// The rectangle of a triangle with a corner that is not in front of the eye: clipped to a screen a
/// little wider than the true one, in homogeneous space. Only the rectangle comes of this; the
/// triangle itself is never clipped.
#[cold]
fn crossing_rect(lens: &Lens, corners: &[Clip; 3], samples: &Samples) -> Option<Rect> {
    // So much wider that rounding cannot make the difference.
    const WIDER: f64 = 1.01;
    const DEPTH_SLACK: f64 = 1e-9;
    let [low, high] = lens.range;
    let size = corners.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    let sides: [[f64; 4]; 6] = [
        [-1.0, 0.0, 0.0, -WIDER],
        [1.0, 0.0, 0.0, -WIDER],
        [0.0, -1.0, 0.0, -WIDER],
        [0.0, 1.0, 0.0, -WIDER],
        [0.0, 0.0, -1.0, low - DEPTH_SLACK],
        [0.0, 0.0, 1.0, -high - DEPTH_SLACK],
    ];
    // Points within rounding of a side count as inside.
    let sides = sides.map(|row| HalfSpace::new(row, size * 1e-14));
    let Ok(region) = sides.into_iter().collect::<Result<Vec<_>, _>>().and_then(Region::new) else {
        // A coordinate that is not finite: the surface will have none of it.
        return Some(samples.everything());
    };
    let mut clipper = Clipper::new();
    let polygon = clipper.clip(&region, corners);
    if polygon.is_empty() {
        return None;
    }
    let mut rect = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for p in polygon {
        // At the eye itself any direction may be meant.
        if p[3] <= size * 1e-9 || p[3].is_nan() {
            return Some(samples.everything());
        }
        for a in 0..2 {
            let v = p[a] / p[3];
            // Rounding of the clipping, relative to the size of the corners.
            let s = 1e-13 * size / p[3];
            rect[0][a] = rect[0][a].min(v - s);
            rect[1][a] = rect[1][a].max(v + s);
        }
    }
    samples.rect(rect[0], rect[1])
}

/// Whether a surface covers no sample of some pixels.
#[inline]
pub(crate) fn misses(surface: &Surface, rect: &Rect, samples: &Samples) -> bool {
    let [ox, oy] = samples.offsets();
    let low = [samples.x(rect.x[0], ox[0]), samples.y(rect.y[1], oy[1])];
    let high = [samples.x(rect.x[1], ox[1]), samples.y(rect.y[0], oy[0])];
    surface.misses(low, high)
}
