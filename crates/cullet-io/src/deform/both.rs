//! Bounds of meshes that are morphed first and skinned after, as glTF has it.

use cullet::Transform;
use cullet::bounds::Aabb;
use glam::DVec3;

use super::joints::{JointBoxes, Moved, Skin};
use super::morphs::Morphs;
use super::{DeformError, F32_UNDERFLOW, linear};

/// For each joint the box of the vertices it moves, and for each target the box of what it adds to
/// them, all in the joint's own space: bounds of a mesh that is morphed and then skinned, for the
/// cost of its joints times its targets.
///
/// Under weights w, what a joint moves lies in its box grown by Σ `wᵢ · targetᵢ` (the sum of
/// boxes); from there on it is as [`JointBoxes`] has it. A target that moves nothing of a joint
/// does not grow its box: a face that smiles leaves the feet alone.
#[derive(Clone, Debug)]
pub struct MorphedJointBoxes {
    joints: JointBoxes,
    /// For each target, what it adds to the vertices of each moved joint, in the order of those.
    targets: Vec<Vec<Pull>>,
}

/// Box of the displacements that a target adds to the vertices of a joint.
#[derive(Clone, Copy, Debug)]
struct Pull {
    /// In the joint's space.
    min: DVec3,
    max: DVec3,
    /// The sizes of all terms that made it.
    size: DVec3,
}

impl MorphedJointBoxes {
    /// Takes the boxes. `skin.positions` is the base shape, and each target has the displacement of
    /// every vertex. O(vertices × targets). What is not finite and matters makes bounds
    /// [`Aabb::EVERYTHING`]: of the skin all, of a target those under a weight that is not 0.
    ///
    /// # Errors
    /// As [`JointBoxes::new`]; also if a target has not one displacement for each vertex.
    pub fn new(skin: &Skin<'_>, targets: &[&[[f32; 3]]]) -> Result<Self, DeformError> {
        Morphs { positions: skin.positions, targets }.check()?;
        let joints = JointBoxes::new(skin)?;
        let mut at = vec![usize::MAX; skin.inverse_binds.len()];
        joints.moved.iter().enumerate().for_each(|(i, m)| at[usize::from(m.joint)] = i);
        let pulls = |target: &&[[f32; 3]]| {
            let none = Pull { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY, size: DVec3::ZERO };
            let mut pulls = vec![none; joints.moved.len()];
            for (vertex, d) in target.iter().enumerate() {
                let d = DVec3::from(d.map(f64::from));
                for (joint, _) in skin.moved_by(vertex) {
                    let m = linear(&skin.inverse_binds[usize::from(joint)]);
                    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::abs);
                    let size = x * d.x.abs() + y * d.y.abs() + z * d.z.abs();
                    // A joint that only vertices without a place name has no box, and all is
                    // unbounded.
                    let Some(pull) = pulls.get_mut(at[usize::from(joint)]) else { continue };
                    let image = m * d;
                    // The lesser of NaN and a number is the number: it must not vanish.
                    let [low, high] = match image.is_finite() {
                        true => [image; 2],
                        false => [DVec3::NEG_INFINITY, DVec3::INFINITY],
                    };
                    (pull.min, pull.max) = (pull.min.min(low), pull.max.max(high));
                    pull.size = pull.size.max(size);
                }
            }
            pulls
        };
        let targets = targets.iter().map(pulls).collect();
        Ok(Self { joints, targets })
    }

    /// The box around the mesh under `weights` when its joints are at `joints`, relative to
    /// `origin`, rounded outward: it holds every vertex though morphing and skinning be done in
    /// f32. Targets beyond the weights have weight 0, and weights beyond the targets do not matter.
    /// O(joints × targets).
    ///
    /// [`Aabb::EVERYTHING`] where a weight is not finite, or a joint that moves something is
    /// missing from `joints` or not finite.
    #[must_use]
    pub fn bounds(&self, joints: &[Transform], weights: &[f32], origin: [f64; 3]) -> Aabb {
        let active = || self.targets.iter().zip(weights).filter(|(_, w)| **w != 0.0);
        if !active().all(|(_, w)| w.is_finite()) {
            return Aabb::EVERYTHING;
        }
        // Each target is one more sum, and one more rounding of all before it: as in `MorphBounds`.
        let more = 1.0 + self.targets.len() as f64 / 16.0;
        let mut lost = false;
        let moved: Vec<Moved> = self
            .joints
            .moved
            .iter()
            .enumerate()
            .map(|(i, m)| {
                let point = |p: [f32; 3]| DVec3::from(p.map(f64::from));
                let (mut min, mut max) = (point(m.bounds.min), point(m.bounds.max));
                let mut size = m.size;
                for (target, &w) in active() {
                    let (pull, w) = (target[i], f64::from(w));
                    let (a, b) = (pull.min * w, pull.max * w);
                    lost |= !(a.is_finite() && b.is_finite());
                    (min, max) = (min + a.min(b), max + a.max(b));
                    size += pull.size * w.abs();
                }
                let (min, max) = (min - F32_UNDERFLOW, max + F32_UNDERFLOW);
                let bounds = Aabb::rounded_out(min.into(), max.into());
                lost |= !bounds.is_finite();
                Moved { joint: m.joint, bounds, size: size * more }
            })
            .collect();
        if lost {
            return Aabb::EVERYTHING;
        }
        self.joints.bounds_of(moved.into_iter(), joints, origin)
    }
}
