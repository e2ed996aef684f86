//! Affine transforms of instances: f32 in the linear part, f64 in the translation.

use glam::{DAffine3, DMat3, DVec3};

use crate::array::Each;
use crate::bounds::Aabb;
use crate::exact;
use crate::matrix::Matrix;

/// Any affine transform, mirrored and singular ones included: x ↦ linear · x + translation.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::AnyBitPattern)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct Transform {
    /// The columns of the linear part.
    pub linear: [[f32; 3]; 3],
    /// The translation, in f64 so that worlds of 1e7 units stay right.
    pub translation: [f64; 3],
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// Leaves everything where it is.
    pub const IDENTITY: Self =
        Self { linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };

    /// Moves by `translation`.
    #[must_use]
    pub fn from_translation(translation: impl Into<[f64; 3]>) -> Self {
        Self { translation: translation.into(), ..Self::IDENTITY }
    }

    /// Scales along the axes, then moves.
    #[must_use]
    pub fn from_scale_translation(scale: [f32; 3], translation: impl Into<[f64; 3]>) -> Self {
        let [x, y, z] = scale;
        Self {
            linear: [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]],
            translation: translation.into(),
        }
    }

    /// Scales, rotates by a unit quaternion (x, y, z, w), then moves: the order of glTF.
    #[must_use]
    pub fn from_scale_rotation_translation(
        scale: [f64; 3],
        rotation: [f64; 4],
        translation: [f64; 3],
    ) -> Self {
        let a = DAffine3::from_scale_rotation_translation(
            scale.into(),
            glam::DQuat::from_array(rotation),
            translation.into(),
        );
        Self::from_affine(&a)
    }

    /// From a column-major 4×4 matrix whose last row is 0, 0, 0, 1; that row is not read.
    #[must_use]
    pub fn from_matrix(m: impl Into<Matrix>) -> Self {
        let Matrix(m) = m.into();
        let column = |c: usize| [m[c * 4] as f32, m[c * 4 + 1] as f32, m[c * 4 + 2] as f32];
        Self { linear: [column(0), column(1), column(2)], translation: [m[12], m[13], m[14]] }
    }

    /// The column-major 4×4 matrix.
    #[must_use]
    pub fn to_matrix(&self) -> [f64; 16] {
        let [x, y, z] = self.linear.each(|c| c.each(f64::from));
        let t = self.translation;
        [x[0], x[1], x[2], 0.0, y[0], y[1], y[2], 0.0, z[0], z[1], z[2], 0.0, t[0], t[1], t[2], 1.0]
    }

    /// Whether all twelve numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.linear.iter().flatten().all(|v| v.is_finite())
            && self.translation.iter().all(|v| v.is_finite())
    }

    /// The determinant of the linear part: negative where the transform mirrors.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        self.linear_f64().determinant()
    }

    /// Whether the transform mirrors, so that what is wound counter-clockwise becomes clockwise:
    /// the exact sign of the determinant. False where a number is not finite.
    #[must_use]
    pub fn is_mirrored(&self) -> bool {
        self.is_finite() && exact::determinant_sign(&self.linear) < 0
    }

    /// The rank of the linear part, exactly: 3 ordinarily, 2 flattens to a plane, 1 to a line, 0 to
    /// a point. A transform with a number that is not finite is taken for 3, since it must keep
    /// everything.
    #[must_use]
    pub fn rank(&self) -> u8 {
        if !self.is_finite() || exact::determinant_sign(&self.linear) != 0 {
            return 3;
        }
        let m = self.linear_f64();
        let columns = [m.x_axis, m.y_axis, m.z_axis];
        // Products of two f32 are exact in f64, and so is the sign of their difference.
        let minors = [(0, 1), (1, 2), (2, 0)].each(|(i, j)| columns[i].cross(columns[j]));
        if minors != [DVec3::ZERO; 3] { 2 } else { u8::from(columns != [DVec3::ZERO; 3]) }
    }

    pub(crate) fn linear_f64(&self) -> DMat3 {
        let [x, y, z] = self.linear.each(|c| DVec3::from(c.each(f64::from)));
        DMat3::from_cols(x, y, z)
    }

    pub(crate) fn from_affine(a: &DAffine3) -> Self {
        let column = |c: DVec3| [c.x as f32, c.y as f32, c.z as f32];
        let m = a.matrix3;
        Self {
            linear: [column(m.x_axis), column(m.y_axis), column(m.z_axis)],
            translation: a.translation.into(),
        }
    }

    /// The box around the image of `b`, relative to `origin`, rounded outward: it holds the image
    /// of every point of `b` though each be computed in f64 with rounding of its own.
    /// [`Aabb::EVERYTHING`] where a number is not finite; empty for an empty box.
    ///
    /// (Arvo, *Transforming Axis-Aligned Bounding Boxes*, 1990.)
    #[must_use]
    pub fn transform_box(&self, b: &Aabb, origin: [f64; 3]) -> Aabb {
        if b.is_empty() {
            return Aabb::EMPTY;
        }
        let m = self.linear_f64();
        let center = DVec3::from(b.center());
        let half = DVec3::from(b.half_extent());
        let reach = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
        let image = m * center + (DVec3::from(self.translation) - DVec3::from(origin));
        // Rounding of these lines, and of whoever transforms the vertices: relative to every term.
        let size = self.reach(center.abs() + half) + DVec3::from(origin).abs();
        let slack = size * 1e-15;
        let (min, max) = (image - reach - slack, image + reach + slack);
        if !(min.is_finite() && max.is_finite()) {
            return Aabb::EVERYTHING;
        }
        Aabb::rounded_out(min.into(), max.into())
    }

    /// |linear|·size + |translation|: what rounding in the image of points up to `size` is relative to.
    fn reach(&self, size: DVec3) -> DVec3 {
        let m = self.linear_f64();
        m.x_axis.abs() * size.x
            + m.y_axis.abs() * size.y
            + m.z_axis.abs() * size.z
            + DVec3::from(self.translation).abs()
    }
}
