//! Funnel of a cull: stages, reasons, and the counts in and out of each stage.

use alloc::vec::Vec;
use core::ops::{Add, AddAssign, Sub, SubAssign};

use crate::cull::shadow::CasterReason;

/// One kind of culling in the pipeline. Stages run in the order of the rows of a [`Funnel`], some
/// of them once for each [`Unit`]; their numbers are those in files and bindings. They ascend in
/// the order of the rows of a unit, with two exceptions: [`Degenerate`](Self::Degenerate) drops
/// flattened instances before [`Lod`](Self::Lod), and [`Detail`](Self::Detail) tests the samples of
/// triangles last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[repr(u8)]
pub enum Stage {
    /// Culls instances that share no layer with the view.
    Layer = 1,
    /// Culls what is outside the frustum of the view, or for a light, where no caster can matter.
    Frustum = 2,
    /// Culls instances that are not in the potentially visible set of the eye's cell, or not among
    /// the [candidates](crate::candidates::Candidates) of the caller.
    Pvs = 3,
    /// Culls what is not seen through any portal.
    Portal = 4,
    /// Culls what is too small on the screen.
    Detail = 5,
    /// Draws another level of detail in place of an instance.
    Lod = 6,
    /// Culls what is hidden behind other geometry.
    Occlusion = 7,
    /// Culls what the eye sees from behind (or from the front, if front faces are culled).
    Backface = 8,
    /// Culls what has no area.
    Degenerate = 9,
}

impl Stage {
    /// All stages, by their numbers.
    pub const ALL: [Self; 9] = [
        Self::Layer,
        Self::Frustum,
        Self::Pvs,
        Self::Portal,
        Self::Detail,
        Self::Lod,
        Self::Occlusion,
        Self::Backface,
        Self::Degenerate,
    ];

    /// The stage's name, as in `report.json`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Layer => "layer",
            Self::Frustum => "frustum",
            Self::Pvs => "pvs",
            Self::Portal => "portal",
            Self::Detail => "detail",
            Self::Lod => "lod",
            Self::Occlusion => "occlusion",
            Self::Backface => "backface",
            Self::Degenerate => "degenerate",
        }
    }
}

/// Reason for which an instance was dropped: the stage, and a detail that is the stage's own
/// (frustum: the number of the plane). Two bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct Reason {
    /// The stage that dropped it.
    pub stage: Stage,
    /// For the frustum, the number of the first plane it is outside of, or [`Reason::MIXED`], and
    /// for a light what [`Reason::caster`] reads; for sets of cells and portals, the number of the
    /// instance's cell, or [`Reason::MIXED`] where it is in several, or in one whose number is no
    /// smaller than that; else 0.
    pub detail: u8,
}

impl Reason {
    /// The detail where parts of an instance were dropped for different details of one stage.
    pub const MIXED: u8 = u8::MAX;

    /// Why its shadow cannot matter, in an answer of
    /// [`Culler::cull_shadow`](crate::Culler::cull_shadow); `None` where another stage than the
    /// frustum took it.
    #[must_use]
    pub fn caster(self) -> Option<CasterReason> {
        (self.stage == Stage::Frustum).then(|| CasterReason::from_detail(self.detail))
    }
}

/// Unit that a stage counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[repr(u8)]
pub enum Unit {
    /// Instances.
    Instances = 0,
    /// Clusters.
    Clusters = 1,
    /// Triangles.
    Triangles = 2,
}

impl Unit {
    /// The unit's name, as in `report.json`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Instances => "instances",
            Self::Clusters => "clusters",
            Self::Triangles => "triangles",
        }
    }
}

/// Numbers of instances, of their clusters and of their triangles.
///
/// Degenerate triangles are in no cluster; they count with their instance until the degenerate
/// stage or whatever drops the whole instance takes them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct Counts {
    /// Instances of which something is there.
    pub instances: u64,
    /// Their clusters, but for those that were dropped as a whole. A stage of triangles leaves
    /// them, also empty, until their instance has no triangle left.
    pub clusters: u64,
    /// Their triangles.
    pub triangles: u64,
}

impl Counts {
    /// The number of one unit.
    #[must_use]
    pub const fn of(&self, unit: Unit) -> u64 {
        match unit {
            Unit::Instances => self.instances,
            Unit::Clusters => self.clusters,
            Unit::Triangles => self.triangles,
        }
    }
}

