//! Draws: an answer as the index ranges and the arrays that a renderer takes.
//!
//! [`Visible::draws`] is the simple way: one draw for each part of each instance. [`DrawList`] is
//! the one for every frame: instances of one mesh become one indirect draw, in arrays that are
//! uploaded as they are, and nothing is allocated once they have grown.
//!
//! Both are sorted by state: opaque parts before alpha-masked ones before blended ones, and in each
//! class by material, then mesh. Blended parts want an order from back to front, which is the
//! renderer's to make.

use alloc::vec::Vec;
use core::ops::Range;

use super::Visible;
use crate::hierarchy::Handle;
use crate::mesh::{Alpha, Mesh};
use crate::scene::{MeshId, Scene, SceneError};
use crate::sort::Sorter;

/// A range of indices of a mesh, to be drawn for one instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draw {
    /// The instance's slot.
    pub slot: u32,
    /// The instance's handle.
    pub handle: Handle,
    /// The mesh that the indices are of: the instance's, or that of its
    /// [levels](crate::Scene::levels).
    pub mesh: MeshId,
    /// The level of detail.
    pub level: u32,
    /// The part of the mesh.
    pub part: u32,
    /// The part's material.
    pub material: u32,
    /// The state that the part is drawn with.
    pub state: DrawState,
    /// Range of [`Mesh::indices`].
    pub indices: Range<u32>,
}

/// The state that a part of an instance is drawn with. Ascends in the order in which to draw.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, bytemuck::Pod, bytemuck::Zeroable,
)]
#[repr(transparent)]
pub struct DrawState(pub u32);

impl DrawState {
    /// Both sides are drawn: no back-face culling by the renderer.
    pub const TWO_SIDED: u32 = 1;
    /// The transform mirrors: fronts that are counter-clockwise in the mesh are clockwise on the
    /// screen.
    pub const MIRRORED: u32 = 2;
    /// The material is cut out by a threshold.
    pub const MASKED: u32 = 4;
    /// The material is blended.
    pub const BLENDED: u32 = 8;

    fn of(scene: &Scene, slot: u32) -> Self {
        let flags = scene.flags(slot);
        let mut bits = 0;
        bits |= if flags.double_sided { Self::TWO_SIDED } else { 0 };
        bits |= if scene.transform(slot).is_mirrored() { Self::MIRRORED } else { 0 };
        bits |= if flags.transparent { Self::BLENDED } else { 0 };
        Self(bits)
    }

    fn with_part(self, mesh: &Mesh, part: u32) -> Self {
        let part = &mesh.parts()[part as usize];
        let sides = if part.two_sided { Self::TWO_SIDED } else { 0 };
        let alpha = match part.alpha {
            Alpha::Opaque => 0,
            Alpha::Masked => Self::MASKED,
            Alpha::Blended => Self::BLENDED,
        };
        Self(self.0 | sides | alpha)
    }

    /// Whether all of some bits are set.
    #[must_use]
    pub const fn has(self, bits: u32) -> bool {
        self.0 & bits == bits
    }
}

impl Visible {
    /// Returns the draws, one for each instance and part. An instance that is drawn in part has
    /// draws for the clusters that are left. They include triangles that were dropped individually;
    /// [`DrawList::fill_triangles`] leaves those out.
    ///
    /// Allocates the list. O(n log n) of what is visible.
    ///
    /// # Errors
    /// [`SceneError::Stale`] if the result is not of the scene as it is.
    pub fn draws(&self, scene: &Scene) -> Result<Vec<Draw>, SceneError> {
        self.check(scene)?;
        let mut draws = Vec::new();
        self.for_each_range(scene, |slot, level, clusters| {
            let (Some(handle), mesh) = (scene.handle(slot), scene.mesh_at(slot, level)) else {
                return;
            };
            let state = DrawState::of(scene, slot);
            for (part, clusters) in mesh.runs_of_parts(clusters) {
                draws.push(Draw {
                    slot,
                    handle,
                    mesh: scene.mesh_id_at(slot, level),
                    level,
                    part,
                    material: mesh.parts()[part as usize].material,
                    state: state.with_part(mesh, part),
                    indices: mesh.index_range(clusters),
                });
            }
        });
        Sorter::default().sort_by_seven(&mut draws, |d| {
            [d.state.0, d.material, d.mesh, d.part, d.level, d.slot, d.indices.start]
        });
        Ok(draws)
    }

    /// Calls `each` with slot, level and clusters, first of the instances that are whole.
    fn for_each_range(&self, scene: &Scene, mut each: impl FnMut(u32, u32, Range<u32>)) {
        for slot in self.whole.iter().flat_map(|r| r.first..r.first + r.count) {
            each(slot, 0, 0..scene.mesh(slot).cluster_count());
        }
        for d in &self.partial {
            each(d.slot, d.level, d.first_cluster..d.first_cluster + d.cluster_count);
        }
    }
}

