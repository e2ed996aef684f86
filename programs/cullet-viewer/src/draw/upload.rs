//! A scene on the device.

use std::ops::Range;

use cullet::{Scene, Transform};
use cullet_io::Model;
use eframe::wgpu::util::{BufferInitDescriptor, DeviceExt};
use eframe::wgpu::*;

use super::error::DrawError;
use super::geometry::{ChunkData, Geometry, Room, vertex_normals};
use super::groups::{Grouping, Instances};
use super::textures::ListTexture;

/// Buffers that meshes share, and what is made of them at the first request.
#[derive(Debug)]
pub(super) struct Chunk {
    pub(super) vertices: Buffer,
    pub(super) indices: Buffer,
    /// Vertices and indices in textures, for shaders that look at whole triangles.
    pulled: Option<[ListTexture; 2]>,
    normals: Option<ListTexture>,
    group: Option<BindGroup>,
}

/// All of a scene that lies on the device.
#[derive(Debug)]
pub(super) struct Uploaded {
    pub(super) geometry: Geometry,
    pub(super) instances: Instances,
    pub(super) chunks: Vec<Chunk>,
    pub(super) transforms: ListTexture,
    pub(super) parts: ListTexture,
    pub(super) colours: ListTexture,
    /// Texels and table of the impostors, if there are any.
    impostors: Option<[ListTexture; 2]>,
    impostor_group: Option<BindGroup>,
    /// Half the diagonal of the scene.
    pub(super) radius: f32,
    /// Bytes written since the last frame.
    pub(super) uploaded: u64,
}

/// Texels that a slot's transform takes.
const TEXELS: usize = 4;

/// A scene on its way to the device.
#[derive(Debug)]
pub(super) struct Upload {
    new: Uploaded,
    grouping: Grouping,
    /// The first slot that is not there yet.
    next: u32,
}

/// Rows of transforms that are uploaded in one step: 1 MiB.
const ROWS: usize = 16;

impl Upload {
    /// Uploads what is not of instances.
    pub(super) fn begin(device: &Device, queue: &Queue, model: &Model) -> Result<Self, DrawError> {
        let room = Room::of(&device.limits());
        let scene = &model.scene;
        let (count, limit) = (u64::from(scene.slot_count()), room.texels() / TEXELS as u64);
        if count > limit {
            return Err(DrawError::Texture { what: "instances", count, limit, side: room.side });
        }
        let geometry = Geometry::new(model, room)?;
        let float = TextureFormat::Rgba32Float;
        let texture = |label, format, len| ListTexture::new(device, label, format, len);
        let colour = TextureFormat::Rgba8UnormSrgb;
        let slots = scene.slot_count() as usize;
        let extent = scene.extent();
        let impostors = &geometry.impostors;
        let impostors = (!impostors.texels.is_empty()).then(|| {
            [
                texture("texels of impostors", TextureFormat::R32Uint, impostors.texels.len()),
                texture("impostors", float, impostors.table.len()),
            ]
        });
        let mut new = Uploaded {
            impostors,
            impostor_group: None,
            instances: Instances::default(),
            chunks: geometry.chunks.iter().map(|c| Chunk::new(device, c)).collect(),
            transforms: texture("transforms", float, slots * TEXELS),
            parts: texture("parts", float, geometry.parts.len()),
            colours: texture("colours of instances", colour, slots),
            radius: if extent.is_empty() {
                1.0
            } else {
                (glam::DVec3::from(extent.half_extent()).length() as f32).max(f32::MIN_POSITIVE)
            },
            geometry,
            uploaded: 0,
        };
        new.uploaded += new.parts.write(queue, &new.geometry.parts);
        if let Some([texels, table]) = &new.impostors {
            new.uploaded += texels.write(queue, &new.geometry.impostors.texels);
            new.uploaded += table.write(queue, &new.geometry.impostors.table);
            // They lie on the device now.
            new.geometry.impostors.texels = Vec::new();
        }
        let bytes = |c: &Chunk| c.vertices.size() + c.indices.size();
        new.uploaded += new.chunks.iter().map(bytes).sum::<u64>();
        Ok(Self { new, grouping: Grouping::new(scene), next: 0 })
    }

    /// Uploads some instances of the scene that it was begun with; true when all are there.
    pub(super) fn step(&mut self, queue: &Queue, scene: &Scene) -> bool {
        let new = &mut self.new;
        let first = self.next as usize;
        let end = (first + ROWS * new.transforms.width() / TEXELS).min(scene.slot_count() as usize);
        let slots = self.next..end as u32;
        let texels = transforms(scene, slots.clone());
        let row = first * TEXELS / new.transforms.width();
        new.uploaded += new.transforms.write_from(queue, row, &texels);
        let grey = vec![[0xA0, 0xA0, 0xA0, 0xFF_u8]; slots.len()];
        new.uploaded += new.colours.write_from(queue, first / new.colours.width(), &grey);
        self.grouping.add(scene, slots);
        self.next = end as u32;
        self.next == scene.slot_count()
    }

    /// The scene that it was begun with, once all of it is there.
    pub(super) fn finish(self, scene: &Scene) -> Uploaded {
        Uploaded { instances: self.grouping.finish(scene), ..self.new }
    }
}

