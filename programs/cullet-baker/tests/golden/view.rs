//! The views: cameras in f32, as engines hold them, and the matrix in f64 that comes of them.

use cullet::bounds::Aabb;
use glam::{DMat3, DQuat, DVec3, Mat4, Quat, Vec3};
use serde::Serialize;

/// A camera: where it is, how it is turned, and a perspective without a far plane, near at depth 1.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Camera {
    pub(crate) eye: [f32; 3],
    /// Quaternion x, y, z, w.
    pub(crate) rotation: [f32; 4],
    /// Radians.
    pub(crate) fov_y: f32,
    /// Width over height.
    pub(crate) aspect: f32,
    pub(crate) near: f32,
}

/// Pixels of every view.
pub(crate) const VIEWPORT: [u32; 2] = [640, 400];

impl Camera {
    /// Cameras in and around a scene of this extent: from a corner above, from its middle, and
    /// along one side near the ground.
    pub(crate) fn around(extent: &Aabb) -> [Self; 3] {
        let (centre, half) = (DVec3::from(extent.center()), DVec3::from(extent.half_extent()));
        let looking = |eye: DVec3, target: DVec3| {
            let back = (eye - target).normalize();
            let right = DVec3::Y.cross(back).normalize();
            let rotation = DMat3::from_cols(right, back.cross(right), back);
            let eye = eye.as_vec3();
            Self {
                eye: eye.to_array(),
                rotation: DQuat::from_mat3(&rotation).as_quat().normalize().to_array(),
                fov_y: 0.9,
                aspect: 1.6,
                near: 0.125,
            }
        };
        let low = centre - half * DVec3::new(0.9, 0.6, 0.05);
        [
            looking(centre + half * DVec3::new(1.3, 2.0, 1.7), centre),
            looking(centre, centre + DVec3::new(0.8, -0.1, 0.6)),
            looking(low, low + DVec3::new(1.0, 0.0, 0.2)),
        ]
    }

    /// The matrix from world to clip space, column-major: the camera's f32 numbers, multiplied in
    /// f64.
    pub(crate) fn clip_from_world(&self) -> [f64; 16] {
        let (eye, rotation) = (Vec3::from(self.eye), Quat::from_array(self.rotation));
        let world_from_view = Mat4::from_rotation_translation(rotation, eye).as_dmat4();
        let clip_from_view = Mat4::from_cols_array(&self.clip_from_view()).as_dmat4();
        (clip_from_view * world_from_view.inverse()).to_cols_array()
    }

    /// The projection, column-major.
    pub(crate) fn clip_from_view(&self) -> [f32; 16] {
        let y = 1.0 / (0.5 * self.fov_y).tan();
        let mut m = [0.0; 16];
        (m[0], m[5], m[11], m[14]) = (y / self.aspect, y, -1.0, self.near);
        m
    }
}
