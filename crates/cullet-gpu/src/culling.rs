//! A frame of a scene, culled on the device: what is uploaded, which passes run, and what is drawn
//! between them.

use cullet::bounds::Plane;
use cullet::{Scene, View, Visible};
use wgpu::{
    Buffer, BufferUsages, CommandEncoder, Device, IndexFormat, Queue, RenderPass,
    VertexBufferLayout, VertexFormat, VertexStepMode,
};

use super::blocks::Blocks;
use super::buffers::buffer;
use super::checked::checked;
use super::clusters::ClusterInstances;
use super::cones::{ConeBuffers, Cones};
use super::error::GpuError;
use super::geometry::{Draw, GpuScene};
use super::instances::InstanceBits;
use super::levels::{LevelBuffers, LevelChoice};
use super::occlusion::VisibleBits;
use super::passes::Passes;
use super::planes::BlockPlanes;
use super::pyramid::Pyramid;
use super::reference::visible_ref;
use super::sizes::{ROWS, SizeRule};
use super::units::{DrawMode, Phase, Units};

/// Planes of a view at the most.
const MOST_PLANES: usize = 32;

/// Stages that run besides those that always do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Whether clusters are dropped that face away with all of their triangles, where the view
    /// culls such faces. They would show nothing. Default on; only [`DrawMode::Clusters`] has them.
    pub backfaces: bool,
    /// Instances, or clusters of them, are dropped whose box is narrower and lower than so many
    /// pixels in the picture, from 0, at which none is. Lossy: what is dropped may show that much.
    /// Default 0. Clusters are dropped by themselves with [`DrawMode::Clusters`], which leaves
    /// holes in what is made of clusters as small, as with
    /// [`Detail::clusters`](cullet::cull::detail::Detail).
    pub small_px: f32,
    /// Largest error in pixels of a surface that is drawn by a [level of
    /// detail](Scene::add_levels), at the centre of the picture, as with
    /// [`Lod::pixels`](cullet::lod::Lod); from 0, at which everything is drawn in full. Lossy.
    /// Default 0; only [`DrawMode::Clusters`] has levels.
    pub level_px: f32,
}

impl Default for Settings {
    /// All that changes no picture.
    fn default() -> Self {
        Self { backfaces: true, small_px: 0.0, level_px: 0.0 }
    }
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
/// What was hidden in the frame before and no longer is is drawn in the late phase of the same
/// frame, so that nothing is missing in any frame, whichever way the eye jumps. All that is drawn
/// is a superset of what owns a pixel; its order is the same each time.
#[derive(Debug)]
pub struct Culling {
    blocks: Blocks,
    planes: BlockPlanes,
    /// To be changed at will: it counts from the next view that is [set](Self::set) on.
    pub settings: Settings,
    scene: GpuScene,
    passed: InstanceBits,
    cones: Option<ConeBuffers>,
    levels: Option<LevelBuffers>,
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
    /// If a buffer would be larger than the device allows, the message says which; if the device
    /// has no memory left, or is lost.
    pub fn new(
        device: &Device,
        queue: &Queue,
        passes: &Passes,
        scene: &Scene,
    ) -> Result<Self, GpuError> {
        Self::with_mode(device, queue, passes, scene, DrawMode::default())
    }

    /// The same in another way.
    ///
    /// # Errors
    /// As [`new`](Self::new), and if the device does not have the mode.
    pub fn with_mode(
        device: &Device,
        queue: &Queue,
        passes: &Passes,
        scene: &Scene,
        mode: DrawMode,
    ) -> Result<Self, GpuError> {
        mode.tier().demand(device)?;
        checked(device, || Self::upload((device, queue, passes), scene, mode))?
    }

