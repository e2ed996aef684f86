//! Meshes as they are drawn: vertices and indices of many meshes in a few buffers, and where in
//! them each mesh, part and cluster lies. Pure computation: nothing here needs a device.

use std::ops::Range;

use cullet::mesh::Alpha;
use cullet::{Mesh, Scene};
use cullet_draw::palette;
use cullet_io::Model;
use eframe::wgpu::Limits;

use super::error::DrawError;
use super::frame::LEVELS;
use super::impostors::{Boxes, Impostors};

/// A vertex of a cluster.
///
/// Every cluster has vertices of its own, so all corners of a triangle agree on `key`: which corner
/// it is that speaks for a triangle differs between WebGPU and OpenGL, and here it does not matter.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Vertex {
    pub(super) position: [f32; 3],
    /// The part, counted through all meshes, and in the low byte the cluster; of the box of an
    /// impostor its [heading](Boxes::heading).
    pub(super) key: u32,
}

/// Parts of all meshes at the most: what is left of a vertex's key.
const MAX_PARTS: u64 = 1 << 24;

/// How wide textures that hold lists are: a power of two, so that a place is a mask and a shift.
pub(super) const fn list_width(max_side: u32) -> u32 {
    if max_side >= 4096 { 4096 } else { 2048 }
}

/// Limits of a device.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    /// Largest buffer, in bytes.
    pub(super) buffer: u64,
    /// Largest side of a texture.
    pub(super) side: u32,
}

impl Room {
    pub(super) fn of(limits: &Limits) -> Self {
        Self { buffer: limits.max_buffer_size, side: limits.max_texture_dimension_2d }
    }

    /// How many texels a list in a texture has at the most.
    pub(super) fn texels(&self) -> u64 {
        u64::from(list_width(self.side)) * u64::from(self.side)
    }

    /// How many elements of so many bytes fit both a buffer and, one a texel, a texture.
    fn elements(&self, bytes: u64) -> u64 {
        (self.buffer / bytes).min(self.texels()).min(u64::from(u32::MAX))
    }
}

/// Triangles, successive in the mesh's order, that are drawn in one way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) triangles: Range<u32>,
    pub(super) two_sided: bool,
    pub(super) blended: bool,
}

/// Where a mesh lies.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshPlace {
    pub(super) chunk: u32,
    /// The chunk's triangle that is the mesh's first.
    pub(super) first_triangle: u32,
    /// Triangles of the finest level.
    pub(super) whole: u32,
    /// Ranges of one way of drawing, covering all clusters.
    pub(super) runs: Vec<Run>,
    /// For each cluster, and for the end, its first triangle, and the chunk's vertex that is its
    /// first.
    clusters: Vec<[u32; 2]>,
}

impl MeshPlace {
    /// The triangles of some clusters; those that do not exist are left out.
    pub(super) fn triangles(&self, first_cluster: u32, count: u32) -> Range<u32> {
        let last = self.clusters.len().saturating_sub(1);
        let first = (first_cluster as usize).min(last);
        let end = first.saturating_add(count as usize).min(last);
        match (self.clusters.get(first), self.clusters.get(end)) {
            (Some(a), Some(b)) => a[0]..b[0],
            _ => 0..0,
        }
    }

    /// The chunk's vertices of the clusters that a range of triangles touches.
    pub(super) fn vertices(&self, triangles: &Range<u32>) -> Range<u32> {
        if triangles.is_empty() || self.clusters.is_empty() {
            return 0..0;
        }
        let first = self.clusters.partition_point(|c| c[0] <= triangles.start).saturating_sub(1);
        let end = self.clusters.partition_point(|c| c[0] < triangles.end);
        self.clusters[first][1]..self.clusters[end.min(self.clusters.len() - 1)][1]
    }
}

/// Vertices and indices that share a pair of buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct ChunkData {
    pub(super) vertices: Vec<Vertex>,
    /// Three vertices of this chunk a triangle.
    pub(super) indices: Vec<u32>,
    /// For each mesh of the chunk, its first vertex; normals are smooth within a mesh alone.
    mesh_starts: Vec<u32>,
}

