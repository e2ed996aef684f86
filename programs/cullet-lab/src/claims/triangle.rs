//! Triangles on the screen in f64, with bounds on what rounding does to them.
//!
//! A corner is a vector (x·w, y·w, w). The edge between two of them is their cross product e, and e
//! · (x, y, 1) is positive on one side of it. With all three of one sign, that of the determinant
//! of the corners, the ray of (x, y) meets the triangle, and in front of the eye: it is a sum of
//! the corners with positive weights. Nearness and the height over the near plane, each over w, are
//! the sums of the corners' values with the same weights, over the determinant: affine on the
//! screen.

use cullet::{Depth, Transform, View};

/// Bound on the rounding of a number that is summed from products of entries of matrices and a
/// point: their sizes times this. Three rows are summed and scaled, four products summed twice
/// over: less than 16 roundings of half a unit each.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A number, and how far it may be off.
#[derive(Clone, Copy, Debug)]
struct Number {
    value: f64,
    error: f64,
}

impl Number {
    fn new(value: f64, error: f64) -> Self {
        Self { value, error }
    }

    fn times(self, other: Self) -> Self {
        let value = self.value * other.value;
        let error = self.error * (other.value.abs() + other.error)
            + other.error * self.value.abs()
            + value.abs() * f64::EPSILON;
        Self { value, error }
    }

    fn plus(self, other: Self) -> Self {
        let value = self.value + other.value;
        Self { value, error: self.error + other.error + value.abs() * f64::EPSILON }
    }

    fn minus(self, other: Self) -> Self {
        self.plus(Self { value: -other.value, ..other })
    }

    fn over(self, other: Self) -> Self {
        let value = self.value / other.value;
        let error = (self.error + value.abs() * other.error) / (other.value.abs() - other.error)
            + value.abs() * f64::EPSILON;
        Self { value, error }
    }

    /// The product with a number that is exact.
    fn scaled(self, by: f64) -> Self {
        self.times(Self::new(by, 0.0))
    }

    fn has_sign(self) -> bool {
        self.value.abs() > self.error
    }
}

/// Rows that take a point of the world to x·w, y·w (pixels, down from the top left corner), w,
/// nearness·w and height over the near plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScreenRows {
    rows: [[f64; 4]; 5],
    /// Sums of the absolute values that the entries were summed from.
    sizes: [[f64; 4]; 5],
    size: [f64; 2],
    mirrored: bool,
}

impl ScreenRows {
    pub(super) fn new(view: &View, size: [u32; 2]) -> Self {
        let m = view.clip_from_world();
        let row = |r: usize| [m[r], m[4 + r], m[8 + r], m[12 + r]];
        let [x, y, z, w] = [row(0), row(1), row(2), row(3)];
        let perspective = !view.is_orthographic();
        // So that w is the distance along the line of view, or 1: a matrix may be times any factor.
        let unit =
            if perspective { w[..3].iter().map(|v| v * v).sum::<f64>().sqrt() } else { w[3] };
        let none = [0.0; 4];
        // Pairs of rows that are added, scaled: those of the screen, and what they were summed
        // from.
        let mix = |a: [f64; 4], b: [f64; 4], k: f64| -> [[f64; 4]; 2] {
            [
                std::array::from_fn(|i| (a[i] + b[i]) * k / unit),
                std::array::from_fn(|i| (a[i].abs() + b[i].abs()) * k / unit.abs()),
            ]
        };
        let minus = |a: [f64; 4]| a.map(|v| -v);
        let size = size.map(f64::from);
        let (far, near) = (mix(w, minus(z), 1.0), mix(z, none, 1.0));
        let (height, share) = match view.depth() {
            Depth::Standard => (near, far),
            Depth::Reversed => (far, near),
        };
        let nearness = if perspective { [[0.0, 0.0, 0.0, 1.0]; 2] } else { share };
        let all = [
            mix(x, w, 0.5 * size[0]),
            mix(w, minus(y), 0.5 * size[1]),
            mix(w, none, 1.0),
            nearness,
            height,
        ];
        let (rows, sizes) = (all.map(|r| r[0]), all.map(|r| r[1]));
        let share = share[0];
        // Right, up and towards the viewer are right-handed, unless something mirrors.
        let viewer = if perspective { w.map(|v| -v / unit) } else { share };
        let [a, b, c] = [x.map(|v| v / unit), y.map(|v| v / unit), viewer];
        let handed = a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        Self { rows, sizes, size, mirrored: handed < 0.0 }
    }

