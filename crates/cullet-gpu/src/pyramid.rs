//! The depth pyramid: for each rectangle of pixels a few texels that say how far the farthest depth
//! in it is.
//!
//! After Greene, Kass & Miller, *Hierarchical Z-Buffer Visibility*, 1993, in the form of Haar &
//! Aaltonen, *GPU-Driven Rendering Pipelines*, 2015.

use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutEntry,
    BindingResource, BindingType, BufferUsages, CommandEncoder, ComputePassDescriptor,
    ComputePipeline, Device, Extent3d, Sampler, SamplerBindingType, SamplerDescriptor,
    ShaderStages, StorageTextureAccess, Texture, TextureAspect, TextureDescriptor,
    TextureDimension, TextureFormat, TextureSampleType, TextureUsages, TextureView,
    TextureViewDescriptor, TextureViewDimension,
};

use super::buffers::{Access, layout, pipelines};
use super::checked::checked;
use super::error::GpuError;

/// Sizes of the levels above a picture: half of it, rounded up, each half of the one before, down
/// to one texel.
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

/// Levels that a dispatch makes.
const TOGETHER: usize = 3;

/// Pipelines that make pyramids of depth of one sample a pixel, or of several.
#[derive(Debug)]
pub struct PyramidPass {
    /// Layout of the levels that are made.
    made: BindGroupLayout,
    /// Layouts of depth with one sample and with several.
    depths: [BindGroupLayout; 2],
    levels: BindGroupLayout,
    of_depth: [ComputePipeline; 2],
    of_level: ComputePipeline,
    nearest: Sampler,
}

/// The pyramid of a picture of one size.
#[derive(Debug)]
pub struct Pyramid {
    texture: Texture,
    /// Size of the picture.
    size: [u32; 2],
    samples: u32,
    sizes: Vec<[u32; 2]>,
    steps: Vec<Step>,
    depth: BindGroup,
    levels: BindGroup,
}

/// Some levels, made of the one below or of the depth.
#[derive(Debug)]
struct Step {
    made: BindGroup,
    below: Option<BindGroup>,
    groups: [u32; 2],
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
    pub(crate) fn new(device: &Device) -> Self {
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
        let level = texture(TextureSampleType::Float { filterable: false }, false);
        let used = Access::Uniform.entry(0, ShaderStages::COMPUTE);
        let stored = [1, 2, 3].map(|binding| entry(binding, store));
        let made = layout(device, "levels made", &[used, stored[0], stored[1], stored[2]]);
        let depth = |many| entry(0, texture(TextureSampleType::Depth, many));
        let nearest = entry(1, BindingType::Sampler(SamplerBindingType::NonFiltering));
        let depths = [
            layout(device, "depth", &[depth(false), nearest]),
            layout(device, "depth of samples", &[depth(true)]),
        ];
        let levels = layout(device, "levels", &[entry(0, level)]);
        let make = |source, below| {
            let [made] = pipelines(device, "pyramid", source, &[&made, below], &[], ["make"]);
            made
        };
        let [one, many] = of_depths!("shaders/pyramid.wgsl");
        let below =
            concat!(include_str!("shaders/below.wgsl"), include_str!("shaders/pyramid.wgsl"));
        let of_depth = [make(one, &depths[0]), make(many, &depths[1])];
        let of_level = make(below, &levels);
        let nearest = device.create_sampler(&SamplerDescriptor::default());
        Self { made, depths, levels, of_depth, of_level, nearest }
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
        for Step { made, below, groups: [x, y] } in &pyramid.steps {
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
                label: Some("pyramid"),
                timestamp_writes: None,
            });
            let of_depth = &self.of_depth[usize::from(pyramid.has_several())];
            pass.set_pipeline(if below.is_some() { &self.of_level } else { of_depth });
            pass.set_bind_group(0, made, &[]);
            pass.set_bind_group(1, below.as_ref().unwrap_or(&pyramid.depth), &[]);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }
}

