//! Baked data of a model's meshes, as `CULLET_baked` of a GLB holds it: levels, and how their
//! errors were measured.
//!
//! [`load`](crate::load) gives the scene the levels that a file has; [`save`](crate::save()) writes
//! those that [`Model::baked`](crate::Model::baked) names. What does not fit the mesh beside it is
//! left out with a warning: the plain mesh is always right, and levels of another would be a wrong
//! picture.

mod cell_sets;
mod container;
mod error;
mod hash;
mod impostor;
mod occluder_bytes;
mod occluder_shapes;
mod occluders;
mod scene_join;
mod scene_sets;
mod stand_ins;
mod tables;

use cullet::{Mesh, MeshData, MeshId};

pub use cell_sets::{CellSets, PvsFileError};
pub use container::{Container, ContainerError, Tag, write_chunks};
pub use error::BakedError;
pub(crate) use hash::root_sum;
pub use hash::{Sum, graph_hash, hash, mix};
pub(crate) use impostor::impostor_sum;
pub use impostor::{impostor_from_bytes, impostor_to_bytes};
pub(crate) use occluder_bytes::occluder_sum;
pub use occluder_shapes::{BOX_QUADS, box_corners};
pub use occluders::{OccluderPolygon, OccluderSheet, Occluders, pays};
pub use scene_sets::{InstanceMark, Region, SceneSets, SceneSetsError, instance_marks, scene_hash};
pub(crate) use stand_ins::{StandInTables, attribute_sum, sum_of as sum_of_stand_ins};
pub use tables::{ClusterRow, LevelTables};
pub(crate) use tables::{ROWS, sum_of};

/// The version of the extension that is written, and the only one that is read.
pub const VERSION: u32 = 1;

/// Tables begin at multiples of this, in the file as it lies: a line of the cache, and more than
/// any type needs.
pub const TABLE_ALIGNMENT: usize = 64;

/// The most sets of levels of one mesh that are read.
pub const MOST_LEVELS: usize = 8;

/// Baked data of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Baked {
    /// Program that baked it, with its version; empty for this crate.
    pub generator: String,
    /// The meshes with something baked, or with something in the file that does not fit them.
    pub meshes: Vec<BakedMesh>,
    /// How the errors were found of instances that [stand for others](cullet::Scene::stand_for),
    /// where there are any.
    pub stand_ins: Option<Measured>,
    /// Why all of it was left out, where it was.
    pub problem: Option<BakedError>,
}

impl Baked {
    /// Returns the baked data of a mesh.
    #[must_use]
    pub fn of(&self, mesh: MeshId) -> Option<&BakedMesh> {
        self.meshes.iter().find(|m| m.mesh == mesh)
    }

    /// How many meshes of the scene are there only to hold the levels of others. In a model that
    /// was loaded they come last.
    #[must_use]
    pub fn held_count(&self) -> usize {
        self.meshes.iter().map(|m| m.levels.len()).sum()
    }

    /// Whether a mesh of the scene is there only to hold the levels of another.
    #[must_use]
    pub fn holds_levels(&self, mesh: MeshId) -> bool {
        self.meshes.iter().any(|m| m.levels.iter().any(|l| l.held_by == mesh))
    }
}

/// Baked data of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakedMesh {
    /// The mesh.
    pub mesh: MeshId,
    /// [`geometry_hash`] of the mesh that it was baked of.
    pub geometry: u64,
    /// Its levels, in the order in which the scene has them.
    pub levels: Vec<BakedLevels>,
    /// Its occluders, where they were baked.
    pub occluders: Option<Occluders>,
    /// Bytes of its levels in the file; 0 where it comes from none.
    pub bytes: u64,
    /// Why it was left out, where it was.
    pub problem: Option<BakedError>,
}

/// Levels of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakedLevels {
    /// Kind of the levels.
    pub kind: LevelKind,
    /// The mesh of the scene that holds them.
    pub held_by: MeshId,
    /// How their errors were found.
    pub measured: Measured,
}

/// Kind of levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LevelKind {
    /// Whole meshes, each of fewer triangles than the one before.
    Chain,
    /// Clusters, simplified in groups that meet without cracks.
    Hierarchy,
    /// An impostor: pictures from all around, drawn in the box of the mesh. Its
    /// [`Measured::points`] are the directions from which its error was measured.
    Impostor,
}

impl LevelKind {
    /// Its name, as the file has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Chain => "chain",
            Self::Hierarchy => "hierarchy",
            Self::Impostor => "impostor",
        }
    }

    /// The kind of levels of triangles that has that name.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        [Self::Chain, Self::Hierarchy].into_iter().find(|kind| kind.name() == name)
    }
}

/// How the errors of levels were found: from points of the surface, at random from a seed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Points of each triangle of the original from which the simplified surface was looked for,
    /// beside its corners.
    pub points: u32,
    /// Points of each simplified triangle from which the original was looked for.
    pub reverse_points: u32,
    /// The share of points that are not farther off than the error.
    pub quantile: f64,
    /// Bound that no measured point exceeds, as a factor of the error.
    pub most_over: f64,
    /// Seed of the points; below 2⁵³.
    pub seed: u64,
}

/// Hash of what levels depend on: positions, triangles in their original order, and how many of
/// them each part has that has any. The same for a mesh and for what is loaded from the file that
/// it was saved to. O(size of the mesh).
#[must_use]
pub fn geometry_hash(mesh: &Mesh) -> u64 {
    let counts = mesh.parts().iter().map(|p| p.triangle_count);
    hash_of(mesh.positions(), &mesh.original_indices(), counts)
}

/// [`geometry_hash`] of a mesh that is yet to be made, its parts given.
pub(crate) fn geometry_hash_of(data: &MeshData) -> u64 {
    hash_of(&data.positions, &data.indices, data.parts.iter().map(|p| p.triangle_count))
}

fn hash_of(positions: &[[f32; 3]], indices: &[u32], parts: impl Iterator<Item = u32>) -> u64 {
    let mut sum = Sum::new(positions.len() as u64);
    positions.iter().for_each(|&[x, y, z]| {
        sum.add(u64::from(x.to_bits()) | u64::from(y.to_bits()) << 32);
        sum.add(u64::from(z.to_bits()));
    });
    indices.chunks(2).for_each(|pair| {
        sum.add(pair.iter().rev().fold(0, |word, &v| word << 32 | u64::from(v)));
    });
    parts.filter(|&count| count > 0).for_each(|count| sum.add(u64::from(count) | 1 << 32));
    sum.end()
}
