//! The elliptic cone in 21 bytes.

use cullet::cull::backface::{Apex, ClusterEye, ClusterPlanes, EllipticCone};
use fearless_simd::Simd;
use glam::DVec3;

use super::lanes::{self, ByteRow, Lanes, Row, ZEROS};
use super::margin::elliptic_margin;
use super::{Blocks, Bound, dot};

/// An [`EllipticCone`] in 21 bytes: directions in signed bytes, on one scale.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct EllipticConeQuantised {
    /// A point behind every plane.
    pub apex: [f32; 3],
    /// Axis as in [`EllipticCone`], all three numbers on one scale.
    pub axis: [i8; 3],
    /// One half-axis.
    pub s: [i8; 3],
    /// The other.
    pub t: [i8; 3],
}

impl Bound for EllipticConeQuantised {
    type Batch = Blocks<Self>;

    const BYTES: usize = 21;

    /// Rounds an ellipse on several scales, grows each until every normal is inside again, and
    /// takes the smallest.
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        let fit = planes.apex(0.0)?;
        let cone = EllipticCone::fit_doubting(planes, 0.0)?;
        let [axis, s, t] = [cone.axis, cone.s, cone.t].map(|v| DVec3::from(v.map(f64::from)));
        let largest = [axis, s, t].map(|v| v.abs().max_element());
        let largest = largest.into_iter().fold(0.0, f64::max);
        // Scales at which the axis happens to round well are luck; a few draws suffice.
        let scales = (0..24).map(|k| 127.0 - 2.0 * f64::from(k));
        let best = scales.filter_map(|scale| {
            let axis = axis * (scale / largest);
            let [s, t] = [s, t].map(|v| v * (scale / largest));
            grown(&fit, axis, s, t)
        });
        let (_, [axis, s, t]) = best.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Self { apex: cone.apex, axis, s, t })
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        let w = eye.way_from(self.apex);
        let [z, s, t] = [self.axis, self.s, self.t].map(|v| dot(v.map(f32::from), w));
        z < 0.0 && z * z - (s * s + t * t) > ClusterEye::LEAST_SQUARE
    }

    fn margin(&self, eye: [f64; 3]) -> f64 {
        elliptic_margin(self.apex, [self.axis, self.s, self.t].map(|v| v.map(f32::from)), eye)
    }
}

/// Sixteen elliptic cones in bytes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct ByteRows {
    apex: [Row; 3],
    /// axis, s and t.
    vectors: [[ByteRow; 3]; 3],
}

impl Lanes for EllipticConeQuantised {
    type Block = ByteRows;
    const NOTHING: ByteRows = ByteRows { apex: ZEROS, vectors: [[[0; 16]; 3]; 3] };

    fn set_lane(&self, block: &mut ByteRows, lane: usize) {
        for k in 0..3 {
            block.apex[k][lane] = self.apex[k];
            for (rows, vector) in block.vectors.iter_mut().zip([self.axis, self.s, self.t]) {
                rows[k][lane] = vector[k];
            }
        }
    }

    #[inline(always)]
    fn test_lanes<S: Simd>(simd: S, block: &ByteRows, start: usize, eye: &ClusterEye) -> u64 {
        let w = lanes::to_eye(simd, &block.apex, start, eye);
        let [axis, s, t] = &block.vectors;
        let z = lanes::dot::<S>(lanes::byte_rows(simd, axis, start), w);
        let s = lanes::dot::<S>(lanes::byte_rows(simd, s, start), w);
        let t = lanes::dot::<S>(lanes::byte_rows(simd, t, start), w);
        lanes::in_cone(simd, z, s * s + t * t)
    }
}

/// The first bytes that hold all normals when the half-axes grow by eighths of a unit, and how
/// large their ellipse is.
fn grown(fit: &Apex, axis: DVec3, s: DVec3, t: DVec3) -> Option<(f64, [[i8; 3]; 3])> {
    let longer = |v: DVec3, by: f64| v + v.normalize() * by;
    for step in 0..40 {
        let by = f64::from(step) * 0.125;
        let rounded = [axis, longer(s, by), longer(t, by)].map(DVec3::round);
        if rounded.iter().any(|v| v.abs().max_element() > 127.0) {
            return None;
        }
        let bytes = rounded.map(|v| v.to_array().map(|v| v as i8));
        let [axis, s, t] = bytes.map(|v| v.map(f32::from));
        if (EllipticCone { apex: [0.0; 3], axis, s, t }).holds(fit) {
            let [axis, s, t] = rounded;
            // The area that the ellipse takes of the sphere of directions, for a narrow one.
            let size = s.cross(t).dot(axis).abs() / axis.length().powi(3);
            return Some((size, bytes));
        }
    }
    None
}
