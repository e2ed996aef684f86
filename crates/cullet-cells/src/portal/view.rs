//! The view as portal culling needs it: an eye, the sides of its picture, and where that is on the
//! screen.

use glam::{DMat4, DVec3};

use crate::ROUNDING;
use cullet::View;
use cullet::view::FrustumPlane;

/// An eye and the sides of what it sees.
#[derive(Clone, Debug)]
pub struct PortalView {
    pub(super) eye: DVec3,
    /// Left, right, bottom and top, as far as they are there: relative to the eye, pointing out.
    pub(super) sides: [Option<(DVec3, f64)>; 4],
    /// x, y and w of clip space, of points relative to the eye.
    pub(super) rows: [DVec3; 3],
    near: Option<[[f64; 3]; 2]>,
    pub(super) door_reach: f64,
}

impl PortalView {
    /// The eye of a view; `None` of an orthographic one, which has no eye that could be in a cell,
    /// and of a stereo view.
    #[must_use]
    pub fn new(view: &View) -> Option<Self> {
        let [x, y, z, w] = view.eye();
        let eye = DVec3::new(x, y, z);
        // Two eyes see beside a portal what the point between them does not.
        if w == 0.0 || !eye.is_finite() || view.eyes_apart() != [0.0; 3] {
            return None;
        }
        let frustum = view.frustum();
        let sides = [0, 1, 2, 3].map(|which| {
            let plane = frustum.plane(FrustumPlane::ALL[which])?;
            let n = DVec3::from(plane.normal);
            // They go through the eye, but for the rounding of the matrix.
            let slack = (n.abs().dot(eye.abs()) + plane.d.abs()) * ROUNDING;
            Some((n, (plane.d - n.dot(eye)).max(0.0) + slack))
        });
        let m = DMat4::from_cols_array(&view.clip_from_world());
        let rows = [0, 1, 3].map(|row| m.row(row).truncate());
        let rows = rows.map(|row| row / row.abs().max_element().max(f64::MIN_POSITIVE));
        let near = near_box(&frustum, eye);
        Some(Self { eye, sides, rows, near, door_reach: 0.0 })
    }

    /// The same, for whom shut doors nearer than this are open: in world units, more than half of
    /// what a door is thick and how far the near plane is away, beyond which a door is not seen.
    /// Default 0.
    #[must_use]
    pub(crate) fn with_door_reach(self, reach: f64) -> Self {
        Self { door_reach: reach, ..self }
    }

    /// Where the eye is.
    #[must_use]
    pub fn eye(&self) -> [f64; 3] {
        self.eye.into()
    }

    /// A box around the eye and its near rectangle, in world space: what is in it may be cut away.
    /// `None` where that is not known.
    #[must_use]
    pub fn near_box(&self) -> Option<[[f64; 3]; 2]> {
        self.near
    }
}

fn near_box(frustum: &cullet::view::Frustum, eye: DVec3) -> Option<[[f64; 3]; 2]> {
    let corners = frustum.corners()?;
    let (mut min, mut max) = (eye, eye);
    for [x, y, z, w] in &corners[..4] {
        let p = DVec3::new(*x, *y, *z) / *w;
        if !p.is_finite() {
            return None;
        }
        (min, max) = (min.min(p), max.max(p));
    }
    // Corners are off by their rounding.
    let slack = (min.abs().max(max.abs())) * 1e-9;
    Some([(min - slack).into(), (max + slack).into()])
}
