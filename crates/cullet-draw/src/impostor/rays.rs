//! The rays of a view against the impostor of an instance.

use glam::{DMat4, DVec3, DVec4};

use super::trace::Tracer;
use crate::geometry::{Lens, ObjectLens};

/// The rays of a view in the space of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Rays<'a> {
    tracer: &'a Tracer,
    to_clip: DMat4,
    from_clip: DMat4,
    /// Inner depths of the near plane, and of a plane behind it that is at no infinity.
    depths: [f64; 2],
}

impl<'a> Rays<'a> {
    /// `None` where the transform of the instance flattens the mesh.
    pub(crate) fn new(tracer: &'a Tracer, lens: &Lens, object: &ObjectLens) -> Option<Self> {
        let to_clip = DMat4::from_cols_array_2d(&object.rows).transpose();
        let from_clip = to_clip.inverse();
        let [near, far] = lens.range;
        let depths = [near, (near + far) * 0.5];
        from_clip.is_finite().then_some(Self { tracer, to_clip, from_clip, depths })
    }

    /// Returns what the ray through a place of the screen meets: its inner depth, and the number of
    /// its texel.
    pub(crate) fn meet(&self, [x, y]: [f64; 2]) -> Option<(f64, u32)> {
        let [from, to] = self.depths.map(|depth| {
            let p = self.from_clip * DVec4::new(x, y, depth, 1.0);
            p.truncate() / p.w
        });
        let hit = self.tracer.trace(from, to - from)?;
        let clip = self.to_clip * DVec3::extend(hit.point, 1.0);
        Some((clip.z / clip.w, hit.texel))
    }
}
