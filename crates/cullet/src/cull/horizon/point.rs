//! Horizon occlusion points: one point in place of all that a tile shows.
//!
//! In space divided by the radii the ellipsoid is the unit ball B. What an eye has behind B is convex
//! and holds B. So where it holds a point P, it holds the hull of B and P as well: the cone that
//! touches B, with its tip in P. The tip of a cone that holds a tile therefore stands for the tile.
//!
//! Let P have the direction D. A point p that is above the ground sees a cap of it, of the angle α
//! with cos α = 1/|p|, and it is in the cone of P if its cap is in the cap of P: if β + α ≤ γ, where β
//! is the angle of p and D, and cos γ = 1/|P|. Points inside B are in every cone.
//!
//! Ground that goes below the ellipsoid holds a ball of radius g < 1 only. From p an eye e > 1 can be
//! seen past that ball up to the angle acos(g/|p|) + acos(g/|e|), and from P past B up to γ +
//! acos(1/|e|). The difference acos(g/|e|) − acos(1/|e|) is largest at |e| = 1, where it is acos g. So
//! γ = β + acos(g/|p|) + acos g is enough for every eye above the ellipsoid.
//!
//! Kevin Ring, *Computing the horizon occlusion point*, 2013, has the angles for points above the
//! ellipsoid. The hull, ground below the ellipsoid and the bounds of rounding are ours.

use super::ellipsoid::Ellipsoid;
use super::vector::{cross, dot};
use crate::array;
use crate::bounds::ROUNDING;
#[cfg(not(feature = "std"))]
use crate::math::Float;

/// Bound of the rounding of a cosine of a sum of angles. Cosines and sines below are off by at most
/// 12 u each, with u = 2⁻⁵³, two products of two by 50 u, and the direction and length of the point
/// that comes of it by 10 u; this is 128 u. At the surface it is an angle of a metre on the earth.
const SLACK: f64 = 8.0 * ROUNDING;

impl Ellipsoid {
    /// Computes a horizon occlusion point, in space divided by the radii, for everything within
    /// `radius` of the convex hull of `points`: a box by its eight corners and radius 0, a sphere by
    /// its centre. `None` if there is no such point, as for a body that reaches around a quarter of
    /// the globe; for no points; and for numbers that are not finite, a negative `radius` or a NaN.
    ///
    /// `depth` is that of the lowest ground below this ellipsoid, 0 or less for none. For every eye
    /// above this ellipsoid, if the ellipsoid [hides](super::Horizon::hides_occlusion_point) the point,
    /// no part of the body can be seen past the ellipsoid [lowered](Self::lowered) by `depth`. The
    /// point is the lowest such point above the middle of the bounds of `points`. Costs two square
    /// roots per point.
    #[must_use]
    pub fn occlusion_point(
        &self,
        depth: f64,
        points: &[[f64; 3]],
        radius: f64,
    ) -> Option<[f64; 3]> {
        let ground = self.ground(depth)?;
        let radius = radius * (1.0 + ROUNDING) / self.bounds()[0];
        // The cone of a point and its ball is that of the point on a smaller ground.
        let level = ground - radius;
        if !(radius >= 0.0 && level > 0.0) {
            return None;
        }
        let scaled = |p: &[f64; 3]| -> [f64; 3] { array::from_fn(|a| p[a] / self.radii[a]) };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points.iter().map(scaled) {
            (low, high) =
                (array::from_fn(|a| low[a].min(p[a])), array::from_fn(|a| high[a].max(p[a])));
        }
        let middle: [f64; 3] = array::from_fn(|a| low[a] + high[a]);
        let length = dot(middle, middle).sqrt();
        let axis: [f64; 3] = array::from_fn(|a| middle[a] / length);
        let mut least = 1.0_f64;
        for p in points.iter().map(scaled) {
            let distance = dot(p, p).sqrt();
            // All of its ball is below the ground, and seen from nowhere.
            if distance * (1.0 + ROUNDING) <= level {
                continue;
            }
            let (along, above) = (dot(p, axis) / distance, level / distance);
            // Written so that a NaN has no point. The sum of two angles below 90° has its cosine.
            if !(along > 0.0 && above > 0.0) {
                return None;
            }
            let across = cross(p, axis);
            let across = dot(across, across).sqrt() / distance;
            least = least.min(along * above - across * sine(above));
        }
        // An axis that is none, with all points below the ground.
        if !(length > 0.0 && least > SLACK) {
            return None;
        }
        let cosine = add_ground(least, ground);
        (cosine > 0.0).then(|| array::from_fn(|a| axis[a] / cosine))
    }

    /// Returns the horizon occlusion point for the ellipsoid [lowered](Self::lowered) by `depth`, in
    /// space divided by the radii of that, where `point` is one for this ellipsoid. If the lowered
    /// ellipsoid hides the result, it hides everything that `point` stands for, as long as `point` was
    /// computed with ground below the ellipsoid taken into account, or raised to the ellipsoid.
    ///
    /// `None` if there is no such point, or `point` is inside this ellipsoid or not finite. With a
    /// `depth` of 0 or less it is `point` itself.
    ///
    /// ```
    /// use cullet::cull::horizon::{Ellipsoid, Horizon};
    ///
    /// // A hut on the equator and its point, as a file has it; the ground may be 500 m lower.
    /// let earth = Ellipsoid::WGS84;
    /// let hut = earth.occlusion_point(0.0, &[[6_378_140.0, 0.0, 0.0]], 5.0).unwrap();
    /// let lower = earth.lowered_occlusion_point(500.0, hut).unwrap();
    /// // Two metres above the ellipsoid, so many kilometres away.
    /// let eye = |km: f64| {
    ///     let (sin, cos) = (km / 6378.137).sin_cos();
    ///     [cos, sin, 0.0].map(|c| c * 6_378_139.0)
    /// };
    /// let hides = |km| Horizon::from_eye(&earth, eye(km)).hides_occlusion_point(hut);
    /// assert!(!hides(14.0) && hides(16.0));
    /// let ground = earth.lowered(500.0);
    /// let hides = |km| Horizon::from_eye(&ground, eye(km)).hides_occlusion_point(lower);
    /// assert!(!hides(169.0) && hides(171.0));
    /// ```
    #[must_use]
    pub fn lowered_occlusion_point(&self, depth: f64, point: [f64; 3]) -> Option<[f64; 3]> {
        let ground = self.ground(depth)?;
        let distance = dot(point, point).sqrt();
        if !(distance >= 1.0 && distance.is_finite()) {
            return None;
        }
        if ground == 1.0 {
            return Some(point);
        }
        let cosine = add_ground(1.0 / distance, ground);
        (cosine > 0.0).then(|| array::from_fn(|a| point[a] / (distance * cosine)))
    }

    /// Scale of the ground; `None` where it holds no ball.
    fn ground(&self, depth: f64) -> Option<f64> {
        let level = self.level(depth);
        (self.is_solid() && level > 0.0).then_some(level)
    }
}

/// Cosine of the sum of two angles by their cosines, that of the ground being the second; rounded
/// down.
fn add_ground(cosine: f64, ground: f64) -> f64 {
    let below = if ground < 1.0 { sine(cosine) * sine(ground) } else { 0.0 };
    cosine * ground - below - SLACK
}

/// Sine of an angle up to 90° by its cosine, which may be off by 7 u; rounded up.
fn sine(cosine: f64) -> f64 {
    (((1.0 - cosine) * (1.0 + cosine)).max(0.0) + ROUNDING).sqrt()
}
