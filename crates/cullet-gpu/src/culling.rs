//! A frame of a scene, culled on the device: what is uploaded, which passes run, and what is drawn between them.

use cullet::bounds::Plane;
use cullet::{Scene, View};
use wgpu::{
    Buffer, BufferUsages, CommandEncoder, Device, Features, IndexFormat, Queue, RenderPass,
    VertexBufferLayout, VertexFormat, VertexStepMode,
};

use super::blocks::Blocks;
use super::buffers::buffer;
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
                pyramid,
            }
        })
    }
}

/// How draws are handed in; the picture is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tier {
    /// One by one. Every device can.
    #[default]
    Each,
    /// All that are alike but for their mesh in one call, for scenes of many meshes. The device must have been opened with
    /// [`Features::INDIRECT_FIRST_INSTANCE`].
    Multi,
}

impl Tier {
    /// The most that a device can.
    #[must_use]
    pub fn of(device: &Device) -> Self {
        let can = device.features().contains(Features::INDIRECT_FIRST_INSTANCE);
        if can { Self::Multi } else { Self::Each }
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
    lanes: Lanes,
    scene: GpuScene,
    passed: InstanceBits,
    visible: VisibleBits,
    /// A bit a slot: what was visible in the frame before.
    seen: Buffer,
    lane_buffers: LaneBuffers,
    tier: Tier,
    /// By phase.
    lists: [SlotList; 3],
    draws: [Vec<Draw>; 3],
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

    /// The same, its draws handed in as told.
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
        if tier != Tier::Each && Tier::of(device) == Tier::Each {
            return Err(GpuError::Tier);
        }
        let blocks = Blocks::new(scene);
        let lanes = Lanes::of(scene);
        let on_device = GpuScene::new(device, queue, scene)?;
        let passed = InstanceBits::new(device, queue, &passes.instances, &blocks, MOST_PLANES)?;
        let visible = VisibleBits::new(device, &passes.occlusion, &blocks, &passed)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let words = visible.bits().size() as usize / 4;
        let seen = buffer(device, "slots seen before", words, 4, usage)?;
        let lane_buffers = LaneBuffers::new(device, queue, &lanes)?;
        let (blended, opaque): (Vec<_>, Vec<_>) =
            on_device.draws(&lanes).into_iter().partition(|draw| draw.blended);
        let list = |draws: &[Draw], bits: &Buffer, listed| {
            let first = |draw: &Draw| match tier {
                Tier::Each => 0,
                Tier::Multi => lanes.buckets()[draw.bucket as usize].lanes.start,
            };
            let with_first = |draw: &Draw| {
                let arguments = DrawArguments { first_instance: first(draw), ..draw.arguments };
                (draw.bucket, arguments)
            };
            let draws: Vec<(u32, DrawArguments)> = draws.iter().map(with_first).collect();
            let source = ListSource { bits, seen: &seen, listed };
            SlotList::new(device, queue, &passes.lists, &lane_buffers, &draws, source)
        };
        let lists = [
            list(&opaque, passed.bits(), Listed::Seen)?,
            list(&opaque, visible.bits(), Listed::New)?,
            list(&blended, visible.bits(), Listed::All)?,
        ];
        Ok(Self {
            blocks,
            planes: BlockPlanes::default(),
            lanes,
            scene: on_device,
            passed,
            visible,
            seen,
            lane_buffers,
            tier,
            lists,
            draws: [opaque.clone(), opaque, blended],
            scratch: Vec::new(),
        })
    }

    /// Follows a scene whose instances moved, uploading what changed. Where instances came or went, or are drawn in another way,
    /// everything is uploaded again and nothing counts as seen. Meshes must be the same. O(slots) reading.
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
        self.blocks.update(scene);
        let same = self.passed.update(queue, &self.blocks)
            && self.scene.update(queue, scene)
            && Lanes::of(scene) == self.lanes;
        if !same {
            *self = Self::with_tier(device, queue, passes, scene, self.tier)?;
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
        passes.lists.record(encoder, &self.lists[Phase::Early as usize]);
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
        passes.lists.record(encoder, &self.lists[Phase::Late as usize]);
        if !self.draws[Phase::Blended as usize].is_empty() {
            passes.lists.record(encoder, &self.lists[Phase::Blended as usize]);
        }
        encoder.copy_buffer_to_buffer(self.visible.bits(), 0, &self.seen, 0, None);
    }

    /// Records that nothing was seen before. The next frame is right without it, too; after a cut it tests against what is really there.
    pub fn forget(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.seen, 0, None);
    }

    /// Draws a phase: before each draw `prepare` sets pipeline and bind groups, and says whether it is to be drawn. With
    /// [`Tier::Multi`] it is asked about the first of those that are alike, and may look at nothing that tells them apart. Vertices are as
    /// [`vertex_layouts`](Self::vertex_layouts) say.
    pub fn draw<'p>(
        &self,
        pass: &mut RenderPass<'p>,
        phase: Phase,
        mut prepare: impl FnMut(&mut RenderPass<'p>, &Draw) -> bool,
    ) {
        let list = &self.lists[phase as usize];
        let draws = &self.draws[phase as usize];
        pass.set_vertex_buffer(0, self.scene.vertices().slice(..));
        pass.set_vertex_buffer(1, list.list().slice(..));
        pass.set_index_buffer(self.scene.indices().slice(..), IndexFormat::Uint32);
        let alike = |a: &Draw, b: &Draw| self.tier == Tier::Multi && a.way() == b.way();
        let mut first = 0;
        for together in draws.chunk_by(alike) {
            let offset = first * size_of::<DrawArguments>() as u64;
            first += together.len() as u64;
            if !prepare(pass, &together[0]) {
                continue;
            }
            if self.tier == Tier::Multi {
                let count = together.len() as u32;
                pass.multi_draw_indexed_indirect(list.arguments(), offset, count);
            } else {
                let lanes = &self.lanes.buckets()[together[0].bucket as usize].lanes;
                let bytes = u64::from(lanes.start) * 4..u64::from(lanes.end) * 4;
                pass.set_vertex_buffer(1, list.list().slice(bytes));
                pass.draw_indexed_indirect(list.arguments(), offset);
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

    /// What is drawn in a phase.
    #[must_use]
    pub fn draws(&self, phase: Phase) -> &[Draw] {
        &self.draws[phase as usize]
    }

    /// The list of a phase.
    #[must_use]
    pub fn list(&self, phase: Phase) -> &SlotList {
        &self.lists[phase as usize]
    }

    /// Slots in the order of the lists.
    #[must_use]
    pub fn lanes(&self) -> &Lanes {
        &self.lanes
    }

    /// How draws are handed in.
    #[must_use]
    pub fn tier(&self) -> Tier {
        self.tier
    }

    /// A bit a slot: what is in the view.
    #[must_use]
    pub fn in_view(&self) -> &Buffer {
        self.passed.bits()
    }

    /// A bit a slot: what is visible, after the late phase.
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
        let lists: u64 = self.lists.iter().map(SlotList::bytes).sum();
        self.passed.bytes() + self.lane_buffers.bytes() + lists + 2 * self.seen.size()
    }
}
