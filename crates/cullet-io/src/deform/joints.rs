//! Bounds of skinned meshes: one box a joint, around what it moves.

use cullet::Transform;
use cullet::bounds::Aabb;
use glam::{DAffine3, DVec3};

use super::{DeformError, F32_LOSS, F32_UNDERFLOW, linear};

/// A mesh bound to joints (linear blend skinning with four joints a vertex or more, as in glTF):
/// vertex v is drawn at Σ `weightᵢ · jointᵢ · inverse_bindᵢ · v`.
#[derive(Clone, Copy, Debug)]
pub struct Skin<'a> {
    /// Vertex positions, as bound.
    pub positions: &'a [[f32; 3]],
    /// Four joints for each vertex. Four more of each may follow, in the order of the vertices.
    pub joints: &'a [[u16; 4]],
    /// Their weights, as many; a joint of weight 0 does not matter and need not exist.
    pub weights: &'a [[f32; 4]],
    /// For each joint, from the mesh's space to the joint's.
    pub inverse_binds: &'a [Transform],
}

impl Skin<'_> {
    pub(super) fn check(&self) -> Result<(), DeformError> {
        let vertices = self.positions.len();
        let (joints, weights) = (self.joints.len(), self.weights.len());
        let sets = joints.checked_div(vertices).unwrap_or(1).max(1);
        for (what, count) in [("joints", joints), ("weights", weights)] {
            if count != vertices * sets {
                return Err(DeformError::Length { what: what.into(), count, vertices });
            }
        }
        let joints = self.inverse_binds.len();
        for vertex in 0..vertices {
            if let Some((joint, _)) = self.moved_by(vertex).find(|(j, _)| usize::from(*j) >= joints)
            {
                return Err(DeformError::Joint { vertex, joint, joints });
            }
        }
        Ok(())
    }

    /// The joints that move a vertex, and how much.
    pub(super) fn moved_by(&self, vertex: usize) -> impl Iterator<Item = (u16, f64)> {
        let sets = (vertex..self.joints.len()).step_by(self.positions.len());
        let pairs = sets.flat_map(|at| self.joints[at].into_iter().zip(self.weights[at]));
        pairs.filter(|(_, w)| *w != 0.0).map(|(j, w)| (j, f64::from(w)))
    }

    /// Where every vertex is drawn when the joints are at `joints`: evaluated in f64, rounded at
    /// the end. The slow truth that [`JointBoxes::bounds`] is held against. A vertex without
    /// weights is at zero.
    ///
    /// # Errors
    /// As [`JointBoxes::new`]; a joint beyond `joints` counts as one that is not there.
    pub fn pose(&self, joints: &[Transform]) -> Result<Vec<[f32; 3]>, DeformError> {
        let known = self.inverse_binds.len().min(joints.len());
        Skin { inverse_binds: &self.inverse_binds[..known], ..*self }.check()?;
        let pairs = joints.iter().zip(self.inverse_binds);
        let matrices: Vec<DAffine3> = pairs.map(|(j, b)| affine(j) * affine(b)).collect();
        let place = |(vertex, p): (usize, &[f32; 3])| {
            let p = DVec3::from(p.map(f64::from));
            let sum = self.moved_by(vertex).fold(DVec3::ZERO, |sum, (j, w)| {
                sum + matrices[usize::from(j)].transform_point3(p) * w
            });
            sum.as_vec3().to_array()
        };
        Ok(self.positions.iter().enumerate().map(place).collect())
    }
}

fn affine(t: &Transform) -> DAffine3 {
    DAffine3 { matrix3: linear(t), translation: t.translation.into() }
}

/// Box of the vertices that one joint moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    pub(super) joint: u16,
    /// In the joint's space.
    pub(super) bounds: Aabb,
    /// The sizes of all terms that made those positions, for what rounding may lose.
    pub(super) size: DVec3,
}

/// For each joint the box of the vertices it moves, in the joint's own space: bounds of a skinned
/// mesh for the cost of its joints, not of its vertices.
///
/// A vertex is a blend of its images under several joints. Where weights are not negative and add
/// to 1 it lies between them, so the box around all joints' moved boxes holds it. Weights that add
/// to something else, or are negative, are allowed: the least and greatest sums are kept, and the
/// box grows by them (about the zero of the space that the joints are given in: give joints
/// relative to the mesh, not to a far world, if weights are careless).
#[derive(Clone, Debug)]
pub struct JointBoxes {
    pub(super) moved: Vec<Moved>,
    /// Least and greatest sum of a vertex's positive weights.
    positive: [f64; 2],
    /// Greatest sum of a vertex's negative weights, without the sign.
    negative: f64,
    pub(super) unbounded: bool,
}

