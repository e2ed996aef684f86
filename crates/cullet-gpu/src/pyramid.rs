//! The depth pyramid: for each rectangle of pixels a few texels that say how far the farthest depth in it is.
//!
//! After Greene, Kass & Miller, *Hierarchical Z-Buffer Visibility*, 1993, in the form of Haar & Aaltonen, *GPU-Driven Rendering
//! Pipelines*, 2015.

use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutEntry,
    BindingResource, BindingType, BufferUsages, CommandEncoder, ComputePassDescriptor,
    ComputePipeline, Device, Extent3d, ShaderStages, StorageTextureAccess, Texture, TextureAspect,
    TextureDescriptor, TextureDimension, TextureFormat, TextureSampleType, TextureUsages,
    TextureView, TextureViewDescriptor, TextureViewDimension,
};

use super::buffers::{Access, layout, pipelines};

/// Sizes of the levels above a picture: half of it, rounded up, each half of the one before, down to one texel.
pub fn level_sizes(size: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    let half = |size: [u32; 2]| size.map(|v| v.max(1).div_ceil(2));
    std::iter::successors(Some(half(size)), move |own| (*own != [1, 1]).then(|| half(*own)))
}

/// The levels above a picture of depths, row by row, reversed: slow and obvious.
#[must_use]
pub fn pyramid_ref(depths: &[f32], size: [u32; 2]) -> Vec<Vec<f32>> {
    let mut levels: Vec<Vec<f32>> = Vec::new();
    for (level, [width, height]) in level_sizes(size).enumerate() {
        let span = 2_u32 << level;
        let texel = |i: u32| {
            let [x, y] = [i % width, i / width].map(|v| v * span);
            let mut far = 1.0_f32;
            for at_y in y..(y + span).min(size[1]) {
                for at_x in x..(x + span).min(size[0]) {
                    far = far.min(depths[(at_y * size[0] + at_x) as usize]);
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
    /// For those who test against a pyramid.
    reading: BindGroupLayout,
}

/// The pyramid of a picture of one size.
#[derive(Debug)]
pub struct Pyramid {
    texture: Texture,
    /// Of the picture.
    size: [u32; 2],
    sizes: Vec<[u32; 2]>,
    /// What makes each level.
    groups: Vec<BindGroup>,
    reading: BindGroup,
}

fn view_entry(binding: u32, view: &TextureView) -> BindGroupEntry<'_> {
    BindGroupEntry { binding, resource: BindingResource::TextureView(view) }
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
        let source = include_str!("shaders/pyramid.wgsl");
        let make = |name, entries: &[BindGroupLayoutEntry]| {
            let own = layout(device, name, entries);
            let [pipeline] = pipelines(device, "pyramid", source, &[&own], &[], [name]);
            (own, pipeline)
        };
        let levels = texture(TextureSampleType::Float { filterable: false });
        let depth = entry(0, texture(TextureSampleType::Depth));
        let used = Access::Uniform.entry(3, ShaderStages::COMPUTE);
        let (of_depth, first) = make("first", &[depth, entry(2, store), used]);
        let (of_level, next) = make("next", &[entry(1, levels), entry(2, store), used]);
        let depth = entry(1, texture(TextureSampleType::Depth));
        let reading = layout(device, "pyramid", &[entry(0, levels), depth]);
        Self { layouts: [of_depth, of_level], first, next, reading }
    }

    /// The layout of what a shader needs that tests against a pyramid: all levels, and the depth that they are of.
    #[must_use]
    pub fn reading(&self) -> &BindGroupLayout {
        &self.reading
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
        let sizes = level_sizes([depth.width(), depth.height()]).collect();
        Self::with_levels(device, pass, depth, sizes)
    }

    /// The same with levels of other sizes, to see that they hide what is visible.
    #[doc(hidden)]
    #[must_use]
    pub fn with_levels(
        device: &Device,
        pass: &PyramidPass,
        depth: &Texture,
        sizes: Vec<[u32; 2]>,
    ) -> Self {
        let size = [depth.width(), depth.height()];
        let [width, height] = sizes[0].map(u32::next_power_of_two);
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
            let below = number.checked_sub(1).map_or(size, |below| sizes[below as usize]);
            let used = device.create_buffer_init(&BufferInitDescriptor {
                label: Some("used of levels"),
                contents: bytemuck::cast_slice(&[below, sizes[number as usize]]),
                usage: BufferUsages::UNIFORM,
            });
            let used = BindGroupEntry { binding: 3, resource: used.as_entire_binding() };
            device.create_bind_group(&BindGroupDescriptor {
                label: Some("pyramid"),
                layout,
                entries: &[view_entry(binding, from), view_entry(2, &level(number)), used],
            })
        };
        let groups = (0..sizes.len() as u32).map(group).collect();
        let view = texture.create_view(&TextureViewDescriptor::default());
        let reading = device.create_bind_group(&BindGroupDescriptor {
            label: Some("pyramid"),
            layout: &pass.reading,
            entries: &[view_entry(0, &view), view_entry(1, &of_depth)],
        });
        Self { texture, size, sizes, groups, reading }
    }

    /// Width and height of the picture.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The size of each level; its texture may be larger.
    #[must_use]
    pub fn sizes(&self) -> &[[u32; 2]] {
        &self.sizes
    }

    /// All levels, and the depth that they are of, for those who test against them.
    #[must_use]
    pub fn reading(&self) -> &BindGroup {
        &self.reading
    }

    /// The texture.
    #[must_use]
    pub fn texture(&self) -> &Texture {
        &self.texture
    }
}