impl Pyramid {
    /// Makes room for the pyramid of a depth texture, reversed, that may be bound. Of several
    /// samples a pixel the farthest counts.
    ///
    /// # Errors
    /// If the device has no memory left for it, or is lost.
    pub fn new(device: &Device, pass: &PyramidPass, depth: &Texture) -> Result<Self, GpuError> {
        let sizes = level_sizes([depth.width(), depth.height()]).collect();
        Self::with_levels(device, pass, depth, sizes)
    }

    /// Makes one with levels of other sizes, to see that they hide what is visible.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    #[doc(hidden)]
    pub fn with_levels(
        device: &Device,
        pass: &PyramidPass,
        depth: &Texture,
        sizes: Vec<[u32; 2]>,
    ) -> Result<Self, GpuError> {
        checked(device, || Self::made(device, pass, depth, sizes))
    }

    fn made(device: &Device, pass: &PyramidPass, depth: &Texture, sizes: Vec<[u32; 2]>) -> Self {
        let size = [depth.width(), depth.height()];
        let room = |label, [width, height]: [u32; 2], mip_level_count| {
            device.create_texture(&TextureDescriptor {
                label: Some(label),
                size: Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: TextureFormat::R32Float,
                usage: TextureUsages::STORAGE_BINDING
                    | TextureUsages::TEXTURE_BINDING
                    | TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        };
        let texture =
            room("depth pyramid", sizes[0].map(u32::next_power_of_two), sizes.len() as u32);
        // Bound where there is no level left; each by itself, for nothing may be bound twice to be
        // written.
        let unused = [(); TOGETHER - 1]
            .map(|()| room("no level", [1, 1], 1).create_view(&TextureViewDescriptor::default()));
        let level = |number: usize| {
            texture.create_view(&TextureViewDescriptor {
                base_mip_level: number as u32,
                mip_level_count: Some(1),
                ..TextureViewDescriptor::default()
            })
        };
        let bind = |label, layout, entries: &[BindGroupEntry<'_>]| {
            device.create_bind_group(&BindGroupDescriptor { label: Some(label), layout, entries })
        };
        let step = |first: usize| {
            let of = |level: usize| sizes.get(level).copied().unwrap_or_default();
            let below = first.checked_sub(1);
            let used = [below.map_or(size, of), of(first), of(first + 1), of(first + 2)];
            let used = device.create_buffer_init(&BufferInitDescriptor {
                label: Some("used of levels"),
                contents: bytemuck::cast_slice(&used),
                usage: BufferUsages::UNIFORM,
            });
            let used = BindGroupEntry { binding: 0, resource: used.as_entire_binding() };
            let views: Vec<_> = (first..sizes.len()).take(TOGETHER).map(level).collect();
            let views: Vec<_> = views.iter().chain(&unused).take(TOGETHER).collect();
            let stored = (1..).zip(views).map(|(binding, view)| view_entry(binding, view));
            let entries: Vec<_> = [used].into_iter().chain(stored).collect();
            let below =
                below.map(|own| bind("level below", &pass.levels, &[view_entry(0, &level(own))]));
            // Each invocation makes four by four of the first, each group eight by eight of that.
            let groups = of(first).map(|v| v.div_ceil(32));
            Step { made: bind("levels made", &pass.made, &entries), below, groups }
        };
        let steps = (0..sizes.len()).step_by(TOGETHER).map(step).collect();
        let of_depth = depth.create_view(&TextureViewDescriptor {
            aspect: TextureAspect::DepthOnly,
            ..TextureViewDescriptor::default()
        });
        let samples = depth.sample_count();
        let nearest =
            BindGroupEntry { binding: 1, resource: BindingResource::Sampler(&pass.nearest) };
        let entries = [view_entry(0, &of_depth), nearest];
        let entries = if samples > 1 { &entries[..1] } else { &entries };
        let depth = bind("depth", pass.depth(samples > 1), entries);
        let all = texture.create_view(&TextureViewDescriptor::default());
        let levels = bind("levels", &pass.levels, &[view_entry(0, &all)]);
        Self { texture, size, samples, sizes, steps, depth, levels }
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
