//! Back-face tests of whole clusters: one small bound for all their triangles.
//!
//! A cluster is back-facing where the eye is behind the planes of all its triangles: in the
//! intersection of their back half-spaces, a convex region. Every bound here is a simpler region inside
//! of that one, so that what it culls is proved; they differ in shape, size and cost.
//!
//! | bound | bytes | region |
//! |---|---|---|
//! | [`ClusterPlanes`] | 16 a triangle | the region itself: the ideal that the others are measured by |
//! | [`Pyramid`] | 12 + 12 k | k planes through one apex |
//! | [`EllipticCone`] | 48, quantised 21 | an elliptic cone |
//! | [`NormalCone`] | 28 | a circular cone |
//! | [`NormalConeCentre`] | 32 | the same around a sphere, without an apex |
//! | [`NormalBox`] | 40, at a common origin 28 | the normals in a box: Johannsen & Carter's |
//!
//! The cones and pyramids have an apex inside the region. With the normals of the cluster in an open
//! hemisphere around an axis a, project them to the plane at distance 1 along a: their conic hull is a
//! planar convex hull. Any convex shape around those points is a cone K of generator normals g that
//! contains all normals, and {e : g·(e − apex) ≤ 0 for all g in K} lies inside the region, since each
//! normal is one of the g and the apex is behind each plane. The test of an elliptic shape needs no
//! square root; leaving planes of the cluster out would make the region larger, so wrong.
//!
//! One bound is tested by [`Bound::is_behind`], many by [`ClusterBounds`], which gives the same answers
//! at every SIMD level.
//!
//! ```
//! use cullet::Level;
//! use cullet::cull::backface::cluster::{Bound, ClusterBounds, ClusterPlanes, EllipticCone};
//!
//! // One triangle that faces up, and one that faces down.
//! let up = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
//! let down = [up[0], up[2], up[1]];
//! let bounds: ClusterBounds<EllipticCone> =
//!     [up, down].into_iter().map(|t| EllipticCone::fit(&ClusterPlanes::new([t]))).collect();
//! let mut culled = Vec::new();
//! bounds.cull(Level::new(), [0.3, 2.0, 0.3, 1.0], &mut culled);
//! assert_eq!(culled, [0b10]);
//! ```

mod batch;
mod coherence;
mod ellipse;
mod elliptic;
mod eye;
mod fit;
mod no_region;
mod nodes;
mod normal_box;
mod normal_cone;
mod pyramid;
mod quantised;
mod region;

pub use batch::{BatchBound, ClusterBounds};
pub use coherence::{ClusterTracker, Tracked};
pub use elliptic::EllipticCone;
pub use eye::ClusterEye;
pub use fit::ClusterPlanes;
pub use no_region::NoRegion;
pub use nodes::{ClusterCut, ClusterNodes};
pub use normal_box::{NormalBox, NormalBoxAtOrigin, NormalBoxTurned};
pub use normal_cone::{NormalCone, NormalConeCentre};
pub use pyramid::Pyramid;
pub use quantised::EllipticConeQuantised;
pub use region::{CullingRegion, RegionFace};

use fit::ApexFit;

/// Which sides of a cluster's triangles the eye sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClusterFacing {
    /// All of them from behind.
    Back,
    /// All of them from the front.
    Front,
    /// Both, or it is not proved.
    Mixed,
}

/// How a bound is fitted to the planes of a cluster, and tested.
pub trait Bound: Sized {
    /// A bound of a cluster with these planes. `None` where no eye can be proved behind all of them:
    /// normals that span half of space or nearly so, a triangle whose normal is not certain (see
    /// [`ClusterPlanes::is_complete`]), no triangle at all, or coordinates that the test in f32 cannot
    /// hold (beyond 1e14, or a cluster smaller than 1e-30). [`ClusterPlanes::region`] names which.
    fn fit(planes: &ClusterPlanes) -> Option<Self>;

    /// Whether the eye is proved behind every plane.
    fn is_behind_eye(&self, eye: &ClusterEye) -> bool;

    /// [`is_behind_eye`](Self::is_behind_eye) for a homogeneous eye in the space of the cluster. False
    /// for one that is no eye: see [`ClusterEye::new`].
    fn is_behind(&self, eye: [f64; 4]) -> bool {
        ClusterEye::new(eye).is_some_and(|eye| self.is_behind_eye(&eye))
    }
}

/// A bound of the eyes that see a cluster wholly from behind, and one of those that see it wholly from
/// the front; either may be missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoWay<B> {
    back: Option<B>,
    front: Option<B>,
}

impl<B: Bound> TwoWay<B> {
    /// The bounds of a cluster with these planes.
    #[must_use]
    pub fn fit(planes: &ClusterPlanes) -> Self {
        // To be in front of a plane is to be behind it the other way round.
        Self { back: B::fit(planes), front: B::fit(&planes.flipped()) }
    }

    /// Whether all triangles are proved to be seen from behind.
    #[must_use]
    pub fn is_backfacing(&self, eye: [f64; 4]) -> bool {
        self.back.as_ref().is_some_and(|b| b.is_behind(eye))
    }

    /// Whether all triangles are proved to be seen from the front.
    #[must_use]
    pub fn is_frontfacing(&self, eye: [f64; 4]) -> bool {
        self.front.as_ref().is_some_and(|b| b.is_behind(eye))
    }

    /// The three-way answer.
    #[must_use]
    pub fn facing(&self, eye: [f64; 4]) -> ClusterFacing {
        if self.is_backfacing(eye) {
            ClusterFacing::Back
        } else if self.is_frontfacing(eye) {
            ClusterFacing::Front
        } else {
            ClusterFacing::Mixed
        }
    }

    /// The bound of the eyes behind, if there is one.
    #[must_use]
    pub fn back(&self) -> Option<&B> {
        self.back.as_ref()
    }

    /// The bound of the eyes in front, if there is one.
    #[must_use]
    pub fn front(&self) -> Option<&B> {
        self.front.as_ref()
    }
}
