//! The renderer: what it keeps between frames, and how a frame is made of panes.

use cullet::Scene;
use cullet_io::Model;
use eframe::wgpu::*;

use super::culling::DeviceCulling;
use super::error::DrawError;
use super::frame::{DeviceFigures, DeviceView, DrawStats, LineVertex, Pane, Style};
use super::pane::{Numbers, PaneState, STRIDE, is_pulled, to_linear};
use super::pass::{Extras, PaneDraw};
use super::pipelines::Pipelines;
use super::textures::{COLOUR, GrowingBuffer, ListTexture, Target};
use super::timer::Timer;
use super::upload::{Upload, Uploaded};

/// Draws scenes into a texture of its own, which others show.
///
/// It needs nothing beyond WebGL2: no storage buffers and no compute. What it keeps from frame to
/// frame follows the panes it draws: a list of slots is made and uploaded again only where it
/// changed.
#[derive(Debug)]
pub struct Renderer {
    pipelines: Pipelines,
    target: Target,
    /// Whether four samples a pixel can be had.
    four: bool,
    timer: Option<Timer>,
    numbers: GrowingBuffer,
    numbers_scratch: Vec<u8>,
    extras: GrowingBuffer,
    extras_scratch: Vec<LineVertex>,
    panes: Vec<PaneState>,
    scene: Option<Uploaded>,
    /// The next scene, while it is uploaded.
    coming: Option<Upload>,
    /// Culling on the device, where the device decides.
    culling: Option<DeviceCulling>,
    /// Stands in for a scene's textures where there is none.
    empty: ListTexture,
    group: Option<BindGroup>,
    translucent: bool,
    colours_uploaded: u64,
    stats: DrawStats,
}

impl Renderer {
    /// A renderer without a scene, whose picture is one pixel until the first frame.
    #[must_use]
    pub fn new(adapter: &Adapter, device: &Device) -> Self {
        let features = adapter.get_texture_format_features(COLOUR).flags;
        Self {
            pipelines: Pipelines::new(device, size_of::<Numbers>() as u64),
            target: Target::new(device, [1, 1], 1),
            four: features.sample_count_supported(4),
            timer: Timer::new(device),
            numbers: GrowingBuffer::new(device, "panes", BufferUsages::UNIFORM),
            numbers_scratch: Vec::new(),
            extras: GrowingBuffer::new(device, "lines and ghosts", BufferUsages::VERTEX),
            extras_scratch: Vec::new(),
            panes: Vec::new(),
            scene: None,
            coming: None,
            culling: None,
            empty: ListTexture::new(device, "nothing", TextureFormat::Rgba32Float, 1),
            group: None,
            translucent: false,
            colours_uploaded: 0,
            stats: DrawStats::default(),
        }
    }

    /// Uploads a scene in place of the one before. O(triangles + slots). The model is not needed
    /// any more afterwards; where its scene changes (moves, commits), upload it again.
    ///
    /// # Errors
    /// If it does not fit the device; the message names the limit. The scene before stays.
    pub fn set_scene(
        &mut self,
        device: &Device,
        queue: &Queue,
        model: &Model,
    ) -> Result<(), DrawError> {
        self.begin_scene(device, queue, model)?;
        self.go_on(queue, model, || true);
        Ok(())
    }

    /// Begins to upload a scene beside the one that is drawn; [`go_on`](Self::go_on) ends it. One
    /// that was begun before is dropped. O(triangles).
    ///
    /// # Errors
    /// As [`set_scene`](Self::set_scene).
    pub fn begin_scene(
        &mut self,
        device: &Device,
        queue: &Queue,
        model: &Model,
    ) -> Result<(), DrawError> {
        self.coming = None;
        self.coming = Some(Upload::begin(device, queue, model)?);
        Ok(())
    }