/// All meshes of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Geometry {
    pub(super) chunks: Vec<ChunkData>,
    pub(super) meshes: Vec<MeshPlace>,
    /// Linear colour of every part of every mesh, and its alpha and twice the number of its level
    /// of detail. A part that has triangles of several levels has one entry for each, one after the
    /// other.
    pub(super) parts: Vec<[f32; 4]>,
    /// Impostors that are drawn in place of the meshes that are their boxes.
    pub(super) impostors: Impostors,
}

impl Geometry {
    /// Lays out the meshes of a model. O(triangles); some 25 bytes a triangle stay in memory beside
    /// what goes to the device, for lists of triangles and for normals.
    pub(super) fn new(model: &Model, room: Room) -> Result<Self, DrawError> {
        let mut all = Self::default();
        let meshes = model.scene.meshes();
        let steps = level_steps(&model.scene);
        let entries = |(mesh, steps): (&Mesh, &Vec<u32>)| {
            mesh.parts().len() as u64 * u64::from(levels_of(steps))
        };
        let parts: u64 = meshes.iter().zip(&steps).map(entries).sum();
        let limit = room.texels().min(MAX_PARTS);
        if parts > limit {
            return Err(DrawError::Texture { what: "parts", count: parts, limit, side: room.side });
        }
        let boxes = Boxes::of(&model.scene);
        for (what, count) in boxes.counts() {
            if count > room.texels() {
                let limit = room.texels();
                return Err(DrawError::Texture { what, count, limit, side: room.side });
            }
        }
        let (mut local, mut part_places) = (Vec::new(), Vec::new());
        for (number, steps) in steps.iter().enumerate() {
            part_places.push([all.parts.len() as u32, levels_of(steps)]);
            let heading = boxes.heading(number as u32);
            all.add(model, number, (steps, heading), room, &mut local)?;
        }
        all.impostors = Impostors::new(&model.scene, boxes, &part_places);
        Ok(all)
    }

    fn add(
        &mut self,
        model: &Model,
        number: usize,
        (steps, heading): (&[u32], Option<u32>),
        room: Room,
        local: &mut Vec<u32>,
    ) -> Result<(), DrawError> {
        let mesh = &model.scene.meshes()[number];
        let first_part = self.parts.len() as u32;
        let levels = levels_of(steps);
        self.parts.extend(mesh.parts().iter().flat_map(|part| {
            let given = model.materials.get(part.material as usize).map(|m| m.color);
            let [r, g, b, a] = given.unwrap_or_else(|| {
                let colour = palette::material_color(part.material.wrapping_add(number as u32));
                let [r, g, b] = colour.map(linear);
                [r, g, b, 1.0]
            });
            (0..levels).map(move |step| [r, g, b, a.clamp(0.0, 1.0) + 2.0 * step as f32])
        }));
        let entry = |cluster: usize, part: u32| {
            let step = steps.get(cluster).map_or(0, |&step| step.min(LEVELS - 1));
            first_part + part * levels + step
        };
        let (mut vertices, indices, clusters) = cut(mesh, entry, local);
        if let Some(heading) = heading {
            vertices.iter_mut().for_each(|v| v.key = heading);
        }
        let name = || model.mesh_names.get(number).cloned().unwrap_or_default();
        let (most_vertices, most_indices) = (room.elements(16), room.elements(4));
        for (what, count, limit, bytes) in [
            ("vertices", vertices.len() as u64, most_vertices, 16),
            ("indices", indices.len() as u64, most_indices, 4),
        ] {
            if count > limit {
                let cause = if room.buffer / bytes <= limit {
                    "max_buffer_size"
                } else {
                    "max_texture_dimension_2d"
                };
                return Err(DrawError::Mesh {
                    mesh: number,
                    name: name(),
                    what,
                    count,
                    limit,
                    cause,
                });
            }
        }
        let fits = |c: &ChunkData| {
            (c.vertices.len() + vertices.len()) as u64 <= most_vertices
                && (c.indices.len() + indices.len()) as u64 <= most_indices
        };
        if !self.chunks.last().is_some_and(fits) {
            self.chunks.push(ChunkData::default());
        }
        let at = self.chunks.len() - 1;
        let chunk = &mut self.chunks[at];
        let first_vertex = chunk.vertices.len() as u32;
        let mut place = MeshPlace {
            chunk: at as u32,
            first_triangle: (chunk.indices.len() / 3) as u32,
            whole: 0,
            runs: runs(mesh),
            clusters: clusters.into_iter().map(|[t, v]| [t, v + first_vertex]).collect(),
        };
        place.whole = place.triangles(0, mesh.cluster_count()).end;
        chunk.mesh_starts.push(first_vertex);
        chunk.vertices.extend(vertices);
        chunk.indices.extend(indices.into_iter().map(|i| i + first_vertex));
        self.meshes.push(place);
        Ok(())
    }
}

