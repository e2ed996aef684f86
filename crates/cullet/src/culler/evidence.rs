//! Numbers behind an explanation: what a stage held against what.

use alloc::vec::Vec;

use crate::cull::shadow::CasterReason;

/// Numbers of a stage's test of one instance, as the stage had them. Lengths are in units of the
/// scene, and planes point out: a positive distance is outside.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Evidence {
    /// Counts alone: nothing of the instance as a whole was measured.
    #[default]
    None,
    /// No test: the instance is [exempt](crate::Scene::exempt).
    Exempt,
    /// No test: the box crosses the near plane, or there is none, so it has no bounds on the
    /// screen.
    NearPlane,
    /// No test: the box is beyond an edge of the screen.
    OffScreen,
    /// No test: the stage would cost more than it could save.
    Cost,
    /// No test: the mesh has no levels of detail, or the instance is not
    /// [rigid](crate::Scene::is_rigid).
    NoLevels,
    /// No test: the cells have no portals.
    NoPortals,
    /// No test: the cells have no visible sets.
    NoSets,
    /// No test: the view is orthographic, so it has no eye in a cell.
    Orthographic,
    /// No test: the eye is in no cell.
    NoCell,
    /// No test: the near plane reaches out of the cells, into a wall.
    InWall,
    /// Layers, one bit each: it stays where the two share one.
    Layers {
        /// Layers of the instance.
        instance: u32,
        /// Layers of the view.
        view: u32,
    },
    /// The instance's box against each plane of the frustum that there is.
    Planes(Vec<PlaneTest>),
    /// The box of a caster against the region in which casters of a light matter.
    Caster {
        /// Why its shadow cannot matter, if that is so.
        reason: Option<CasterReason>,
        /// The box against each plane of the region.
        planes: Vec<PlaneTest>,
    },
    /// The cells of an instance against those that the eye sees into.
    Cells(CellTest),
    /// The projected size of its box.
    Size {
        /// Width and height on the screen in pixels, the parts beyond its edges included.
        pixels: [f64; 2],
        /// Factor by which the size counts.
        weight: f32,
    },
    /// Area that the transform and the mesh leave to the instance.
    Area {
        /// Rank of the transform: 3 for all that is not flattened.
        rank: u8,
        /// Triangles of the mesh that have an area.
        with_area: u32,
        /// All triangles of the mesh.
        triangles: u32,
    },
    /// Its screen bounds against the occlusion buffer.
    Cover(CoverTest),
    /// The level of detail that was chosen.
    Levels {
        /// Triangles of what is drawn.
        drawn: u64,
        /// Triangles of the mesh in full.
        triangles: u64,
        /// Number of pixels by which the drawn levels may be off from the full mesh.
        pixels: f64,
    },
    /// Another instance is drawn in its place.
    Replaced {
        /// Slot of that instance.
        by: u32,
        /// Number of instances that it stands for.
        count: u32,
    },
    /// The instance stands for others.
    StandIn {
        /// Number of instances that it stands for.
        count: u32,
        /// One of them has changed, so it is never drawn.
        is_off: bool,
    },
}

/// A box against a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlaneTest {
    /// Number of the plane, as in a [`Reason`](crate::Reason) and in
    /// [`FrustumPlane::ALL`](crate::view::FrustumPlane::ALL).
    pub plane: u8,
    /// Signed distance of the corner that is farthest inside: above 0 all of the box is outside.
    pub nearest: f64,
    /// Signed distance of the corner that is farthest outside: at most 0 all of the box is inside.
    pub farthest: f64,
}

/// The cells of an instance against those that the eye sees into.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CellTest {
    /// Cells that the instance is in.
    pub instance: Vec<u32>,
    /// Cells that the near plane may be in, that of the eye first.
    pub eye: Vec<u32>,
    /// Portals from the eye on: of the chain through which it is seen; or beside which it is, where
    /// its cell is reached; or else of the shortest open way to it. Always empty for sets.
    pub portals: Vec<u32>,
    /// Whether it may be seen.
    pub in_sight: bool,
    /// Grounds of that answer.
    pub sight: Sight,
}

/// Grounds on which an instance counts as in sight of the cells of the eye, or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Sight {
    /// The instance is outside the cells, or moved since they were updated: it counts as seen from
    /// everywhere.
    #[default]
    Everywhere,
    /// The visible sets.
    Sets,
    /// The portals through which its cell is seen: it is seen through them, or beside what they
    /// show.
    Portals,
    /// The limits of chains of portals, behind which all is taken to be seen.
    Limited,
    /// Every way to the instance has a shut portal. This is the first shut portal on the shortest
    /// way.
    Shut(u32),
    /// A way is open, but no line of sight leads along it.
    Open,
    /// No portals lead to its cells.
    NoWay,
}

/// The screen bounds of a box against the occlusion buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CoverTest {
    /// Pixels of the buffer.
    pub buffer: [u32; 2],
    /// First column and row that the box may touch, in pixels of the buffer from the top left.
    pub min: [u32; 2],
    /// Last column and row, inclusive.
    pub max: [u32; 2],
    /// Greatest nearness of the box. Larger is nearer: 1 / w in perspective, where w is the
    /// distance along the view direction.
    pub nearness: f32,
    /// Least nearness of the covered pixels within those bounds: 0 if a pixel is not covered.
    pub covered: f32,
    /// First pixel that lets the box through, by row and then column; `None` if the box is hidden.
    pub open: Option<[u32; 2]>,
}
