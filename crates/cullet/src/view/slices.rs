//! Slices of a view by distance, such as the cascades of a shadow map.

use alloc::vec::Vec;

use glam::DVec4;

use super::{Depth, View, ViewError};
use crate::view::FrustumPlane;

impl View {
    /// Returns this view between two distances: the same eye and sides, with `near` and `far` in
    /// place of its own near and far plane. `far` may be infinite in perspective.
    ///
    /// Distances are along the direction of view, in world units: from the eye in perspective, from
    /// the near plane in an orthographic view.
    ///
    /// # Errors
    /// If `near` is not below `far`, or not above zero in perspective; or the view has no near
    /// plane.
    pub fn slice(&self, near: f64, far: f64) -> Result<Self, ViewError> {
        let range = |what, value, must| Err(ViewError::Range { what, value, must });
        let orthographic = self.is_orthographic();
        if !(near.is_finite() && (orthographic || near > 0.0)) {
            return range("near", near, "finite, and above zero in perspective");
        }
        if !(far > near && (far.is_finite() || !orthographic)) {
            return range("far", far, "above near, and finite in an orthographic view");
        }
        let mut m = self.clip_from_world;
        let w = m.row(3);
        // `scale * (distance - near)` is zero on the near plane, and w on the far plane.
        let (distance, scale) = if orthographic {
            let frustum = self.frustum();
            let Some(plane) = frustum.plane(FrustumPlane::Near) else {
                return Err(ViewError::Singular(0.0));
            };
            let [x, y, z] = plane.normal;
            (DVec4::new(-x, -y, -z, plane.d), w.w / (far - near))
        } else {
            let unit = w.truncate().length();
            (w / unit, if far.is_finite() { unit * (far / (far - near)) } else { unit })
        };
        let standard = (distance - DVec4::new(0.0, 0.0, 0.0, near)) * scale;
        let z = match self.depth {
            Depth::Standard => standard,
            Depth::Reversed => w - standard,
        };
        for column in 0..4 {
            m.col_mut(column).z = z[column];
        }
        let sliced = Self::from_matrix(m.to_cols_array(), self.depth, self.viewport)?;
        Ok(Self { clip_from_world: sliced.clip_from_world, eye: sliced.eye, ..self.clone() })
    }

    /// Returns one [slice](Self::slice) between each two distances of `splits`, which ascend.
    ///
    /// # Errors
    /// The errors of [`slice`](Self::slice).
    pub fn slices(&self, splits: &[f64]) -> Result<Vec<Self>, ViewError> {
        splits.windows(2).map(|pair| self.slice(pair[0], pair[1])).collect()
    }
}
