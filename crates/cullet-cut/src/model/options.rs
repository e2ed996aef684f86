//! How a model is cut.

use cullet::bounds::Plane;

use crate::options::Keep;

/// How to cut a model. Lengths and places are those of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelOptions<'a> {
    /// The planes, whose normals point out of the region: at most
    /// [`MAX_CUT_PLANES`](crate::MAX_CUT_PLANES).
    pub planes: &'a [Plane],
    /// Part that is kept; the inside unless said otherwise.
    pub keep: Keep,
    /// Whether the cut is closed, where it can be.
    pub caps: bool,
    /// Whether the outlines of the cut are wanted, with caps or without.
    pub outlines: bool,
    /// A point in the open: what lies around it and is no solid is a shell, and gets no cap, which
    /// would close it.
    pub hollow: Option<[f64; 3]>,
    /// Whether a mesh that the cut leaves open, because it has no cap, shows both its sides: one
    /// looks into it.
    pub show_insides: bool,
    /// Ends of open outlines up to this far apart are joined by a straight line; 0, the default,
    /// joins none.
    pub heal: f64,
    /// Vertices of a mesh up to this far apart are moved to one position before the cut; 0, the
    /// default, moves none.
    pub weld: f64,
    /// The most triangles of instances that planes go through, each of which becomes a mesh of its
    /// own; `None`, the default, is no limit.
    pub most_triangles: Option<u64>,
}
