//! Levels of detail of clusters of instances: which groups each was made from and simplified in,
//! the eyes of a view, and the pass that chooses.

use bytemuck::{Pod, Zeroable};
use cullet::bounds::Aabb;
use cullet::lod::{LevelEye, Levels, Lod, NO_GROUP, PixelScale};
use cullet::{MeshId, Scene, View};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePassDescriptor,
    ComputePipeline, Device, Queue,
};

use super::blocks::is_exempt;
use super::buffers::{Access, buffer, buffers_layout, dispatch_rows, group, pipelines};
use super::clusters::{ClusterInstances, levels_of};
use super::error::GpuError;
use super::grid::Grid;
use super::grid_group::{GridGroup, GroupEye};
use super::instances::InstanceBits;
use super::planes::BlockPlanes;

/// In place of the number of a group: one that is never over the threshold.
const NEVER: u32 = u32::MAX - 1;
/// In place of the number of a group: one that always is.
const ALWAYS: u32 = u32::MAX;

/// The groups of a cluster of an instance: 16 bytes, as they lie on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
struct Unit {
    slot: u32,
    made_from: u32,
    replaced_by: u32,
    padding: u32,
}

/// The groups of clusters of instances, and the eye of one view in the space of each instance.
#[derive(Clone, Debug, Default)]
pub struct LevelChoice {
    units: Vec<Unit>,
    groups: Vec<GridGroup>,
    /// One grid per mesh.
    grids: Vec<Option<Grid>>,
    /// Slots whose meshes have levels.
    slots: Vec<u32>,
    /// One eye per slot.
    eyes: Vec<GroupEye>,
}

impl LevelChoice {
    /// The groups of all clusters; `None` where no mesh has levels. O(clusters).
    #[must_use]
    pub fn new(scene: &Scene, clusters: &ClusterInstances) -> Option<Self> {
        if clusters.levels().iter().all(|level| *level == 0) {
            return None;
        }
        let mut made = Self::default();
        made.grids.resize(scene.meshes().len(), None);
        made.eyes.resize(scene.slot_count() as usize, GroupEye::default());
        // By mesh the levels, and where their groups begin.
        let mut known = vec![None; scene.meshes().len()];
        for id in 0..scene.meshes().len() as MeshId {
            if let Some((_, levels, own)) = levels_of(scene, id) {
                known[id as usize] = Some((levels, own, made.add_groups(scene, id, levels)));
            }
        }
        let numbers = clusters.slots().iter().zip(clusters.clusters()).zip(clusters.levels());
        for ((&slot, &cluster), &level) in numbers {
            let number = |first: u32, group: u32, none: u32| match group {
                NO_GROUP => none,
                group => first + group,
            };
            let at = cluster as usize;
            let [made_from, replaced_by] = match (known[scene.mesh_id(slot) as usize], level) {
                (None, _) => [NEVER, ALWAYS],
                (Some((_, own, first)), 0) => [NEVER, own.map_or(NEVER, |own| first + own)],
                (Some((levels, _, first)), _) => [
                    number(first, levels.made_from()[at], NEVER),
                    number(first, levels.replaced_by()[at], ALWAYS),
                ],
            };
            made.units.push(Unit { slot, made_from, replaced_by, padding: 0 });
            if level > 0 && made.slots.last() != Some(&slot) {
                made.slots.push(slot);
            }
        }
        Some(made)
    }

    /// Adds the groups of a mesh: where they begin.
    fn add_groups(&mut self, scene: &Scene, id: MeshId, levels: &Levels) -> u32 {
        let first = self.groups.len() as u32;
        let centres = (0..levels.group_count()).map(|g| levels.group(g).centre);
        let bounds = scene.meshes()[id as usize].bounds();
        let around = centres.fold(bounds, |all, c| all.union(&Aabb::new(c, c)));
        let grid = Grid::around(&around);
        self.groups.extend(GridGroup::of(levels, &grid));
        self.grids[id as usize] = Some(grid);
        first
    }

    /// The eyes of a view, for surfaces that are off by so many pixels at the most: O(instances
    /// that have levels). Everything is drawn in full where that is not above 0, as are instances
    /// that do not lie as their mesh says.
    pub fn set(&mut self, scene: &Scene, view: &View, pixels: f32) {
        let lod = Lod::default().with_pixels(pixels.into());
        let scale = PixelScale::of(view, lod.at_corners);
        for &slot in &self.slots {
            let grid = self.grids[scene.mesh_id(slot) as usize];
            let in_full = is_exempt(scene, slot) || !scene.is_rigid(slot);
            self.eyes[slot as usize] = match grid.filter(|_| !in_full) {
                None => GroupEye::default(),
                Some(grid) => {
                    let eye = LevelEye::new(&lod, &scale, scene.transform(slot), view.eyes);
                    GroupEye::new(&eye, &grid)
                }
            };
        }
    }