    /// Uploads instances of the scene that was begun, the same `model`, while there is `time`, some
    /// thousand between two questions; true when it is the one that is drawn, or when none was
    /// begun.
    pub fn go_on(&mut self, queue: &Queue, model: &Model, mut time: impl FnMut() -> bool) -> bool {
        let Some(mut coming) = self.coming.take() else { return true };
        while !coming.step(queue, &model.scene) {
            if !time() {
                self.coming = Some(coming);
                return false;
            }
        }
        let scene = coming.finish(&model.scene);
        self.panes.iter_mut().for_each(|pane| pane.list.reset(&scene.instances));
        self.scene = Some(scene);
        self.culling = None;
        self.group = None;
        self.translucent = false;
        true
    }

    /// The colours of [`Paint::Instances`](super::Paint::Instances): sRGB with straight alpha, one
    /// a slot. An alpha of 0 hides the instance; one below 255 shows it through a screen of dots.
    /// Slots beyond the list keep their colour (grey at first), colours beyond the slots are left
    /// out.
    pub fn set_instance_colours(&mut self, queue: &Queue, colours: &[[u8; 4]]) {
        let Some(scene) = &self.scene else { return };
        let colours = &colours[..colours.len().min(scene.instances.layers.len())];
        self.colours_uploaded += scene.colours.write(queue, colours);
        self.translucent = colours.iter().any(|c| c[3] < u8::MAX);
    }

