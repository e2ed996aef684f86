//! Bézier patches: culled whole, before they are tessellated.
//!
//! Shirman & Abi-Ezzi, *The Cone of Normals Technique for Fast Processing of Curved Patches*
//! (1993), bound the normals of a patch by a cone and its points by the cone's apex, both from the
//! control net. Here the net yields planes, and every bound of [`cluster`](crate::methods::cluster)
//! can be fitted to them.
//!
//! The eye e is behind a patch at (u, v) where `S_u` × `S_v` · (S − e) > 0. That is a polynomial in
//! u and v, so a sum of Bernstein polynomials, which are not negative, with coefficients d − n·e:
//! planes that depend on the net alone. Where e is behind all of them the sum is positive
//! everywhere. Normals and points are taken together in each coefficient, which is tighter than any
//! normal with any point.
//!
//! A tessellation has other normals than its surface. A triangle with two sides along u and v has
//! the mean of `S_u`(a, v₀) × `S_v`(u₀, b) over a and b for its normal, where (u₀, v₀) is the
//! corner between them: a polynomial in four variables, with more planes and a smaller region, and
//! the surface is its case a = u₀, b = v₀. [`BezierPatch::planes`] are these;
//! [`BezierPatch::surface_planes`] hold for the surface alone. Measured from three radii on patches
//! that bend by a quarter of a circle both ways, the latter are behind in 19 to 20 per cent of
//! views and the former, which must hold for a grid of one cell too, in 6 to 7, where a grid of 8
//! by 8 is all back-facing in 23. On flatter ones less is lost: 27 and 15 of 33 on a wave, all of
//! 50 on a plane.
//!
//! Rational patches are out of scope: their normals have another form, and taken as polynomial ones
//! they would be culled wrongly.
//!
//! ```
//! use cullet::cull::backface::EllipticCone;
//! use cullet_lab::methods::BezierPatch;
//! use cullet_lab::methods::cluster::{ClusterFacing, TwoWay};
//!
//! // A sheet in x and y that bulges towards +z, from where it is counter-clockwise.
//! let net: Vec<[f32; 3]> = (0..16)
//!     .map(|i| ((i / 4) as f32, (i % 4) as f32))
//!     .map(|(x, y)| [x, y, 0.1 * (x * (3.0 - x) + y * (3.0 - y))])
//!     .collect();
//! let patch = BezierPatch::new([3, 3], &net)?;
//! let bound = TwoWay::<EllipticCone>::fit(&patch.planes());
//! assert_eq!(bound.facing([1.5, 1.5, -9.0, 1.0]), ClusterFacing::Back);
//! assert_eq!(bound.facing([1.5, 1.5, 9.0, 1.0]), ClusterFacing::Front);
//! assert_eq!(bound.facing([9.0, 1.5, 0.0, 1.0]), ClusterFacing::Mixed);
//! # Ok::<(), cullet_lab::methods::PatchError>(())
//! ```

use cullet::cull::backface::ClusterPlanes;
use cullet::math;
use glam::DVec3;
use thiserror::Error;

/// Why points are no control net.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PatchError {
    /// A degree out of range.
    #[error("degree {degree} along {along}; 1 to {limit} are possible", limit = BezierPatch::MAX_DEGREE)]
    Degree {
        /// `u` or `v`.
        along: char,
        /// The degree.
        degree: usize,
    },
    /// Not one point for each coefficient.
    #[error("{found} control points; degrees {} by {} need {expected}", degree[0], degree[1])]
    Points {
        /// Along u and v.
        degree: [usize; 2],
        /// How many these degrees need.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A control point with a NaN or infinite coordinate.
    #[error("control point {point} is not finite: {position:?}")]
    NotFinite {
        /// Number of the point.
        point: usize,
        /// Where it is.
        position: [f32; 3],
    },
}

/// The control net of a polynomial Bézier patch.
///
/// The front is where `S_u` × `S_v` points: a triangle of (0, 0), (1, 0) and (0, 1) is
/// counter-clockwise seen from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BezierPatch<'a> {
    degree: [usize; 2],
    points: &'a [[f32; 3]],
}

/// A coefficient whose normal is below this share of what it is added up from is too uncertain. A
/// sum of at most 4,096 terms is off by 4.5e-13 of that, which turns the normal by 4.5e-7 at most,
/// and moves the plane by as much of the patch's radius: what the bounds of clusters allow for.
const CERTAIN: f64 = 1e-6;

