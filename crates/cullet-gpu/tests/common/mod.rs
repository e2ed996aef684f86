//! A device for tests, and what lies on it.

#[allow(dead_code, reason = "not every test draws frames")]
pub(crate) mod stage;

use bytemuck::Pod;
use cullet_gpu::{Gpu, Tier};
use wgpu::*;

/// A device of a tier; skips, aloud, without one.
pub(crate) fn gpu(least: Tier) -> Option<&'static Gpu> {
    cullet_gpu::testing::device(least, cullet_testkit::skip)
}

/// The texels of one level of a texture, four bytes each, row by row.
#[allow(dead_code, reason = "not every test looks at textures")]
pub(crate) fn texels<T: Pod>(
    gpu: &Gpu,
    texture: &Texture,
    level: u32,
    [width, height]: [u32; 2],
) -> Vec<T> {
    let row = (width * 4).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
    let bytes = u64::from(row) * u64::from(height);
    let buffer = gpu.device.create_buffer(&BufferDescriptor {
        label: None,
        size: bytes,
        usage: BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let layout =
        TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let from = TexelCopyTextureInfo { mip_level: level, ..texture.as_image_copy() };
    let size = Extent3d { width, height, depth_or_array_layers: 1 };
    encoder.copy_texture_to_buffer(from, TexelCopyBufferInfo { buffer: &buffer, layout }, size);
    gpu.queue.submit([encoder.finish()]);
    let all = gpu.read(&buffer, bytes).unwrap();
    let rows = all.chunks_exact(row as usize);
    rows.flat_map(|r| bytemuck::pod_collect_to_vec::<u8, T>(&r[..width as usize * 4])).collect()
}
