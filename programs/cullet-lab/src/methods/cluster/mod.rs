//! Back-face tests of whole clusters: one small bound for all their triangles.
//!
//! A cluster is back-facing where the eye is behind the planes of all its triangles: in the
//! intersection of their back half-spaces, a convex region. Every bound here is a simpler region
//! inside of that one, so that what it culls is proved; they differ in shape, size and cost.
//!
//! | bound | bytes | region |
//! |---|---|---|
//! | [`ClusterPlanes`] | 16 a triangle | the region itself: the ideal that the others are measured by |
//! | [`Pyramid`] | 12 + 12 k | k planes through one apex |
//! | [`EllipticCone`](cullet::cull::backface::EllipticCone) | 48, quantised 21 | an elliptic cone: what the engine uses |
//! | [`NormalCone`] | 28 | a circular cone |
//! | [`NormalConeCentre`] | 32 | the same around a sphere, without an apex |
//! | [`NormalBox`] | 40, at a common origin 28 | the normals in a box: Johannsen & Carter's |
//!
//! The cones and pyramids have an apex inside the region. With the normals of the cluster in an
//! open hemisphere around an axis a, project them to the plane at distance 1 along a: their conic
//! hull is a planar convex hull. Any convex shape around those points is a cone K of generator
//! normals g that contains all normals, and {e : g·(e − apex) ≤ 0 for all g in K} lies inside the
//! region, since each normal is one of the g and the apex is behind each plane. The test of an
//! elliptic shape needs no square root; leaving planes of the cluster out would make the region
//! larger, so wrong.
//!
//! One bound is tested by [`Bound::is_behind`], many by [`ClusterBounds`], which gives the same
//! answers at every SIMD level. From frame to frame there is [`ClusterTracker`], over nodes
//! [`ClusterNodes`].

mod batch;
mod elliptic;
mod lanes;
mod margin;
mod no_region;
mod nodes;
mod normal_box;
mod normal_cone;
mod pyramid;
mod quantised;
mod region;
mod tracker;

use std::fmt::Debug;

use cullet::Simd;
use cullet::cull::backface::{ClusterEye, ClusterPlanes};

pub use batch::{Blocks, ClusterBounds};
pub use lanes::{Lanes, Rows};
pub use no_region::{NoRegion, region};
pub use nodes::{ClusterCut, ClusterNodes, join};
pub use normal_box::{NormalBox, NormalBoxAtOrigin, NormalBoxTurned};
pub use normal_cone::{NormalCone, NormalConeCentre};
pub use pyramid::{Pyramid, PyramidRows};
pub use quantised::{ByteRows, EllipticConeQuantised};
pub use region::{CullingRegion, RegionFace};
pub use tracker::ClusterTracker;

/// Margin added to every shape, as an angle or relative to its size. It covers the rounding of the
/// bound's numbers to f32 (1e-7) and of its test (4e-7), and the normals' own doubt (4.5e-7).
const ANGULAR_SLACK: f64 = 1e-5;

/// The product of two vectors, in the order in which the batch tests add it up.
#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A bound of a cluster: how it is fitted to the cluster's planes and tested, alone, in batches and
/// from frame to frame.
pub trait Bound: Copy + Debug {
    /// Many of them, structure of arrays.
    type Batch: Batch<Self>;

    /// Bytes of one in a batch.
    const BYTES: usize = size_of::<Self>();

    /// A bound of a cluster with these planes. `None` where no eye can be proved behind all of
    /// them: normals that span half of space or nearly so, a triangle whose normal is not certain
    /// (see [`ClusterPlanes::is_complete`]), no triangle at all, or coordinates that the test in
    /// f32 cannot hold (beyond 1e14, or a cluster smaller than 1e-30). [`region`] names which.
    fn fit(planes: &ClusterPlanes) -> Option<Self>;

    /// Whether the eye is proved behind every plane.
    fn is_behind_eye(&self, eye: &ClusterEye) -> bool;

    /// [`is_behind_eye`](Self::is_behind_eye) for a homogeneous eye in the space of the cluster.
    /// False for one that is no eye: see [`ClusterEye::new`].
    fn is_behind(&self, eye: [f64; 4]) -> bool {
        ClusterEye::new(eye).is_some_and(|eye| self.is_behind_eye(&eye))
    }

    /// How far a position may move, at least, before [`is_behind_eye`](Self::is_behind_eye) can
    /// change, rounding included; 0 where that is not known. Units of the cluster.
    fn margin(&self, _eye: [f64; 3]) -> f64 {
        0.0
    }
}

/// Many bounds of one kind, tested sixty-four at a time.
pub trait Batch<B>: Clone + Debug + Default {
    /// Adds a cluster; `None` is one that is never culled.
    fn push(&mut self, bound: Option<B>);

    /// How many clusters there are.
    fn len(&self) -> usize;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Words `first..` of the mask of the clusters that the eye is proved behind, as many as
    /// `culled` has; the bits beyond the last cluster are 0. The same at every level, and as
    /// [`Bound::is_behind_eye`].
    ///
    /// # Panics
    /// If the words reach beyond the last cluster's.
    fn cull_words(&self, simd: Simd, eye: &ClusterEye, first: usize, culled: &mut [u64]);
}

/// Sides of a cluster's triangles that the eye sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClusterFacing {
    /// All of them from behind.
    Back,
    /// All of them from the front.
    Front,
    /// Both, or it is not proved.
    Mixed,
}

/// A bound of the eyes that see a cluster wholly from behind, and one of those that see it wholly
/// from the front; either may be missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoWay<B> {
    /// The bound of the eyes behind.
    pub back: Option<B>,
    /// The bound of the eyes in front.
    pub front: Option<B>,
}

impl<B: Bound> TwoWay<B> {
    /// The bounds of a cluster with these planes.
    #[must_use]
    pub fn fit(planes: &ClusterPlanes) -> Self {
        // To be in front of a plane is to be behind it the other way round.
        Self { back: B::fit(planes), front: B::fit(&planes.flipped()) }
    }

    /// The three-way answer.
    #[must_use]
    pub fn facing(&self, eye: [f64; 4]) -> ClusterFacing {
        if self.back.is_some_and(|b| b.is_behind(eye)) {
            ClusterFacing::Back
        } else if self.front.is_some_and(|b| b.is_behind(eye)) {
            ClusterFacing::Front
        } else {
            ClusterFacing::Mixed
        }
    }
}