impl Add for Counts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            instances: self.instances + other.instances,
            clusters: self.clusters + other.clusters,
            triangles: self.triangles + other.triangles,
        }
    }
}

impl Sub for Counts {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            instances: self.instances - other.instances,
            clusters: self.clusters - other.clusters,
            triangles: self.triangles - other.triangles,
        }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Counts {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl core::iter::Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Self::add)
    }
}

/// Counts of one stage at one unit: what came in and what went on, in all three units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct FunnelRow {
    /// The stage.
    pub stage: Stage,
    /// Unit that it tested: whole instances, whole clusters, or single triangles.
    pub unit: Unit,
    /// Counts in: those that the row before left, and for the first row all of the scene.
    pub entered: Counts,
    /// Counts passed on.
    pub left: Counts,
    /// Time that the stage took in nanoseconds, or [`NO_TIME`](Self::NO_TIME); see
    /// [`time`](Self::time).
    pub nanoseconds: u64,
}

impl FunnelRow {
    /// The [`nanoseconds`](Self::nanoseconds) of a row where the caller gave no clock.
    pub const NO_TIME: u64 = u64::MAX;

    /// Returns the time that the stage took in nanoseconds, if the caller gave a clock.
    #[must_use]
    pub fn time(&self) -> Option<u64> {
        (self.nanoseconds != Self::NO_TIME).then_some(self.nanoseconds)
    }

    /// Counts that the stage dropped, of each unit.
    #[must_use]
    pub fn dropped(&self) -> Counts {
        self.entered - self.left
    }
}

/// Work of the frustum stage: its tests of the scene's hierarchy. All are 0 if neither the view nor
/// the scene changed since the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrustumWork {
    /// Nodes whose children were tested, sixteen at a time.
    pub nodes: u64,
    /// Blocks of sixteen instances that were tested one by one.
    pub blocks: u64,
    /// How many times sixteen boxes were tested against a plane.
    pub plane_tests: u64,
    /// Instances that were swept without testing a node: those added since the last commit, or all
    /// of them where that is cheaper.
    pub swept: u64,
}

/// Work of the occlusion stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OcclusionWork {
    /// Shapes that were scored: those of instances that, by their size on the screen, might have a
    /// better shape than the ones that were chosen, and were not hidden when the search came to
    /// them.
    pub considered: u64,
    /// Considered shapes that were taken to be drawn.
    pub chosen: u64,
    /// Chosen shapes that were drawn. The others were hidden by then.
    pub drawn: u64,
    /// Nodes of the hierarchy, instances and clusters whose boxes were tested.
    pub tests: u64,
    /// Times of the stage of instances, where the culler has a clock.
    pub times: Option<OcclusionTimes>,
}

/// Nanoseconds of the parts of the occlusion stage of instances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OcclusionTimes {
    /// Emptying the buffer, and choosing what to draw into it.
    pub choosing: u64,
    /// Drawing it.
    pub drawing: u64,
    /// Testing what is hidden.
    pub testing: u64,
}

/// Counts in and out of each stage that ran, in the order in which they ran: what leaves a row
/// enters the next. Equal funnels took the same work and time as well: see
/// [`same_counts`](Self::same_counts).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Funnel {
    /// One row for each stage and unit.
    pub rows: Vec<FunnelRow>,
    /// Work of the frustum stage, where it ran: less where the last frame's result serves.
    pub frustum: FrustumWork,
    /// Work of the occlusion stage, where it ran.
    pub occlusion: OcclusionWork,
}

impl Funnel {
    /// Whether the same stages counted the same, whatever work and time it took them.
    #[must_use]
    pub fn same_counts(&self, other: &Self) -> bool {
        let counts = |row: &FunnelRow| (row.stage, row.unit, row.entered, row.left);
        self.rows.iter().map(counts).eq(other.rows.iter().map(counts))
    }

    /// Returns the counts of the whole scene: what entered the first stage.
    #[must_use]
    pub fn entered(&self) -> Counts {
        self.rows.first().map_or(Counts::default(), |row| row.entered)
    }

    /// The answer: what the last stage left.
    #[must_use]
    pub fn left(&self) -> Counts {
        self.rows.last().map_or(Counts::default(), |row| row.left)
    }

    /// Counts that a stage dropped, whether as instances, as clusters or triangle by triangle.
    #[must_use]
    pub fn dropped(&self, stage: Stage) -> Counts {
        self.rows.iter().filter(|row| row.stage == stage).map(FunnelRow::dropped).sum()
    }
}
