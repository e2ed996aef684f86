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
//!
//! All but the first have an apex inside the region. With the normals of the cluster in an open
//! hemisphere around an axis a, project them to the plane at distance 1 along a: their conic hull is a
//! planar convex hull. Any convex shape around those points is a cone K of generator normals g that
//! contains all normals, and {e : g·(e − apex) ≤ 0 for all g in K} lies inside the region, since each
//! normal is one of the g and the apex is behind each plane. The test of an elliptic shape needs no
//! square root; leaving planes of the cluster out would make the region larger, so wrong.

mod elliptic;
mod fit;
mod normal_cone;
mod pyramid;

pub use elliptic::{EllipticCone, EllipticConeQuantised};
pub use fit::ClusterPlanes;
pub use normal_cone::NormalCone;
pub use pyramid::Pyramid;

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

/// How a bound is fitted to the planes of a cluster.
pub trait Bound: Sized {
    /// A bound of a cluster with these planes; `None` where no eye can be proved behind all of them
    /// (normals that span half of space or more).
    fn fit(planes: &ClusterPlanes) -> Option<Self>;

    /// Whether the homogeneous eye, in the space of the cluster, is proved behind every plane. False
    /// for an eye that is not finite.
    fn is_behind(&self, eye: [f64; 4]) -> bool;
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
}
