//! A camera as people describe one, its matrix, and its frustum by geometric construction.

use glam::{DMat3, DMat4, DVec3, DVec4};

use super::{Depth, Frustum, ViewError};
use crate::bounds::{Plane, unit};
use crate::math;

/// A projection, in the units of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Projection {
    /// Symmetric perspective.
    Perspective {
        /// Full vertical field of view, in (0, π).
        fov_y_radians: f64,
        /// Width over height.
        aspect: f64,
        /// Distance of the near plane, above 0.
        near: f64,
        /// Distance of the far plane; infinite is an ordinary value.
        far: f64,
    },
    /// Perspective whose window need not be centred: stereo, tiles of a large picture.
    OffCentre {
        /// Left edge of the window on the near plane.
        left: f64,
        /// Right edge.
        right: f64,
        /// Bottom edge.
        bottom: f64,
        /// Top edge.
        top: f64,
        /// Distance of the near plane, above 0.
        near: f64,
        /// Distance of the far plane; may be infinite.
        far: f64,
    },
    /// Parallel lines of sight.
    Orthographic {
        /// Left edge of the window.
        left: f64,
        /// Right edge.
        right: f64,
        /// Bottom edge.
        bottom: f64,
        /// Top edge.
        top: f64,
        /// Distance of the near plane; may be negative.
        near: f64,
        /// Distance of the far plane, above `near` and finite.
        far: f64,
    },
}

impl Projection {
    /// Window on the near plane (left, right, bottom, top), near, far, and whether lines of sight
    /// meet.
    fn window(&self) -> ([f64; 4], f64, f64, bool) {
        match *self {
            Self::Perspective { fov_y_radians, aspect, near, far } => {
                let h = near * math::tan(fov_y_radians * 0.5);
                ([-h * aspect, h * aspect, -h, h], near, far, true)
            }
            Self::OffCentre { left, right, bottom, top, near, far } => {
                ([left, right, bottom, top], near, far, true)
            }
            Self::Orthographic { left, right, bottom, top, near, far } => {
                ([left, right, bottom, top], near, far, false)
            }
        }
    }

    fn check(&self) -> Result<(), ViewError> {
        let range = |what, value: f64, ok: bool, must| {
            if ok { Ok(()) } else { Err(ViewError::Range { what, value, must }) }
        };
        if let Self::Perspective { fov_y_radians, aspect, .. } = *self {
            let angle = fov_y_radians > 0.0 && fov_y_radians < core::f64::consts::PI;
            range("field of view", fov_y_radians, angle, "between 0 and pi radians")?;
            range("aspect", aspect, aspect > 0.0 && aspect.is_finite(), "positive and finite")?;
        }
        let ([left, right, bottom, top], near, far, perspective) = self.window();
        // The window of a field of view is as wide as its near distance is: that comes first.
        range("near", near, near.is_finite(), "finite")?;
        if perspective {
            range("near", near, near > 0.0, "above 0")?;
        } else {
            range("far", far, far.is_finite(), "finite in an orthographic view")?;
        }
        range("far", far, far > near, "beyond near")?;
        let width = right - left;
        let height = top - bottom;
        range("window width", width, width != 0.0 && width.is_finite(), "finite and not 0")?;
        range("window height", height, height != 0.0 && height.is_finite(), "finite and not 0")
    }
}

/// A camera: where it stands, where it looks, what it projects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Camera {
    /// Position of the camera.
    pub eye: [f64; 3],
    /// Direction in which the camera looks, of any length above 0.
    pub direction: [f64; 3],
    /// Up direction; need not be perpendicular to `direction`, must not lie along it.
    pub up: [f64; 3],
    /// Projection of the camera.
    pub projection: Projection,
}

