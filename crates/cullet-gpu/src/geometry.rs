//! The triangles and places of a scene on a device.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use cullet::mesh::Alpha;
use cullet::{Mesh, Scene, Transform};
use wgpu::{Buffer, BufferUsages, Device, Queue};

use super::buffers::buffer;
use super::error::GpuError;
use super::lanes::{Kind, Lanes};
use super::lists::DrawArguments;

/// Triangles of a mesh that are drawn in one way, and follow each other.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Run {
    indices: Range<u32>,
    two_sided: bool,
    blended: bool,
}

/// Where the mesh of a scene lies.
#[derive(Clone, Debug, Default)]
struct MeshPlace {
    first_vertex: u32,
    first_index: u32,
    runs: Vec<Run>,
}

/// One draw of one bucket: what a program needs to know to choose a pipeline for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// The bucket's number.
    pub bucket: u32,
    /// How its instances are drawn.
    pub kind: Kind,
    /// Whether both sides of its triangles are drawn.
    pub two_sided: bool,
    /// Whether they are blended: drawn last, and hiding nothing.
    pub blended: bool,
    /// Draw arguments, except for the instance count.
    pub arguments: DrawArguments,
}

impl Draw {
    /// Returns the properties that a pipeline depends on.
    pub(crate) fn way(&self) -> [bool; 3] {
        [self.blended, self.two_sided, self.kind.mirrored]
    }
}

/// Where an instance is, as shaders take it: 64 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Place {
    /// Rows of the linear part, each with the high half of the translation.
    pub rows: [[f32; 4]; 3],
    /// The translation's low half, so that far from the origin nothing jitters.
    pub low: [f32; 4],
}

impl Place {
    /// The place of a transform.
    #[must_use]
    pub fn new(transform: &Transform) -> Self {
        let Transform { linear, translation } = transform;
        let [high, low] = halves(translation);
        let row = |r: usize| [linear[0][r], linear[1][r], linear[2][r], high[r]];
        Self { rows: [0, 1, 2].map(row), low: [low[0], low[1], low[2], 0.0] }
    }
}

/// A point as the sum of two f32 numbers a coordinate.
pub(crate) fn halves(point: &[f64; 3]) -> [[f32; 3]; 2] {
    let high = point.map(|v| v as f32);
    [high, std::array::from_fn(|a| (point[a] - f64::from(high[a])) as f32)]
}

/// Meshes and places of a scene on a device.
#[derive(Debug)]
pub struct GpuScene {
    vertices: Buffer,
    indices: Buffer,
    places: Buffer,
    /// Place of each slot, as uploaded.
    known: Vec<Place>,
    meshes: Vec<MeshPlace>,
    uploaded: u64,
}

impl GpuScene {
    /// Uploads meshes and instances. O(triangles + slots).
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(device: &Device, queue: &Queue, scene: &Scene) -> Result<Self, GpuError> {
        let (mut vertices, mut indices) = (Vec::<[f32; 3]>::new(), Vec::<u32>::new());
        let mut meshes = Vec::new();
        for mesh in scene.meshes() {
            let first_index = indices.len() as u32;
            meshes.push(MeshPlace {
                first_vertex: vertices.len() as u32,
                first_index,
                runs: runs(mesh, first_index),
            });
            vertices.extend(mesh.positions());
            indices.extend(mesh.indices());
        }
        let written = BufferUsages::COPY_DST;
        let known: Vec<Place> = (0..scene.slot_count()).map(|slot| place(scene, slot)).collect();
        let (position, number, of_slot) = (12, 4, size_of::<Place>());
        let on_device =
            |what, count, size, usage| buffer(device, what, count, size, usage | written);
        let made = Self {
            vertices: on_device("vertices", vertices.len(), position, BufferUsages::VERTEX)?,
            indices: on_device("indices", indices.len(), number, BufferUsages::INDEX)?,
            places: on_device("places", known.len(), of_slot, BufferUsages::STORAGE)?,
            meshes,
            uploaded: (vertices.len() * position + indices.len() * number + known.len() * of_slot)
                as u64,
            known,
        };
        queue.write_buffer(&made.vertices, 0, bytemuck::cast_slice(&vertices));
        queue.write_buffer(&made.indices, 0, bytemuck::cast_slice(&indices));
        queue.write_buffer(&made.places, 0, bytemuck::cast_slice(&made.known));
        Ok(made)
    }