    fn upload(
        (device, queue, passes): (&Device, &Queue, &Passes),
        scene: &Scene,
        mode: DrawMode,
    ) -> Result<Self, GpuError> {
        let on_device = GpuScene::new(device, queue, scene)?;
        let mut blocks = Blocks::default();
        let is_of_clusters = matches!(mode, DrawMode::Clusters | DrawMode::Counted);
        let clusters = is_of_clusters.then(|| ClusterInstances::of(scene, &on_device));
        match &clusters {
            None => blocks.update(scene),
            Some(all) => blocks.follow(all.len(), |number| all.bounds(scene, number)),
        }
        let most = MOST_PLANES + ROWS;
        let passed = InstanceBits::new(device, queue, &passes.instances, &blocks, most)?;
        let upload = |own| ConeBuffers::new(device, queue, &passes.cones, own);
        let cones = clusters.as_ref().map(|all| upload(Cones::new(scene, all))).transpose()?;
        let upload = |own| LevelBuffers::new(device, queue, &passes.levels, own, &passed);
        let levels = clusters.as_ref().and_then(|all| LevelChoice::new(scene, all));
        let levels = levels.map(upload).transpose()?;
        let visible = VisibleBits::new(device, &passes.occlusion, &blocks, &passed)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let words = visible.bits().size() as usize / 4;
        let seen = buffer(device, "seen before", words, 4, usage)?;
        let bits = [passed.bits(), visible.bits(), &seen];
        let on = (device, queue, passes);
        let units = match clusters {
            None => Units::instances(on, (scene, &on_device), bits, mode)?,
            Some(clusters) => Units::clusters(on, clusters, bits, mode)?,
        };
        Ok(Self {
            blocks,
            planes: BlockPlanes::default(),
            settings: Settings::default(),
            scene: on_device,
            passed,
            cones,
            levels,
            visible,
            seen,
            units,
            scratch: Vec::new(),
        })
    }

    /// Follows a scene whose instances moved, uploading what changed. Where instances came or went,
    /// or are drawn in another way, everything is uploaded again, nothing counts as seen, and the
    /// answer is true: buffers are others, and what binds them has to be made again. Meshes must be
    /// the same. O(slots) reading, or O(clusters).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn follow(
        &mut self,
        device: &Device,
        queue: &Queue,
        passes: &Passes,
        scene: &Scene,
    ) -> Result<bool, GpuError> {
        let same = match &self.units {
            Units::Instances { lanes, .. } => lanes.are_of(scene),
            Units::Clusters { clusters, .. } => clusters.are_of(scene),
        };
        if same {
            match &self.units {
                Units::Instances { .. } => self.blocks.update(scene),
                Units::Clusters { clusters, .. } => {
                    self.blocks.follow(clusters.len(), |number| clusters.bounds(scene, number));
                }
            }
        }
        let same =
            same && self.passed.update(queue, &self.blocks) && self.scene.update(queue, scene);
        if !same {
            let settings = self.settings;
            *self = Self::with_mode(device, queue, passes, scene, self.mode())?;
            self.settings = settings;
        }
        Ok(!same)
    }

