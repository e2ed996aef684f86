//! A frame of a scene, culled on the device: what is uploaded, which passes run, and what is drawn between them.

use cullet::bounds::Plane;
use cullet::{Scene, View};
use wgpu::{
    Buffer, BufferUsages, CommandEncoder, Device, Features, IndexFormat, Queue, RenderPass,
    VertexBufferLayout, VertexFormat, VertexStepMode,
};

use super::blocks::Blocks;
use super::buffers::buffer;
use super::clusters::{ArgumentPass, ClusterArguments, ClusterInstances};
use super::device::checked;
use super::error::GpuError;
use super::geometry::{Draw, GpuScene};
use super::instances::{InstanceBits, InstancePass};
use super::lanes::Lanes;
use super::lists::{DrawArguments, LaneBuffers, ListPass, ListSource, Listed, SlotList};
use super::occlusion::{OcclusionPass, VisibleBits};
use super::planes::BlockPlanes;
use super::pyramid::{Pyramid, PyramidPass};

/// Planes of a view at the most.
const MOST_PLANES: usize = 32;

/// All passes, compiled once for a device.
#[derive(Debug)]
pub struct Passes {
    /// Tests instances.
    pub instances: InstancePass,
    /// Makes lists.
    pub lists: ListPass,
    /// Makes pyramids.
    pub pyramid: PyramidPass,
    /// Tests against them.
    pub occlusion: OcclusionPass,
    /// Says of clusters whether they are drawn.
    pub arguments: ArgumentPass,
}

impl Passes {
    /// Compiles them.
    ///
    /// # Errors
    /// If the device cannot run them.
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        checked(device, || {
            let pyramid = PyramidPass::new(device);
            Self {
                instances: InstancePass::new(device),
                lists: ListPass::new(device),
                occlusion: OcclusionPass::new(device, &pyramid),
                arguments: ArgumentPass::new(device),
                pyramid,
            }
        })
    }
}

/// What is culled, and how draws are handed in; the picture is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tier {
    /// Instances; one draw after the other for each bucket of those that are alike. Every device can.
    #[default]
    Each,
    /// Instances; all draws that are alike but for their mesh in one call, for scenes of many meshes. The device must have been opened
    /// with [`Features::INDIRECT_FIRST_INSTANCE`].
    Multi,
    /// Clusters of instances, each a draw of its own, those that are alike in one call: for scenes of large meshes. As
    /// [`Multi`](Self::Multi).
    Clusters,
}

impl Tier {
    /// What suits a scene, of what a device can: clusters where there are at most 65,536 and eight or more to an instance.
    #[must_use]
    pub fn of(device: &Device, scene: &Scene) -> Self {
        if !device.features().contains(Features::INDIRECT_FIRST_INSTANCE) {
            return Self::Each;
        }
        let of = |slot| scene.mesh(slot).levels().first().map_or(0, |l| u64::from(l.cluster_count));
        let clusters: u64 = scene.slots().map(of).sum();
        let many = clusters >= 8 * u64::from(scene.instance_count());
        if many && clusters <= 1 << 16 { Self::Clusters } else { Self::Multi }
    }
}

/// What is culled, and lists or arguments of it by phase.
#[derive(Debug)]
enum Units {
    Instances {
        lanes: Lanes,
        buffers: LaneBuffers,
        lists: [SlotList; 3],
        draws: [Vec<Draw>; 3],
        tier: Tier,
    },
    Clusters {
        clusters: ClusterInstances,
        slots: Buffer,
        arguments: [ClusterArguments; 3],
    },
}

/// What of the bits of a phase is drawn.
const LISTED: [Listed; 3] = [Listed::Seen, Listed::New, Listed::All];

impl Units {
    fn instances(
        (device, queue, passes): (&Device, &Queue, &Passes),
        (scene, on_device): (&Scene, &GpuScene),
        [passed, visible, seen]: [&Buffer; 3],
        tier: Tier,
    ) -> Result<Self, GpuError> {
        let lanes = Lanes::of(scene);
        let buffers = LaneBuffers::new(device, queue, &lanes)?;
        let (blended, opaque): (Vec<_>, Vec<_>) =
            on_device.draws(&lanes).into_iter().partition(|draw| draw.blended);
        let draws = [opaque.clone(), opaque, blended];
        let list = |phase: usize, bits| {
            let first_instance = |draw: &Draw| match tier {
                Tier::Each => 0,
                _ => lanes.buckets()[draw.bucket as usize].lanes.start,
            };
            let with_first = |draw: &Draw| {
                let first_instance = first_instance(draw);
                (draw.bucket, DrawArguments { first_instance, ..draw.arguments })
            };
            let draws: Vec<_> = draws[phase].iter().map(with_first).collect();
            let source = ListSource { bits, seen, listed: LISTED[phase] };
            SlotList::new(device, queue, &passes.lists, &buffers, &draws, source)
        };
        let lists = [list(0, passed)?, list(1, visible)?, list(2, visible)?];
        Ok(Self::Instances { lanes, buffers, lists, draws, tier })
    }

