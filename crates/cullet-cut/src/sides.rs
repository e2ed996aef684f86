//! On which side of each plane every vertex lies: once, and exactly.

use cullet::bounds::Plane;
use cullet::exact::plane_sign;
use cullet::mesh::MeshError;
use glam::DVec3;

use crate::options::{CutError, MAX_CUT_PLANES};

/// Units of rounding of n·p − d in f64: four products and three sums, doubled.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A plane, scaled by a power of two so that its largest coefficient is near 1: the sign is the
/// same.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CutPlane {
    pub(crate) normal: [f64; 3],
    pub(crate) d: f64,
    /// The axis of the largest coefficient: dropping it maps the plane to two dimensions one to
    /// one.
    pub(crate) axis: usize,
    /// The coordinate along `axis` of every point of the plane, where it has one.
    level: Option<f32>,
}

/// Checks and scales.
pub(crate) fn prepare(planes: &[Plane]) -> Result<Vec<CutPlane>, CutError> {
    if planes.len() > MAX_CUT_PLANES {
        return Err(CutError::TooManyPlanes(planes.len()));
    }
    let prepared = planes.iter().enumerate().map(|(number, &plane)| {
        let size = plane.normal.map(f64::abs);
        let axis = (0..3).fold(0, |a, b| if size[b] > size[a] { b } else { a });
        let error = CutError::Plane { plane: number, value: plane };
        if !plane.is_finite() || !size[axis].is_normal() {
            return Err(error);
        }
        // The exponent alone, so that scaling does not round.
        let scale = f64::from_bits((2046u64 << 52) - (size[axis].to_bits() & (0x7FF << 52)));
        let (normal, d) = (plane.normal.map(|n| n * scale), plane.d * scale);
        if !scale.is_normal() || !d.is_finite() {
            return Err(error);
        }
        let along = (0..3).all(|a| a == axis || normal[a] == 0.0);
        let level = along.then(|| (d / normal[axis]) as f32).filter(|l| l.is_finite());
        Ok(CutPlane { normal, d, axis, level })
    });
    prepared.collect()
}

impl CutPlane {
    /// n·p − d, rounded, and the most that it may be off.
    #[inline]
    fn value(&self, p: [f64; 3]) -> (f64, f64) {
        let [x, y, z] = [self.normal[0] * p[0], self.normal[1] * p[1], self.normal[2] * p[2]];
        let size = x.abs() + y.abs() + z.abs() + self.d.abs();
        (x + y + z - self.d, size * ROUNDING)
    }

    /// −1 inside, 0 on the plane, 1 outside; exact for finite points.
    pub(crate) fn side(&self, p: [f32; 3]) -> i8 {
        let p = p.map(f64::from);
        let (value, error) = self.value(p);
        if value > error {
            1
        } else if value < -error {
            -1
        } else {
            self.exact_side(p)
        }
    }

    #[cold]
    fn exact_side(&self, p: [f64; 3]) -> i8 {
        plane_sign(self.normal, self.d, p) as i8
    }

