//! The renderer's picture as egui takes it. The picture is stored as sRGB, so that sampling it
//! gives linear light; egui takes what it samples for encoded values, and would show it too dark.
//! One pass encodes it. (A second view of the same texture would be free, but WebGL2 knows none of
//! another format.)

use eframe::wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Color,
    CommandEncoderDescriptor, Device, Extent3d, FragmentState, LoadOp, Operations, Queue,
    RenderPassColorAttachment, RenderPassDescriptor, RenderPipeline, RenderPipelineDescriptor,
    ShaderModuleDescriptor, ShaderSource, StoreOp, TextureDescriptor, TextureDimension,
    TextureFormat, TextureUsages, TextureView, VertexState,
};

const SHADER: &str = "
@group(0) @binding(0) var picture: texture_2d<f32>;

// One triangle over all of the target.
@vertex fn vs(@builtin(vertex_index) n: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(n & 1u) * 4.0 - 1.0, f32(n >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let c = textureLoad(picture, vec2<i32>(at.xy), 0).rgb;
    let low = c * 12.92;
    let high = 1.055 * pow(max(c, vec3<f32>(0.0)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return vec4<f32>(select(high, low, c <= vec3<f32>(0.0031308)), 1.0);
}";

const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

/// Encodes pictures into a texture of its own.
#[derive(Debug)]
pub(crate) struct Present {
    pipeline: RenderPipeline,
    made: Option<(TextureView, BindGroup)>,
}

impl Present {
    /// One without a picture.
    #[must_use]
    pub(crate) fn new(device: &Device) -> Self {
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("present"),
            source: ShaderSource::Wgsl(SHADER.into()),
        });
        let pipeline = device.create_render_pipeline(&RenderPipelineDescriptor {
            label: Some("present"),
            layout: None,
            vertex: VertexState {
                module: &module,
                entry_point: Some("vs"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(FragmentState {
                module: &module,
                entry_point: Some("fs"),
                compilation_options: Default::default(),
                targets: &[Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline, made: None }
    }

    /// Encodes `picture` of `size` pixels; `fresh` says that its texture is another than last time.
    /// True where the texture of [`shown`](Self::shown) was made anew.
    pub(crate) fn encode(
        &mut self,
        device: &Device,
        queue: &Queue,
        picture: &TextureView,
        size: [u32; 2],
        fresh: bool,
    ) -> bool {
        let anew = fresh || self.made.is_none();
        if anew {
            self.made = Some(self.make(device, picture, size));
        }
        let Some((target, group)) = &self.made else { return false };
        let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
                label: Some("present"),
                color_attachments: &[Some(RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: Operations { load: LoadOp::Clear(Color::BLACK), store: StoreOp::Store },
                })],
                depth_stencil_attachment: None,
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.draw(0..3, 0..1);
        }
        queue.submit([encoder.finish()]);
        anew
    }

    /// The encoded picture; `None` before the first.
    #[must_use]
    pub(crate) fn shown(&self) -> Option<&TextureView> {
        self.made.as_ref().map(|(view, _)| view)
    }

    fn make(
        &self,
        device: &Device,
        picture: &TextureView,
        size: [u32; 2],
    ) -> (TextureView, BindGroup) {
        let texture = device.create_texture(&TextureDescriptor {
            label: Some("shown"),
            size: Extent3d {
                width: size[0].max(1),
                height: size[1].max(1),
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: FORMAT,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: Some("present"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[BindGroupEntry {
                binding: 0,
                resource: BindingResource::TextureView(picture),
            }],
        });
        (texture.create_view(&Default::default()), group)
    }
}
