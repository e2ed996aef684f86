//! Decision of what is drawn of the scene, made on the graphics device: two phases of culling by
//! compute passes, and draws whose numbers of instances these write.
//!
//! ```text
//!  in the view? ──► seen before ──► depth alone ──► pyramid ──► boxes against it ──► list ──► panes
//! ```
//!
//! The early phase draws depth alone, into a texture of its own. So panes may lie anywhere and be
//! painted in any way, and draw what is visible in one order, whatever was seen before: their
//! pixels are those of what the CPU decides.

mod depth;
mod figures;
mod picture;

use std::ops::Range;

use cullet::Scene;
use cullet::bounds::Plane;
use cullet_gpu::{
    BlockPlanes, Blocks, DrawArguments, GpuError, InstanceBits, LaneBuffers, Lanes, ListSource,
    Listed, Passes, SlotList, Tier, VisibleBits,
};
use eframe::wgpu::*;

use super::error::DrawError;
use super::frame::{DeviceFigures, DeviceView, Pane};
use super::groups::Kind;
use super::pane::culled;
use super::pipelines::Pipelines;
use super::textures::Target;
use super::upload::Uploaded;
use depth::{Depth, DepthPipelines};
use figures::Measuring;
use picture::{Picture, Shown};

/// Planes of a view at the most.
const MOST_PLANES: usize = 32;

/// Bytes of the arguments of a draw.
const ARGUMENTS: u64 = size_of::<DrawArguments>() as u64;

/// One draw: some triangles of all instances of a kind that are listed.
#[derive(Debug)]
pub(super) struct ListedDraw {
    pub(super) kind: Kind,
    pub(super) chunk: u32,
    pub(super) two_sided: bool,
    pub(super) blended: bool,
    /// Where in the list its slots stand, in bytes.
    slots: Range<u64>,
    /// Where its arguments stand, in bytes.
    arguments: u64,
}

/// The instances of a scene on the device, and what one view saw of them last.
#[derive(Debug)]
pub(super) struct DeviceCulling {
    passes: Passes,
    origin: [f64; 3],
    blocks: Blocks,
    planes: BlockPlanes,
    passed: InstanceBits,
    visible: VisibleBits,
    /// A bit a slot: what was visible in the frame before.
    seen: Buffer,
    early: SlotList,
    listed: SlotList,
    /// In the order in which what the CPU decides is drawn.
    draws: Vec<ListedDraw>,
    pipelines: DepthPipelines,
    depth: Option<Depth>,
    picture: Picture,
    measuring: Measuring,
    /// Nothing was seen before.
    is_cold: bool,
    scratch: Vec<Plane>,
}

impl DeviceCulling {
    /// Why a device cannot decide, if it cannot.
    pub(super) fn refused(adapter: &Adapter) -> Option<String> {
        Tier::Pyramid.lack(adapter).map(|lack| lack.to_string())
    }

    /// Uploads boxes and lists of the scene that was uploaded. O(slots log slots).
    pub(super) fn new(
        device: &Device,
        queue: &Queue,
        pipelines: &Pipelines,
        (scene, uploaded): (&Scene, &Uploaded),
    ) -> Result<Self, DrawError> {
        Self::made(device, queue, pipelines, (scene, uploaded))
            .map_err(|error| DrawError::Device(error.to_string()))
    }

