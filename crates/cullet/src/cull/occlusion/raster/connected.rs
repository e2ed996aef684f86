//! Triangles that share edges, laid out for drawing.

use super::primitives::LANES;
use crate::bounds::Aabb;

/// Some triangles of a surface, its *own*, and those *around* that touch them, with the edges of both.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Connected {
    /// x, y and z of the vertices, first those of its own triangles; the last is repeated up to a whole number of
    /// lanes.
    pub(crate) places: [Vec<f32>; 3],
    pub(crate) own_vertices: usize,
    /// Triangles, eight at a time, corner by corner: first groups of its own, then of those around it. What fills up
    /// a group has the same corner three times. A triangle's number is eight times its group's, and its lane.
    pub(crate) groups: Vec<[[u32; LANES]; 3]>,
    /// The groups that are its own.
    pub(crate) own_groups: usize,
    /// Edges: two vertices, and the triangles on both sides; [`NONE`](Self::NONE) where there is none.
    pub(crate) edges: Vec<[u32; 4]>,
    pub(crate) two_sided: bool,
    /// The box around its own triangles.
    pub(crate) bounds: Aabb,
    /// The largest absolute coordinate of all vertices along each axis.
    pub(crate) reach: [f32; 3],
}

/// The side of a triangle that is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Side {
    /// Too nearly none to tell, or nothing of it is in front of the near plane.
    #[default]
    Neither,
    Front,
    Back,
}

impl Connected {
    /// No triangle.
    pub(crate) const NONE: u32 = u32::MAX;

    /// Its triangles, each with its number.
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (u32, [u32; 3])> {
        let lanes = self.groups.iter().flat_map(|[a, b, c]| (0..LANES).map(|l| [a[l], b[l], c[l]]));
        (0..).zip(lanes).filter(|(_, t)| is_whole(t))
    }
}

/// Whether a triangle has three different corners.
pub(crate) fn is_whole(t: &[u32; 3]) -> bool {
    t[0] != t[1] && t[1] != t[2] && t[2] != t[0]
}
