//! Oriented boxes.

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};

use super::aabb::{round_up, surface_area};
use super::fit;
use super::plane::ROUNDING;
use super::{Aabb, Plane, Side};

/// A box with three axes of its own: all points `center + Σ tᵢ·half[i]·axes[i]` with |tᵢ| ≤ 1.
///
/// The axes are unit and orthogonal but for their rounding to f32. The set is what that formula says,
/// so a test of it needs no allowance for axes that are not quite square to each other.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Obb {
    /// The middle of the box.
    pub center: [f32; 3],
    /// Unit axes, one a row.
    pub axes: [[f32; 3]; 3],
    /// Half the length along each axis; a negative one means empty.
    pub half: [f32; 3],
}

pub(super) const IDENTITY: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Obb {
    /// The box of nothing: joining it with another gives the other.
    pub const EMPTY: Self = Self { center: [0.0; 3], axes: IDENTITY, half: [-1.0; 3] };
    /// The whole of space; what stands for missing or non-finite bounds.
    pub const EVERYTHING: Self =
        Self { center: [0.0; 3], axes: IDENTITY, half: [f32::INFINITY; 3] };

    /// A tight box around `points`: every point is in it in exact arithmetic, and its surface is
    /// never larger than that of the axis-aligned box written as an `Obb`.
    ///
    /// Surface, not volume, is made small, because the chance that a box meets a plane or a view
    /// goes with it, and flat point sets still compare. No point gives [`Obb::EMPTY`]; a point that is not
    /// finite gives [`Obb::EVERYTHING`]. About 10 to 30 passes over the points, and a sort of those on
    /// their outline: some 0.3 to 0.8 µs a point, so a thing for loading, not for every frame.
    ///
    /// (Start: Larsson & Källberg, *Fast Computation of Tight-Fitting Oriented Bounding Boxes*, 2011, and
    /// the principal axes. Then each axis in turn is held and the smallest rectangle around it found:
    /// Toussaint, *Solving Geometric Problems with the Rotating Calipers*, 1983.)
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
        let points: Vec<DVec3> =
            points.iter().map(|p| DVec3::from(p.map(f64::from)) - middle).collect();
        let aligned = Self::from(&b);
        match Self::fit(&points, middle, 0.0) {
            Some(fitted) if fitted.surface_area() < aligned.surface_area() => fitted,
            _ => aligned,
        }
    }

    /// A tight box around `points`, each given relative to `middle` and uncertain by `error` in each
    /// coordinate. `None` where numbers overflow.
    fn fit(points: &[DVec3], middle: DVec3, error: f64) -> Option<Self> {
        let aligned = Self::around(points, middle, error, &DMat3::IDENTITY);
        let axes = fit::tight_axes(points);
        let found = Self::around(points, middle, error, &axes);
        match (aligned, found) {
            (Some(a), Some(f)) if f.surface_area() < a.surface_area() => Some(f),
            (Some(a), _) => Some(a),
            (None, f) => f,
        }
    }

    /// The box with these axes (columns) around points given relative to `middle`. `None` where the
    /// axes are dependent or a number overflows f32.
    fn around(points: &[DVec3], middle: DVec3, error: f64, axes: &DMat3) -> Option<Self> {
        // The axes as they will be stored: what they lack in squareness, their inverse makes good.
        let axes = [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.to_array().map(|v| v as f32));
        let [x, y, z] = axes.map(|a| DVec3::from(a.map(f64::from)));
        let columns = DMat3::from_cols(x, y, z);
        let inverse = columns.inverse();
        if !inverse.is_finite() {
            return None;
        }
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &p in points {
            let t = inverse * p;
            low = low.min(t);
            high = high.max(t);
        }
        let center = (middle + columns * ((low + high) * 0.5)).to_array().map(|v| v as f32);
        let shift = DVec3::from(center.map(f64::from)) - middle;
        let mut half = DVec3::ZERO;
        for &p in points {
            half = half.max((inverse * (p - shift)).abs());
        }
        let abs =
            DMat3::from_cols(inverse.x_axis.abs(), inverse.y_axis.abs(), inverse.z_axis.abs());
        // The points lie within |columns|·half of the centre; the centre and they are off by a few u
        // of their size.
        let size = half.max_element() * 3.0 + shift.abs().max_element();
        let slack = abs * DVec3::splat(error + size * ROUNDING)
            + abs * (middle.abs() + DVec3::from(center.map(f64::from)).abs()) * f64::EPSILON;
        let half = (half * (1.0 + ROUNDING) + slack).to_array().map(round_up);
        let b = Self { center, axes, half };
        b.is_finite().then_some(b)
    }

    /// A tight box around the parallelepiped with this middle and these half edges (columns), all of
    /// which may be off by `error` in each coordinate.
    pub(crate) fn around_parallelepiped(center: DVec3, edges: &DMat3, error: f64) -> Self {
        let corners = fit::corners(edges);
        let lengths = [edges.x_axis, edges.y_axis, edges.z_axis].map(DVec3::length);
        let longest = lengths.iter().fold(0.0, |a: f64, &b| a.max(b));
        let square = |a: DVec3, b: DVec3| a.dot(b).abs() <= 1e-7 * a.length() * b.length();
        let flat = lengths.iter().any(|&l| l <= 1e-6 * longest);
        // Square edges are the axes themselves; a search could only lose digits.
        let own = square(edges.x_axis, edges.y_axis)
            && square(edges.y_axis, edges.z_axis)
            && square(edges.z_axis, edges.x_axis)
            && !flat;
        let b = if own {
            let unit = |a: DVec3| a / a.length();
            let axes = DMat3::from_cols(unit(edges.x_axis), unit(edges.y_axis), unit(edges.z_axis));
            Self::around(&corners, center, error, &axes)
        } else {
            Self::fit(&corners, center, error)
        };
        b.unwrap_or(Self::EVERYTHING)
    }

    /// Whether there is no point in the box. One with a NaN is not empty: what it holds is not known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !self.numbers().any(f32::is_nan) && self.half.iter().any(|&h| h < 0.0)
    }

    /// Whether all fifteen numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.numbers().all(f32::is_finite)
    }

    fn numbers(&self) -> impl Iterator<Item = f32> {
        self.center.into_iter().chain(self.axes.into_iter().flatten()).chain(self.half)
    }

    /// The area of the surface; 0 for an empty box.
    #[must_use]
    pub fn surface_area(&self) -> f64 {
        if self.is_empty() { 0.0 } else { surface_area(self.half.map(f64::from)) }
    }

    /// The volume; 0 for an empty box.
    #[must_use]
    pub fn volume(&self) -> f64 {
        if self.is_empty() { 0.0 } else { self.half.iter().map(|&h| 2.0 * f64::from(h)).product() }
    }

    /// The eight corners, in f64; bit 0, 1, 2 of the index choose the high end of axis 0, 1, 2.
    #[must_use]
    pub fn corners(&self) -> [[f64; 3]; 8] {
        let center = DVec3::from(self.center.map(f64::from));
        fit::corners(&self.half_edges()).map(|c| (center + c).into())
    }

    /// half[i] · axes[i] as columns; each product of two f32 is exact.
    fn half_edges(&self) -> DMat3 {
        let [x, y, z] = std::array::from_fn(|a| {
            DVec3::from(self.axes[a].map(f64::from)) * f64::from(self.half[a])
        });
        DMat3::from_cols(x, y, z)
    }

    /// Whether `point` is in the box, its surface included, by f64 arithmetic.
    #[must_use]
    pub fn contains(&self, point: [f32; 3]) -> bool {
        let [x, y, z] = self.axes.map(|a| DVec3::from(a.map(f64::from)));
        let offset = DVec3::from(point.map(f64::from)) - DVec3::from(self.center.map(f64::from));
        let t = DMat3::from_cols(x, y, z).inverse() * offset;
        t.abs().cmple(DVec3::from(self.half.map(f64::from))).all()
    }

    /// A tight box around both, fitted to the corners of both and rounded outward;
    /// [`Obb::EVERYTHING`] where either is not finite.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return if self.is_empty() { *other } else { *self };
        }
        if !(self.is_finite() && other.is_finite()) {
            return Self::EVERYTHING;
        }
        let middle = DVec3::from(self.center.map(f64::from));
        let mut points = Vec::with_capacity(16);
        let mut size = 0.0_f64;
        for b in [self, other] {
            let shift = DVec3::from(b.center.map(f64::from)) - middle;
            points.extend(fit::corners(&b.half_edges()).map(|c| shift + c));
            size = size.max(DVec3::from(b.center.map(f64::from)).abs().max_element());
        }
        size += points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        Self::fit(&points, middle, size * ROUNDING).unwrap_or(Self::EVERYTHING)
    }

    /// The lowest and the highest n·x − d over the box, each rounded outward so that the true values
    /// lie between them. The normal need not be of unit length.
    ///
    /// Empty gives `[∞, −∞]`; a number that is NaN or infinite gives `[−∞, ∞]`.
    #[must_use]
    pub fn span(&self, plane: &Plane) -> [f64; 2] {
        if self.is_empty() {
            return [f64::INFINITY, f64::NEG_INFINITY];
        }
        if !self.is_finite() {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let n = DVec3::from(plane.normal);
        let c = DVec3::from(self.center.map(f64::from));
        let (mut reach, mut size) = (0.0, n.abs().dot(c.abs()) + plane.d.abs());
        for a in 0..3 {
            let axis = DVec3::from(self.axes[a].map(f64::from));
            let half = f64::from(self.half[a]);
            reach += half * n.dot(axis).abs();
            size += half * n.abs().dot(axis.abs());
        }
        let middle = n.dot(c) - plane.d;
        let slack = size * ROUNDING + f64::MIN_POSITIVE;
        [middle - reach - slack, middle + reach + slack]
    }

    /// Where the box lies: each of the two certain answers is proved, rounding included. Empty is
    /// [`Side::Outside`] (there is nothing to see), NaN or infinite is [`Side::Straddling`].
    #[must_use]
    pub fn side(&self, plane: &Plane) -> Side {
        Side::from_span(self.span(plane))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Plane = Plane::new([1.0, 0.0, 0.0], 0.0);

    fn turned() -> Obb {
        // A square in x and y, standing on its corner.
        let h = std::f32::consts::FRAC_1_SQRT_2;
        Obb {
            center: [2.0, 0.0, 0.0],
            axes: [[h, h, 0.0], [-h, h, 0.0], [0.0, 0.0, 1.0]],
            half: [1.0; 3],
        }
    }

    #[test]
    fn three_answers_and_their_edges() {
        let mut b = turned();
        assert_eq!(b.side(&X), Side::Outside);
        b.center[0] = -1.5;
        assert_eq!(b.side(&X), Side::Inside);
        b.center[0] = 1.4;
        assert_eq!(b.side(&X), Side::Straddling);
        b.center[0] = 1.42;
        assert_eq!(b.side(&X), Side::Outside, "half a diagonal is 1.4142");
    }

    #[test]
    fn empty_nan_and_infinite_boxes() {
        assert_eq!(Obb::EMPTY.side(&X), Side::Outside);
        assert_eq!(Obb::EVERYTHING.side(&X), Side::Straddling);
        let mut b = turned();
        b.axes[2][2] = f32::NAN;
        assert_eq!(b.side(&X), Side::Straddling);
        assert_eq!(Obb::from_points(&[]), Obb::EMPTY);
        assert_eq!(Obb::from_points(&[[0.0, f32::INFINITY, 0.0]]), Obb::EVERYTHING);
    }

    #[test]
    fn a_turned_box_is_found_again() {
        let b = turned();
        let points = b.corners().map(|c| c.map(|v| v as f32));
        let fitted = Obb::from_points(&points);
        assert!((fitted.surface_area() - 24.0).abs() < 1e-4, "{fitted:?}");
        let aligned = Aabb::from_points(&points);
        assert!(aligned.surface_area() > 1.3 * fitted.surface_area());
    }

    #[test]
    fn flat_long_and_single_sets_have_a_box() {
        let line: Vec<[f32; 3]> = (0..9).map(|i| [i as f32, i as f32 * 2.0, 1.0]).collect();
        let b = Obb::from_points(&line);
        assert!(b.surface_area() < 1e-4 && line.iter().all(|&p| b.contains(p)), "{b:?}");
        let b = Obb::from_points(&[[5.0, 6.0, 7.0]]);
        assert!(b.contains([5.0, 6.0, 7.0]) && b.surface_area() < 1e-9, "{b:?}");
    }
}
