//! Clusters whose every triangle faces away: which cone each has, the eyes of a view, and the pass
//! that tests them.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use cullet::cull::backface::{Facing, ViewEye};
use cullet::{MeshId, Scene, View};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline, Device,
    Queue,
};

use super::blocks::{BLOCK, is_exempt};
use super::buffers::{Access, buffer, buffers_layout, group, pipelines};
use super::clusters::ClusterInstances;
use super::error::GpuError;
use super::grid::Grid;
use super::grid_cone::{ConeEye, GridCone};
use super::instances::{InstanceBits, InstancePass};
use super::planes::BlockPlanes;

/// Where the cone of a cluster of an instance is, and its eye: 8 bytes, as they lie on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
struct Unit {
    cone: u32,
    slot: u32,
}

/// The cones of clusters of instances, and the eye of one view in the space of each instance.
///
/// Cones are those that the engine [prepared](cullet::Scene::prepared) of meshes, in steps of a
/// grid for each mesh: they are the same for all instances and stay as they are when these move.
/// The eyes are the CPU's work, once an instance and frame; no transform makes it inexact, whether
/// it mirrors or stretches. An instance has none where the engine would test its triangles one by
/// one: then its clusters are kept.
#[derive(Clone, Debug, Default)]
pub struct Cones {
    units: Vec<Unit>,
    /// Cones of all meshes that have some, for those who cull backs, then for those who cull
    /// fronts; the first has nothing behind it.
    cones: Vec<GridCone>,
    /// Where those of the second side begin, if there are any.
    fronts: Option<u32>,
    /// One grid per mesh.
    grids: Vec<Grid>,
    /// Units of one instance, with its slot.
    runs: Vec<(u32, Range<u32>)>,
    /// One eye per slot; the eyes of blocks that are not in use are left from an earlier view.
    eyes: Vec<ConeEye>,
    /// Where the cones of the view begin, if it has any.
    side: Option<u32>,
}

impl Cones {
    /// The cones of all clusters. O(clusters).
    #[must_use]
    pub fn new(scene: &Scene, clusters: &ClusterInstances) -> Self {
        let mut firsts: Vec<Option<u32>> = vec![None; scene.meshes().len()];
        let mut made = Self {
            cones: vec![GridCone::default()],
            grids: scene.meshes().iter().map(|mesh| Grid::around(&mesh.bounds())).collect(),
            eyes: vec![ConeEye::default(); scene.slot_count() as usize],
            ..Self::default()
        };
        let mut used: Vec<MeshId> = Vec::new();
        for (draw, numbers) in clusters.runs() {
            for number in numbers.start as usize..numbers.end as usize {
                let (slot, cluster) = (clusters.slots()[number], clusters.clusters()[number]);
                let id = scene.mesh_id(slot);
                let first = *firsts[id as usize].get_or_insert_with(|| {
                    used.push(id);
                    made.add_mesh(scene, id, Facing::Back)
                });
                // Cones are of the mesh itself.
                let has_none = draw.two_sided || first == 0 || clusters.levels()[number] > 0;
                let cone = if has_none { 0 } else { first + cluster };
                made.units.push(Unit { cone, slot });
            }
        }
        if used
            .iter()
            .any(|id| scene.prepared()[*id as usize].cluster_cones(Facing::Front).is_some())
        {
            // In the same order: all of them are as far from those of the first side.
            made.fronts = Some(made.cones.len() as u32);
            made.cones.push(GridCone::default());
            for id in used {
                made.add_mesh(scene, id, Facing::Front);
            }
        }
        let numbered: Vec<(u32, u32)> = (0..).zip(clusters.slots().iter().copied()).collect();
        for own in numbered.chunk_by(|a, b| a.1 == b.1) {
            let first = own[0].0;
            made.runs.push((own[0].1, first..first + own.len() as u32));
        }
        made
    }

    /// Adds the cones of a mesh's clusters: where they begin, or 0 where there are none on any
    /// side.
    fn add_mesh(&mut self, scene: &Scene, id: MeshId, facing: Facing) -> u32 {
        let prepared = &scene.prepared()[id as usize];
        if [Facing::Back, Facing::Front].iter().all(|f| prepared.cluster_cones(*f).is_none()) {
            return 0;
        }
        let first = self.cones.len() as u32;
        let (cones, grid) = (prepared.cluster_cones(facing), self.grids[id as usize]);
        let of = |cluster| Some(GridCone::new(&cones?.get(cluster)?, &grid));
        let clusters = 0..scene.meshes()[id as usize].clusters().len();
        self.cones.extend(clusters.map(|cluster| of(cluster).unwrap_or_default()));
        first
    }

    /// The eyes of a view for the instances that blocks in use have clusters of. O(instances).
    pub fn set(&mut self, scene: &Scene, view: &View, planes: &BlockPlanes) {
        let eye = ViewEye::new(view);
        self.side = match eye.culled_side() {
            Facing::Back => Some(0),
            Facing::Front => self.fronts,
            Facing::Edge => None,
        };
        if self.side.is_none() {
            return;
        }
        let mut next = 0;
        for of in planes.in_use() {
            let [first, end] = [of.block, of.block + 1].map(|b| b * BLOCK as u32);
            next = next.max(self.runs.partition_point(|(_, units)| units.end <= first));
            // One that goes on in the next block is done by then.
            while let Some((slot, _)) = self.runs.get(next).filter(|(_, own)| own.start < end) {
                self.eyes[*slot as usize] = self.eye_of(scene, &eye, *slot);
                next += 1;
            }
        }
    }

