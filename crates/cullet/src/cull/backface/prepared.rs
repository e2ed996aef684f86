//! Back faces of a mesh, prepared to be culled frame after frame: a plane of four bytes for each
//! triangle, and an elliptic cone for each cluster.
//!
//! All forms take the eye as exact. An [`ObjectEye`] is not: it allows for what a renderer loses
//! when it moves vertices to the screen, and culls a triangle only beyond that. The same holds
//! here, so that what is culled is always a part of what [`ObjectEye::culls`] culls. The triangles
//! are measured once for it, and an instance whose doubt is too large for them (a mesh of thin
//! triangles, far from the world's origin) is refused: its triangles want the test from their
//! corners.

use alloc::vec::Vec;
use core::ops::Range;

use glam::DVec3;

use super::cluster::{ClusterEye, ClusterPlanes, EllipticCone, EllipticCones};
use super::planes::Frame;
use super::{Facing, ObjectEye, PlaneEye, Planes8};
use crate::Simd;
use crate::array::Each;

/// A triangle less high than this share of the mesh's size is left to the test from its corners:
/// one alone would put the whole mesh in doubt.
const THIN: f64 = 1e-6;
/// The doubt, as an angle, that the cones are fitted for. At 0.006 degrees it costs no cluster that
/// matters, and covers triangles a millimetre high at half a million metres from the origin.
const CONE_DOUBT: f64 = 1e-4;

/// The planes of a mesh's one-sided triangles: four bytes a triangle.
#[derive(Clone, Debug)]
pub struct Backfaces {
    planes: Planes8,
    frame: Frame,
    /// The most that the coordinates of a triangle's corner and its two edges add up to.
    size: f64,
    /// The least height of a triangle: twice its area over the length of two edges.
    thinnest: f64,
    /// The largest ratio of those lengths and that height.
    aspect: f64,
}

/// How high a triangle is over its two edges, and the length of those.
fn shape(corners: [[f32; 3]; 3]) -> (f64, f64) {
    let [a, b, c] = corners.each(|p| DVec3::from(p.each(f64::from)));
    let (u, v) = (b - a, c - a);
    let edges = u.abs().element_sum() + v.abs().element_sum();
    (u.cross(v).length() / edges, edges)
}

fn corners(positions: &[[f32; 3]], indices: &[u32], t: u32) -> [[f32; 3]; 3] {
    let t = t as usize * 3;
    [0, 1, 2].each(|k| positions[indices[t + k] as usize])
}

impl Backfaces {
    /// The planes of the triangles of some ranges, counter-clockwise fronts; all others are never
    /// culled.
    ///
    /// # Panics
    /// If a range reaches beyond the indices, or an index beyond the positions.
    #[must_use]
    pub fn new(
        positions: &[[f32; 3]],
        indices: &[u32],
        one_sided: impl IntoIterator<Item = Range<u32>>,
    ) -> Self {
        let frame = Frame::around(positions);
        let planes = Planes8::unset(positions, indices.len() / 3);
        let (thinnest, aspect) = (f64::INFINITY, 0.0);
        let mut made = Self { planes, frame, size: 0.0, thinnest, aspect };
        for t in one_sided.into_iter().flatten() {
            let corners = corners(positions, indices, t);
            let (height, edges) = shape(corners);
            // Written so that the NaN of a point is thin.
            if height >= THIN * frame.scale {
                let first: f64 = corners[0].iter().map(|v| f64::from(v.abs())).sum();
                made.size = made.size.max(first + edges);
                made.thinnest = made.thinnest.min(height);
                made.aspect = made.aspect.max(edges / height);
                made.planes.set(t as usize, corners);
            }
        }
        made
    }

    /// The cones of clusters of the same mesh; `None` is one that is never culled. `facing` is what
    /// they are to prove of the eye: that it sees the [`Facing::Back`] of all triangles, or the
    /// [`Facing::Front`]. The cost of a cluster grows with the spread of its normals.
    ///
    /// # Panics
    /// As [`Backfaces::new`].
    #[must_use]
    pub fn cones(
        &self,
        positions: &[[f32; 3]],
        indices: &[u32],
        clusters: impl IntoIterator<Item = Option<Range<u32>>>,
        facing: Facing,
    ) -> ClusterCones {
        let mut any = false;
        let fit = |range: Option<Range<u32>>| {
            let range = range.filter(|_| facing != Facing::Edge)?;
            let corners = |t| corners(positions, indices, t);
            if range.clone().any(|t| shape(corners(t)).0 < THIN * self.frame.scale) {
                return None;
            }
            let planes = ClusterPlanes::new(range.map(corners));
            let planes = if facing == Facing::Front { planes.flipped() } else { planes };
            let cone = EllipticCone::fit_doubting(&planes, CONE_DOUBT);
            any |= cone.is_some();
            cone
        };
        let bounds = clusters.into_iter().map(fit).collect();
        ClusterCones { bounds, any, facing }
    }