    /// The same for points before a transform.
    pub(super) fn of_object(&self, transform: &Transform) -> ObjectRows {
        let m = transform.to_matrix();
        let (mut rows, mut sizes) = ([[0.0; 4]; 5], [[0.0; 4]; 5]);
        for r in 0..5 {
            for column in 0..4 {
                let sum = |row: &[f64; 4], of: fn(f64) -> f64| -> f64 {
                    (0..4).map(|a| row[a] * of(m[column * 4 + a])).sum()
                };
                rows[r][column] = sum(&self.rows[r], |v| v);
                sizes[r][column] = sum(&self.sizes[r], f64::abs);
            }
        }
        let mirrored = self.mirrored ^ transform.is_mirrored();
        ObjectRows { rows, sizes, size: self.size, mirrored }
    }
}

/// The same rows, from the space of an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectRows {
    rows: [[f64; 4]; 5],
    /// Sums of the absolute values that the entries were summed from.
    sizes: [[f64; 4]; 5],
    size: [f64; 2],
    /// Whether what is wound outward is clockwise where it faces the eye.
    mirrored: bool,
}

/// A corner of a triangle.
#[derive(Clone, Copy, Debug)]
struct Corner {
    x: Number,
    y: Number,
    w: Number,
    nearness: Number,
    height: Number,
}

impl Corner {
    /// The same, its x and y relative to a pixel.
    fn relative_to(self, [x, y]: [f64; 2]) -> Self {
        Self { x: self.x.minus(self.w.scaled(x)), y: self.y.minus(self.w.scaled(y)), ..self }
    }

    fn is_in_front(&self) -> bool {
        self.level() >= 0.0 && self.w.value > self.w.error
    }

    /// Height over the near plane, 0 where that is rounding: a triangle that lies in the plane is
    /// all there, as its samples are.
    fn level(&self) -> f64 {
        let Number { value, error } = self.height;
        if value.abs() <= 64.0 * error { 0.0 } else { value }
    }

    fn place(&self) -> [f64; 2] {
        [self.x.value / self.w.value, self.y.value / self.w.value]
    }
}

impl ObjectRows {
    fn corner(&self, p: [f32; 3]) -> Corner {
        let p = p.map(f64::from);
        let number = |r: usize| {
            let (k, s) = (&self.rows[r], &self.sizes[r]);
            let value = k[0] * p[0] + k[1] * p[1] + k[2] * p[2] + k[3];
            let size = s[0] * p[0].abs() + s[1] * p[1].abs() + s[2] * p[2].abs() + s[3];
            Number::new(value, size * ROUNDING)
        };
        Corner { x: number(0), y: number(1), w: number(2), nearness: number(3), height: number(4) }
    }

    /// Whether anything of some triangles may be on the screen: not where all corners of the box
    /// around them are beyond one and the same edge of it, or before the near plane.
    pub(super) fn may_see(&self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> bool {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for p in triangles.as_flattened().iter().filter_map(|&v| positions.get(v as usize)) {
            for a in 0..3 {
                (low[a], high[a]) = (low[a].min(p[a]), high[a].max(p[a]));
            }
        }
        let mut beyond = 0b1_1111_u32;
        for corner in 0..8 {
            let p = std::array::from_fn(|a| if corner >> a & 1 == 1 { high[a] } else { low[a] });
            beyond &= self.beyond(&self.corner(p));
        }
        beyond == 0
    }

    /// The sides of the view volume that a corner is certainly beyond, one bit each.
    fn beyond(&self, c: &Corner) -> u32 {
        let [wide, high] = self.size;
        let negative = |n: Number| u32::from(n.value < -n.error);
        negative(c.x)
            | negative(c.y) << 1
            | negative(c.w.scaled(wide).minus(c.x)) << 2
            | negative(c.w.scaled(high).minus(c.y)) << 3
            | negative(c.height) << 4
    }
}

/// a·x + b·y + c, for x and y in pixels from a triangle's own pixel; at least `least` where it
/// counts as not negative.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Affine {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
    pub(super) least: f64,
}

