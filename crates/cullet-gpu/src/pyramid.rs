//! The depth pyramid: for each rectangle of pixels a few texels that say how far the farthest depth in it is.
//!
//! After Greene, Kass & Miller, *Hierarchical Z-Buffer Visibility*, 1993, in the form of Haar & Aaltonen, *GPU-Driven Rendering
//! Pipelines*, 2015.

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, BindingResource, BindingType, CommandEncoder, ComputePassDescriptor,
    ComputePipeline, ComputePipelineDescriptor, Device, Extent3d, PipelineLayoutDescriptor,
    ShaderModuleDescriptor, ShaderSource, ShaderStages, StorageTextureAccess, Texture,
    TextureAspect, TextureDescriptor, TextureDimension, TextureFormat, TextureSampleType,
    TextureUsages, TextureView, TextureViewDescriptor, TextureViewDimension,
};

/// Sizes of the levels above a picture: powers of two, the first at least half of it, each half of the one before, down to one
/// texel.
pub fn level_sizes([width, height]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    let first = [width, height].map(|v| v.max(1).div_ceil(2).next_power_of_two());
    let halved = |own: &[u32; 2]| (*own != [1, 1]).then(|| own.map(|v| (v / 2).max(1)));
    std::iter::successors(Some(first), halved)
}

/// The levels above a picture of depths, row by row, reversed: slow and obvious. Texels behind the picture have what its last
/// pixels have.
#[must_use]
pub fn pyramid_ref(depths: &[f32], size: [u32; 2]) -> Vec<Vec<f32>> {
    let mut levels: Vec<Vec<f32>> = Vec::new();
    for (level, [width, height]) in level_sizes(size).enumerate() {
        let span = 2_u32 << level;
        let texel = |i: u32| {
            let [x, y] = [i % width, i / width].map(|v| v * span);
            let mut far = 1.0_f32;
            for at_y in y..y + span {
                for at_x in x..x + span {
                    let [px, py] = [at_x.min(size[0] - 1), at_y.min(size[1] - 1)];
                    far = far.min(depths[(py * size[0] + px) as usize]);
                }
            }
            far
        };
        levels.push((0..width * height).map(texel).collect());
    }
    levels
}

/// Pipelines that make pyramids.
#[derive(Debug)]
pub struct PyramidPass {
    layouts: [BindGroupLayout; 2],
    first: ComputePipeline,
    next: ComputePipeline,
}

/// The pyramid of a picture of one size.
#[derive(Debug)]
pub struct Pyramid {
    texture: Texture,
    /// All levels.
    view: TextureView,
    sizes: Vec<[u32; 2]>,
    /// What makes each level.
    groups: Vec<BindGroup>,
}

impl PyramidPass {
    /// Compiles the passes.
    #[must_use]
    pub fn new(device: &Device) -> Self {
        let entry = |binding, ty| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        let texture = |sample_type| BindingType::Texture {
            sample_type,
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let store = BindingType::StorageTexture {
            access: StorageTextureAccess::WriteOnly,
            format: TextureFormat::R32Float,
            view_dimension: TextureViewDimension::D2,
        };
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("pyramid"),
            source: ShaderSource::Wgsl(include_str!("shaders/pyramid.wgsl").into()),
        });
        let make = |name, source| {
            let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
                label: Some(name),
                entries: &[source, entry(2, store)],
            });
            let of_all = device.create_pipeline_layout(&PipelineLayoutDescriptor {
                label: Some(name),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&of_all),
                module: &module,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            });
            (layout, pipeline)
        };
        let unfiltered = TextureSampleType::Float { filterable: false };
        let (of_depth, first) = make("first", entry(0, texture(TextureSampleType::Depth)));
        let (of_level, next) = make("next", entry(1, texture(unfiltered)));
        Self { layouts: [of_depth, of_level], first, next }
    }

    /// Records how a pyramid is made of the depth that it was [made for](Pyramid::new).
    pub fn record(&self, encoder: &mut CommandEncoder, pyramid: &Pyramid) {
        for (level, (group, [width, height])) in
            pyramid.groups.iter().zip(&pyramid.sizes).enumerate()
        {
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
                label: Some("pyramid"),
                timestamp_writes: None,
            });
            pass.set_pipeline(if level == 0 { &self.first } else { &self.next });
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        }
    }
}

impl Pyramid {
    /// Room for the pyramid of a depth texture, reversed, of one sample a pixel, that may be bound.
    #[must_use]
    pub fn new(device: &Device, pass: &PyramidPass, depth: &Texture) -> Self {
        let sizes: Vec<[u32; 2]> = level_sizes([depth.width(), depth.height()]).collect();
        let [width, height] = sizes[0];
        let texture = device.create_texture(&TextureDescriptor {
            label: Some("depth pyramid"),
            size: Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: sizes.len() as u32,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: TextureFormat::R32Float,
            usage: TextureUsages::STORAGE_BINDING
                | TextureUsages::TEXTURE_BINDING
                | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let level = |number: u32| {
            texture.create_view(&TextureViewDescriptor {
                base_mip_level: number,
                mip_level_count: Some(1),
                ..TextureViewDescriptor::default()
            })
        };
        let of_depth = depth.create_view(&TextureViewDescriptor {
            aspect: TextureAspect::DepthOnly,
            ..TextureViewDescriptor::default()
        });
        let group = |number: u32| {
            let (layout, from, binding) = match number.checked_sub(1) {
                None => (&pass.layouts[0], &of_depth, 0),
                Some(below) => (&pass.layouts[1], &level(below), 1),
            };
            let entry = |binding, view| BindGroupEntry {
                binding,
                resource: BindingResource::TextureView(view),
            };
            device.create_bind_group(&BindGroupDescriptor {
                label: Some("pyramid"),
                layout,
                entries: &[entry(binding, from), entry(2, &level(number))],
            })
        };
        let groups = (0..sizes.len() as u32).map(group).collect();
        let view = texture.create_view(&TextureViewDescriptor::default());
        Self { texture, view, sizes, groups }
    }

    /// The size of each level.
    #[must_use]
    pub fn sizes(&self) -> &[[u32; 2]] {
        &self.sizes
    }

    /// All levels, for those who test against them.
    #[must_use]
    pub fn view(&self) -> &TextureView {
        &self.view
    }

    /// The texture.
    #[must_use]
    pub fn texture(&self) -> &Texture {
        &self.texture
    }
}