    /// Uploads what the passes need to know of a view, drawn with so many samples a pixel. Where
    /// views are moved by parts of a pixel from frame to frame, it is the moved one that is drawn.
    /// To be called once between two submissions.
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
        let sizes = SizeRule::new(view, scene.origin(), self.settings.small_px);
        self.planes.set_with(&self.blocks, &self.scratch, view.layers, sizes.as_ref());
        self.passed.set(queue, &self.planes)?;
        match &mut self.cones {
            Some(cones) if self.settings.backfaces => {
                cones.set(queue, scene, view, &self.planes);
            }
            Some(cones) => cones.clear(),
            None => {}
        }
        if let Some(levels) = &mut self.levels {
            levels.set(queue, (scene, view), self.settings.level_px, &self.planes);
        }
        let picture = (view.viewport(), samples);
        let on = (&self.blocks, &self.planes);
        self.visible.set(queue, on, (view, scene.origin()), picture);
        Ok(())
    }

    /// Records the early phase: what is in the view, and of that what was seen before.
    pub fn record_early(&self, passes: &Passes, encoder: &mut CommandEncoder) {
        self.record_exact(passes, encoder);
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
        self.record_exact(passes, encoder);
        encoder.copy_buffer_to_buffer(self.passed.bits(), 0, self.visible.bits(), 0, None);
        self.forget(encoder);
        self.record_rest(passes, encoder);
    }

    /// Takes what the CPU decided in place of the passes: what a [`Culler`](cullet::Culler) listed
    /// of this scene for this view, whole instances and clusters of them. To be called once between
    /// two submissions.
    ///
    /// # Panics
    /// If it names a slot that the scene has not.
    pub fn decide(&self, queue: &Queue, scene: &Scene, visible: &Visible) {
        let bits = self.units.bits_of(scene, visible, self.visible.bits().size() as usize / 4);
        queue.write_buffer(self.visible.bits(), 0, bytemuck::cast_slice(&bits));
    }

    /// Records a frame of what was [decided](Self::decide): everything is late.
    pub fn record_decided(&self, passes: &Passes, encoder: &mut CommandEncoder) {
        self.forget(encoder);
        self.record_rest(passes, encoder);
    }

    /// Records what is in the view, by the stages that are the same on every device.
    fn record_exact(&self, passes: &Passes, encoder: &mut CommandEncoder) {
        let with_cones = |cones| passes.cones.record(encoder, &self.passed, cones, &self.planes);
        if !self.cones.as_ref().is_some_and(with_cones) {
            passes.instances.record(encoder, &self.passed, &self.planes);
        }
        if let Some(levels) = &self.levels {
            passes.levels.record(encoder, levels, &self.planes);
        }
    }

    fn record_rest(&self, passes: &Passes, encoder: &mut CommandEncoder) {
        self.units.record(passes, encoder, Phase::Late);
        if self.units.has_blended() {
            self.units.record(passes, encoder, Phase::Blended);
        }
        encoder.copy_buffer_to_buffer(self.visible.bits(), 0, &self.seen, 0, None);
    }

    /// Records that nothing was seen before. The next frame is right without it, too; after a cut
    /// it tests against what is really there.
    pub fn forget(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.seen, 0, None);
    }

    /// Draws a phase: before each draw `prepare` sets pipeline and bind groups, and says whether it
    /// is to be drawn. But with [`DrawMode::Each`] it is asked about the first of those that are
    /// alike, and may look at nothing that tells them apart. Vertices are as
    /// [`vertex_layouts`](Self::vertex_layouts) say.
    pub fn draw<'p>(
        &self,
        pass: &mut RenderPass<'p>,
        phase: Phase,
        mut prepare: impl FnMut(&mut RenderPass<'p>, &Draw) -> bool,
    ) {
        pass.set_vertex_buffer(0, self.scene.vertices().slice(..));
        pass.set_index_buffer(self.scene.indices().slice(..), IndexFormat::Uint32);
        self.units.draw(pass, phase, &mut prepare);
    }

    /// Returns the layouts of the vertex position, at location 0, and of the instance's slot, a u32
    /// at location 1.
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

    /// Returns what the stages before occlusion leave of the view that was set last, ascending: the
    /// bits that are set [in view](Self::in_view), by the CPU. Slow and obvious.
    #[must_use]
    pub fn in_view_ref(&self) -> Vec<u32> {
        let mut list = visible_ref(&self.blocks, &self.planes);
        if let Some(cones) = &self.cones {
            list = cones.cones().keep_ref(&list);
        }
        if let Some(levels) = &self.levels {
            list = levels.choice().keep_ref(&list);
        }
        list
    }

    /// The clusters that the bits are of; `None` where they are of slots.
    #[must_use]
    pub fn clusters(&self) -> Option<&ClusterInstances> {
        match &self.units {
            Units::Instances { .. } => None,
            Units::Clusters { clusters, .. } => Some(clusters),
        }
    }

    /// Meshes and places.
    #[must_use]
    pub fn scene(&self) -> &GpuScene {
        &self.scene
    }

    /// The arguments of a phase's draws, and how many there are; of [`DrawMode::Counted`] one for
    /// each call, whose number of instances is how many draws it makes.
    #[must_use]
    pub fn arguments(&self, phase: Phase) -> (&Buffer, usize) {
        self.units.arguments(phase)
    }

    /// The slot of each bit of [`in_view`](Self::in_view) and [`visible`](Self::visible), where
    /// these are of clusters; `None` where they are of slots.
    #[must_use]
    pub fn slots_of_clusters(&self) -> Option<&[u32]> {
        match &self.units {
            Units::Instances { .. } => None,
            Units::Clusters { clusters, .. } => Some(clusters.slots()),
        }
    }

    /// How draws are handed in.
    #[must_use]
    pub fn mode(&self) -> DrawMode {
        match &self.units {
            Units::Instances { mode, .. } | Units::Clusters { mode, .. } => *mode,
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
        let cones = self.cones.as_ref().map_or(0, ConeBuffers::bytes);
        let levels = self.levels.as_ref().map_or(0, LevelBuffers::bytes);
        cones + levels + self.passed.bytes() + self.units.bytes() + 2 * self.seen.size()
    }
}
