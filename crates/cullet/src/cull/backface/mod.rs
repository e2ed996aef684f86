//! Back-face culling.
//!
//! One rule for every form of the test: a triangle with outward plane n·x = d is back-facing iff
//! n·(p − eye) > 0 for its points p. With the homogeneous eye (e, w), which is (position, 1) in
//! perspective and (direction towards the viewer, 0) in orthographic, that is d·w − n·e > 0. What
//! is edge-on, or cannot be told from edge-on, is kept.
//!
//! [`ObjectEye`] is the eye in the space of the mesh, where triangles are tested, which is right
//! for every transform. [`Planes8`] are quantised planes of triangles, [`EllipticCone`]s bound
//! whole clusters; [`Backfaces`] is what a culler prepares of a mesh.
//!
//! A mirrored instance is not inside out: as in glTF, the winding of its triangles is that of
//! object space.
//!
//! ```
//! use cullet::cull::backface::ObjectEye;
//! use cullet::{Transform, view::{CullFace, FrontFace}};
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

mod cluster;
mod planes;
mod prepared;
mod triangle;

pub use cluster::{Apex, ClusterEye, ClusterPlanes, EllipticCone, EllipticCones};
pub use planes::{PlaneEye, Planes8};
pub use prepared::{BackfaceEye, Backfaces, ClusterCones};
pub use triangle::{ObjectEye, ViewEye};

use crate::view::FrontFace;

/// The side of a triangle that the eye sees.
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
    /// From a value that is positive for counter-clockwise triangles, and a bound of its error. NaN
    /// proves nothing.
    #[must_use]
    pub fn from_value(value: f64, error: f64, front_face: FrontFace) -> Self {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Transform, view::CullFace};

    /// The two polygons of the lectures on back-face culling: N·V of −4 is seen, of +5 is not.
    #[test]
    fn the_example_of_the_lecture() {
        let (n1, n2, v) = ([2.0, 1.0, 2.0], [-3.0, 1.0, -2.0], [-1.0, 0.0, -1.0]);
        let eye = [-v[0], -v[1], -v[2], 0.0];
        let along = |n: [f64; 3]| glam::DVec3::from(n).dot(v.into());
        assert_eq!((along(n1), along(n2)), (-4.0, 5.0));
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