impl Uploaded {
    /// The impostors' textures, once they were [made ready](Self::prepare_impostors); `None` where
    /// there are none.
    pub(super) fn impostors(&self) -> Option<&BindGroup> {
        self.impostor_group.as_ref()
    }

    /// Makes ready what the shader of impostors needs, if there are any.
    pub(super) fn prepare_impostors(&mut self, device: &Device, layout: &BindGroupLayout) {
        if let (Some([texels, table]), None) = (&self.impostors, &self.impostor_group) {
            let [texels, table] = [(3, &texels.view), (4, &table.view)].map(|(binding, view)| {
                BindGroupEntry { binding, resource: BindingResource::TextureView(view) }
            });
            self.impostor_group = Some(device.create_bind_group(&BindGroupDescriptor {
                label: Some("impostors"),
                layout,
                entries: &[texels, table],
            }));
        }
    }

    /// Makes ready what shaders need that look at whole triangles, or at the normals of vertices.
    pub(super) fn prepare(
        &mut self,
        device: &Device,
        queue: &Queue,
        layout: &BindGroupLayout,
        normals: bool,
    ) {
        for (chunk, data) in self.chunks.iter_mut().zip(&self.geometry.chunks) {
            self.uploaded += chunk.prepare(device, queue, layout, data, normals);
        }
    }
}

impl Chunk {
    fn new(device: &Device, data: &ChunkData) -> Self {
        let buffer = |label, contents, usage| {
            device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
        };
        Self {
            vertices: buffer(
                "vertices",
                bytemuck::cast_slice(&data.vertices),
                BufferUsages::VERTEX,
            ),
            indices: buffer("indices", bytemuck::cast_slice(&data.indices), BufferUsages::INDEX),
            pulled: None,
            normals: None,
            group: None,
        }
    }

    /// The textures of the chunk, once they were [prepared](Uploaded::prepare).
    pub(super) fn group(&self) -> Option<&BindGroup> {
        self.group.as_ref()
    }

    fn prepare(
        &mut self,
        device: &Device,
        queue: &Queue,
        layout: &BindGroupLayout,
        data: &ChunkData,
        normals: bool,
    ) -> u64 {
        if self.group.is_some() && (self.normals.is_some() || !normals) {
            return 0;
        }
        let mut uploaded = 0;
        let mut texture = |label, format, bytes: &[u8], texel: usize| {
            let texture = ListTexture::new(device, label, format, bytes.len() / texel);
            uploaded += match texel {
                4 => texture.write(queue, bytemuck::cast_slice::<u8, [u8; 4]>(bytes)),
                _ => texture.write(queue, bytemuck::cast_slice::<u8, [u8; 16]>(bytes)),
            };
            texture
        };
        let pulled = self.pulled.get_or_insert_with(|| {
            let (vertices, indices) = (&data.vertices, &data.indices);
            [
                texture("corners", TextureFormat::Rgba32Uint, bytemuck::cast_slice(vertices), 16),
                texture(
                    "indices to pull",
                    TextureFormat::R32Uint,
                    bytemuck::cast_slice(indices),
                    4,
                ),
            ]
        });
        if normals && self.normals.is_none() {
            let all = vertex_normals(data);
            let format = TextureFormat::Rgba32Float;
            self.normals = Some(texture("normals", format, bytemuck::cast_slice(&all), 16));
        }
        let none = ListTexture::new(device, "no normals", TextureFormat::Rgba32Float, 1);
        let views =
            [&pulled[0].view, &pulled[1].view, &self.normals.as_ref().unwrap_or(&none).view];
        let entries: Vec<BindGroupEntry<'_>> = (0..)
            .zip(views)
            .map(|(binding, v)| BindGroupEntry {
                binding,
                resource: BindingResource::TextureView(v),
            })
            .collect();
        let label = Some("chunk");
        self.group = Some(device.create_bind_group(&BindGroupDescriptor {
            label,
            layout,
            entries: &entries,
        }));
        uploaded
    }
}

/// Four texels a slot: rows of the linear part, each with the high part of the translation, and the
/// low part with the hand: −1 where the instance is mirrored, doubled where it is transparent.
fn transforms(scene: &Scene, slots: Range<u32>) -> Vec<[f32; 4]> {
    let mut texels = Vec::with_capacity(slots.len() * TEXELS);
    for slot in slots {
        let Transform { linear, translation } = scene.transform(slot);
        let high = translation.map(|v| v as f32);
        for row in 0..3 {
            texels.push([linear[0][row], linear[1][row], linear[2][row], high[row]]);
        }
        let hand = if scene.transform(slot).determinant() < 0.0 { -1.0 } else { 1.0 };
        let hand = if scene.flags(slot).transparent { hand * 2.0 } else { hand };
        let [x, y, z] = split(translation)[1];
        texels.push([x, y, z, hand]);
    }
    texels
}

/// A place as the sum of two f32 numbers a coordinate.
pub(super) fn split(place: &[f64; 3]) -> [[f32; 3]; 2] {
    let high = place.map(|v| v as f32);
    [high, std::array::from_fn(|a| (place[a] - f64::from(high[a])) as f32)]
}
