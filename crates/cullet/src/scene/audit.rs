//! Bounds violations: instances that leave their bounds.

use alloc::borrow::Cow;
use alloc::vec;
use alloc::vec::Vec;

use glam::DVec3;

use super::{Handle, Scene, SceneError};
use crate::array::Each;
use crate::sort::sort;

/// An instance whose geometry leaves its bounds: it may vanish while it is in sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundsViolation {
    /// Handle of the instance.
    pub handle: Handle,
    /// Its slot.
    pub slot: u32,
    /// The vertex farthest outside.
    pub vertex: u32,
    /// Where that vertex is, in world space, relative to the scene's origin.
    pub position: [f64; 3],
    /// Distance by which the vertex is outside along its worst axis, in world units; infinite where
    /// its position is not finite. Bounds that grow by this on every side hold the instance.
    pub excess: f64,
    /// How many of its vertices are outside.
    pub outside: u32,
}

impl Scene {
    /// Finds the instances whose true geometry leaves their bounds, in the order of their slots.
    ///
    /// `current` gives where an instance's vertices are now: in the space of its mesh, in the order
    /// of its mesh's vertices, before the instance's transform; `None` for those that are drawn as
    /// the mesh says. Only vertices of triangles that are drawn count. An instance without bounds,
    /// or with infinite ones, is never lost and so never listed; all others are held against the
    /// very box that culling uses, to the last bit. For tests and debug builds: O(vertices of all
    /// instances).
    ///
    /// # Errors
    /// If `current` gives more or fewer positions than the mesh has.
    pub fn audit<'a>(
        &self,
        mut current: impl FnMut(Handle) -> Option<Cow<'a, [[f32; 3]]>>,
    ) -> Result<Vec<BoundsViolation>, SceneError> {
        let mut drawn: Vec<Option<Vec<u32>>> = vec![None; self.meshes.len()];
        let mut violations = Vec::new();
        for slot in self.slots() {
            let bounds = self.bounds(slot);
            if !bounds.is_finite() && !bounds.is_empty() {
                continue;
            }
            let Some(handle) = self.handle(slot) else { continue };
            let mesh = self.mesh(slot);
            let given = current(handle);
            let positions = given.as_deref().unwrap_or(mesh.positions());
            let vertices = mesh.positions().len();
            if positions.len() != vertices {
                return Err(SceneError::Positions { handle, given: positions.len(), vertices });
            }
            let used = drawn[self.mesh_id(slot) as usize].get_or_insert_with(|| drawn_by(mesh));
            let t = self.transform(slot);
            let m = t.linear_f64();
            let shift = DVec3::from(t.translation) - DVec3::from(self.origin);
            let [min, max] = [bounds.min, bounds.max].each(|v| DVec3::from(v.each(f64::from)));
            let mut worst: Option<BoundsViolation> = None;
            let mut outside = 0;
            for &vertex in used.iter() {
                let p = m * DVec3::from(positions[vertex as usize].each(f64::from)) + shift;
                let excess = match p.is_finite() {
                    true => (min - p).max(p - max).max_element(),
                    false => f64::INFINITY,
                };
                if excess > 0.0 {
                    outside += 1;
                    if worst.is_none_or(|w| excess > w.excess) {
                        let position = p.to_array();
                        worst = Some(BoundsViolation {
                            handle,
                            slot,
                            vertex,
                            position,
                            excess,
                            outside,
                        });
                    }
                }
            }
            violations.extend(worst.map(|w| BoundsViolation { outside, ..w }));
        }
        Ok(violations)
    }
}

/// The vertices of the triangles that are in a cluster: no other triangle is ever drawn.
fn drawn_by(mesh: &crate::Mesh) -> Vec<u32> {
    let drawn = (mesh.triangle_count() - mesh.degenerate_count()) as usize;
    let mut used = mesh.indices()[..drawn * 3].to_vec();
    sort(&mut used);
    used.dedup();
    used
}
