//! The frame of a set of triangle planes: what their numbers are relative to.

use cullet::bounds::Aabb;
use cullet::cull::backface::ClusterPlanes;
use glam::{DVec3, DVec4};

/// Where the numbers of a set of planes are relative to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    centre: DVec3,
    /// Divisor of the offsets, so that they are comparable to normals.
    scale: f64,
}

impl Frame {
    pub(crate) fn around(positions: &[[f32; 3]]) -> Self {
        let bounds = Aabb::from_points(positions);
        if bounds.is_empty() {
            return Self { centre: DVec3::ZERO, scale: 1.0 };
        }
        let scale = DVec3::from(bounds.half_extent()).length();
        let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
        Self { centre: bounds.center().into(), scale }
    }

    /// (n, −d) of a triangle with its largest number ±1; zeros, which no eye is behind, for a
    /// sliver.
    pub(crate) fn plane(&self, corners: [[f32; 3]; 3]) -> DVec4 {
        let triangle = ClusterPlanes::new([corners]);
        triangle.half_spaces().next().map_or(DVec4::ZERO, |(n, d)| {
            let n = DVec3::from(n);
            let plane = n.extend((n.dot(self.centre) - d) / self.scale);
            plane / plane.abs().max_element()
        })
    }

    /// The eye in units of the frame, its largest number ±1; `None` where it is not finite, zero,
    /// or of negative weight.
    pub(crate) fn eye(&self, eye: [f64; 4]) -> Option<DVec4> {
        let eye = DVec4::from(eye);
        let e = (eye.truncate() - self.centre * eye.w).extend(eye.w * self.scale);
        let largest = e.abs().max_element();
        // The largest of some NaN and a number may be the number.
        (eye.w >= 0.0 && largest > 0.0 && e.is_finite()).then(|| e / largest)
    }
}
