//! Horizon culling: what lies behind the horizon of a globe, as the eye sees it.
//!
//! Space divided by the radii of an ellipsoid makes it the unit sphere, and straight lines stay
//! straight. With the eye e there, a point p is hidden if the way from e to p meets the sphere. The
//! hidden points are S = {e + s (q − e) : s ≥ 1, |q| ≤ 1}: beyond the plane of the horizon the
//! cone that touches the sphere, before it the cap of the sphere. S is convex, since s (q − e) and
//! s' (q' − e) have a mean of the same form. So a box is hidden as soon as its eight corners are,
//! and a ball as soon as it is on the inner side of all planes that touch S: those of the cone, and
//! those of the cap.
//!
//! The ellipsoid must lie within opaque ground that is drawn: [`Ellipsoid::lowered`] by the depth
//! of the lowest valley. An eye in or under the surface hides nothing.
//!
//! Kevin Ring, *Horizon Culling*, 2013, derives plane and cone for points, as `CesiumJS` uses them;
//! Cozzi & Ring, *3D Engine Design for Virtual Globes*, 2011, chapter 12, have it among the ways to
//! cull terrain. Boxes by their corners, the cap and the bounds of rounding are ours.
//!
//! ```
//! use cullet::cull::horizon::{Ellipsoid, Horizon};
//!
//! // Two metres above the equator, in metres from the centre of the earth.
//! let earth = Ellipsoid::WGS84;
//! let horizon = Horizon::from_eye(&earth, [6_378_139.0, 0.0, 0.0]);
//! // A house of ten metres 5 km away is still seen; one 20 km away is not.
//! let house = |away: f64| {
//!     let ground = (6_378_137_f64.powi(2) - away * away).sqrt();
//!     ([ground - 1.0, away, 0.0], [ground + 10.0, away + 10.0, 10.0])
//! };
//! let hides = |(low, high)| horizon.hides_box(low, high);
//! assert!(!hides(house(5e3)) && hides(house(20e3)));
//! ```

mod ellipsoid;
mod point;
mod vector;

use alloc::vec::Vec;

use crate::array::{self, Each};
use crate::bounds::{Aabb, ROUNDING};
#[cfg(not(feature = "std"))]
use crate::math::Float;
pub use ellipsoid::Ellipsoid;
use vector::{cross, dot, length1};

/// The horizon of an ellipsoid as seen by one eye: made once per view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Horizon {
    radii: [f64; 3],
    /// Factor from lengths to the longest that they become in space divided by the radii, rounded up.
    longest_scale: f64,
    /// The eye, in space divided by the radii.
    eye: [f64; 3],
    /// Squared distance of the eye from the centre, rounded up.
    squared: f64,
    /// Sum of |eyeᵢ|, for bounds of rounding.
    size: f64,
    /// Distance from the eye to its horizon, rounded up; NaN if nothing is hidden.
    reach: f64,
}

impl Horizon {
    /// Finds the horizon of `ellipsoid` for an eye in its coordinates. An eye that is not proved to
    /// be above the surface hides nothing; nor does one that is not finite.
    #[must_use]
    pub fn from_eye(ellipsoid: &Ellipsoid, eye: [f64; 3]) -> Self {
        let radii = ellipsoid.radii;
        let eye = array::from_fn(|a| eye[a] / radii[a]);
        let squared = dot(eye, eye);
        let slack = squared * ROUNDING;
        let above = squared - 1.0;
        // Written so that a NaN has no horizon.
        let reach = if ellipsoid.is_solid() && above > slack {
            (above + slack).sqrt() * (1.0 + ROUNDING)
        } else {
            f64::NAN
        };
        Self {
            radii,
            longest_scale: (1.0 + ROUNDING) / ellipsoid.bounds()[0],
            eye,
            squared: squared + slack,
            size: length1(eye),
            reach,
        }
    }

    /// Tests a box from corner `min` to corner `max`: `true` if no point of it can be seen past the
    /// ellipsoid. A box with a corner that is not finite is never hidden.
    #[must_use]
    pub fn hides_box(&self, min: [f64; 3], max: [f64; 3]) -> bool {
        // The ball around it answers for most boxes, at an eighth of the cost.
        let middle = self.scaled(array::from_fn(|a| min[a] * 0.5 + max[a] * 0.5));
        let half: [f64; 3] = array::from_fn(|a| (max[a] * 0.5 - min[a] * 0.5) / self.radii[a]);
        // The middle is off by up to 4 u of the corners, of which the farthest is about middle + half.
        let off = ROUNDING * (length1(middle) + length1(half));
        let radius = dot(half, half).sqrt() * (1.0 + ROUNDING) + off;
        self.hides_ball(middle, radius)
            || (0..8).all(|corner| {
                let at = |a: usize| if corner >> a & 1 == 0 { min[a] } else { max[a] };
                self.hides_point(array::from_fn(at))
            })
    }