impl Camera {
    /// A camera at `eye` that looks at `target` with +Y up, or +Z up where it looks along Y.
    #[must_use]
    pub fn look_at(
        eye: impl Into<[f64; 3]>,
        target: impl Into<[f64; 3]>,
        projection: Projection,
    ) -> Self {
        let eye = eye.into();
        let direction = DVec3::from(target.into()) - DVec3::from(eye);
        let along_y = unit(direction).is_some_and(|d| d.y.abs() > 0.9999);
        let up = if along_y { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        Self { eye, direction: direction.into(), up, projection }
    }

    /// The unit axes right, up and back of the camera, the axes of camera space: right is
    /// direction × up, and a view looks along −back.
    ///
    /// # Errors
    /// If a number is not finite, or direction and up span no plane.
    pub fn basis(&self) -> Result<[[f64; 3]; 3], ViewError> {
        self.check()?;
        let m = self.axes()?;
        Ok([m.x_axis.into(), m.y_axis.into(), m.z_axis.into()])
    }

    /// The unit axes right, up and back of the camera: right is direction × up.
    fn axes(&self) -> Result<DMat3, ViewError> {
        let error = ViewError::NoOrientation { direction: self.direction, up: self.up };
        let forward = unit(self.direction.into()).ok_or(error)?;
        let right = unit(self.up.into()).map(|up| forward.cross(up)).ok_or(error)?;
        let right = if right.length() > 1e-9 { right.normalize() } else { return Err(error) };
        Ok(DMat3::from_cols(right, right.cross(forward), -forward))
    }

    fn check(&self) -> Result<(), ViewError> {
        let finite = |what, v: &[f64; 3]| {
            if v.iter().all(|v| v.is_finite()) { Ok(()) } else { Err(ViewError::NotFinite(what)) }
        };
        finite("eye", &self.eye)?;
        finite("direction", &self.direction)?;
        finite("up", &self.up)?;
        self.projection.check()
    }

    /// World to clip space.
    pub(super) fn clip_from_world(&self, depth: Depth) -> Result<DMat4, ViewError> {
        self.check()?;
        let axes = self.axes()?;
        let rotate = axes.transpose();
        let view = DMat4::from_mat3_translation(rotate, -(rotate * DVec3::from(self.eye)));
        let ([left, right, bottom, top], near, far, perspective) = self.projection.window();
        let (w, h) = (right - left, top - bottom);
        let x_shift = (right + left) / w;
        let y_shift = (top + bottom) / h;
        // Depth as a row (z factor, constant). The reversed one is w − depth, written out:
        // subtracting would lose the far plane's digits, which are what reversed depth is for.
        let span = far - near;
        let (z, c) = match (perspective, depth, far.is_infinite()) {
            (true, Depth::Standard, true) => (-1.0, -near),
            (true, Depth::Standard, false) => (-far / span, -near * (far / span)),
            (true, Depth::Reversed, true) => (0.0, near),
            (true, Depth::Reversed, false) => (near / span, near * (far / span)),
            (false, Depth::Standard, _) => (-1.0 / span, -near / span),
            (false, Depth::Reversed, _) => (1.0 / span, far / span),
        };
        let w_row = if perspective { (-1.0, 0.0) } else { (0.0, 1.0) };
        let project = if perspective {
            DMat4::from_cols(
                DVec4::new(2.0 * near / w, 0.0, 0.0, 0.0),
                DVec4::new(0.0, 2.0 * near / h, 0.0, 0.0),
                DVec4::new(x_shift, y_shift, z, w_row.0),
                DVec4::new(0.0, 0.0, c, w_row.1),
            )
        } else {
            DMat4::from_cols(
                DVec4::new(2.0 / w, 0.0, 0.0, 0.0),
                DVec4::new(0.0, 2.0 / h, 0.0, 0.0),
                DVec4::new(0.0, 0.0, z, w_row.0),
                DVec4::new(-x_shift, -y_shift, c, w_row.1),
            )
        };
        Ok(project * view)
    }

    /// The frustum by the geometric construction of the lectures: the corners of the near window,
    /// and planes spanned by the eye and its edges. Normals point out, all six. It equals the
    /// [`View::frustum`](super::View::frustum) of this camera but for rounding.
    ///
    /// # Errors
    /// If the camera's numbers make no view.
    pub fn frustum(&self) -> Result<Frustum, ViewError> {
        self.check()?;
        Ok(self.projection.planes(&self.axes()?, self.eye.into()))
    }
}

impl Projection {
    /// The frustum in camera space: the eye at the origin, right along +X, up along +Y, looking
    /// along −Z.
    ///
    /// # Errors
    /// If the numbers make no view.
    pub fn frustum(&self) -> Result<Frustum, ViewError> {
        self.check()?;
        Ok(self.planes(&DMat3::IDENTITY, DVec3::ZERO))
    }

    fn planes(&self, axes: &DMat3, eye: DVec3) -> Frustum {
        let (r, u, back) = (axes.x_axis, axes.y_axis, axes.z_axis);
        let ([left, right, bottom, top], near, far, perspective) = self.window();
        // Corners are relative to the eye: subtracting it again far from the origin would cost
        // digits.
        let corner = |x: f64, y: f64| r * x + u * y - back * near;
        // The direction of the line of sight through a point of the near window.
        let sight = |p: DVec3| if perspective { p } else { -back };
        let mirrored = (right < left) != (top < bottom);
        let side = |p: DVec3, q: DVec3| {
            // p to q runs counter-clockwise around the window as the viewer sees it, so
            // sight × (q − p) points away from its inside. A window given right to left, or top to
            // bottom, is run around clockwise.
            let out = sight(p).cross(q - p).normalize() * if mirrored { -1.0 } else { 1.0 };
            // In perspective the plane goes through the eye: out · p is 0.
            let d = out.dot(eye) + if perspective { 0.0 } else { out.dot(p) };
            Plane { normal: out.into(), d }
        };
        let (lb, rb) = (corner(left, bottom), corner(right, bottom));
        let (rt, lt) = (corner(right, top), corner(left, top));
        let at = |distance: f64, n: DVec3| Plane {
            normal: n.into(),
            d: n.dot(eye) - n.dot(back) * distance,
        };
        Frustum::from_planes([
            Some(side(lt, lb)),
            Some(side(rb, rt)),
            Some(side(lb, rb)),
            Some(side(rt, lt)),
            Some(at(near, back)),
            far.is_finite().then(|| at(far, -back)),
        ])
    }
}
