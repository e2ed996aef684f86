//! Clusters of instances, each culled and drawn by itself: for scenes whose meshes are large.

use std::ops::Range;

use cullet::bounds::Aabb;
use cullet::lod::Levels;
use cullet::{MeshId, Scene};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePassDescriptor,
    ComputePipeline, Device, Queue,
};

use super::buffers::{Access, buffer, buffers_layout, dispatch_rows, group, pipelines};
use super::error::GpuError;
use super::geometry::{Draw, GpuScene};
use super::lanes::{Bucket, Kind, Lanes};
use super::lists::{DrawArguments, ListSource};
use super::tier::GROUP;

/// The clusters of all instances of a scene, those that are drawn alike one after the other, else
/// in the order of slots. A number stands for each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ClusterInstances {
    lanes: Lanes,
    slots: Vec<u32>,
    clusters: Vec<u32>,
    levels: Vec<u32>,
    arguments: Vec<DrawArguments>,
    runs: Vec<(Draw, Range<u32>)>,
}

impl ClusterInstances {
    /// All of those that can be drawn: of meshes with levels of detail also those of the coarser
    /// ones. O(n log n).
    #[must_use]
    pub fn of(scene: &Scene, on_device: &GpuScene) -> Self {
        let mut all: Vec<(Draw, u32, u32, u32)> = Vec::new();
        let lanes = Lanes::of(scene);
        for (Bucket { kind, .. }, slots) in lanes.split() {
            let of = |slot: &u32| of_instance(scene, on_device, (*kind, *slot));
            all.extend(slots.iter().flat_map(of));
        }
        all.sort_by_key(|(draw, slot, level, cluster)| (draw.way(), *slot, *level, *cluster));
        let mut made = Self { lanes, ..Self::default() };
        for alike in all.chunk_by(|a, b| a.0.way() == b.0.way()) {
            let first = made.slots.len() as u32;
            made.runs.push((alike[0].0, first..first + alike.len() as u32));
            made.slots.extend(alike.iter().map(|one| one.1));
            made.levels.extend(alike.iter().map(|one| one.2));
            made.clusters.extend(alike.iter().map(|one| one.3));
            made.arguments.extend(alike.iter().map(|one| one.0.arguments));
        }
        // Its own number is where its slot is read.
        for (number, arguments) in (0..).zip(&mut made.arguments) {
            arguments.first_instance = number;
        }
        made
    }

    /// Whether they are those of a scene of the same meshes. O(slots).
    #[must_use]
    pub fn are_of(&self, scene: &Scene) -> bool {
        self.lanes.are_of(scene)
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> u32 {
        self.slots.len() as u32
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// The slot of each.
    #[must_use]
    pub fn slots(&self) -> &[u32] {
        &self.slots
    }

    /// The cluster of its instance's mesh, or of the mesh that holds its level, that each is.
    #[must_use]
    pub fn clusters(&self) -> &[u32] {
        &self.clusters
    }

    /// The draw of each, of no instance.
    #[must_use]
    pub fn arguments(&self) -> &[DrawArguments] {
        &self.arguments
    }

    /// A lane for each, in buckets of those that are drawn alike.
    #[must_use]
    pub fn lanes(&self) -> Lanes {
        let bucket = |(draw, numbers): &(Draw, Range<u32>)| Bucket {
            kind: draw.kind,
            lanes: numbers.clone(),
        };
        Lanes::numbered(self.runs.iter().map(bucket).collect())
    }

    /// The number of the level of each, as in [`DrawRange`](cullet::draw::DrawRange): 0 of the mesh
    /// itself.
    #[must_use]
    pub fn levels(&self) -> &[u32] {
        &self.levels
    }

    /// Returns the runs of clusters that are drawn alike.
    pub(crate) fn runs(&self) -> &[(Draw, Range<u32>)] {
        &self.runs
    }

    /// The box of one, its layers, and the weight of its size. Where an instance does not lie as
    /// its mesh says, the instance's own.
    pub(crate) fn bounds(&self, scene: &Scene, number: u32) -> (Aabb, u32, f32) {
        let slot = self.slots[number as usize];
        let whole = super::blocks::bounds_of(scene, slot);
        let bounds = if whole.is_finite() && scene.is_rigid(slot) {
            let mesh = scene.mesh_at(slot, self.levels[number as usize]);
            let own = mesh.cluster_boxes().get(self.clusters[number as usize] as usize);
            scene.transform(slot).transform_box(&own, scene.origin())
        } else {
            whole
        };
        (bounds, scene.layers(slot), scene.size_weight(slot))
    }
}

fn of_instance<'a>(
    scene: &'a Scene,
    on_device: &'a GpuScene,
    (kind, slot): (Kind, u32),
) -> impl Iterator<Item = (Draw, u32, u32, u32)> + 'a {
    let of_mesh = |level: u32| {
        let mesh = scene.mesh_id_at(slot, level);
        let clusters = 0..scene.meshes()[mesh as usize].cluster_count();
        (Kind { mesh, ..kind }, level, clusters)
    };
    let coarser = levels_of(scene, kind.mesh).map(|(level, ..)| of_mesh(level));
    [of_mesh(0)].into_iter().chain(coarser).flat_map(move |(kind, level, clusters)| {
        let draw = move |cluster| on_device.draw_of_cluster(scene, kind, cluster);
        clusters.map(move |cluster| (draw(cluster), slot, level, cluster))
    })
}

