//! Drawing without a window: pictures read back from a device.

use cullet_gpu::GpuError;
use eframe::wgpu::{
    BufferDescriptor, BufferUsages, COPY_BYTES_PER_ROW_ALIGNMENT, TexelCopyBufferInfo,
    TexelCopyBufferLayout,
};

use crate::draw::Renderer;

pub use cullet_gpu::Gpu;

/// The renderer's picture, when it is finished: width, height and RGBA.
///
/// # Errors
/// If the device is lost, or has no memory left for a copy.
pub fn picture(gpu: &Gpu, renderer: &Renderer) -> Result<([u32; 2], Vec<[u8; 4]>), GpuError> {
    let texture = renderer.colour().texture();
    let size = [texture.width(), texture.height()];
    let row = (size[0] * 4).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&BufferDescriptor {
        label: Some("picture"),
        size: u64::from(row) * u64::from(size[1]),
        usage: BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let layout =
        TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        TexelCopyBufferInfo { buffer: &buffer, layout },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read(&buffer, buffer.size())?;
    let rows = bytes.chunks_exact(row as usize);
    let pixels = rows.flat_map(|r| r[..size[0] as usize * 4].as_chunks::<4>().0).copied();
    Ok((size, pixels.collect()))
}