    fn clusters(
        (device, queue, passes): (&Device, &Queue, &Passes),
        clusters: ClusterInstances,
        [passed, visible, seen]: [&Buffer; 3],
    ) -> Result<Self, GpuError> {
        let usage = BufferUsages::VERTEX | BufferUsages::COPY_DST;
        let slots = buffer(device, "slots of clusters", clusters.slots().len(), 4, usage)?;
        queue.write_buffer(&slots, 0, bytemuck::cast_slice(clusters.slots()));
        let of = |phase: usize, bits| {
            let source = ListSource { bits, seen, listed: LISTED[phase] };
            ClusterArguments::new(device, queue, &passes.arguments, &clusters, source)
        };
        let arguments = [of(0, passed)?, of(1, visible)?, of(2, visible)?];
        Ok(Self::Clusters { clusters, slots, arguments })
    }

    fn has_blended(&self) -> bool {
        match self {
            Self::Instances { draws, .. } => !draws[2].is_empty(),
            Self::Clusters { clusters, .. } => clusters.runs().iter().any(|run| run.0.blended),
        }
    }

    fn record(&self, passes: &Passes, encoder: &mut CommandEncoder, phase: Phase) {
        match self {
            Self::Instances { lists, .. } => passes.lists.record(encoder, &lists[phase as usize]),
            Self::Clusters { arguments, .. } => {
                passes.arguments.record(encoder, &arguments[phase as usize]);
            }
        }
    }
}

/// When something is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// What is in the view and was visible in the frame before: drawn first, so that the pyramid is made of it.
    Early,
    /// What is visible and was not.
    Late,
    /// What is blended, all of it: after the others, and hiding nothing.
    Blended,
}

/// A scene on a device, and what one view saw of it last.
///
/// A frame has five steps:
///
/// ```text
///  set ──► early ──► draw Early ──► late ──► draw Late ──► draw Blended
///          planes    depth          pyramid of that depth, boxes against it
/// ```
///
/// What was hidden in the frame before and no longer is is drawn in the late phase of the same frame, so that nothing is missing in any
/// frame, whichever way the eye jumps. All that is drawn is a superset of what owns a pixel; its order is the same each time.
#[derive(Debug)]
pub struct Culling {
    blocks: Blocks,
    planes: BlockPlanes,
    scene: GpuScene,
    passed: InstanceBits,
    visible: VisibleBits,
    /// A bit each: what was visible in the frame before.
    seen: Buffer,
    units: Units,
    scratch: Vec<Plane>,
}

impl Culling {
    /// Uploads a scene, to be drawn one draw after the other. O(triangles + slots log slots).
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows; the message says which.
    pub fn new(
        device: &Device,
        queue: &Queue,
        passes: &Passes,
        scene: &Scene,
    ) -> Result<Self, GpuError> {
        Self::with_tier(device, queue, passes, scene, Tier::default())
    }

    /// The same in another way.
    ///
    /// # Errors
    /// As [`new`](Self::new), and if the device does not have the tier.
    pub fn with_tier(
        device: &Device,
        queue: &Queue,
        passes: &Passes,
        scene: &Scene,
        tier: Tier,
    ) -> Result<Self, GpuError> {
        if tier != Tier::Each && !device.features().contains(Features::INDIRECT_FIRST_INSTANCE) {
            return Err(GpuError::Tier);
        }
        let on_device = GpuScene::new(device, queue, scene)?;
        let mut blocks = Blocks::default();
        let clusters = (tier == Tier::Clusters).then(|| ClusterInstances::of(scene, &on_device));
        match &clusters {
            None => blocks.update(scene),
            Some(all) => blocks.follow(all.len(), |number| all.bounds(scene, number)),
        }
        let passed = InstanceBits::new(device, queue, &passes.instances, &blocks, MOST_PLANES)?;
        let visible = VisibleBits::new(device, &passes.occlusion, &blocks, &passed)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let words = visible.bits().size() as usize / 4;
        let seen = buffer(device, "seen before", words, 4, usage)?;
        let bits = [passed.bits(), visible.bits(), &seen];
        let on = (device, queue, passes);
        let units = match clusters {
            None => Units::instances(on, (scene, &on_device), bits, tier)?,
            Some(clusters) => Units::clusters(on, clusters, bits)?,
        };
        Ok(Self {
            blocks,
            planes: BlockPlanes::default(),
            scene: on_device,
            passed,
            visible,
            seen,
            units,
            scratch: Vec::new(),
        })
    }