    /// The eye of an instance as planes and cones take it. `None` where it culls nothing, or
    /// where its doubt is too large for these forms: then only [`ObjectEye::culls`] is right.
    ///
    /// [`ObjectEye::culls`] tests n·(eye − w·a) < −(2·reach·Q + s·error)/h of a triangle with unit
    /// normal n, edges s and height h, where Q is the length of eye − w·a. Both forms leave as much
    /// in relation to Q: the planes by a wider bound, the cones by being fitted so. All is doubled
    /// for the rounding of that test itself.
    #[must_use]
    pub fn eye(&self, eye: &ObjectEye) -> Option<BackfaceEye> {
        let facing = eye.culled_side();
        let (e, w) = (eye.eye, eye.weight);
        let reach = eye.reach[0] + eye.reach[1] * self.size;
        let error = eye.eye_error[0] + eye.eye_error[1] * self.size;
        let to_centre = e - self.frame.centre * w;
        let radius = w * self.frame.scale;
        // In the planes' units: the largest number of the eye is at least this, Q at most five
        // times as much, and the largest of a unit normal at least 0.577.
        let largest = to_centre.abs().max_element().max(radius);
        let of_planes = 3.5 * (10.0 * reach / self.thinnest + self.aspect * error / largest);
        // In the cones', as an angle: Q is at most √3 times the distance. What the eye is off by is
        // relative to the cluster's radius, which is a seventh of the edges, or to the distance,
        // whichever says less.
        let near = 14.0 * error / (w * self.thinnest);
        let far = 2.0 * self.aspect * error / (to_centre.length() - radius).max(0.0);
        let of_cones = 7.0 * reach / self.thinnest + near.min(far);
        let eye = e.extend(w).to_array();
        // Written so that NaN is too much.
        (of_cones <= CONE_DOUBT).then_some(())?;
        let planes = self.planes.eye(eye, facing, of_planes)?;
        Some(BackfaceEye { eye, planes, facing })
    }

    /// Fills words `first..` of the mask of culled triangles, as many as `culled` has. The same at
    /// every level.
    ///
    /// # Panics
    /// If the words reach beyond the last triangle's.
    pub fn cull_words(&self, simd: Simd, eye: &BackfaceEye, first: usize, culled: &mut [u64]) {
        self.planes.cull_words(simd, &eye.planes, first, culled);
    }

    /// Fills `culled` like [`cull_words`](Self::cull_words), and fills `doubt` with the triangles
    /// that are neither culled nor proved to be kept. Those are nearly edge-on, or have no plane.
    /// `doubt` is as long as `culled`.
    pub(crate) fn test_words(
        &self,
        simd: Simd,
        eye: &BackfaceEye,
        first: usize,
        culled: &mut [u64],
        doubt: &mut [u64],
    ) {
        self.planes.test_words(simd, &eye.planes, first, culled, doubt);
    }
}

/// An eye made ready for the [`Backfaces`] and [`ClusterCones`] of one mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackfaceEye {
    eye: [f64; 4],
    planes: PlaneEye,
    facing: Facing,
}

impl BackfaceEye {
    /// Returns the side that is culled where the eye sees it. The cones must have been fitted for
    /// the same side.
    #[must_use]
    pub fn facing(&self) -> Facing {
        self.facing
    }

    /// The eye in the space of the mesh: a positive multiple of (position, 1), or of (direction
    /// towards the viewer, 0).
    #[must_use]
    pub fn homogeneous(&self) -> [f64; 4] {
        self.eye
    }
}

/// The cones of a mesh's clusters, for one of their sides: 48 bytes a cluster.
#[derive(Clone, Debug)]
pub struct ClusterCones {
    bounds: EllipticCones,
    any: bool,
    facing: Facing,
}

impl ClusterCones {
    /// Whether no cluster is ever culled: all wide, two-sided or thin.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !self.any
    }

    /// The cone of a cluster; `None` for one that is never culled. For those who test cones
    /// elsewhere, as on a graphics device: an eye for which [`Backfaces::eye`] has an answer, and
    /// which is within the cone, is behind every triangle.
    ///
    /// # Panics
    /// If there is no such cluster.
    #[must_use]
    pub fn get(&self, cluster: usize) -> Option<EllipticCone> {
        self.bounds.get(cluster)
    }

    /// Sets bit i of `culled` where every triangle of cluster i is proved to be culled. Nothing is
    /// for an eye that culls the other side. The same at every level.
    pub fn cull(&self, simd: Simd, eye: &BackfaceEye, culled: &mut Vec<u64>) {
        culled.clear();
        culled.resize(self.bounds.len().div_ceil(64), 0);
        if let Some(eye) = ClusterEye::new(eye.eye).filter(|_| eye.facing == self.facing) {
            self.bounds.cull_words(simd, &eye, 0, culled);
        }
    }
}
