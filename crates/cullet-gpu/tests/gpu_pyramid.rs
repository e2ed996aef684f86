//! The depth pyramid: each texel the farthest of its pixels, for any size.

use crate::common;

use cullet_gpu::{Gpu, Passes, Pyramid, Tier, level_sizes, pyramid_ref};
use wgpu::*;

use common::{gpu, texels};

/// Depths that depend on the pixel alone, most of them near.
const DEPTHS: &str = "
@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i32(i & 1u) * 4 - 1), f32(i32(i >> 1u) * 4 - 1), 0.5, 1.0);
}
@fragment fn fs(@builtin(position) at: vec4<f32>) -> @builtin(frag_depth) f32 {
    var h = u32(at.x) * 0x9e3779b9u + u32(at.y) * 0x85ebca6bu;
    h = (h ^ (h >> 15u)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12u)) * 0x297a2d39u;
    return 1.0 - f32(h >> 8u) / 16777216.0 * select(0.1, 1.0, h % 7u == 0u);
}";

/// A texture of such depths.
fn depths(gpu: &Gpu, [width, height]: [u32; 2]) -> Texture {
    let device = &gpu.device;
    let texture = device.create_texture(&TextureDescriptor {
        label: None,
        size: Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: TextureFormat::Depth32Float,
        usage: TextureUsages::RENDER_ATTACHMENT
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let module = device.create_shader_module(ShaderModuleDescriptor {
        label: None,
        source: ShaderSource::Wgsl(DEPTHS.into()),
    });
    let pipeline = device.create_render_pipeline(&RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        fragment: Some(FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[],
        }),
        primitive: PrimitiveState::default(),
        depth_stencil: Some(DepthStencilState {
            format: TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        multiview_mask: None,
        cache: None,
    });
    let view = texture.create_view(&Default::default());
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
        label: None,
        color_attachments: &[],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: &view,
            depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Store }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    pass.set_pipeline(&pipeline);
    pass.draw(0..3, 0..1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    texture
}

#[test]
fn levels_are_halved_down_to_one_texel() {
    let sizes = |size| level_sizes(size).collect::<Vec<_>>();
    assert_eq!(sizes([1, 1]), [[1, 1]]);
    assert_eq!(sizes([0, 0]), [[1, 1]]);
    assert_eq!(sizes([5, 2]), [[3, 1], [2, 1], [1, 1]]);
    assert_eq!(sizes([1333, 751])[..2], [[667, 376], [334, 188]]);
    assert_eq!(sizes([1333, 751]).last(), Some(&[1, 1]));
}

#[test]
fn each_texel_is_the_farthest_of_its_pixels() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let pass = Passes::new(&gpu.device).unwrap().pyramid;
    let sizes =
        [[1, 1], [1, 9], [2, 2], [3, 3], [64, 64], [65, 63], [333, 187], [479, 269], [640, 360]];
    for size in sizes {
        let depth = depths(gpu, size);
        let pyramid = Pyramid::new(&gpu.device, &pass, &depth).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        pass.record(&mut encoder, &pyramid);
        gpu.queue.submit([encoder.finish()]);
        let pixels: Vec<f32> = texels(gpu, &depth, 0, size);
        assert!(pixels.iter().all(|d| (0.0..=1.0).contains(d)));
        let expected = pyramid_ref(&pixels, size);
        assert_eq!(expected.len(), pyramid.sizes().len());
        for (level, (expected, &of_level)) in expected.iter().zip(pyramid.sizes()).enumerate() {
            let found: Vec<f32> = texels(gpu, pyramid.texture(), level as u32, of_level);
            assert!(&found == expected, "level {level} of {size:?}");
        }
        let least = pixels.iter().copied().fold(1.0, f32::min);
        assert_eq!(expected.last(), Some(&vec![least]));
    }
}
