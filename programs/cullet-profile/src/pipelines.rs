//! Pipelines, passes and textures: what scenes and frames of a known limit are both drawn with.

use wgpu::*;

/// Properties that set one pipeline apart from the others.
pub(crate) struct Wanted<'a> {
    pub(crate) module: &'a ShaderModule,
    pub(crate) layouts: &'a [&'a BindGroupLayout],
    pub(crate) vertices: &'a [Option<VertexBufferLayout<'a>>],
    /// Entry point; that of the vertices is the only one.
    pub(crate) fragment: &'static str,
    pub(crate) cull_mode: Option<Face>,
    pub(crate) colour: ColorTargetState,
    /// Whether depth is written, and which passes.
    pub(crate) depth: Option<(bool, CompareFunction)>,
}

/// The colours that are seen, over what is there or blended with it.
pub(crate) fn seen(blended: bool) -> ColorTargetState {
    ColorTargetState {
        format: TextureFormat::Rgba8Unorm,
        blend: blended.then_some(BlendState::ALPHA_BLENDING),
        write_mask: ColorWrites::ALL,
    }
}

/// Compiles a pipeline.
pub(crate) fn pipeline(device: &Device, label: &str, wanted: &Wanted<'_>) -> RenderPipeline {
    let layouts: Vec<_> = wanted.layouts.iter().map(|layout| Some(*layout)).collect();
    let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &layouts,
        immediate_size: 0,
    });
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
        vertex: VertexState {
            module: wanted.module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: wanted.vertices,
        },
        fragment: Some(FragmentState {
            module: wanted.module,
            entry_point: Some(wanted.fragment),
            compilation_options: Default::default(),
            targets: &[Some(wanted.colour.clone())],
        }),
        primitive: PrimitiveState { cull_mode: wanted.cull_mode, ..PrimitiveState::default() },
        depth_stencil: wanted.depth.map(|(writes, compare)| DepthStencilState {
            format: TextureFormat::Depth32Float,
            depth_write_enabled: Some(writes),
            depth_compare: Some(compare),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        multiview_mask: None,
        cache: None,
    })
}

/// Makes a layout of buffers, with their bindings in order.
pub(crate) fn bindings(
    device: &Device,
    label: &str,
    buffers: &[(ShaderStages, BufferBindingType)],
) -> BindGroupLayout {
    let entry = |(binding, (visibility, ty)): (u32, &(ShaderStages, BufferBindingType))| {
        let ty = BindingType::Buffer { ty: *ty, has_dynamic_offset: false, min_binding_size: None };
        BindGroupLayoutEntry { binding, visibility: *visibility, ty, count: None }
    };
    let entries: Vec<_> = (0..).zip(buffers).map(entry).collect();
    device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}

/// Binds whole buffers, in order.
pub(crate) fn group(
    device: &Device,
    label: &str,
    layout: &BindGroupLayout,
    buffers: &[&Buffer],
) -> BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    device.create_bind_group(&BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

/// Makes a buffer that may be written by the program.
pub(crate) fn buffer(device: &Device, label: &str, size: u64, usage: BufferUsages) -> Buffer {
    device.create_buffer(&BufferDescriptor {
        label: Some(label),
        size,
        usage: usage | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Compiles a shader.
pub(crate) fn shader(device: &Device, label: &str, source: &str) -> ShaderModule {
    device.create_shader_module(ShaderModuleDescriptor {
        label: Some(label),
        source: ShaderSource::Wgsl(source.into()),
    })
}

/// A texture to draw into.
pub(crate) fn target(
    device: &Device,
    [width, height]: [u32; 2],
    format: TextureFormat,
) -> TextureView {
    let texture = device.create_texture(&TextureDescriptor {
        label: Some("frame"),
        size: Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&TextureViewDescriptor::default())
}

/// The size of a picture of twice the area.
pub(crate) fn twice(size: [u32; 2]) -> [u32; 2] {
    size.map(|v| (f64::from(v) * std::f64::consts::SQRT_2).round() as u32)
}

/// Pictures of a size and of twice the area: colour and depth.
pub(crate) fn targets(device: &Device, size: [u32; 2]) -> [[TextureView; 2]; 2] {
    let of = |size| {
        [TextureFormat::Rgba8Unorm, TextureFormat::Depth32Float]
            .map(|format| target(device, size, format))
    };
    [size, twice(size)].map(of)
}

/// Begins a pass over nothing.
pub(crate) fn begin<'e>(
    encoder: &'e mut CommandEncoder,
    label: &str,
    colour: (&TextureView, StoreOp),
    depth: Option<&TextureView>,
) -> RenderPass<'e> {
    let (view, store) = colour;
    encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: Operations { load: LoadOp::Clear(Color::BLACK), store },
        })],
        // Depth is of no use afterwards.
        depth_stencil_attachment: depth.map(|view| RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