    /// Follows a scene whose instances moved, uploading what changed. Where instances came or went, or are drawn in another way,
    /// everything is uploaded again and nothing counts as seen. Meshes must be the same. O(slots) reading, or O(clusters).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn follow(
        &mut self,
        device: &Device,
        queue: &Queue,
        passes: &Passes,
        scene: &Scene,
    ) -> Result<(), GpuError> {
        let same = match &self.units {
            Units::Instances { lanes, .. } => Lanes::of(scene) == *lanes,
            Units::Clusters { clusters, .. } => {
                ClusterInstances::of(scene, &self.scene) == *clusters
            }
        };
        if same {
            match &self.units {
                Units::Instances { .. } => self.blocks.update(scene),
                Units::Clusters { clusters, .. } => {
                    self.blocks.follow(clusters.len(), |number| clusters.bounds(scene, number));
                }
            }
        }
        if !(same && self.passed.update(queue, &self.blocks) && self.scene.update(queue, scene)) {
            *self = Self::with_tier(device, queue, passes, scene, self.tier())?;
        }
        Ok(())
    }

    /// Uploads what the passes need to know of a view, drawn with so many samples a pixel. To be called once between two submissions.
    ///
    /// # Errors
    /// If the view has more planes than can be.
    pub fn set(
        &mut self,
        queue: &Queue,
        scene: &Scene,
        view: &View,
        samples: u32,
    ) -> Result<(), GpuError> {
        self.scratch.clear();
        let frustum = view.frustum().relative_to(scene.origin());
        self.scratch.extend(frustum.planes().map(|(_, plane)| *plane));
        self.planes.set(&self.blocks, &self.scratch, view.layers);
        self.passed.set(queue, &self.planes)?;
        let picture = (view.viewport(), samples);
        let on = (&self.blocks, &self.planes);
        self.visible.set(queue, on, (view, scene.origin()), picture);
        Ok(())
    }

    /// Records the early phase: what is in the view, and of that what was seen before.
    pub fn record_early(&self, passes: &Passes, encoder: &mut CommandEncoder) {
        passes.instances.record(encoder, &self.passed, &self.planes);
        self.units.record(passes, encoder, Phase::Early);
    }

    /// Records the late phase, when what is early was drawn into the depth that the pyramid is of.
    pub fn record_late(&self, passes: &Passes, encoder: &mut CommandEncoder, pyramid: &Pyramid) {
        passes.pyramid.record(encoder, pyramid);
        passes.occlusion.record(encoder, &self.visible, &self.planes, pyramid);
        self.record_rest(passes, encoder);
    }

    /// Records a frame without occlusion culling: everything in the view is late.
    pub fn record_all(&self, passes: &Passes, encoder: &mut CommandEncoder) {
        passes.instances.record(encoder, &self.passed, &self.planes);
        encoder.copy_buffer_to_buffer(self.passed.bits(), 0, self.visible.bits(), 0, None);
        self.forget(encoder);
        self.record_rest(passes, encoder);
    }

    fn record_rest(&self, passes: &Passes, encoder: &mut CommandEncoder) {
        self.units.record(passes, encoder, Phase::Late);
        if self.units.has_blended() {
            self.units.record(passes, encoder, Phase::Blended);
        }
        encoder.copy_buffer_to_buffer(self.visible.bits(), 0, &self.seen, 0, None);
    }

    /// Records that nothing was seen before. The next frame is right without it, too; after a cut it tests against what is really there.
    pub fn forget(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.seen, 0, None);
    }

    /// Draws a phase: before each draw `prepare` sets pipeline and bind groups, and says whether it is to be drawn. But with
    /// [`Tier::Each`] it is asked about the first of those that are alike, and may look at nothing that tells them apart. Vertices are as
    /// [`vertex_layouts`](Self::vertex_layouts) say.
    pub fn draw<'p>(
        &self,
        pass: &mut RenderPass<'p>,
        phase: Phase,
        mut prepare: impl FnMut(&mut RenderPass<'p>, &Draw) -> bool,
    ) {
        const SIZE: u64 = size_of::<DrawArguments>() as u64;
        pass.set_vertex_buffer(0, self.scene.vertices().slice(..));
        pass.set_index_buffer(self.scene.indices().slice(..), IndexFormat::Uint32);
        match &self.units {
            Units::Clusters { clusters, slots, arguments } => {
                pass.set_vertex_buffer(1, slots.slice(..));
                let arguments = arguments[phase as usize].arguments();
                for (draw, run) in clusters.runs() {
                    if draw.blended == (phase == Phase::Blended) && prepare(pass, draw) {
                        let (first, count) = (u64::from(run.start), run.end - run.start);
                        pass.multi_draw_indexed_indirect(arguments, first * SIZE, count);
                    }
                }
            }
            Units::Instances { lanes, lists, draws, tier, .. } => {
                let list = &lists[phase as usize];
                pass.set_vertex_buffer(1, list.list().slice(..));
                let alike = |a: &Draw, b: &Draw| *tier == Tier::Multi && a.way() == b.way();
                let mut first = 0;
                for together in draws[phase as usize].chunk_by(alike) {
                    let offset = first * SIZE;
                    first += together.len() as u64;
                    if !prepare(pass, &together[0]) {
                        continue;
                    }
                    if *tier == Tier::Multi {
                        let count = together.len() as u32;
                        pass.multi_draw_indexed_indirect(list.arguments(), offset, count);
                    } else {
                        let lanes = &lanes.buckets()[together[0].bucket as usize].lanes;
                        let bytes = u64::from(lanes.start) * 4..u64::from(lanes.end) * 4;
                        pass.set_vertex_buffer(1, list.list().slice(bytes));
                        pass.draw_indexed_indirect(list.arguments(), offset);
                    }
                }
            }
        }
    }

    /// Of vertices the position, at location 0; of instances the slot, a u32 at location 1.
    #[must_use]
    pub fn vertex_layouts() -> [VertexBufferLayout<'static>; 2] {
        let layout = |stride, step, attributes| VertexBufferLayout {
            array_stride: stride,
            step_mode: step,
            attributes,
        };
        const POSITION: [wgpu::VertexAttribute; 1] = [wgpu::VertexAttribute {
            format: VertexFormat::Float32x3,
            offset: 0,
            shader_location: 0,
        }];
        const SLOT: [wgpu::VertexAttribute; 1] =
            [wgpu::VertexAttribute { format: VertexFormat::Uint32, offset: 0, shader_location: 1 }];
        [layout(12, VertexStepMode::Vertex, &POSITION), layout(4, VertexStepMode::Instance, &SLOT)]
    }

    /// Meshes and places.
    #[must_use]
    pub fn scene(&self) -> &GpuScene {
        &self.scene
    }

    /// The arguments of a phase's draws, and how many there are.
    #[must_use]
    pub fn arguments(&self, phase: Phase) -> (&Buffer, usize) {
        match &self.units {
            Units::Instances { lists, draws, .. } => {
                (lists[phase as usize].arguments(), draws[phase as usize].len())
            }
            Units::Clusters { clusters, arguments, .. } => {
                (arguments[phase as usize].arguments(), clusters.slots().len())
            }
        }
    }

    /// The slot of each bit of [`in_view`](Self::in_view) and [`visible`](Self::visible), where these are of clusters; `None` where they are of
    /// slots.
    #[must_use]
    pub fn slots_of_clusters(&self) -> Option<&[u32]> {
        match &self.units {
            Units::Instances { .. } => None,
            Units::Clusters { clusters, .. } => Some(clusters.slots()),
        }
    }

    /// How draws are handed in.
    #[must_use]
    pub fn tier(&self) -> Tier {
        match &self.units {
            Units::Instances { tier, .. } => *tier,
            Units::Clusters { .. } => Tier::Clusters,
        }
    }

    /// A bit a slot, or a cluster: what is in the view.
    #[must_use]
    pub fn in_view(&self) -> &Buffer {
        self.passed.bits()
    }

    /// A bit a slot, or a cluster: what is visible, after the late phase.
    #[must_use]
    pub fn visible(&self) -> &Buffer {
        self.visible.bits()
    }

    /// Bytes that were uploaded when the scene was followed last.
    #[must_use]
    pub fn uploaded(&self) -> u64 {
        self.passed.uploaded() + self.scene.uploaded()
    }

    /// Bytes that the passes take on the device, besides the scene's triangles and places.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let of_units = match &self.units {
            Units::Instances { buffers, lists, .. } => {
                buffers.bytes() + lists.iter().map(SlotList::bytes).sum::<u64>()
            }
            Units::Clusters { arguments, slots, .. } => {
                slots.size() + arguments.iter().map(|a| a.arguments().size()).sum::<u64>()
            }
        };
        self.passed.bytes() + of_units + 2 * self.seen.size()
    }
}
