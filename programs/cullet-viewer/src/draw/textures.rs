//! Lists held in textures, since WebGL2 has no storage buffers.

use eframe::wgpu::*;

use super::geometry::list_width;

/// A list of texels in a texture, row by row.
#[derive(Debug)]
pub(super) struct ListTexture {
    texture: Texture,
    pub(super) view: TextureView,
    width: u32,
}

impl ListTexture {
    /// A texture for so many texels, at least one; the caller has checked that they fit.
    pub(super) fn new(device: &Device, label: &str, format: TextureFormat, len: usize) -> Self {
        let width = list_width(device.limits().max_texture_dimension_2d);
        let rows = len.div_ceil(width as usize).max(1) as u32;
        let texture = device.create_texture(&TextureDescriptor {
            label: Some(label),
            size: Extent3d { width, height: rows, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&TextureViewDescriptor::default());
        Self { texture, view, width }
    }

    /// Writes texels from the start; those beyond the texture are left out. Returns the bytes
    /// written.
    pub(super) fn write<T: bytemuck::Pod>(&self, queue: &Queue, texels: &[T]) -> u64 {
        let most = self.width() * self.texture.height() as usize;
        self.write_from(queue, 0, &texels[..texels.len().min(most)])
    }

    /// How many texels a row has.
    pub(super) fn width(&self) -> usize {
        self.width as usize
    }

    /// Writes texels from the beginning of a row on. Returns the bytes written.
    pub(super) fn write_from<T: bytemuck::Pod>(
        &self,
        queue: &Queue,
        row: usize,
        texels: &[T],
    ) -> u64 {
        let whole = texels.len() / self.width();
        let (rows, rest) = texels.split_at(whole * self.width());
        self.write_rows(queue, rows, row as u32, self.width, whole as u32);
        self.write_rows(queue, rest, (row + whole) as u32, rest.len() as u32, 1);
        size_of_val(texels) as u64
    }

    fn write_rows<T: bytemuck::Pod>(
        &self,
        queue: &Queue,
        texels: &[T],
        row: u32,
        width: u32,
        rows: u32,
    ) {
        if texels.is_empty() {
            return;
        }
        queue.write_texture(
            TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: 0,
                origin: Origin3d { x: 0, y: row, z: 0 },
                aspect: TextureAspect::All,
            },
            bytemuck::cast_slice(texels),
            TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * size_of::<T>() as u32),
                rows_per_image: None,
            },
            Extent3d { width, height: rows, depth_or_array_layers: 1 },
        );
    }
}

/// The textures that are drawn into, of the requested size and number of samples.
#[derive(Debug)]
pub(super) struct Target {
    pub(super) size: [u32; 2],
    pub(super) samples: u32,
    /// Shown by others; a single sample.
    pub(super) colour: TextureView,
    /// Where there are several samples a pixel.
    pub(super) many: Option<TextureView>,
    pub(super) depth: TextureView,
}

/// The format of the picture.
pub(super) const COLOUR: TextureFormat = TextureFormat::Rgba8UnormSrgb;
/// The format of its depth.
pub(super) const DEPTH: TextureFormat = TextureFormat::Depth32Float;

impl Target {
    pub(super) fn new(device: &Device, size: [u32; 2], samples: u32) -> Self {
        let make = |label, format, sample_count, usage| {
            let texture = device.create_texture(&TextureDescriptor {
                label: Some(label),
                size: Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: TextureDimension::D2,
                format,
                usage: usage | TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&TextureViewDescriptor::default())
        };
        let shown = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
        let none = TextureUsages::empty();
        Self {
            size,
            samples,
            colour: make("picture", COLOUR, 1, shown),
            many: (samples > 1).then(|| make("samples of the picture", COLOUR, samples, none)),
            depth: make("depth", DEPTH, samples, none),
        }
    }
}

/// A buffer that grows to what is written to it.
#[derive(Debug)]
pub(super) struct GrowingBuffer {
    pub(super) buffer: Buffer,
    label: &'static str,
    usage: BufferUsages,
}

impl GrowingBuffer {
    pub(super) fn new(device: &Device, label: &'static str, usage: BufferUsages) -> Self {
        let usage = usage | BufferUsages::COPY_DST;
        Self { buffer: Self::make(device, label, usage, 1024), label, usage }
    }

    fn make(device: &Device, label: &'static str, usage: BufferUsages, size: u64) -> Buffer {
        device.create_buffer(&BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Makes room for so many bytes, where the device can; true if the buffer is another one now,
    /// and holds nothing.
    pub(super) fn reserve(&mut self, device: &Device, bytes: u64) -> bool {
        if bytes <= self.buffer.size() {
            return false;
        }
        let size = bytes.next_power_of_two().min(device.limits().max_buffer_size).max(bytes);
        self.buffer = Self::make(device, self.label, self.usage, size);
        true
    }

    /// Writes from the start. Returns the bytes written.
    pub(super) fn write<T: bytemuck::Pod>(
        &mut self,
        device: &Device,
        queue: &Queue,
        data: &[T],
    ) -> u64 {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        self.reserve(device, bytes.len() as u64);
        if !bytes.is_empty() {
            queue.write_buffer(&self.buffer, 0, bytes);
        }
        bytes.len() as u64
    }
}