/// One indexed indirect draw, as Vulkan, Direct3D 12, Metal and WebGPU read it: 20 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DrawCommand {
    /// Number of indices.
    pub index_count: u32,
    /// Number of instances.
    pub instance_count: u32,
    /// First index, in the index buffer.
    pub first_index: u32,
    /// Added to each index.
    pub base_vertex: i32,
    /// First entry of [`DrawList::instances`].
    pub first_instance: u32,
}

/// State, material and part of a mesh that a [`DrawCommand`] draws: the same for all its instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DrawKey {
    /// The state to draw with.
    pub state: DrawState,
    /// The material.
    pub material: u32,
    /// The mesh.
    pub mesh: MeshId,
    /// The part of the mesh.
    pub part: u32,
    /// The level of detail.
    pub level: u32,
}

/// Place of a mesh in the buffers of the renderer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct MeshPlace {
    /// Position of the mesh's first index in the index buffer.
    pub first_index: u32,
    /// Position of the mesh's first vertex in the vertex buffer.
    pub base_vertex: i32,
}

/// Numbers by which a [`DrawList`] lists instances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InstanceNumbers {
    /// Slots: dense, and in the order of place, but a commit changes them.
    #[default]
    Slots,
    /// The indices of handles: dense, and an instance keeps its own, so that no buffer of the
    /// renderer's is ever permuted.
    Handles,
    /// The low 32 bits of [`Instance::user_data`](crate::Instance::user_data), such as a place in
    /// the renderer's own buffer.
    Users,
}

/// Draws of a frame as flat arrays for upload, used again from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct DrawList {
    /// The draws, sorted by what [`keys`](Self::keys) say of them.
    pub commands: Vec<DrawCommand>,
    /// State, material and mesh of each command.
    pub keys: Vec<DrawKey>,
    /// The instances that commands draw, each command a range of them, by
    /// [`numbers`](Self::numbers).
    pub instances: Vec<u32>,
    /// The numbers that [`instances`](Self::instances) are listed by. Default
    /// [`InstanceNumbers::Slots`].
    pub numbers: InstanceNumbers,
    /// The indices of [`fill_triangles`](Self::fill_triangles); else empty.
    pub indices: Vec<u32>,
    /// How many whole instances of each mesh and variant there are; then where their next slot is
    /// written.
    counts: Vec<u32>,
    /// The entries of `counts` that are not zero. Only these are cleared before the next list: a
    /// scene may have as many meshes as instances.
    counted: Vec<u32>,
    /// The entry of each whole instance.
    variants: Vec<u32>,
    entries: Vec<(DrawKey, DrawCommand)>,
    sorter: Sorter,
}

/// Instances of a mesh in different states: [`DrawState::TWO_SIDED`], mirrored and blended.
const VARIANTS: usize = 16;

impl DrawList {
    /// Makes an empty list that lists instances by `numbers`.
    #[must_use]
    pub fn by(numbers: InstanceNumbers) -> Self {
        Self { numbers, ..Self::default() }
    }

    /// Fills the list with what is visible: one command for the whole instances of a mesh and part,
    /// one for each run of clusters of the others. `places` says where the meshes are in the
    /// renderer's buffers; for one that is not among them the command counts from its mesh's first
    /// index.
    ///
    /// O(visible + commands log commands). Allocates only while it grows.
    ///
    /// # Errors
    /// [`SceneError::Stale`] if `visible` is not of the scene as it is; the list is empty then.
    pub fn fill(
        &mut self,
        scene: &Scene,
        visible: &Visible,
        places: &[MeshPlace],
    ) -> Result<(), SceneError> {
        self.clear();
        visible.check(scene)?;
        self.count_whole(scene, visible);
        for at in 0..self.counted.len() {
            let variant = self.counted[at] as usize;
            let (mesh, count) = (variant / VARIANTS, self.counts[variant]);
            let state = DrawState((variant % VARIANTS) as u32);
            let first_instance = self.instances.len() as u32;
            self.instances.resize(self.instances.len() + count as usize, 0);
            self.counts[variant] = first_instance;
            let clusters = 0..scene.meshes()[mesh].cluster_count();
            self.list(scene, places, (mesh as u32, state, 0), clusters, first_instance, count);
        }
        let slots = visible.whole.iter().flat_map(|r| r.first..r.first + r.count);
        for (slot, &variant) in slots.zip(&self.variants) {
            let next = &mut self.counts[variant as usize];
            self.instances[*next as usize] = slot;
            *next += 1;
        }
        for ranges in visible.partial.chunk_by(|a, b| a.slot == b.slot) {
            let slot = ranges[0].slot;
            let first_instance = self.instances.len() as u32;
            self.instances.push(slot);
            let mesh = scene.mesh_id_at(slot, ranges[0].level);
            let state = DrawState::of(scene, slot);
            for d in ranges {
                let clusters = d.first_cluster..d.first_cluster + d.cluster_count;
                self.list(scene, places, (mesh, state, d.level), clusters, first_instance, 1);
            }
        }
        self.finish(scene);
        Ok(())
    }

