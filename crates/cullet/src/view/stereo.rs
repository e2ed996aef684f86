//! Both eyes of a headset as one view.

use glam::{DMat3, DMat4, DVec3};

use super::{Depth, EyeBall, View, ViewError};

/// Shares by which the sides and the ends of the volume of both eyes lie beyond those of each: more
/// than all rounding here.
const SLACK: f64 = 1e-9;

impl View {
    /// Makes one view of both eyes of a headset: culling it keeps what either eye sees, and hides
    /// what is hidden from both. One walk and one occlusion buffer serve both, from the point in
    /// the middle. [`Visible::by_eye`] says which eye may see an instance. Levels of detail are
    /// those of the nearer eye.
    ///
    /// Both are perspective views of the same viewport, depth, layers and sides; they may be
    /// off-centre, and turned against each other by less than a right angle. Back faces are culled
    /// by whole clusters alone, and portals and sets of cells cull nothing. Occluders nearer than
    /// some hundred times the distance between the eyes hide less than they would from one eye: how
    /// much more is seen beside them grows as they come nearer.
    ///
    /// [`Visible::by_eye`]: crate::Visible::by_eye
    ///
    /// # Errors
    /// [`ViewError::Stereo`] names what the views do not share, or why no view is around both.
    pub fn stereo(left: &Self, right: &Self) -> Result<Self, ViewError> {
        let differ = |what| Err(ViewError::Stereo { what });
        if left.is_orthographic() || right.is_orthographic() {
            return differ("is orthographic");
        }
        if left.layers != right.layers {
            return differ("have different layers");
        }
        if (left.viewport, left.depth) != (right.viewport, right.depth) {
            return differ("have different viewports or depths");
        }
        let sides = |v: &Self| (v.front_face, v.cull_face, v.mirrored);
        if sides(left) != sides(right) {
            return differ("have different sides");
        }
        let eyes = [left, right].map(|view| view.eye.truncate());
        let (middle, half) = ((eyes[0] + eyes[1]) * 0.5, (eyes[1] - eyes[0]) * 0.5);
        let Some(axes) = axes([left, right]) else { return differ("look apart") };
        let mut volume = Volume::default();
        for view in [left, right] {
            let Some(corners) = view.frustum().corners() else {
                return differ("have a frustum without corners");
            };
            for (corner, [x, y, z, w]) in corners.into_iter().enumerate() {
                let point = DVec3::new(x, y, z) - middle * w;
                volume.add(axes.transpose() * point, w == 0.0, corner < 4);
            }
        }
        let Some(projection) = volume.projection(left.depth) else { return differ("look apart") };
        let world = DMat4::from_mat3(axes.transpose()) * DMat4::from_translation(-middle);
        let mirror = if left.mirrored { -1.0 } else { 1.0 };
        let m = DMat4::from_scale(DVec3::new(mirror, 1.0, 1.0)) * projection * world;
        let view = Self::from_matrix(m.to_cols_array(), left.depth, left.viewport)?;
        Ok(Self {
            layers: left.layers,
            front_face: left.front_face,
            cull_face: left.cull_face,
            eyes: Some(EyeBall { centre: middle.into(), radius: half.length() }),
            apart: half.into(),
            near_depth: volume.far_near - volume.near,
            ..view
        })
    }

    /// Half the way from the left to the right eye of a [stereo](Self::stereo) view, in world
    /// space; zeros for a view of one eye.
    #[must_use]
    pub fn eyes_apart(&self) -> [f64; 3] {
        self.apart
    }
}

/// The axes to the right, up and backward between those of two views; `None` where they look apart.
fn axes(views: [&View; 2]) -> Option<DMat3> {
    let ahead = views.map(|view| view.clip_from_world.row(3).truncate().normalize());
    // Off the centre the row of y leans along the view, which turns nothing aside.
    let up = views.map(|view| {
        let (up, w) =
            (view.clip_from_world.row(1).truncate(), view.clip_from_world.row(3).truncate());
        up - w * (up.dot(w) / w.length_squared())
    });
    if ahead[0].dot(ahead[1]) <= 0.0 {
        return None;
    }
    let back = -(ahead[0] + ahead[1]).normalize();
    let up = up[0].normalize() + up[1].normalize();
    let right = up.cross(back).normalize();
    let axes = DMat3::from_cols(right, back.cross(right), back);
    axes.is_finite().then_some(axes)
}

/// The volume around the frusta of both eyes, seen from the middle: tangents of its sides, and
/// distances along the view.
struct Volume {
    low: [f64; 2],
    high: [f64; 2],
    near: f64,
    /// The farthest near corner.
    far_near: f64,
    far: f64,
    is_ahead: bool,
}

impl Default for Volume {
    fn default() -> Self {
        Self {
            low: [f64::INFINITY; 2],
            high: [f64::NEG_INFINITY; 2],
            near: f64::INFINITY,
            far_near: 0.0,
            far: 0.0,
            is_ahead: true,
        }
    }
}

impl Volume {
    /// Adds a corner of a frustum: a point, or the direction of one at infinity.
    fn add(&mut self, p: DVec3, is_direction: bool, is_near: bool) {
        let depth = -p.z;
        self.is_ahead &= depth > 0.0;
        for (axis, value) in [p.x, p.y].into_iter().enumerate() {
            self.low[axis] = self.low[axis].min(value / depth);
            self.high[axis] = self.high[axis].max(value / depth);
        }
        if is_near {
            self.near = self.near.min(depth);
            self.far_near = self.far_near.max(depth);
        }
        self.far = if is_direction { f64::INFINITY } else { self.far.max(depth) };
    }

    fn projection(&self, depth: Depth) -> Option<DMat4> {
        let finite = |v: [f64; 2]| v.iter().all(|v| v.is_finite());
        if !(self.is_ahead && finite(self.low) && finite(self.high) && self.near > 0.0) {
            return None;
        }
        let size = [0, 1].map(|a| self.high[a] - self.low[a]);
        let low = [0, 1].map(|a| self.low[a] - size[a] * SLACK);
        let high = [0, 1].map(|a| self.high[a] + size[a] * SLACK);
        let (near, far) = (self.near * (1.0 - SLACK), self.far * (1.0 + SLACK));
        let scale = [0, 1].map(|a| 2.0 / (high[a] - low[a]));
        let lean = [0, 1].map(|a| (high[a] + low[a]) / (high[a] - low[a]));
        // z = a · distance + b, over w = distance.
        let (a, b) = match far.is_finite() {
            true => (far / (far - near), -near * far / (far - near)),
            false => (1.0, -near),
        };
        let (a, b) = if depth == Depth::Reversed { (1.0 - a, -b) } else { (a, b) };
        Some(DMat4::from_cols_array_2d(&[
            [scale[0], 0.0, 0.0, 0.0],
            [0.0, scale[1], 0.0, 0.0],
            [lean[0], lean[1], -a, -1.0],
            [0.0, 0.0, b, 0.0],
        ]))
    }
}