    fn made(
        device: &Device,
        queue: &Queue,
        pipelines: &Pipelines,
        (scene, uploaded): (&Scene, &Uploaded),
    ) -> Result<Self, GpuError> {
        let passes = Passes::new(device)?;
        let blocks = Blocks::new(scene);
        let passed = InstanceBits::new(device, queue, &passes.instances, &blocks, MOST_PLANES)?;
        let visible = VisibleBits::new(device, &passes.occlusion, &blocks, &passed)?;
        // As large as the bits that were made just now.
        let seen = device.create_buffer(&BufferDescriptor {
            label: Some("seen before"),
            size: visible.bits().size(),
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let lanes = Lanes::of(scene);
        let (draws, arguments) = draws(&lanes, uploaded);
        let buffers = LaneBuffers::new(device, queue, &lanes)?;
        let list = |bits, listed| {
            let source = ListSource { bits, seen: &seen, listed };
            SlotList::new(device, queue, &passes.lists, &buffers, &arguments, source)
        };
        let early = list(passed.bits(), Listed::Seen)?;
        let listed = list(visible.bits(), Listed::All)?;
        let measured = [passed.bits(), visible.bits(), early.arguments(), listed.arguments()]
            .map(Buffer::size);
        Ok(Self {
            origin: scene.origin(),
            planes: BlockPlanes::default(),
            pipelines: DepthPipelines::new(device, pipelines),
            depth: None,
            picture: Picture::new(device),
            measuring: Measuring::new(device, measured, arguments.len()),
            is_cold: true,
            scratch: Vec::new(),
            passes,
            blocks,
            passed,
            visible,
            seen,
            early,
            listed,
            draws,
        })
    }

    /// Uploads what the passes need to know of a view in a scene of some radius, for panes of so
    /// many samples a pixel; false where the device cannot decide for it. Once between two
    /// submissions.
    pub(super) fn set(
        &mut self,
        device: &Device,
        queue: &Queue,
        by: &DeviceView<'_>,
        (radius, samples): (f32, u32),
    ) -> bool {
        let (view, size) = (by.view, by.view.viewport());
        let limit = device.limits().max_texture_dimension_2d;
        if view.depth() != cullet::Depth::Reversed || size.iter().any(|side| *side > limit) {
            return false;
        }
        self.scratch.clear();
        if by.frustum {
            let frustum = view.frustum().relative_to(self.origin);
            self.scratch.extend(frustum.planes().map(|(_, plane)| *plane));
        }
        self.planes.set(&self.blocks, &self.scratch, view.layers);
        if self.passed.set(queue, &self.planes).is_err() {
            return false;
        }
        let on = (&self.blocks, &self.planes);
        self.visible.set(queue, on, (view, self.origin), (size, samples));
        if self.depth.as_ref().is_none_or(|d| !d.fits(size, samples)) {
            let Ok(made) = Depth::new(device, &self.passes.pyramid, size, samples) else {
                return false;
            };
            self.picture.follow(device, &made.pyramid);
            self.depth = Some(made);
        }
        if let Some((place, level)) = by.pyramid {
            self.picture.set(queue, &Shown::new(view, (place, level), radius));
        }
        true
    }

    /// Records how it is decided. `group` is that of panes, and `offset` where in its numbers those
    /// of the view stand.
    pub(super) fn record(
        &mut self,
        queue: &Queue,
        encoder: &mut CommandEncoder,
        (group, offset): (&BindGroup, u32),
        scene: &Uploaded,
        by: &DeviceView<'_>,
    ) {
        let measured = self.measuring.start(queue);
        // At first nothing was seen before, and all of the view is: the second round finds what it
        // hides.
        let rounds = if std::mem::take(&mut self.is_cold) && by.occlusion { 2 } else { 1 };
        for round in 1..=rounds {
            let measuring = (measured && round == rounds).then_some(&self.measuring);
            self.round(encoder, (group, offset), scene, by, measuring);
        }
        if measured {
            let [in_view, visible] = [self.passed.bits(), self.visible.bits()];
            let all = [in_view, visible, self.early.arguments(), self.listed.arguments()];
            self.measuring.resolve(encoder, all);
        }
    }

    fn round(
        &self,
        encoder: &mut CommandEncoder,
        panes: (&BindGroup, u32),
        scene: &Uploaded,
        by: &DeviceView<'_>,
        measuring: Option<&Measuring>,
    ) {
        let mark = |encoder: &mut CommandEncoder, number| {
            if let Some(measuring) = measuring {
                measuring.mark(encoder, number);
            }
        };
        let Some(depth) = &self.depth else { return };
        let (passed, visible) = (self.passed.bits(), self.visible.bits());
        mark(encoder, 0);
        self.passes.instances.record(encoder, &self.passed, &self.planes);
        if by.occlusion {
            self.passes.lists.record(encoder, &self.early);
        }
        mark(encoder, 1);
        if by.occlusion {
            self.draw_depth(encoder, panes, scene, (by, depth));
        }
        mark(encoder, 2);
        if by.occlusion {
            self.passes.pyramid.record(encoder, &depth.pyramid);
        }
        mark(encoder, 3);
        if by.occlusion {
            self.passes.occlusion.record(encoder, &self.visible, &self.planes, &depth.pyramid);
        } else {
            encoder.copy_buffer_to_buffer(passed, 0, visible, 0, None);
        }
        self.passes.lists.record(encoder, &self.listed);
        encoder.copy_buffer_to_buffer(visible, 0, &self.seen, 0, None);
        mark(encoder, 4);
    }

    /// Draws the depth of what was seen before, as far as it hides anything.
    fn draw_depth(
        &self,
        encoder: &mut CommandEncoder,
        (group, offset): (&BindGroup, u32),
        scene: &Uploaded,
        (by, depth): (&DeviceView<'_>, &Depth),
    ) {
        let mut pass = depth.begin(encoder);
        pass.set_bind_group(0, group, &[offset]);
        let pane = Pane::of_device(by);
        let mut bound_chunk = None;
        for draw in self.draws.iter().filter(|draw| !draw.blended) {
            let Some(faces) = culled(&pane, &draw.kind, draw.two_sided) else { continue };
            if bound_chunk != Some(draw.chunk) {
                let chunk = &scene.chunks[draw.chunk as usize];
                pass.set_vertex_buffer(0, chunk.vertices.slice(..));
                pass.set_index_buffer(chunk.indices.slice(..), IndexFormat::Uint32);
                bound_chunk = Some(draw.chunk);
            }
            pass.set_pipeline(self.pipelines.get(faces, depth.samples));
            pass.set_vertex_buffer(1, self.early.list().slice(draw.slots.clone()));
            pass.draw_indexed_indirect(self.early.arguments(), draw.arguments);
        }
    }

    /// All draws.
    pub(super) fn draws(&self) -> &[ListedDraw] {
        &self.draws
    }

    /// Draws what is listed, when pipeline, triangles and groups are set: by indices, or by
    /// textures.
    pub(super) fn draw(&self, pass: &mut RenderPass<'_>, draw: &ListedDraw, is_indexed: bool) {
        // Behind that of vertices, where there is one.
        let number = u32::from(is_indexed);
        pass.set_vertex_buffer(number, self.listed.list().slice(draw.slots.clone()));
        if is_indexed {
            pass.draw_indexed_indirect(self.listed.arguments(), draw.arguments);
        } else {
            // The first four of the five words are the arguments of a draw without indices:
            // corners, instances, the first corner, and what is 0 in both.
            pass.draw_indirect(self.listed.arguments(), draw.arguments);
        }
    }

    /// Draws a level of the pyramid where it is to be shown.
    pub(super) fn draw_pyramid(
        &mut self,
        device: &Device,
        pass: &mut RenderPass<'_>,
        by: &DeviceView<'_>,
        target: &Target,
    ) {
        if let Some((place, _)) = by.pyramid.filter(|_| by.occlusion) {
            self.picture.draw(device, pass, place, target);
        }
    }

    /// To be called after what was recorded is submitted.
    pub(super) fn submitted(&self) {
        self.measuring.submitted();
    }

    /// Figures of the newest frame that are known.
    pub(super) fn figures(&self) -> DeviceFigures {
        self.measuring.last
    }

    /// How many frames were decided so far.
    pub(super) fn frames(&self) -> u64 {
        self.measuring.frames
    }
}

/// The draws of a scene's buckets, in the order of the groups of panes, and of each its bucket and
/// its arguments.
fn draws(lanes: &Lanes, scene: &Uploaded) -> (Vec<ListedDraw>, Vec<(u32, DrawArguments)>) {
    let kind = |of: &cullet_gpu::Kind| Kind {
        mesh: of.mesh,
        mirrored: of.mirrored,
        two_sided: of.two_sided,
        transparent: of.transparent,
    };
    let mut buckets: Vec<_> =
        (0..).zip(lanes.buckets()).map(|(n, b)| (kind(&b.kind), n, b)).collect();
    buckets.sort_by_key(|(kind, ..)| *kind);
    let (mut draws, mut all) = (Vec::new(), Vec::new());
    for (kind, number, bucket) in buckets {
        if scene.geometry.impostors.has(kind.mesh) {
            continue;
        }
        let mesh = &scene.geometry.meshes[kind.mesh as usize];
        for run in &mesh.runs {
            let triangles = run.triangles.start..run.triangles.end.min(mesh.whole);
            if triangles.is_empty() {
                continue;
            }
            draws.push(ListedDraw {
                kind,
                chunk: mesh.chunk,
                two_sided: run.two_sided,
                blended: run.blended || kind.transparent,
                slots: u64::from(bucket.lanes.start) * 4..u64::from(bucket.lanes.end) * 4,
                arguments: all.len() as u64 * ARGUMENTS,
            });
            let arguments = DrawArguments {
                index_count: (triangles.end - triangles.start) * 3,
                first_index: (mesh.first_triangle + triangles.start) * 3,
                ..DrawArguments::default()
            };
            all.push((number, arguments));
        }
    }
    (draws, all)
}
