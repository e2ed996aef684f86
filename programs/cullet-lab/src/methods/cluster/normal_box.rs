//! The bound of Johannsen & Carter: the normals of a cluster in a box.
//!
//! A. Johannsen & M. B. Carter, *Clustered Backface Culling* (1998), as taught in Zachmann's
//! lectures. With m′ ≤ n ≤ m on each axis for every normal, and n·(p − c) ≥ d for every plane, the
//! eye e is behind them all where the largest n·(e − c) of the box of normals, Σ max(mₖvₖ, m′ₖvₖ)
//! with v = e − c, is below d.
//!
//! The lectures leave open where to put c and whether to turn the axes. Measured: the middle of the
//! cluster's box is as good as any other c, a common origin for all clusters is the smallest and
//! the loosest, and axes along the cluster's own normals gain what three more vectors cost. The
//! lectures of 2014 choose the signs from the position of the eye, `w_e`·(e − c); they must come
//! from v = e − c.

use cullet::cull::backface::{ClusterEye, ClusterPlanes, EllipticCone};
use fearless_simd::{Simd, prelude::*};
use glam::{DMat3, DVec3};

use super::lanes::{self, Row, plain};
use super::{Blocks, Bound, dot};

/// Distance that a side of the box of normals is moved out: the rounding of the test (3e-7 of each
/// product), of the box to f32, and the normals' own doubt.
const SIDE_SLACK: f64 = 2e-6;

/// The box of normals relative to an origin of the cluster's own: 40 bytes.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct NormalBox {
    /// The largest of each component of the normals.
    pub largest: [f32; 3],
    /// The smallest.
    pub smallest: [f32; 3],
    /// No plane is nearer to `origin` along its normal: n·(p − origin) ≥ d.
    pub d: f32,
    /// Where `d` is measured from.
    pub origin: [f32; 3],
}

/// The box of normals relative to the origin of the mesh: 28 bytes.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct NormalBoxAtOrigin {
    /// The largest of each component of the normals.
    pub largest: [f32; 3],
    /// The smallest.
    pub smallest: [f32; 3],
    /// n·p ≥ d for every plane.
    pub d: f32,
}

/// The box of normals in axes of the cluster's own: 76 bytes.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct NormalBoxTurned {
    /// Unit axes, the first along the middle of the normals.
    pub axes: [[f32; 3]; 3],
    /// The box in these axes.
    pub bounds: NormalBox,
}

impl NormalBox {
    /// The bound with its origin at `origin`; `None` where there is none, as in [`Bound::fit`].
    #[must_use]
    pub fn fit_at(planes: &ClusterPlanes, origin: [f64; 3]) -> Option<Self> {
        Self::fit_in(planes, origin, DMat3::IDENTITY)
    }

    /// The bound with the best origin of nine, the middle and the corners of the cluster's box,
    /// judged by 64 eyes at four radii. Gains next to nothing over the middle; kept to show it.
    #[must_use]
    pub fn fit_best(planes: &ClusterPlanes) -> Option<Self> {
        let eyes = |i: u32| {
            // Fibonacci directions.
            let z = (f64::from(i) + 0.5) / 32.0 - 1.0;
            let angle = f64::from(i) * 2.399_963_229_728_653;
            let r = (1.0 - z * z).sqrt();
            let direction = DVec3::new(r * angle.cos(), r * angle.sin(), z);
            (DVec3::from(planes.centre()) + direction * (4.0 * planes.radius())).extend(1.0)
        };
        let (centre, half) = (planes.centre(), planes.half_extent());
        let corner = |i: usize| {
            std::array::from_fn(|k| centre[k] + if i >> k & 1 == 1 { half[k] } else { -half[k] })
        };
        let origins = std::iter::once(planes.centre()).chain((0..8).map(corner));
        let fits = origins.filter_map(|origin| Self::fit_at(planes, origin));
        let behind = |b: &Self| (0..64).filter(|&i| b.is_behind(eyes(i).to_array())).count();
        // The first of equals, the middle, is the one to have.
        fits.map(|b| (behind(&b), b)).reduce(|a, b| if b.0 > a.0 { b } else { a }).map(|(_, b)| b)
    }

    fn fit_in(planes: &ClusterPlanes, origin: [f64; 3], axes: DMat3) -> Option<Self> {
        if !planes.is_usable() {
            return None;
        }
        let origin = DVec3::from(origin).as_vec3();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut d = f64::INFINITY;
        for (n, offset) in planes.half_spaces() {
            let n = DVec3::from(n);
            d = d.min(offset - n.dot(origin.as_dvec3()));
            let n = axes.transpose() * n;
            (low, high) = (low.min(n), high.max(n));
        }
        // Zero in the box would let no eye pass however far, but near ones may.
        let slack = planes.slack(origin.as_dvec3().into());
        let out = |v: DVec3, by: f64| (v + DVec3::splat(by)).as_vec3().to_array();
        Some(Self {
            largest: out(high, SIDE_SLACK),
            smallest: out(low, -SIDE_SLACK),
            d: ((d - slack) as f32).next_down(),
            origin: origin.into(),
        })
    }