    /// Where the edge from `a` to `b` meets the plane, as the share of the way and as a point.
    ///
    /// `a` must be the lower of the two in [`before`]'s order: then every triangle at the edge gets
    /// the same bits.
    pub(crate) fn meet(&self, a: [f32; 3], b: [f32; 3]) -> (f64, [f32; 3]) {
        let (p, q) = (a.map(f64::from), b.map(f64::from));
        let (va, vb) = (self.value(p).0, self.value(q).0);
        let share = va / (va - vb);
        // Rounding may have lost the difference.
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 };
        let mut point = [0.0; 3];
        for axis in 0..3 {
            let v = p[axis] + (q[axis] - p[axis]) * share;
            point[axis] = v.clamp(p[axis].min(q[axis]), p[axis].max(q[axis])) as f32 + 0.0;
        }
        if let Some(level) = self.level {
            point[self.axis] = level + 0.0;
        }
        (share, point)
    }

    /// A point of the plane above these two coordinates (those after and after next of `axis`).
    pub(crate) fn lift(&self, [u, v]: [f32; 2]) -> [f32; 3] {
        let (a, b) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let mut point = [0.0; 3];
        (point[a], point[b]) = (u, v);
        let rest = self.d - self.normal[a] * f64::from(u) - self.normal[b] * f64::from(v);
        point[self.axis] = self.level.unwrap_or((rest / self.normal[self.axis]) as f32);
        point
    }

    /// The two coordinates that [`lift`](Self::lift) takes.
    pub(crate) fn flat(&self, p: [f32; 3]) -> [f32; 2] {
        [p[(self.axis + 1) % 3], p[(self.axis + 2) % 3]]
    }

    /// Two directions along the plane and its normal, right-handed and of unit length: the second
    /// leans towards +Y, or towards −Z where the plane is level.
    pub(crate) fn frame(&self) -> [[f64; 3]; 3] {
        let n = DVec3::from(self.normal).normalize();
        let up = if n.y.abs() < 0.999 { DVec3::Y } else { DVec3::NEG_Z };
        let u = up.cross(n).normalize();
        [u, n.cross(u), n].map(Into::into)
    }

    /// Where a point lies along the first two directions of a [`frame`](Self::frame).
    pub(crate) fn frame_point(frame: &[[f64; 3]; 3], point: [f32; 3]) -> [f64; 2] {
        let p = DVec3::from(point.map(f64::from));
        [0, 1].map(|i| DVec3::from(frame[i]).dot(p))
    }

    /// Whether counter-clockwise in [`flat`](Self::flat) coordinates is so seen from where the
    /// normal points.
    pub(crate) fn upright(&self) -> bool {
        self.normal[self.axis] > 0.0
    }
}

/// An order of positions that does not depend on how vertices are numbered.
pub(crate) fn before(a: [f32; 3], b: [f32; 3]) -> bool {
    a < b
}

/// One bit a plane for every vertex.
pub(crate) struct Sides {
    /// Strictly outside.
    pub(crate) outside: Vec<u32>,
    /// On the plane; empty where no vertex is on any.
    pub(crate) on: Vec<u32>,
}

impl Sides {
    pub(crate) fn new(positions: &[[f32; 3]], planes: &[CutPlane]) -> Result<Self, CutError> {
        let mut outside = Vec::with_capacity(positions.len());
        let mut on = Vec::new();
        for (vertex, &position) in positions.iter().enumerate() {
            let p = position.map(f64::from);
            let (mut out, mut unsure) = (0, 0);
            for (i, plane) in planes.iter().enumerate() {
                let (value, error) = plane.value(p);
                out |= u32::from(value > error) << i;
                // A NaN is unsure too.
                let sure = value.abs() > error;
                unsure |= u32::from(!sure) << i;
            }
            if unsure != 0 {
                if !position.iter().all(|v| v.is_finite()) {
                    return Err(MeshError::NotFinite { vertex, position }.into());
                }
                for (i, plane) in planes.iter().enumerate().filter(|(i, _)| unsure >> i & 1 == 1) {
                    match plane.exact_side(p) {
                        0 => {
                            on.resize(positions.len(), 0);
                            on[vertex] |= 1 << i;
                        }
                        side => out |= u32::from(side > 0) << i,
                    }
                }
            }
            outside.push(out);
        }
        if planes.is_empty()
            && let Some(vertex) = positions.iter().position(|p| !p.iter().all(|v| v.is_finite()))
        {
            return Err(MeshError::NotFinite { vertex, position: positions[vertex] }.into());
        }
        Ok(Self { outside, on })
    }

    /// −1 inside, 0 on, 1 outside of a plane.
    pub(crate) fn side(&self, vertex: u32, plane: usize) -> i8 {
        let v = vertex as usize;
        if self.outside[v] >> plane & 1 == 1 {
            1
        } else if !self.on.is_empty() && self.on[v] >> plane & 1 == 1 {
            0
        } else {
            -1
        }
    }
}
