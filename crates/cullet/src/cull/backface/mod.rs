//! Back-face culling.
//!
//! One rule for every form of the test: a triangle with outward plane n·x = d is back-facing iff
//! n·(p − eye) > 0 for its points p. With the homogeneous eye (e, w), which is (position, 1) in
//! perspective and (direction towards the viewer, 0) in orthographic, that is d·w − n·e > 0. What is
//! edge-on, or cannot be told from edge-on, is kept.
//!
//! [`triangle`] moves the eye into the space of the mesh and tests triangles there, which is right for
//! every transform; [`screen`] is the form after projection that graphics hardware uses, equal to it.
//!
//! A mirrored instance is not inside out: as in glTF, the winding of its triangles is that of object
//! space.
//!
//! ```
//! use cullet::cull::backface::ObjectEye;
//! use cullet::{CullFace, FrontFace, Transform};
//!
//! // Two triangles of one square, the second turned over; the eye is above them.
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! let indices = [0, 1, 2, 0, 3, 2];
//! let eye = [0.5, 0.5, 3.0, 1.0];
//! let eye = ObjectEye::new(eye, &Transform::IDENTITY, FrontFace::default(), CullFace::Back);
//! let mut kept = Vec::new();
//! eye.keep_into(&positions, &indices, 0..2, &mut kept);
//! assert_eq!(kept, [0]);
//! ```

mod bulk;
pub mod cluster;
mod groups;
mod mask;
mod mask_cull;
mod of_mesh;
mod patch;
mod planes32;
mod prepared;
mod quantised;
mod regions;
pub mod screen;
mod sectors;
pub mod triangle;
mod update;

pub use groups::Groups;
pub use mask::{
    BackfaceMask, MaskError, MaskGrid, MaskUse, NormalMask, NormalMasks, ViewCone,
    corner_directions,
};
pub use mask_cull::{count_masked, cull_masked, cull_masked_ref, keep_unmasked};
pub use patch::{BezierPatch, PatchError};
pub use planes32::Planes32;
pub use prepared::{BackfaceEye, Backfaces, ClusterCones};
pub use quantised::{PlaneEye, Planes8, Planes16};
pub use regions::back_regions;

pub use sectors::SectorMasks;

pub use screen::{flips_winding, ndc_normal_z, screen_facing};
pub use triangle::{ObjectEye, ViewEye, facing_ref};

use crate::view::{CullFace, FrontFace};

/// Which side of a triangle the eye sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Facing {
    /// Its front.
    Front,
    /// Its back.
    Back,
    /// Neither is proved: the triangle is edge-on, without area, or not finite. Always kept.
    Edge,
}

impl Facing {
    /// Whether a triangle that faces like this is dropped.
    #[must_use]
    pub const fn is_culled(self, cull: CullFace) -> bool {
        matches!((self, cull), (Self::Back, CullFace::Back) | (Self::Front, CullFace::Front))
    }

    /// From a value that is positive for counter-clockwise triangles, and a bound of its error.
    fn from_value(value: f64, error: f64, front_face: FrontFace) -> Self {
        let (positive, negative) = match front_face {
            FrontFace::CounterClockwise => (Self::Front, Self::Back),
            FrontFace::Clockwise => (Self::Back, Self::Front),
        };
        // Written so that a NaN proves nothing.
        if value > error {
            positive
        } else if value < -error {
            negative
        } else {
            Self::Edge
        }
    }
}

/// d·w − n·e: positive where a plane with outward normal is seen from behind, in the plain f64 of the
/// textbooks, without error bound.
///
/// With a direction of sight v in place of an eye, give (−v, 0): the value is then n·v.
#[must_use]
pub fn view_value(normal: [f64; 3], d: f64, eye: [f64; 4]) -> f64 {
    d * eye[3] - (normal[0] * eye[0] + normal[1] * eye[1] + normal[2] * eye[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Transform;

    /// The two polygons of the lectures on back-face culling: N·V of −4 is seen, of +5 is not.
    #[test]
    fn the_example_of_the_lecture() {
        let (n1, n2, v) = ([2.0, 1.0, 2.0], [-3.0, 1.0, -2.0], [-1.0, 0.0, -1.0]);
        let eye = [-v[0], -v[1], -v[2], 0.0];
        assert_eq!(view_value(n1, 0.0, eye), -4.0);
        assert_eq!(view_value(n2, 0.0, eye), 5.0);
        // The same of triangles with these normals.
        let object =
            ObjectEye::new(eye, &Transform::IDENTITY, FrontFace::default(), CullFace::default());
        let first = [[0.0; 3], [1.0, 0.0, -1.0], [0.0, 2.0, -1.0]];
        let second = [[0.0; 3], [0.0, 2.0, 1.0], [1.0, 3.0, 0.0]];
        assert_eq!((normal(&first), normal(&second)), (n1, n2));
        assert_eq!(object.facing(&first), Facing::Front);
        assert_eq!(object.facing(&second), Facing::Back);
    }

    fn normal(t: &[[f32; 3]; 3]) -> [f64; 3] {
        let [a, b, c] = t.map(|p| glam::DVec3::from(p.map(f64::from)));
        (b - a).cross(c - a).into()
    }
}