    fn eye_of(&self, scene: &Scene, eye: &ViewEye, slot: u32) -> ConeEye {
        if is_exempt(scene, slot) || !scene.is_rigid(slot) {
            return ConeEye::default();
        }
        let id = scene.mesh_id(slot) as usize;
        let own = eye.in_space_of(scene.transform(slot));
        let known = scene.prepared()[id].backfaces().and_then(|backs| backs.eye(&own));
        known.map_or_else(ConeEye::default, |e| ConeEye::new(e.homogeneous(), &self.grids[id]))
    }

    /// Returns the units of a list that are not behind their cones: what the pass leaves, byte for
    /// byte. Slow and obvious.
    #[must_use]
    pub fn keep_ref(&self, list: &[u32]) -> Vec<u32> {
        let Some(side) = self.side else { return list.to_vec() };
        let is_kept = |number: &&u32| {
            let own = self.units[**number as usize];
            let cone = self.cones[(own.cone + side) as usize];
            !cone.is_behind(&self.eyes[own.slot as usize])
        };
        list.iter().filter(is_kept).copied().collect()
    }
}

/// The pipeline that tests boxes against planes and clusters by their cones: seven storage buffers,
/// no optional feature.
#[derive(Debug)]
pub struct ConePass {
    layout: BindGroupLayout,
    face: ComputePipeline,
}

/// Cones on a device, and what one view needs of them.
#[derive(Debug)]
pub struct ConeBuffers {
    cones: Cones,
    eyes: Buffer,
    side: Buffer,
    /// Side whose data the buffer holds.
    known_side: u32,
    group: BindGroup,
    bytes: u64,
}

impl ConePass {
    /// Compiles the pass.
    pub(crate) fn new(device: &Device, instances: &InstancePass) -> Self {
        const ACCESS: [Access; 4] = [Access::Read, Access::Read, Access::Read, Access::Uniform];
        let layout = buffers_layout(device, "cones", &ACCESS);
        let source = concat!(
            include_str!("shaders/boxes.wgsl"),
            include_str!("shaders/instances.wgsl"),
            include_str!("shaders/cones.wgsl"),
        );
        let layouts = [instances.layout(), &layout];
        let [face] = pipelines(device, "cones", source, &layouts, &[], ["face"]);
        Self { layout, face }
    }

    /// Records the test of a view in place of [that of boxes alone](InstancePass::record): one
    /// dispatch for both, since each costs more than the test of many clusters where the device is
    /// a program. False, and nothing is recorded, where the view that was [set](ConeBuffers::set)
    /// last culls no side that cones were made for.
    #[must_use]
    pub fn record(
        &self,
        encoder: &mut CommandEncoder,
        to: &InstanceBits,
        cones: &ConeBuffers,
        planes: &BlockPlanes,
    ) -> bool {
        let is_used = cones.cones.side.is_some();
        if is_used {
            let more = Some(&cones.group);
            to.record(encoder, &self.face, more, planes);
        }
        is_used
    }
}

impl ConeBuffers {
    /// Uploads cones. O(clusters).
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(
        device: &Device,
        queue: &Queue,
        pass: &ConePass,
        cones: Cones,
    ) -> Result<Self, GpuError> {
        let written = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let make = |what, items, size| buffer(device, what, items, size, written);
        let units = make("cones of units", cones.units.len(), size_of::<Unit>())?;
        let table = make("cones", cones.cones.len(), size_of::<GridCone>())?;
        let eyes = make("eyes of instances", cones.eyes.len(), size_of::<ConeEye>())?;
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let side = buffer(device, "side of cones", 4, 4, uniform)?;
        queue.write_buffer(&units, 0, bytemuck::cast_slice(&cones.units));
        queue.write_buffer(&table, 0, bytemuck::cast_slice(&cones.cones));
        let all = [&units, &table, &eyes, &side];
        let group = group(device, "cones", &pass.layout, &all.map(|b| b.as_entire_binding()));
        let bytes = all.into_iter().map(Buffer::size).sum();
        // Buffers begin with zeros.
        Ok(Self { cones, eyes, side, known_side: 0, group, bytes })
    }

    /// Uploads the eyes of a view. To be called before the pass is [recorded](ConePass::record);
    /// once between two submissions.
    pub fn set(&mut self, queue: &Queue, scene: &Scene, view: &View, planes: &BlockPlanes) {
        self.cones.set(scene, view, planes);
        let Some(side) = self.cones.side else { return };
        queue.write_buffer(&self.eyes, 0, bytemuck::cast_slice(&self.cones.eyes));
        if side != self.known_side {
            queue.write_buffer(&self.side, 0, &side.to_ne_bytes());
            self.known_side = side;
        }
    }

    /// Has the pass test nothing until a view is set again.
    pub fn clear(&mut self) {
        self.cones.side = None;
    }

    /// Returns the cones that were uploaded.
    #[must_use]
    pub fn cones(&self) -> &Cones {
        &self.cones
    }

    /// Bytes that they take on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}