    /// Uploads the places that changed, with few others between them; false where the scene has
    /// more or fewer slots than before. O(slots) reading.
    #[must_use]
    pub fn update(&mut self, queue: &Queue, scene: &Scene) -> bool {
        /// So many slots are looked at together.
        const RUN: usize = 64;
        self.uploaded = 0;
        if scene.slot_count() as usize != self.known.len() {
            return false;
        }
        for (number, known) in self.known.chunks_mut(RUN).enumerate() {
            let first = number * RUN;
            let mut differs = false;
            for (slot, known) in (first as u32..).zip(known.iter_mut()) {
                let own = place(scene, slot);
                // Compared by their bits: a transform that is not a number is what it was.
                differs |= bytemuck::bytes_of(&own) != bytemuck::bytes_of(known);
                *known = own;
            }
            if differs {
                let bytes: &[u8] = bytemuck::cast_slice(known);
                queue.write_buffer(&self.places, (first * size_of::<Place>()) as u64, bytes);
                self.uploaded += bytes.len() as u64;
            }
        }
        true
    }

    /// The draws of some lanes: for each bucket one a run of its mesh, those that are alike one
    /// after the other.
    #[must_use]
    pub fn draws(&self, lanes: &Lanes) -> Vec<Draw> {
        let of_bucket = |(bucket, own): (u32, &super::lanes::Bucket)| {
            let kind = own.kind;
            let place = &self.meshes[kind.mesh as usize];
            place.runs.iter().map(move |run| Draw {
                bucket,
                kind,
                two_sided: run.two_sided || kind.two_sided,
                blended: run.blended || kind.transparent,
                arguments: DrawArguments {
                    index_count: run.indices.end - run.indices.start,
                    first_index: run.indices.start,
                    base_vertex: place.first_vertex as i32,
                    ..DrawArguments::default()
                },
            })
        };
        let mut draws: Vec<Draw> = (0..).zip(lanes.buckets()).flat_map(of_bucket).collect();
        draws.sort_by_key(Draw::way);
        draws
    }

    /// The draw of one cluster of an instance of some kind.
    pub(crate) fn draw_of_cluster(&self, scene: &Scene, kind: Kind, cluster: u32) -> Draw {
        let (mesh, place) = (&scene.meshes()[kind.mesh as usize], &self.meshes[kind.mesh as usize]);
        let own = &mesh.clusters()[cluster as usize];
        let part = mesh.parts().get(own.part as usize).copied().unwrap_or_default();
        let indices = own.triangles();
        Draw {
            bucket: 0,
            kind,
            two_sided: part.two_sided || kind.two_sided,
            blended: part.alpha == Alpha::Blended || kind.transparent,
            arguments: DrawArguments {
                index_count: (indices.end - indices.start) * 3,
                first_index: place.first_index + indices.start * 3,
                base_vertex: place.first_vertex as i32,
                ..DrawArguments::default()
            },
        }
    }

    /// Vertices: three f32 each.
    #[must_use]
    pub fn vertices(&self) -> &Buffer {
        &self.vertices
    }

    /// Indices, u32 each, from the vertices of their mesh on.
    #[must_use]
    pub fn indices(&self) -> &Buffer {
        &self.indices
    }

    /// A [`Place`] for each slot.
    #[must_use]
    pub fn places(&self) -> &Buffer {
        &self.places
    }

    /// Bytes that were uploaded the last time.
    #[must_use]
    pub fn uploaded(&self) -> u64 {
        self.uploaded
    }
}

fn place(scene: &Scene, slot: u32) -> Place {
    if scene.is_removed(slot) { Place::default() } else { Place::new(scene.transform(slot)) }
}

/// Clusters of a mesh, joined where they are drawn in one way.
fn runs(mesh: &Mesh, first_index: u32) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for cluster in mesh.clusters() {
        let part = mesh.parts().get(cluster.part as usize).copied().unwrap_or_default();
        let (two_sided, blended) = (part.two_sided, part.alpha == Alpha::Blended);
        let own = cluster.triangles();
        let end = first_index + own.end * 3;
        match runs.last_mut() {
            Some(run) if (run.two_sided, run.blended) == (two_sided, blended) => {
                run.indices.end = end;
            }
            _ => {
                let indices = first_index + own.start * 3..end;
                runs.push(Run { indices, two_sided, blended });
            }
        }
    }
    runs
}