impl<'a> BezierPatch<'a> {
    /// The largest degree along a side.
    pub const MAX_DEGREE: usize = 8;

    /// A patch of `degree` along u and v. Point i·(degree along v + 1) + j is the coefficient of
    /// the i-th Bernstein polynomial in u and the j-th in v; the common bicubic patch has degrees 3
    /// and 3 and 16 points.
    ///
    /// # Errors
    /// If a degree is not in 1..=8, the number of points does not fit, or a point is not finite.
    pub fn new(degree: [usize; 2], points: &'a [[f32; 3]]) -> Result<Self, PatchError> {
        for (along, degree) in ['u', 'v'].into_iter().zip(degree) {
            if !(1..=Self::MAX_DEGREE).contains(&degree) {
                return Err(PatchError::Degree { along, degree });
            }
        }
        let expected = (degree[0] + 1) * (degree[1] + 1);
        if points.len() != expected {
            return Err(PatchError::Points { degree, expected, found: points.len() });
        }
        match points.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
            Some(point) => Err(PatchError::NotFinite { point, position: points[point] }),
            None => Ok(Self { degree, points }),
        }
    }

    /// The point of the surface at (u, v), in plain f64. Meant for u and v in 0..=1.
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> [f64; 3] {
        let [m, n] = self.degree;
        let (bu, bv) = (bernstein(m, u), bernstein(n, v));
        let mut sum = DVec3::ZERO;
        for i in 0..=m {
            for j in 0..=n {
                sum += self.at(i, j) * (bu[i] * bv[j]);
            }
        }
        sum.into()
    }

    /// The normal `S_u` × `S_v` at (u, v), not of unit length, in plain f64; zero at a pole.
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> [f64; 3] {
        let [m, n] = self.degree;
        let (mut along_u, mut along_v) = (DVec3::ZERO, DVec3::ZERO);
        let (bu, bv) = (bernstein(m, u), bernstein(n, v));
        let (cu, cv) = (bernstein(m - 1, u), bernstein(n - 1, v));
        for i in 0..=m {
            for j in 0..=n {
                if i < m {
                    along_u += (self.at(i + 1, j) - self.at(i, j)) * (cu[i] * bv[j] * m as f64);
                }
                if j < n {
                    along_v += (self.at(i, j + 1) - self.at(i, j)) * (bu[i] * cv[j] * n as f64);
                }
            }
        }
        along_u.cross(along_v).into()
    }

    /// Planes such that an eye behind them all is behind the surface, and behind every triangle of
    /// every tessellation whose corners are points of the surface and that have two sides along u
    /// and v (as the halves of the cells of any grid have), but for the rounding of those corners.
    ///
    /// (2m + 1)(2n + 1)mn planes for degrees m and n: 441 for a bicubic patch. Poles (edges that
    /// are one point) are no obstacle. A corner at which the two sides of the net are parallel, but
    /// not exactly so in f32, leaves the planes incomplete: no eye is behind.
    #[must_use]
    pub fn planes(&self) -> ClusterPlanes {
        let [m, n] = self.degree;
        let places = [2 * m + 1, m, 2 * n + 1, n];
        // u₀ is in S_v and in S, a in S_u alone; likewise v.
        self.coefficients(places.iter().product(), |[i, j, k, l, p, q]| {
            let weight = share([m, m], [k, p]) * share([n, n], [j, q]);
            (((k + p) * places[1] + i) * places[2] + j + q, l, places[3], weight)
        })
    }

    /// Planes such that an eye behind them all is behind the surface, though not always behind the
    /// triangles of a coarse tessellation. 9·m·n planes for degrees m and n: 81 for a bicubic
    /// patch; otherwise as [`planes`](Self::planes).
    #[must_use]
    pub fn surface_planes(&self) -> ClusterPlanes {
        let [m, n] = self.degree;
        self.coefficients(9 * m * n, |[i, j, k, l, p, q]| {
            let weight = share([m - 1, m, m], [i, k, p]) * share([n, n - 1, n], [j, l, q]);
            ((i + k + p) * 3 * n + j + l + q, 0, 1, weight)
        })
    }

    /// Adds up, for each side along u (i, j), side along v (k, l) and point (p, q) of the net, what
    /// belongs to one coefficient. `place` yields a number, a number below the third with which it
    /// is interleaved, and a weight.
    fn coefficients(
        &self,
        count: usize,
        place: impl Fn([usize; 6]) -> (usize, usize, usize, f64),
    ) -> ClusterPlanes {
        let [m, n] = self.degree;
        let points = || self.points.iter().map(|p| DVec3::from(p.map(f64::from)));
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
        // Offsets are relative to the middle until they are divided, or their rounding would be
        // that of a patch far from the origin.
        let middle = (low + high) * 0.5;
        let mut sums = vec![(DVec3::ZERO, 0.0, 0.0); count];
        for (i, j) in pairs(m, n + 1) {
            for (k, l) in pairs(m + 1, n) {
                let Some((normal, size)) = self.product([i, j], [k, l]) else { continue };
                for (p, q) in pairs(m + 1, n + 1) {
                    let (major, minor, minors, weight) = place([i, j, k, l, p, q]);
                    let sum = &mut sums[major * minors + minor];
                    sum.0 += normal * weight;
                    sum.1 += normal.dot(self.at(p, q) - middle) * weight;
                    sum.2 += size * weight;
                }
            }
        }
        // A sum of zeros alone is zero wherever the eye is.
        sums.retain(|(_, _, size)| *size > 0.0);
        let is_certain = |(normal, _, size): &(DVec3, f64, f64)| normal.length() > size * CERTAIN;
        let complete = sums.iter().all(is_certain);
        let planes = sums.iter().filter(|s| is_certain(s)).map(|(normal, offset, _)| {
            let (length, normal) = (normal.length(), normal.normalize());
            (normal.to_array(), offset / length + normal.dot(middle))
        });
        ClusterPlanes::of_planes(planes, [low.into(), high.into()], complete)
    }

    /// The product of a side along u and one along v, and of their lengths; `None` where it is
    /// exactly zero.
    fn product(&self, [i, j]: [usize; 2], [k, l]: [usize; 2]) -> Option<(DVec3, f64)> {
        let u = self.at(i + 1, j) - self.at(i, j);
        let v = self.at(k, l + 1) - self.at(k, l);
        let (normal, size) = (u.cross(v), u.length() * v.length());
        if normal.length() > size * CERTAIN {
            return Some((normal, size));
        }
        // Sides that are exactly parallel are common, as those of a quarter of a circle; what
        // merely rounds to it must not be taken for it.
        let exact = |a: DVec3, b: DVec3| (0..3).all(|k| is_exact(a[k], b[k]));
        let is_zero = exact(self.at(i, j), self.at(i + 1, j))
            && exact(self.at(k, l), self.at(k, l + 1))
            && (0..3).all(|x| {
                let [y, z] = [(x + 1) % 3, (x + 2) % 3];
                product(u[y], v[z]) == product(u[z], v[y])
            });
        (!is_zero).then_some((normal, size))
    }

    fn at(&self, i: usize, j: usize) -> DVec3 {
        self.points[i * (self.degree[1] + 1) + j].map(f64::from).into()
    }
}