/// For each mesh that holds levels of others, the step of each of its clusters; nothing for the
/// rest.
fn level_steps(scene: &Scene) -> Vec<Vec<u32>> {
    let mut steps = vec![Vec::new(); scene.meshes().len()];
    for mesh in 0..scene.meshes().len() as u32 {
        for levels in scene.levels(mesh) {
            let of = &mut steps[levels.mesh as usize];
            if of.is_empty() {
                *of = levels.levels.steps();
            }
        }
    }
    steps
}

/// How many entries each part of a mesh has, whose clusters are of these steps.
fn levels_of(steps: &[u32]) -> u32 {
    steps.iter().max().map_or(1, |&most| most.min(LEVELS - 1) + 1)
}

/// The vertices and indices of a mesh's clusters, in the mesh's order, and where each cluster
/// starts. `entry` is that of a cluster of a part in the list of parts; `local` is scratch.
fn cut(
    mesh: &Mesh,
    entry: impl Fn(usize, u32) -> u32,
    local: &mut Vec<u32>,
) -> (Vec<Vertex>, Vec<u32>, Vec<[u32; 2]>) {
    const NONE: u32 = u32::MAX;
    local.clear();
    local.resize(mesh.positions().len(), NONE);
    let mut vertices: Vec<Vertex> = Vec::with_capacity(mesh.positions().len());
    let mut indices = Vec::with_capacity(mesh.indices().len());
    let mut clusters = Vec::with_capacity(mesh.clusters().len() + 1);
    for (number, cluster) in mesh.clusters().iter().enumerate() {
        clusters.push([cluster.first_triangle, vertices.len() as u32]);
        let start = vertices.len() as u32;
        let key = entry(number, cluster.part) << 8 | (number as u32 & 0xFF);
        for t in cluster.triangles() {
            for v in mesh.triangle(t) {
                let own = &mut local[v as usize];
                // A number from before this cluster is another cluster's vertex.
                if *own == NONE || *own < start {
                    *own = vertices.len() as u32;
                    vertices.push(Vertex { position: mesh.positions()[v as usize], key });
                }
                indices.push(*own);
            }
        }
    }
    clusters.push([(indices.len() / 3) as u32, vertices.len() as u32]);
    (vertices, indices, clusters)
}

/// Clusters of one sidedness and one alpha, joined.
fn runs(mesh: &Mesh) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for cluster in mesh.clusters() {
        let part = mesh.parts().get(cluster.part as usize).copied().unwrap_or_default();
        let (two_sided, blended) = (part.two_sided, part.alpha == Alpha::Blended);
        match runs.last_mut() {
            Some(run) if (run.two_sided, run.blended) == (two_sided, blended) => {
                run.triangles.end = cluster.triangles().end;
            }
            _ => runs.push(Run { triangles: cluster.triangles(), two_sided, blended }),
        }
    }
    runs
}