    /// A bound of two clusters together, relative to `origin`.
    ///
    /// Both distances are first moved to the common origin c′: n·(p − c′) ≥ d − h(c′ − c) with h
    /// the largest n·(c′ − c) of the box of normals. Taking the smaller of two distances from
    /// different origins would be wrong.
    #[must_use]
    pub fn join(&self, other: &Self, origin: [f32; 3]) -> Self {
        let moved = |b: &Self| {
            let v: [f64; 3] =
                std::array::from_fn(|k| f64::from(origin[k]) - f64::from(b.origin[k]));
            f64::from(b.d) - support(b, v)
        };
        // The eye's rounding to f32 depends on the origin: see [`ClusterPlanes::slack`].
        let size = self.origin.iter().chain(&other.origin).chain(&origin);
        let size = size.fold(0.0, |a: f64, v| a.max(f64::from(v.abs())));
        let d = moved(self).min(moved(other)) - size * f64::from(f32::EPSILON) * 2.0;
        Self {
            largest: std::array::from_fn(|k| self.largest[k].max(other.largest[k])),
            smallest: std::array::from_fn(|k| self.smallest[k].min(other.smallest[k])),
            d: (d as f32).next_down(),
            origin,
        }
    }

    /// The half-spaces n·x ≤ d, as (n, d), whose intersection is the culling volume: one for each
    /// corner of the box of normals.
    #[must_use]
    pub fn half_spaces(&self) -> [([f64; 3], f64); 8] {
        std::array::from_fn(|i| {
            let n: [f64; 3] = std::array::from_fn(|k| {
                f64::from(if i >> k & 1 == 1 { self.largest[k] } else { self.smallest[k] })
            });
            let offset: f64 = (0..3).map(|k| n[k] * f64::from(self.origin[k])).sum();
            (n, f64::from(self.d) + offset)
        })
    }
}

/// The largest n·v of the box of normals.
fn support(b: &NormalBox, v: [f64; 3]) -> f64 {
    (0..3).map(|k| f64::max(f64::from(b.largest[k]) * v[k], f64::from(b.smallest[k]) * v[k])).sum()
}

/// Σ max(mₖvₖ, m′ₖvₖ), as the batch tests add it up.
#[inline(always)]
fn farthest(largest: [f32; 3], smallest: [f32; 3], v: [f32; 3]) -> f32 {
    let part = |k: usize| {
        let (a, b) = (largest[k] * v[k], smallest[k] * v[k]);
        if a > b { a } else { b }
    };
    part(0) + part(1) + part(2)
}

impl Bound for NormalBox {
    type Batch = Blocks<Self>;

    /// Fits with the origin in the middle of the cluster's box.
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        Self::fit_at(planes, planes.centre())
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        farthest(self.largest, self.smallest, eye.way_from(self.origin)) < self.d * eye.weight()
    }
}

impl Bound for NormalBoxAtOrigin {
    type Batch = Blocks<Self>;

    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        let NormalBox { largest, smallest, d, .. } = NormalBox::fit_at(planes, [0.0; 3])?;
        Some(Self { largest, smallest, d })
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        farthest(self.largest, self.smallest, eye.xyz()) < self.d * eye.weight()
    }
}

impl Bound for NormalBoxTurned {
    type Batch = Blocks<Self>;

    /// Fits with the origin at the apex of the cones, the axes along the ellipse of the normals.
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        let apex = planes.apex(0.0)?;
        // The longer half-axis of the ellipse.
        let long = DVec3::from(EllipticCone::fit_doubting(planes, 0.0)?.s.map(f64::from));
        let axis = DVec3::from(apex.axis);
        let along = (long - axis * long.dot(axis)).try_normalize();
        let along = along.unwrap_or_else(|| DVec3::from(apex.across[0]));
        let axes = DMat3::from_cols(axis, along, axis.cross(along));
        let mut bounds = NormalBox::fit_in(planes, apex.point, axes)?;
        // The axes as f32 turn a line of sight once more.
        let more = SIDE_SLACK as f32;
        bounds.largest = bounds.largest.map(|v| v + more);
        bounds.smallest = bounds.smallest.map(|v| v - more);
        let axes = [axes.x_axis, axes.y_axis, axes.z_axis].map(|v| v.as_vec3().to_array());
        Some(Self { axes, bounds })
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        let NormalBox { largest, smallest, d, origin } = self.bounds;
        let v = eye.way_from(origin);
        farthest(largest, smallest, self.axes.map(|axis| dot(axis, v))) < d * eye.weight()
    }
}

plain!(NormalBox, 10, |simd, block, start, eye| {
    let v = lanes::to_eye(simd, block.three(7), start, eye);
    behind_box(simd, [block.three(0), block.three(3)], block.one(6), v, start, eye)
});

plain!(NormalBoxAtOrigin, 7, |simd, block, start, eye| {
    let v = eye.xyz().map(|v| S::f32s::splat(simd, v));
    behind_box(simd, [block.three(0), block.three(3)], block.one(6), v, start, eye)
});

plain!(NormalBoxTurned, 19, |simd, block, start, eye| {
    let v = lanes::to_eye(simd, block.three(16), start, eye);
    let v = [
        lanes::dot::<S>(lanes::rows(simd, block.three(0), start), v),
        lanes::dot::<S>(lanes::rows(simd, block.three(3), start), v),
        lanes::dot::<S>(lanes::rows(simd, block.three(6), start), v),
    ];
    behind_box(simd, [block.three(9), block.three(12)], block.one(15), v, start, eye)
});

/// Σ max(mₖvₖ, m′ₖvₖ) < d.
#[inline(always)]
fn behind_box<S: Simd>(
    simd: S,
    [largest, smallest]: [&[Row; 3]; 2],
    d: &Row,
    v: [S::f32s; 3],
    start: usize,
    eye: &ClusterEye,
) -> u64 {
    let part = |k: usize| {
        let a = lanes::load::<S>(simd, &largest[k], start) * v[k];
        let b = lanes::load::<S>(simd, &smallest[k], start) * v[k];
        a.max(b)
    };
    let sum = part(0) + part(1) + part(2);
    let d = lanes::load::<S>(simd, d, start) * S::f32s::splat(simd, eye.weight());
    sum.simd_lt(d).to_bitmask()
}