impl Affine {
    /// Builds the function with the error bound for exact coordinates of at most `reach`.
    fn new([a, b, c]: [Number; 3], reach: [f64; 2]) -> Self {
        let size = a.value.abs() * reach[0] + b.value.abs() * reach[1] + c.value.abs();
        let error = a.error * reach[0] + b.error * reach[1] + c.error;
        Self { a: a.value, b: b.value, c: c.value, least: -(error + size * 4.0 * f64::EPSILON) }
    }

    #[inline(always)]
    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        self.a * x + self.b * y + self.c
    }

    /// How far it is from its value in the middle of a pixel at the most.
    #[inline(always)]
    pub(super) fn swing(&self) -> f64 {
        0.5 * (self.a.abs() + self.b.abs())
    }
}

/// A triangle that may cover samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    /// Positive inside.
    pub(super) edges: [Affine; 3],
    pub(super) nearness: Affine,
    /// Height over the near plane, where a corner is before it.
    pub(super) height: Option<Affine>,
    /// No part of it is farther.
    pub(super) farthest: f64,
    /// The pixel that the functions are relative to.
    pub(super) origin: [f64; 2],
    /// First and last column and row that it may touch.
    pub(super) columns: [u32; 2],
    pub(super) rows: [u32; 2],
}

impl Triangle {
    /// `None` where it covers nothing: beyond the screen, seen from a side that is not drawn, not
    /// finite, or so thin that its side is in doubt.
    pub(super) fn new(
        rows: &ObjectRows,
        positions: [[f32; 3]; 3],
        two_sided: bool,
        size: [u32; 2],
    ) -> Option<Self> {
        let corners = positions.map(|p| rows.corner(p));
        if corners.iter().fold(u32::MAX, |all, c| all & rows.beyond(c)) != 0 {
            return None;
        }
        let (columns, rows_of) = Self::rectangle(&corners, size)?;
        let origin = [columns, rows_of].map(|r| f64::from(r[0]));
        let span = [columns, rows_of].map(|r| f64::from(r[1] - r[0] + 1));
        let [p, q, r] = corners.map(|c| c.relative_to(origin));
        let line = |p: &Corner, q: &Corner| {
            [
                p.y.times(q.w).minus(p.w.times(q.y)),
                p.w.times(q.x).minus(p.x.times(q.w)),
                p.x.times(q.y).minus(p.y.times(q.x)),
            ]
        };
        let lines = [line(&q, &r), line(&r, &p), line(&p, &q)];
        let [a, b, c] = lines[0];
        let determinant = p.x.times(a).plus(p.y.times(b)).plus(p.w.times(c));
        // False for NaN.
        if !determinant.has_sign() {
            return None;
        }
        // y runs down: counter-clockwise is negative.
        let front = (determinant.value < 0.0) != rows.mirrored;
        if !(front || two_sided) {
            return None;
        }
        let sign = determinant.value.signum();
        let edges = lines.map(|l| Affine::new(l.map(|n| n.scaled(sign)), span));
        let sum = |of: [Number; 3]| {
            let term = |i: usize| {
                let [a, b, c] = [0, 1, 2].map(|corner| of[corner].times(lines[corner][i]));
                a.plus(b).plus(c).over(determinant)
            };
            Affine::new([term(0), term(1), term(2)], span)
        };
        let all = [p, q, r];
        let is_cut = all.iter().any(|c| c.height.value < 0.0);
        let farthest = all.iter().map(|c| {
            let n = c.nearness.over(c.w);
            // Behind the eye there is no place that says how far it is.
            if c.is_in_front() { n.value + n.error } else { f64::NEG_INFINITY }
        });
        let farthest = farthest.fold(f64::INFINITY, f64::min);
        let made = Self {
            edges,
            nearness: sum(all.map(|c| c.nearness)),
            height: is_cut.then(|| sum(all.map(|c| c.height))),
            farthest: if is_cut { f64::NEG_INFINITY } else { farthest },
            origin,
            columns,
            rows: rows_of,
        };
        let is_finite = |f: &Affine| (f.a + f.b + f.c + f.least).is_finite();
        (made.edges.iter().all(is_finite) && is_finite(&made.nearness)).then_some(made)
    }