/// Whether b − a is exact in f64, for numbers that are f32.
fn is_exact(a: f64, b: f64) -> bool {
    let sum = b - a;
    let part = sum + a;
    (b - part) + ((part - sum) - a) == 0.0
}

/// A product and what its rounding leaves: equal pairs are equal products, for numbers that are
/// differences of f32, whose products are far above the least that f64 holds.
fn product(a: f64, b: f64) -> [f64; 2] {
    math::two_product(a, b).into()
}

fn pairs(first: usize, second: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..first).flat_map(move |i| (0..second).map(move |j| (i, j)))
}

/// Ratio of the product of Bernstein polynomials of these degrees and numbers to the one of their
/// sums.
fn share<const N: usize>(degrees: [usize; N], numbers: [usize; N]) -> f64 {
    let parts: f64 = degrees.iter().zip(numbers).map(|(d, i)| binomial(*d, i)).product();
    parts / binomial(degrees.iter().sum(), numbers.iter().sum())
}

/// At most C(24, 12), which f64 holds.
fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64)
}

fn bernstein(n: usize, t: f64) -> [f64; BezierPatch::MAX_DEGREE + 1] {
    std::array::from_fn(|i| {
        if i > n {
            return 0.0;
        }
        binomial(n, i) * t.powi(i as i32) * (1.0 - t).powi((n - i) as i32)
    })
}