    /// Fills the list with the triangles of an answer with
    /// [`Output::Triangles`](crate::Output::Triangles): one command for each part of each instance,
    /// of [`indices`](Self::indices) that are to be uploaded with it. Of `places` only the base
    /// vertices matter.
    ///
    /// O(triangles). Allocates only while it grows.
    ///
    /// # Errors
    /// [`SceneError::Stale`] if `visible` is not of the scene as it is; the list is empty then.
    pub fn fill_triangles(
        &mut self,
        scene: &Scene,
        visible: &Visible,
        places: &[MeshPlace],
    ) -> Result<(), SceneError> {
        self.clear();
        visible.check(scene)?;
        for range in &visible.triangle_ranges {
            let slot = range.slot;
            let id = scene.mesh_id_at(slot, range.level);
            let (mesh, state) = (&scene.meshes()[id as usize], DrawState::of(scene, slot));
            let base_vertex = places.get(id as usize).map_or(0, |place| place.base_vertex);
            let first_instance = self.instances.len() as u32;
            self.instances.push(slot);
            let first = range.first as usize;
            let mut rest = &visible.triangles[first..first + range.count as usize];
            for run in mesh.part_runs() {
                // In no cluster are degenerate triangles, which come last.
                let end = mesh.index_range(run.clusters()).end / 3;
                let own;
                (own, rest) = rest.split_at(rest.partition_point(|&t| t < end));
                if own.is_empty() {
                    continue;
                }
                let first_index = self.indices.len() as u32;
                for &t in own {
                    self.indices.extend_from_slice(&mesh.indices()[t as usize * 3..][..3]);
                }
                let command = DrawCommand {
                    index_count: own.len() as u32 * 3,
                    instance_count: 1,
                    first_index,
                    base_vertex,
                    first_instance,
                };
                self.entries.push((key(mesh, (id, state, range.level), run.part), command));
            }
        }
        self.finish(scene);
        Ok(())
    }

    fn clear(&mut self) {
        self.commands.clear();
        self.keys.clear();
        self.instances.clear();
        self.indices.clear();
        self.entries.clear();
        self.counted.drain(..).for_each(|variant| self.counts[variant as usize] = 0);
        self.variants.clear();
    }

    fn count_whole(&mut self, scene: &Scene, visible: &Visible) {
        let variants = scene.meshes().len() * VARIANTS;
        self.counts.resize(self.counts.len().max(variants), 0);
        for slot in visible.whole.iter().flat_map(|r| r.first..r.first + r.count) {
            let variant = variant_of(scene, slot);
            if self.counts[variant] == 0 {
                self.counted.push(variant as u32);
            }
            self.counts[variant] += 1;
            self.variants.push(variant as u32);
        }
    }

    /// Lists clusters of a mesh in a state and of a level, a part at a time.
    fn list(
        &mut self,
        scene: &Scene,
        places: &[MeshPlace],
        of: (MeshId, DrawState, u32),
        clusters: Range<u32>,
        first_instance: u32,
        instance_count: u32,
    ) {
        let mesh = &scene.meshes()[of.0 as usize];
        let place = places.get(of.0 as usize).copied().unwrap_or_default();
        for (part, clusters) in mesh.runs_of_parts(clusters) {
            let indices = mesh.index_range(clusters);
            let command = DrawCommand {
                index_count: indices.len() as u32,
                instance_count,
                first_index: place.first_index + indices.start,
                base_vertex: place.base_vertex,
                first_instance,
            };
            self.entries.push((key(mesh, of, part), command));
        }
    }

    fn finish(&mut self, scene: &Scene) {
        let number: fn(&Scene, u32) -> u32 = match self.numbers {
            InstanceNumbers::Slots => |_, slot| slot,
            InstanceNumbers::Handles => |scene, slot| scene.handle(slot).map_or(slot, |h| h.index),
            InstanceNumbers::Users => |scene, slot| scene.user_data(slot) as u32,
        };
        if self.numbers != InstanceNumbers::Slots {
            self.instances.iter_mut().for_each(|i| *i = number(scene, *i));
        }
        self.sorter.sort_by_seven(&mut self.entries, |(key, command)| {
            let DrawKey { state, material, mesh, part, level } = *key;
            [state.0, material, mesh, part, level, command.first_instance, command.first_index]
        });
        self.keys.extend(self.entries.iter().map(|e| e.0));
        self.commands.extend(self.entries.iter().map(|e| e.1));
    }
}

fn key(mesh: &Mesh, (id, state, level): (MeshId, DrawState, u32), part: u32) -> DrawKey {
    let material = mesh.parts()[part as usize].material;
    DrawKey { state: state.with_part(mesh, part), material, mesh: id, part, level }
}

fn variant_of(scene: &Scene, slot: u32) -> usize {
    scene.mesh_id(slot) as usize * VARIANTS + DrawState::of(scene, slot).0 as usize
}