/// The levels of a mesh that are chosen on a device, with their number, and the group that the
/// mesh's own clusters are simplified in.
///
/// The first of its [levels](Scene::levels) that are no impostor, and either a chain that the mesh
/// itself is the finest of, or a hierarchy that holds the original's clusters, too, so that the
/// mesh's own are never drawn and in no group.
pub(crate) fn levels_of(scene: &Scene, mesh: MeshId) -> Option<(u32, &Levels, Option<u32>)> {
    let (number, of) = (1..).zip(scene.levels(mesh)).find(|(_, l)| l.impostor.is_none())?;
    let levels = &of.levels;
    let has_inputs = |g: &u32| levels.replaced_by().contains(g);
    let mut without = (0..levels.group_count() as u32).filter(|g| !has_inputs(g));
    let own = match (without.next(), without.next(), levels.original_clusters()) {
        (None, _, 1..) => None,
        (Some(finest), None, 0) => Some(finest),
        _ => return None,
    };
    Some((number, levels, own))
}

/// The pipeline that says of each cluster whether it is drawn: three storage buffers.
#[derive(Debug)]
pub struct ArgumentPass {
    layout: BindGroupLayout,
    fill: ComputePipeline,
}

/// Arguments of draws, one for each cluster: of one instance, or of none.
#[derive(Debug)]
pub struct ClusterArguments {
    arguments: Buffer,
    group: BindGroup,
    groups: u32,
}

impl ArgumentPass {
    /// Compiles the pass.
    pub(crate) fn new(device: &Device) -> Self {
        const ACCESS: [Access; 4] = [Access::Read, Access::Read, Access::Write, Access::Uniform];
        let layout = buffers_layout(device, "arguments", &ACCESS);
        let source =
            concat!(include_str!("shaders/listed.wgsl"), include_str!("shaders/arguments.wgsl"));
        let [fill] = pipelines(device, "arguments", source, &[&layout], &[], ["fill"]);
        Self { layout, fill }
    }

    /// Records what bits make of arguments.
    pub fn record(&self, encoder: &mut CommandEncoder, to: &ClusterArguments) {
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("arguments"),
            timestamp_writes: None,
        });
        pass.set_bind_group(0, &to.group, &[]);
        dispatch_rows(&mut pass, &self.fill, to.groups);
    }
}

impl ClusterArguments {
    /// Arguments of all clusters, of none so far.
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(
        device: &Device,
        queue: &Queue,
        pass: &ArgumentPass,
        clusters: &ClusterInstances,
        source: ListSource<'_>,
    ) -> Result<Self, GpuError> {
        let written = BufferUsages::COPY_DST;
        let usage =
            BufferUsages::STORAGE | BufferUsages::INDIRECT | written | BufferUsages::COPY_SRC;
        let size = size_of::<DrawArguments>();
        let count = clusters.arguments.len();
        let arguments = buffer(device, "arguments of clusters", count, size, usage)?;
        queue.write_buffer(&arguments, 0, bytemuck::cast_slice(&clusters.arguments));
        let which = buffer(device, "which", 4, 4, BufferUsages::UNIFORM | written)?;
        let numbers = [clusters.len(), source.listed as u32, 0, 0];
        queue.write_buffer(&which, 0, bytemuck::cast_slice(&numbers));
        let resources =
            [source.bits, source.seen, &arguments, &which].map(|b| b.as_entire_binding());
        let group = group(device, "arguments", &pass.layout, &resources);
        Ok(Self { arguments, group, groups: clusters.len().div_ceil(GROUP) })
    }

    /// [`DrawArguments`] of each.
    #[must_use]
    pub fn arguments(&self) -> &Buffer {
        &self.arguments
    }
}