/// One channel from sRGB to linear.
pub(crate) fn linear(v: u8) -> f32 {
    let v = f32::from(v) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// The normal of every vertex of a chunk, of unit length, weighted by area, zero where no triangle
/// has an area; and in w about how long the edges there are. Vertices of a mesh in the same place
/// share a normal, so that clusters do not show.
pub(super) fn vertex_normals(chunk: &ChunkData) -> Vec<[f32; 4]> {
    let mut normals = vec![glam::Vec3::ZERO; chunk.vertices.len()];
    let corner = |i: u32| glam::Vec3::from(chunk.vertices[i as usize].position);
    for t in chunk.indices.chunks_exact(3) {
        let (a, b, c) = (corner(t[0]), corner(t[1]), corner(t[2]));
        let normal = (b - a).cross(c - a);
        t.iter().for_each(|&i| normals[i as usize] += normal);
    }
    let ends = chunk.mesh_starts.iter().skip(1).copied().chain([chunk.vertices.len() as u32]);
    let mut order: Vec<u32> = Vec::new();
    for (&start, end) in chunk.mesh_starts.iter().zip(ends) {
        let place = |i: u32| chunk.vertices[i as usize].position.map(f32::to_bits);
        order.clear();
        order.extend(start..end);
        order.sort_unstable_by_key(|&i| place(i));
        for same in order.chunk_by(|&a, &b| place(a) == place(b)) {
            let sum: glam::Vec3 = same.iter().map(|&i| normals[i as usize]).sum();
            same.iter().for_each(|&i| normals[i as usize] = sum);
        }
    }
    // The area of the triangles around is several times that of one.
    let with_size = |n: glam::Vec3| n.normalize_or_zero().extend(n.length().sqrt() * 0.5);
    normals.into_iter().map(|n| with_size(n).to_array()).collect()
}

#[cfg(test)]
mod tests {

    use super::*;

    const ROOM: Room = Room { buffer: 1 << 28, side: 8192 };

    #[test]
    fn chunks_hold_the_triangles_of_the_meshes() {
        let model = cullet_scenes::build("solids").unwrap();
        // So little that meshes fall into several chunks.
        for buffer in [1 << 28, 1 << 16] {
            let all = Geometry::new(&model, Room { buffer, side: 8192 }).unwrap();
            assert_eq!(all.chunks.len() > 1, buffer == 1 << 16);
            for (mesh, place) in model.scene.meshes().iter().zip(&all.meshes) {
                let chunk = &all.chunks[place.chunk as usize];
                assert!(chunk.vertices.len() * 16 <= buffer as usize);
                for (number, cluster) in mesh.clusters().iter().enumerate() {
                    let triangles = place.triangles(number as u32, 1);
                    assert_eq!(triangles, cluster.triangles());
                    let own = place.vertices(&triangles);
                    for t in triangles {
                        let at = (place.first_triangle + t) as usize * 3;
                        let corners = [0, 1, 2].map(|k| chunk.indices[at + k]);
                        assert!(corners.iter().all(|v| own.contains(v)));
                        let vertices = corners.map(|v| chunk.vertices[v as usize]);
                        assert_eq!(vertices.map(|v| v.position), mesh.corners(t));
                        assert!(vertices.iter().all(|v| v.key == vertices[0].key));
                    }
                }
                let runs: u32 =
                    place.runs.iter().map(|r| r.triangles.end - r.triangles.start).sum();
                assert_eq!(
                    (runs, place.whole),
                    (mesh.clusters().iter().map(|c| c.triangle_count).sum(), runs)
                );
                assert_eq!(place.triangles(u32::MAX, u32::MAX), runs..runs);
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let model = cullet_scenes::build("solids").unwrap();
        let error = Geometry::new(&model, Room { buffer: 512, ..ROOM }).unwrap_err();
        let DrawError::Mesh { what, count, limit, cause, .. } = &error else { panic!("{error}") };
        assert!(count > limit, "{error}");
        assert_eq!((*what, *limit, *cause), ("vertices", 32, "max_buffer_size"));
        assert!(error.to_string().contains("split or simplify"), "{error}");
        assert_eq!(Room { buffer: 1 << 40, side: 2048 }.texels(), 2048 * 2048);
    }

    #[test]
    fn normals_point_out_of_a_ball_and_do_not_show_clusters() {
        let model = cullet_scenes::build("solids").unwrap();
        let all = Geometry::new(&model, ROOM).unwrap();
        for chunk in &all.chunks {
            let normals = vertex_normals(chunk);
            assert_eq!(normals.len(), chunk.vertices.len());
            let mut mixed = 0;
            for t in chunk.indices.chunks_exact(3) {
                let corner = |k: usize| glam::Vec3::from(chunk.vertices[t[k] as usize].position);
                let face = (corner(1) - corner(0)).cross(corner(2) - corner(0));
                for &v in t {
                    let n = glam::Vec4::from(normals[v as usize]);
                    assert!((n.truncate().length() - 1.0).abs() < 1e-4 && n.w > 0.0);
                    mixed += usize::from(n.truncate().dot(face) <= 0.0);
                }
            }
            // Only at creases of more than a right angle may a face look away from its vertex's
            // normal.
            assert!(mixed * 50 < chunk.indices.len(), "{mixed} of {}", chunk.indices.len());
        }
    }
}