impl JointBoxes {
    /// Takes the boxes. O(vertices). A mesh without vertices has empty bounds; a position, weight
    /// or inverse bind matrix that matters and is not finite makes all bounds [`Aabb::EVERYTHING`].
    ///
    /// # Errors
    /// If the lists are not of one length, or a weight that is not zero names a joint without an
    /// inverse bind matrix.
    pub fn new(skin: &Skin<'_>) -> Result<Self, DeformError> {
        skin.check()?;
        let joints = skin.inverse_binds.len();
        let mut boxes = vec![Aabb::EMPTY; joints];
        let mut sizes = vec![DVec3::ZERO; joints];
        let (mut positive, mut negative) = ([f64::INFINITY, 0.0f64], 0.0f64);
        let mut unbounded = false;
        for (vertex, p) in skin.positions.iter().enumerate() {
            let p = DVec3::from(p.map(f64::from));
            unbounded |= !p.is_finite();
            let (mut plus, mut minus) = (0.0f64, 0.0f64);
            for (joint, w) in skin.moved_by(vertex) {
                unbounded |= !w.is_finite();
                plus += w.max(0.0);
                minus += (-w).max(0.0);
                let bind = &skin.inverse_binds[usize::from(joint)];
                let [x, y, z] = bind.linear.map(|c| DVec3::from(c.map(f64::from)));
                let size = x.abs() * p.x.abs()
                    + y.abs() * p.y.abs()
                    + z.abs() * p.z.abs()
                    + DVec3::from(bind.translation).abs();
                let image = affine(bind).transform_point3(p);
                unbounded |= !size.is_finite();
                let point = Aabb::rounded_out(image.into(), image.into());
                let joint = usize::from(joint);
                boxes[joint] = boxes[joint].union(&point);
                sizes[joint] = sizes[joint].max(size);
            }
            positive = [positive[0].min(plus), positive[1].max(plus)];
            negative = negative.max(minus);
        }
        let moved = (0..joints)
            .filter(|&j| !boxes[j].is_empty())
            .map(|j| Moved { joint: j as u16, bounds: boxes[j], size: sizes[j] })
            .collect();
        Ok(Self { moved, positive, negative, unbounded })
    }

    /// The box of a joint in its own space; [`Aabb::EMPTY`] where it moves nothing.
    #[must_use]
    pub fn joint_box(&self, joint: u16) -> Aabb {
        self.moved.iter().find(|m| m.joint == joint).map_or(Aabb::EMPTY, |m| m.bounds)
    }

    /// The box around the mesh when its joints are at `joints`, relative to `origin`, rounded
    /// outward: it holds every vertex though the skinning be done in f32. O(joints that move
    /// something).
    ///
    /// [`Aabb::EVERYTHING`] where a joint that moves something is missing from `joints` or not
    /// finite.
    #[must_use]
    pub fn bounds(&self, joints: &[Transform], origin: [f64; 3]) -> Aabb {
        self.bounds_of(self.moved.iter().copied(), joints, origin)
    }

    /// The same with other boxes in place of its own, of the same joints.
    pub(super) fn bounds_of(
        &self,
        moved: impl Iterator<Item = Moved>,
        joints: &[Transform],
        origin: [f64; 3],
    ) -> Aabb {
        if self.unbounded {
            return Aabb::EVERYTHING;
        }
        if self.positive[0] == f64::INFINITY {
            return Aabb::EMPTY;
        }
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut size = DVec3::ZERO;
        for m in moved {
            let Some(joint) = joints.get(usize::from(m.joint)).filter(|j| j.is_finite()) else {
                return Aabb::EVERYTHING;
            };
            let joint = affine(joint);
            let half = DVec3::from(m.bounds.half_extent());
            let [x, y, z] =
                [joint.matrix3.x_axis, joint.matrix3.y_axis, joint.matrix3.z_axis].map(DVec3::abs);
            let reach = x * half.x + y * half.y + z * half.z;
            let centre = joint.transform_point3(m.bounds.center().into());
            (low, high) = (low.min(centre - reach), high.max(centre + reach));
            let s = x * m.size.x + y * m.size.y + z * m.size.z + joint.translation.abs();
            size = size.max(s);
        }
        if self.moved.is_empty() {
            // No vertex has a weight: all are at zero.
            (low, high) = (DVec3::ZERO, DVec3::ZERO);
        }
        // p·a − n·b for a, b in the box, p and n the sums of weights: per axis, the extremes of
        // each term.
        let ([p0, p1], n) = (self.positive, self.negative);
        let least = (low * p0).min(low * p1) - (high * n).max(DVec3::ZERO);
        let most = (high * p0).max(high * p1) - (low * n).min(DVec3::ZERO);
        let origin = DVec3::from(origin);
        let slack = size * ((p1 + n) * F32_LOSS) + F32_UNDERFLOW + origin.abs() * 1e-15;
        let (min, max) = (least - origin - slack, most - origin + slack);
        if !(min.is_finite() && max.is_finite()) {
            return Aabb::EVERYTHING;
        }
        Aabb::rounded_out(min.into(), max.into())
    }
}
