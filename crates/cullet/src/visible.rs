//! What a culler returns: what to draw, why the rest went, and how many each stage took.

/// One kind of culling in the pipeline, in the order in which they run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Stage {
    /// Layers that view and instance do not share.
    Layer = 1,
    /// Outside the view's frustum.
    Frustum = 2,
    /// Not seen through any portal.
    Portal = 3,
    /// Too small on the screen.
    Detail = 4,
    /// Another level of detail stands for it.
    Lod = 5,
    /// Behind something.
    Occlusion = 6,
    /// Seen from behind (or from the front, where front faces are culled).
    Backface = 7,
    /// Without area.
    Degenerate = 8,
}

impl Stage {
    /// All stages, in their order.
    pub const ALL: [Self; 8] = [
        Self::Layer,
        Self::Frustum,
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
            Self::Portal => "portal",
            Self::Detail => "detail",
            Self::Lod => "lod",
            Self::Occlusion => "occlusion",
            Self::Backface => "backface",
            Self::Degenerate => "degenerate",
        }
    }
}

/// Why a thing was dropped: the stage, and a detail that is the stage's own (frustum: the number of
/// the plane). Two bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reason {
    /// The stage that dropped it.
    pub stage: Stage,
    /// For the frustum, the number of the first plane it is outside of, or [`Reason::MIXED`]; else 0.
    pub detail: u8,
}

impl Reason {
    /// The detail where the parts of a thing went for different details of one stage.
    pub const MIXED: u8 = u8::MAX;
}

/// What a stage counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Unit {
    /// Instances.
    Instances,
    /// Clusters.
    Clusters,
    /// Triangles.
    Triangles,
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

/// Counts of one stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FunnelRow {
    /// Which stage.
    pub stage: Stage,
    /// What it counts.
    pub unit: Unit,
    /// How many came in.
    pub entered: u64,
    /// How many went on.
    pub left: u64,
    /// How long it took, where the caller gave a clock.
    pub nanoseconds: Option<u64>,
}

/// How the frustum stage found the instances: what it asked of the scene's hierarchy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrustumWork {
    /// Nodes that asked their children, sixteen at a time.
    pub nodes: u64,
    /// Blocks of sixteen instances that were tested one by one.
    pub blocks: u64,
    /// How many times sixteen things were tested against a plane.
    pub plane_tests: u64,
    /// Groups of 256 instances that were not asked at all, for the view has not moved enough since they were.
    pub remembered: u64,
    /// Instances that were swept without asking a node: those added since the last commit, or all of them
    /// where that is cheaper.
    pub swept: u64,
}

/// What the occlusion stage did to get its answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OcclusionWork {
    /// Shapes that were weighed: those that by the size of their nodes and instances on the screen might be
    /// worth more than what the budget was spent on; all in the view, where it pays for all.
    pub offered: u64,
    /// Those of them that the budget allowed.
    pub chosen: u64,
    /// Those of them that were drawn: the others were hidden by then.
    pub drawn: u64,
    /// Nodes of the hierarchy, instances and clusters whose boxes were tested.
    pub tests: u64,
    /// What became of the time of the stage of instances, where the culler has a clock.
    pub times: Option<OcclusionTimes>,
}

/// Nanoseconds of the parts of the occlusion stage of instances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OcclusionTimes {
    /// Emptying the buffer, and choosing what to draw into it.
    pub choosing: u64,
    /// Drawing it.
    pub drawing: u64,
    /// Asking what is hidden.
    pub asking: u64,
}

/// Counts in and out of each stage that ran, in order. Two funnels are equal if their counts are, whatever
/// work it took to get them.
#[derive(Clone, Debug, Default)]
pub struct Funnel {
    /// One row a stage and unit.
    pub rows: Vec<FunnelRow>,
    /// What the frustum stage did to get its answer, where it ran: less where the last frame's answer serves.
    pub frustum: FrustumWork,
    /// What the occlusion stage did, where it ran.
    pub occlusion: OcclusionWork,
}

impl PartialEq for Funnel {
    fn eq(&self, other: &Self) -> bool {
        self.rows == other.rows
    }
}

/// A range of slots whose instances are drawn whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SlotRange {
    /// First slot.
    pub first: u32,
    /// How many slots; all of them hold instances that are visible.
    pub count: u32,
}

/// Some clusters of one instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DrawRange {
    /// The instance's slot.
    pub slot: u32,
    /// The level of detail its clusters belong to.
    pub level: u32,
    /// First cluster of the mesh.
    pub first_cluster: u32,
    /// How many clusters.
    pub cluster_count: u32,
}

/// Some triangles of one instance, as a range of [`Visible::triangles`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct TriangleRange {
    /// The instance's slot.
    pub slot: u32,
    /// First entry.
    pub first: u32,
    /// How many entries.
    pub count: u32,
}

/// What one view sees: a superset of what is truly visible. Ascending by slot; reused from frame to
/// frame without allocation once it has grown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Visible {
    /// Slots whose instances are drawn whole.
    pub whole: Vec<SlotRange>,
    /// Clusters of instances that are drawn in part, ascending by slot and cluster; no slot is both
    /// here and in `whole`.
    pub partial: Vec<DrawRange>,
    /// Where triangles were asked for: the triangles of every visible instance, whole ones too.
    pub triangle_ranges: Vec<TriangleRange>,
    /// Triangle numbers in the order of the instance's mesh, for `triangle_ranges`.
    pub triangles: Vec<u32>,
    /// Where reasons were asked for: one a slot; `None` is visible (or an empty slot).
    pub reasons: Vec<Option<Reason>>,
    /// Counts of each stage.
    pub funnel: Funnel,
    /// Triangles that will be drawn.
    pub triangle_count: u64,
    /// Instances of which something will be drawn.
    pub instance_count: u64,
}

impl Visible {
    /// The slots of which something is drawn, ascending.
    pub fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        let mut whole = self.whole.iter().flat_map(|r| r.first..r.first + r.count).peekable();
        let partial = self.partial.chunk_by(|a, b| a.slot == b.slot);
        let mut partial = partial.map(|ranges| ranges[0].slot).peekable();
        // No slot is in both.
        std::iter::from_fn(move || match (whole.peek(), partial.peek()) {
            (Some(a), Some(b)) if b < a => partial.next(),
            (Some(_), _) => whole.next(),
            (None, _) => partial.next(),
        })
    }

    /// Lists the slots of which something is drawn now and was not in `earlier`, and those that went, both
    /// ascending. Both results must be of one order of the scene's slots (see
    /// [`Scene::order_version`](crate::Scene::order_version)). The lists are cleared first. The cost is that
    /// of what is visible.
    pub fn changes_since(&self, earlier: &Self, added: &mut Vec<u32>, removed: &mut Vec<u32>) {
        added.clear();
        removed.clear();
        let (mut now, mut then) = (self.slots().peekable(), earlier.slots().peekable());
        loop {
            match (now.peek(), then.peek()) {
                (Some(a), Some(b)) if a == b => {
                    now.next();
                    then.next();
                }
                (Some(a), Some(b)) if a > b => removed.extend(then.next()),
                (Some(_), _) => added.extend(now.next()),
                (None, Some(_)) => removed.extend(then.next()),
                (None, None) => return,
            }
        }
    }
}