    /// Tests all that lies between `points`, as the corners of a turned box: `true` if no point of
    /// their convex hull can be seen past the ellipsoid. No points are never hidden.
    #[must_use]
    pub fn hides_points(&self, points: &[[f64; 3]]) -> bool {
        !points.is_empty() && points.iter().all(|p| self.hides_point(*p))
    }

    /// Tests a sphere: `true` if no point of it can be seen past the ellipsoid. A radius that is
    /// negative or not finite is never hidden.
    ///
    /// Divided by the radii a sphere is an ellipsoid, which is taken for the ball around it: too
    /// large by the flattening, 0.3 % for the earth.
    #[must_use]
    pub fn hides_sphere(&self, centre: [f64; 3], radius: f64) -> bool {
        radius >= 0.0 && self.hides_ball(self.scaled(centre), radius * self.longest_scale)
    }

    /// Tests a horizon occlusion point: `true` if everything that it stands for is hidden.
    ///
    /// `point` is in space divided by the radii, as `quantized-mesh` (`HorizonOcclusionPoint`) and 3D
    /// Tiles (`TILE_HORIZON_OCCLUSION_POINT`, `3DTILES_horizon_occlusion_point`) have it, and as
    /// [`Ellipsoid::occlusion_point`] computes it. The ellipsoid has to be the one that it was made
    /// for, which is [WGS 84](Ellipsoid::WGS84) unless the file says otherwise; for one that is
    /// lowered, take [`Ellipsoid::lowered_occlusion_point`]. Whether all of a tile is hidden with its
    /// point is the file's promise. A point inside the ellipsoid stands for nothing, and is never
    /// hidden: files have (0, 0, 0) where they have no point.
    #[must_use]
    pub fn hides_occlusion_point(&self, point: [f64; 3]) -> bool {
        dot(point, point) >= 1.0 && self.hides_ball(point, 0.0)
    }

    /// Writes a mask of the boxes that are not hidden into `kept`, in place of what it held: bit i
    /// mod 64 of word i / 64 is that of box i. `boxes` are relative to `origin`.
    ///
    /// In the order of a scene's slots it is a mask of [candidates](crate::candidates::Candidates)
    /// for [`Culler::cull_among`](crate::Culler::cull_among). Two tests of a
    /// ball answer for most boxes; those that straddle the border take up to nine.
    pub fn keep_boxes(&self, origin: [f64; 3], boxes: &[Aabb], kept: &mut Vec<u64>) {
        kept.clear();
        kept.extend(boxes.chunks(64).map(|chunk| {
            let mut word = 0;
            for (i, b) in chunk.iter().enumerate() {
                let [min, max] =
                    [b.min, b.max].each(|c| array::from_fn(|a| origin[a] + f64::from(c[a])));
                word |= u64::from(!self.hides_box(min, max)) << i;
            }
            word
        }));
    }

    fn hides_point(&self, point: [f64; 3]) -> bool {
        self.hides_ball(self.scaled(point), 0.0)
    }

    fn scaled(&self, point: [f64; 3]) -> [f64; 3] {
        array::from_fn(|a| point[a] / self.radii[a])
    }

    /// Tests a ball in space divided by the radii.
    ///
    /// Coordinates come rounded once or, from a sum, twice. With u = 2⁻⁵³, the sum of their sizes
    /// m, and |e|₁ = Σ |eᵢ|, the dot product below is off by 7 u |e|₁ m, and the cross product by 9
    /// u |e|₁ m; `ROUNDING` is 16 u, and takes the sums as well.
    fn hides_ball(&self, centre: [f64; 3], radius: f64) -> bool {
        let e = self.eye;
        let d = array::from_fn(|a| centre[a] - e[a]);
        let (size, toward) = (length1(centre), -dot(e, d));
        let slack = ROUNDING * self.size * (self.size + size) * (1.0 + self.reach);
        // The cone: how far the ball is from its side, times |e|². All are written so that what is
        // not a number is not hidden.
        let across = cross(e, d);
        let inside = toward - self.reach * dot(across, across).sqrt() - slack;
        let is_in_cone = inside > radius * self.squared * (1.0 + ROUNDING);
        // The cap, if it and not its rim comes nearest to the ball.
        let far = dot(centre, centre).sqrt();
        let is_beside_cap = dot(centre, e) < far - ROUNDING * size * self.size;
        is_in_cone && (is_beside_cap || (far + radius) * (1.0 + ROUNDING) <= 1.0)
    }
}
