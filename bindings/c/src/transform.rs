//! Where things stand.

use crate::memory::Plain;

/// An affine transform: x becomes linear * x + translation. Mirrored and singular ones too; one
/// that is not finite keeps its instance visible.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    /// The columns of the linear part, one after another.
    pub linear: [f32; 9],
    /// The translation; double, so that worlds of 1e7 units stay right.
    pub translation: [f64; 3],
}

impl Plain for Transform {}

impl Transform {
    pub(crate) fn to_engine(self) -> engine::Transform {
        let [a, b, c, d, e, f, g, h, i] = self.linear;
        engine::Transform {
            linear: [[a, b, c], [d, e, f], [g, h, i]],
            translation: self.translation,
        }
    }
}
