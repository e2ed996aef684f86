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

/// Pipelines that make pyramids of depth of one sample a pixel, or of several.
#[derive(Debug)]
pub struct PyramidPass {
    /// Of the first level and of the others.
    layouts: [BindGroupLayout; 2],
    /// Of one sample and of several.
    depths: [BindGroupLayout; 2],
    first: [ComputePipeline; 2],
    next: ComputePipeline,
    levels: BindGroupLayout,
}

/// The pyramid of a picture of one size.
#[derive(Debug)]
pub struct Pyramid {
    texture: Texture,
    /// Of the picture.
    size: [u32; 2],
    samples: u32,
    sizes: Vec<[u32; 2]>,
    /// What makes each level.
    groups: Vec<BindGroup>,
    depth: BindGroup,
    levels: BindGroup,
}

/// Shaders that read depth: of one sample a pixel, and of several.
macro_rules! of_depths {
    ($($file:literal),*) => {
        [
            concat!(include_str!("shaders/depth_one.wgsl"), $(include_str!($file)),*),
            concat!(include_str!("shaders/depth_many.wgsl"), $(include_str!($file)),*),
        ]
    };
}
pub(crate) use of_depths;

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
        let texture = |sample_type, multisampled| BindingType::Texture {
            sample_type,
            view_dimension: TextureViewDimension::D2,
            multisampled,
        };
        let store = BindingType::StorageTexture {
            access: StorageTextureAccess::WriteOnly,
            format: TextureFormat::R32Float,
            view_dimension: TextureViewDimension::D2,
        };
        let of_level = texture(TextureSampleType::Float { filterable: false }, false);
        let used = Access::Uniform.entry(0, ShaderStages::COMPUTE);
        let layouts = [
            layout(device, "first level", &[used, entry(1, store)]),
            layout(device, "next level", &[used, entry(1, store), entry(2, of_level)]),
        ];
        let depths = [false, true].map(|many| {
            layout(device, "depth", &[entry(0, texture(TextureSampleType::Depth, many))])
        });
        let [one, many] = of_depths!("shaders/pyramid.wgsl");
        let make = |source, layouts: &[&BindGroupLayout], name| {
            let [made] = pipelines(device, "pyramid", source, layouts, &[], [name]);
            made
        };
        let first = [
            make(one, &[&layouts[0], &depths[0]], "first"),
            make(many, &[&layouts[0], &depths[1]], "first"),
        ];
        let next = make(one, &[&layouts[1]], "next");
        let levels = layout(device, "levels", &[entry(0, of_level)]);
        Self { layouts, depths, first, next, levels }
    }

    /// The layout of [`Pyramid::levels`].
    #[must_use]
    pub fn levels(&self) -> &BindGroupLayout {
        &self.levels
    }

    /// The layout of [`Pyramid::depth`], of one sample a pixel or of several.
    #[must_use]
    pub fn depth(&self, has_several: bool) -> &BindGroupLayout {
        &self.depths[usize::from(has_several)]
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
            pass.set_bind_group(0, group, &[]);
            if level == 0 {
                pass.set_pipeline(&self.first[usize::from(pyramid.has_several())]);
                pass.set_bind_group(1, &pyramid.depth, &[]);
            } else {
                pass.set_pipeline(&self.next);
            }
            pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        }
    }
}

impl Pyramid {
    /// Room for the pyramid of a depth texture, reversed, that may be bound. Of several samples a pixel the farthest counts.
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
        let bind = |label, layout, entries: &[BindGroupEntry<'_>]| {
            device.create_bind_group(&BindGroupDescriptor { label: Some(label), layout, entries })
        };
        let group = |number: u32| {
            let below = number.checked_sub(1);
            let used = [below.map_or(size, |own| sizes[own as usize]), sizes[number as usize]];
            let used = device.create_buffer_init(&BufferInitDescriptor {
                label: Some("used of levels"),
                contents: bytemuck::cast_slice(&used),
                usage: BufferUsages::UNIFORM,
            });
            let used = BindGroupEntry { binding: 0, resource: used.as_entire_binding() };
            let above = level(number);
            let entries = [used, view_entry(1, &above)];
            match below.map(level) {
                None => bind("first level", &pass.layouts[0], &entries),
                Some(below) => {
                    let [used, above] = entries;
                    bind("next level", &pass.layouts[1], &[used, above, view_entry(2, &below)])
                }
            }
        };
        let groups = (0..sizes.len() as u32).map(group).collect();
        let of_depth = depth.create_view(&TextureViewDescriptor {
            aspect: TextureAspect::DepthOnly,
            ..TextureViewDescriptor::default()
        });
        let samples = depth.sample_count();
        let depth = bind("depth", pass.depth(samples > 1), &[view_entry(0, &of_depth)]);
        let all = texture.create_view(&TextureViewDescriptor::default());
        let levels = bind("levels", &pass.levels, &[view_entry(0, &all)]);
        Self { texture, size, samples, sizes, groups, depth, levels }
    }

    /// Whether a pixel of the picture has several samples.
    #[must_use]
    pub fn has_several(&self) -> bool {
        self.samples > 1
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

    /// All levels, for those who test against them.
    #[must_use]
    pub fn levels(&self) -> &BindGroup {
        &self.levels
    }

    /// The depth that it is of, for the same.
    #[must_use]
    pub fn depth(&self) -> &BindGroup {
        &self.depth
    }

    /// The texture.
    #[must_use]
    pub fn texture(&self) -> &Texture {
        &self.texture
    }
}