    /// Returns the units of a list that are of the level of the view: what the pass leaves, byte
    /// for byte. Slow and obvious.
    #[must_use]
    pub fn keep_ref(&self, list: &[u32]) -> Vec<u32> {
        let is_over = |group: u32, eye: &GroupEye| match group {
            NEVER => false,
            ALWAYS => true,
            group => self.groups[group as usize].is_over(eye),
        };
        let is_kept = |number: &&u32| {
            let own = self.units[**number as usize];
            let eye = &self.eyes[own.slot as usize];
            !is_over(own.made_from, eye) && is_over(own.replaced_by, eye)
        };
        list.iter().filter(is_kept).copied().collect()
    }
}

/// The pipeline that chooses levels: five storage buffers, no optional feature.
#[derive(Debug)]
pub struct LevelPass {
    layout: BindGroupLayout,
    choose: ComputePipeline,
}

/// Groups on a device, and what one view needs of them.
#[derive(Debug)]
pub struct LevelBuffers {
    choice: LevelChoice,
    eyes: Buffer,
    view: Buffer,
    group: BindGroup,
    bytes: u64,
}

impl LevelPass {
    /// Compiles the pass.
    pub(crate) fn new(device: &Device) -> Self {
        const ACCESS: [Access; 6] = [
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Write,
            Access::Uniform,
        ];
        let layout = buffers_layout(device, "levels", &ACCESS);
        let source =
            concat!(include_str!("shaders/boxes.wgsl"), include_str!("shaders/levels.wgsl"));
        let [choose] = pipelines(device, "levels", source, &[&layout], &[], ["choose"]);
        Self { layout, choose }
    }

    /// Records that bits of clusters are cleared that are of other levels than the view takes that
    /// was [set](LevelBuffers::set) last.
    pub fn record(&self, encoder: &mut CommandEncoder, to: &LevelBuffers, planes: &BlockPlanes) {
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("levels"),
            timestamp_writes: None,
        });
        pass.set_bind_group(0, &to.group, &[]);
        dispatch_rows(&mut pass, &self.choose, planes.in_use().len() as u32);
    }
}

impl LevelBuffers {
    /// Uploads groups, to clear bits of what passed the planes. O(clusters).
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(
        device: &Device,
        queue: &Queue,
        pass: &LevelPass,
        choice: LevelChoice,
        passed: &InstanceBits,
    ) -> Result<Self, GpuError> {
        let written = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let make = |what, items, size| buffer(device, what, items, size, written);
        let units = make("levels of units", choice.units.len(), size_of::<Unit>())?;
        let groups = make("groups of levels", choice.groups.len(), size_of::<GridGroup>())?;
        let eyes = make("eyes of levels", choice.eyes.len(), size_of::<GroupEye>())?;
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let view = buffer(device, "view of levels", 4, 4, uniform)?;
        queue.write_buffer(&units, 0, bytemuck::cast_slice(&choice.units));
        queue.write_buffer(&groups, 0, bytemuck::cast_slice(&choice.groups));
        let [_, in_use] = passed.boxes_in_use();
        let all = [in_use, &units, &groups, &eyes, passed.bits(), &view];
        let group = group(device, "levels", &pass.layout, &all.map(|b| b.as_entire_binding()));
        let bytes = [&units, &groups, &eyes, &view].into_iter().map(Buffer::size).sum();
        Ok(Self { choice, eyes, view, group, bytes })
    }

    /// Uploads the eyes of a view. To be called before the pass is [recorded](LevelPass::record);
    /// once between two submissions.
    pub fn set(
        &mut self,
        queue: &Queue,
        (scene, view): (&Scene, &View),
        pixels: f32,
        planes: &BlockPlanes,
    ) {
        self.choice.set(scene, view, pixels);
        queue.write_buffer(&self.eyes, 0, bytemuck::cast_slice(&self.choice.eyes));
        let numbers = [planes.in_use().len() as u32, self.choice.units.len() as u32, 0, 0];
        queue.write_buffer(&self.view, 0, bytemuck::cast_slice(&numbers));
    }

    /// Returns the choice that was uploaded.
    #[must_use]
    pub fn choice(&self) -> &LevelChoice {
        &self.choice
    }

    /// Bytes that they take on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}