    /// Draws panes, one over the other where they overlap, into a texture of `size` pixels; true
    /// when that texture was made anew. `background` is sRGB from 0 to 1. Sides are held within 1
    /// and what the device can; samples are the most that a pane requests, if the device can. What
    /// of a pane lies outside is not drawn.
    pub fn draw(
        &mut self,
        device: &Device,
        queue: &Queue,
        size: [u32; 2],
        background: [f32; 3],
        panes: &[Pane<'_>],
    ) -> bool {
        self.draw_by(device, queue, size, background, panes, None)
    }

    /// Why the device cannot decide what is drawn, if it cannot.
    #[must_use]
    pub fn refuses_culling(adapter: &Adapter) -> Option<String> {
        DeviceCulling::refused(adapter)
    }

    /// Makes the device ready to decide what is drawn of the scene that was uploaded, the same
    /// `scene`, unless it is. O(slots log slots).
    ///
    /// # Errors
    /// If it cannot; the message says why.
    pub fn prepare_culling(
        &mut self,
        device: &Device,
        queue: &Queue,
        scene: &Scene,
    ) -> Result<(), DrawError> {
        if let (None, Some(uploaded)) = (&self.culling, &self.scene) {
            let of = (scene, uploaded);
            self.culling = Some(DeviceCulling::new(device, queue, &self.pipelines, of)?);
        }
        Ok(())
    }

    /// Returns the figures of the device's newest decision that is known; all 0 before any is, and
    /// where it decides nothing.
    #[must_use]
    pub fn device_figures(&self) -> DeviceFigures {
        self.culling.as_ref().map_or_else(DeviceFigures::default, DeviceCulling::figures)
    }

    /// How many frames the device decided so far.
    #[must_use]
    pub fn device_frames(&self) -> u64 {
        self.culling.as_ref().map_or(0, DeviceCulling::frames)
    }

    /// Draws like [`draw`](Self::draw), but if it was [made ready](Self::prepare_culling), the
    /// device decides `by` a view what is drawn in the panes that are [on the
    /// device](Pane::on_device). Where the device cannot decide, these panes draw what is visible.
    pub fn draw_by(
        &mut self,
        device: &Device,
        queue: &Queue,
        size: [u32; 2],
        background: [f32; 3],
        panes: &[Pane<'_>],
        by: Option<&DeviceView<'_>>,
    ) -> bool {
        let max_side = device.limits().max_texture_dimension_2d;
        let size = size.map(|v| v.clamp(1, max_side));
        let many = self.four && panes.iter().any(|p| p.style.samples > 1);
        let samples = if many { 4 } else { 1 };
        let fresh = self.target.size != size || self.target.samples != samples;
        if fresh {
            self.target = Target::new(device, size, samples);
        }
        let mut uploaded = self.colours_uploaded;
        self.colours_uploaded = 0;
        let radius = self.scene.as_ref().map_or(1.0, |s| s.radius);
        let culling = self.culling.as_mut();
        let by =
            by.filter(|by| culling.is_some_and(|c| c.set(device, queue, by, (radius, samples))));
        uploaded += self.follow(device, queue, background, panes, (by, max_side));
        let extras = self.gather(panes);
        uploaded += self.extras.write(device, queue, &self.extras_scratch);
        let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
        let measured = self.encode(device, queue, &mut encoder, background, (panes, by), &extras);
        if let (true, Some(timer)) = (measured, &self.timer) {
            timer.resolve(&mut encoder);
        }
        queue.submit([encoder.finish()]);
        if let (true, Some(timer)) = (measured, &self.timer) {
            timer.submitted();
        }
        if let (Some(_), Some(culling)) = (by, &self.culling) {
            culling.submitted();
        }
        self.stats.uploaded = uploaded;
        self.stats.device_ms = self.timer.as_ref().and_then(|t| t.last_ms);
        fresh
    }

    /// The picture: `Rgba8UnormSrgb`, one sample a pixel.
    #[must_use]
    pub fn colour(&self) -> &TextureView {
        &self.target.colour
    }

    /// Statistics of the last frame.
    #[must_use]
    pub fn stats(&self) -> DrawStats {
        self.stats
    }

    /// Makes lists and numbers follow the panes; returns the bytes uploaded.
    fn follow(
        &mut self,
        device: &Device,
        queue: &Queue,
        background: [f32; 3],
        panes: &[Pane<'_>],
        (by, max_side): (Option<&DeviceView<'_>>, u32),
    ) -> u64 {
        let mut uploaded = 0;
        while self.panes.len() < panes.len() {
            let mut state = PaneState::new(device);
            if let Some(scene) = &self.scene {
                state.list.reset(&scene.instances);
            }
            self.panes.push(state);
        }
        if let Some(scene) = &mut self.scene {
            let any = |wanted: fn(&Style) -> bool| panes.iter().any(|p| wanted(&p.style));
            let normals = any(|s| s.vertex_normals);
            if normals || any(|s| is_pulled(s) || s.face_normals) {
                scene.prepare(device, queue, &self.pipelines.chunk_layout, normals);
            }
            scene.prepare_impostors(device, &self.pipelines.impostor_layout);
            for (pane, state) in panes.iter().zip(&mut self.panes) {
                if by.is_none() || !pane.on_device {
                    uploaded += state.update(device, queue, scene, pane);
                }
            }
            uploaded += std::mem::take(&mut scene.uploaded);
        }
        let radius = self.scene.as_ref().map_or(1.0, |s| s.radius);
        self.numbers_scratch.clear();
        let decided = by.map(Pane::of_device);
        for pane in panes.iter().chain(&decided) {
            let numbers = Numbers::new(pane, background, radius, max_side);
            self.numbers_scratch.extend_from_slice(bytemuck::bytes_of(&numbers));
            let end = self.numbers_scratch.len().next_multiple_of(STRIDE as usize);
            self.numbers_scratch.resize(end, 0);
        }
        if self.numbers.reserve(device, self.numbers_scratch.len() as u64) {
            self.group = None;
        }
        uploaded + self.numbers.write(device, queue, &self.numbers_scratch)
    }

    /// Lines and ghosts of all panes, one after the other.
    fn gather(&mut self, panes: &[Pane<'_>]) -> Vec<Extras> {
        self.extras_scratch.clear();
        let mut add = |vertices: &[LineVertex]| {
            let first = self.extras_scratch.len() as u32;
            self.extras_scratch.extend_from_slice(vertices);
            first..self.extras_scratch.len() as u32
        };
        panes
            .iter()
            .map(|p| Extras { lines: add(p.lines), ghosts: add(p.ghosts), overlay: add(p.overlay) })
            .collect()
    }

    /// Encodes the frame; true if it is measured.
    fn encode(
        &mut self,
        device: &Device,
        queue: &Queue,
        encoder: &mut CommandEncoder,
        background: [f32; 3],
        (panes, by): (&[Pane<'_>], Option<&DeviceView<'_>>),
        extras: &[Extras],
    ) -> bool {
        let group = self.pane_group(device);
        if let (Some(by), Some(culling), Some(scene)) = (by, &mut self.culling, &self.scene) {
            // Its numbers stand behind those of the panes.
            let of_view = (&group, (panes.len() as u64 * STRIDE) as u32);
            culling.record(queue, encoder, of_view, scene, by);
        }
        let [r, g, b] = background.map(|v| f64::from(to_linear(v)));
        let target = &self.target;
        let timestamp_writes = self.timer.as_mut().and_then(|t| t.start(queue));
        let measured = timestamp_writes.is_some();
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("panes"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: target.many.as_ref().unwrap_or(&target.colour),
                depth_slice: None,
                resolve_target: target.many.as_ref().map(|_| &target.colour),
                ops: Operations {
                    load: LoadOp::Clear(Color { r, g, b, a: 1.0 }),
                    store: if target.many.is_some() { StoreOp::Discard } else { StoreOp::Store },
                },
            })],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &target.depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        (self.stats.triangles, self.stats.draws, self.stats.impostors) = (0, 0, 0);
        for (number, (pane, extras)) in panes.iter().zip(extras).enumerate() {
            let [x, y, width, height] = pane.place;
            let end = [x.saturating_add(width), y.saturating_add(height)];
            let [right, bottom] = [end[0].min(target.size[0]), end[1].min(target.size[1])];
            if right <= x || bottom <= y {
                continue;
            }
            pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
            pass.set_scissor_rect(x, y, right - x, bottom - y);
            pass.set_bind_group(0, &group, &[number as u32 * STRIDE as u32]);
            let mut draw = PaneDraw {
                device,
                pipelines: &mut self.pipelines,
                pane,
                samples: target.samples,
                on_device: self.culling.as_ref().filter(|_| by.is_some() && pane.on_device),
                translucent: self.translucent,
                triangles: 0,
                impostors: 0,
                draws: 0,
            };
            if !pane.over {
                draw.clear(&mut pass);
            }
            if let (Some(scene), Some(state)) = (&self.scene, self.panes.get(number)) {
                draw.scene(&mut pass, scene, state);
            }
            draw.extras(&mut pass, &self.extras.buffer, extras);
            self.stats.triangles += draw.triangles;
            self.stats.impostors += draw.impostors;
            self.stats.draws += draw.draws;
            if by.is_some() && pane.on_device {
                // As far as it is known.
                self.stats.triangles += self.device_figures().triangles;
            }
        }
        if let (Some(by), Some(culling)) = (by, &mut self.culling) {
            culling.draw_pyramid(device, &mut pass, by, target);
        }
        measured
    }

    /// The bind group of numbers, transforms and colours.
    fn pane_group(&mut self, device: &Device) -> BindGroup {
        let (scene, empty) = (self.scene.as_ref(), &self.empty.view);
        let make = || {
            let views = match scene {
                Some(s) => [&s.transforms.view, &s.parts.view, &s.colours.view],
                None => [empty; 3],
            };
            let numbers = BindingResource::Buffer(BufferBinding {
                buffer: &self.numbers.buffer,
                offset: 0,
                size: BufferSize::new(size_of::<Numbers>() as u64),
            });
            let entry = |binding, resource| BindGroupEntry { binding, resource };
            device.create_bind_group(&BindGroupDescriptor {
                label: Some("panes"),
                layout: &self.pipelines.pane_layout,
                entries: &[
                    entry(0, numbers),
                    entry(1, BindingResource::TextureView(views[0])),
                    entry(2, BindingResource::TextureView(views[1])),
                    entry(3, BindingResource::TextureView(views[2])),
                ],
            })
        };
        self.group.get_or_insert_with(make).clone()
    }
}