    /// First and last column and row that may be touched.
    fn rectangle(corners: &[Corner; 3], size: [u32; 2]) -> Option<([u32; 2], [u32; 2])> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut hold = |p: [f64; 2]| {
            for a in 0..2 {
                // A NaN, of a near plane through the eye, holds everything.
                low[a] = if p[a] >= low[a] { low[a] } else { p[a] };
                high[a] = if p[a] <= high[a] { high[a] } else { p[a] };
                if p[a].is_nan() {
                    (low[a], high[a]) = (f64::NEG_INFINITY, f64::INFINITY);
                }
            }
        };
        for (k, c) in corners.iter().enumerate() {
            let next = &corners[(k + 1) % 3];
            if c.is_in_front() {
                hold(c.place());
            }
            let (h, g) = (c.level(), next.level());
            if (h >= 0.0) != (g >= 0.0) {
                let t = h / (h - g);
                let mix = |a: Number, b: Number| a.value + (b.value - a.value) * t;
                let w = mix(c.w, next.w);
                let over = if w > 0.0 { 1.0 / w } else { f64::NAN };
                hold([mix(c.x, next.x) * over, mix(c.y, next.y) * over]);
            } else if h >= 0.0 && !c.is_in_front() {
                hold([f64::NAN; 2]);
            }
        }
        let range = |a: usize| {
            let last = f64::from(size[a]) - 1.0;
            // More than any rounding of what is on the screen; what is far beyond it is cut off
            // anyway.
            let reach = 1e-3 + 1e-9 * (low[a].abs().min(1e9) + high[a].abs().min(1e9));
            let (first, end) = ((low[a] - reach).floor().max(0.0), (high[a] + reach).floor());
            (first <= last && end >= 0.0).then(|| [first as u32, end.min(last) as u32])
        };
        Some((range(0)?, range(1)?))
    }

    /// Its nearness at a place of the screen that it covers.
    pub(super) fn nearness_at(&self, place: [f64; 2]) -> Option<f64> {
        let [x, y] = [place[0] - self.origin[0], place[1] - self.origin[1]];
        let is_within = |f: &Affine| f.at(x, y) >= f.least;
        (self.edges.iter().all(is_within) && self.height.as_ref().is_none_or(is_within))
            .then(|| self.nearness.at(x, y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tolerance_is_less_than_a_billionth_of_a_pixel_in_the_middle_of_the_screen() {
        let size = [1280, 720];
        let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 1e3, size).unwrap();
        for (height, at) in [(0.02_f32, -3.0_f32), (1.0, -10.0), (40.0, -500.0)] {
            let rows = ScreenRows::new(&view, size).of_object(&Transform::IDENTITY);
            let corners = [[-height, -height, at], [height, -height, at], [0.0, height, at]];
            let t = Triangle::new(&rows, corners, false, size).unwrap();
            for e in t.edges {
                let width = -e.least / e.a.hypot(e.b);
                assert!(width > 0.0 && width < 1e-9, "{width}");
            }
            let share = -t.nearness.least * f64::from(-at);
            assert!(share > 0.0 && share < 1e-9, "{share}");
            // From behind.
            assert!(
                Triangle::new(&rows, [corners[0], corners[2], corners[1]], false, size).is_none()
            );
        }
    }
}
