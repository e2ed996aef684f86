//! Groups of instances merged into one mesh with levels of detail, each of which may stand for all
//! of them where it is far away ([`Scene::stand_for`](cullet::Scene::stand_for)).
//!
//! Instances are grouped by place, groups are grouped again, and so on. The surface of a group is
//! simplified as one: what was a border of a mesh is none any more, and what is small beside its
//! neighbours goes. The error of each level is measured against the instances in full. A group that
//! has no fewer triangles than its members at the same error is none.
//!
//! After C. Erikson, D. Manocha, W. Baxter, *HLODs for faster display of large static and dynamic
//! environments*, 2001.

mod build;
mod fewest;
mod keep;
mod made;
mod tree;

use cullet::{Handle, Instance, Scene, SceneError, Transform};
use thiserror::Error;

use crate::levels::{LevelsData, LevelsError};

pub use crate::gather::MeshAttributes;
pub use keep::Keep;

/// A group of instances, as it is baked.
#[derive(Clone, Debug, PartialEq)]
pub struct MergedGroup {
    /// Levels whose finest is left out: where even the first is off by too much, the members are
    /// drawn.
    pub levels: LevelsData,
    /// Texture coordinates of the vertices of the levels' mesh; empty where no instance has any.
    pub uvs: Vec<[f32; 2]>,
    /// Their colours, linear and with alpha; empty where no instance has any.
    pub colors: Vec<[f32; 4]>,
    /// Where the mesh's origin is in the world.
    pub origin: [f64; 3],
    /// Members that it stands for.
    pub members: Vec<Member>,
}

/// Member that a group stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Member {
    /// The instance of a slot of the scene.
    Instance(u32),
    /// Another group, by its number, which is lower than that of the group.
    Group(u32),
}

/// How errors of groups are found: by so many points of each triangle, up to a million of a group,
/// to the surface of the instances and back; the error that is stated is 1.05 times the largest
/// distance of all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PointsMeasured {
    /// Points of each triangle of the instances, beside its corners.
    pub points: u32,
    /// Points of each simplified triangle.
    pub reverse_points: u32,
    /// Seed of the points.
    pub seed: u64,
}

/// How errors of groups are found.
pub const MEASURED: PointsMeasured =
    PointsMeasured { points: 2, reverse_points: 4, seed: 0x6d65_7267_6564 };

/// Options that decide which groups are made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MergeOptions {
    /// The most instances of the smallest groups, 2 to 64. Default 8.
    pub smallest: u32,
    /// How many groups a larger one is made of at the most: a power of two from 2 to 64. Default 8.
    pub fan: u32,
    /// Groups have no more triangles than this, all instances counted: what is measured at once has
    /// to fit in memory. Default 2,000,000.
    pub most_triangles: u64,
    /// The error of the first level of a group, in radii of it; above 0. Default 1/800: a pixel of
    /// 60° and 720 lines at a distance of some 0.8 radii.
    pub first: f64,
    /// How many levels a group has at the most, each of twice the error of the one before: 1 to 16.
    /// Default 4.
    pub levels: u32,
    /// How many triangles it must have at the most, of those that its members have at the same
    /// error: above 0, at most 1. Default 0.8.
    pub keep: f64,
    /// On how many threads, from 1. The result is the same.
    pub threads: usize,
}

impl Default for MergeOptions {
    fn default() -> Self {
        Self {
            smallest: 8,
            fan: 8,
            most_triangles: 2_000_000,
            first: 1.0 / 800.0,
            levels: 4,
            keep: 0.8,
            threads: 1,
        }
    }
}

/// Input of merging beside the scene.
#[derive(Clone, Copy, Default)]
pub struct MergeInput<'a> {
    /// Attributes of the scene's meshes, by their numbers; meshes beyond the end have none.
    pub attributes: &'a [MeshAttributes<'a>],
    /// Where finished groups are kept, and found again.
    pub keep: Option<&'a dyn Keep>,
    /// Do only the i-th of n shares, `[i, n]` with i from 0, for others to find where finished
    /// groups are kept; nothing comes of it here. At each level of the tree its own groups are made
    /// first; those of others that are not there by then too, but for the topmost, which nobody
    /// needs. Default: all.
    pub share: Option<[u32; 2]>,
}

impl std::fmt::Debug for MergeInput<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (attributes, keep) = (self.attributes.len(), self.keep.is_some());
        f.debug_struct("MergeInput")
            .field("attributes", &attributes)
            .field("keep", &keep)
            .field("share", &self.share)
            .finish()
    }
}

impl MergeOptions {
    fn check(&self) -> Result<(), LevelsError> {
        let range = |what, value: f64, is_in: bool, allowed| match is_in {
            true => Ok(()),
            false => Err(LevelsError::Value { what, value, allowed }),
        };
        let (smallest, fan) = (self.smallest, self.fan);
        range("smallest", smallest.into(), (2..=64).contains(&smallest), "2 to 64")?;
        let is_fan = (2..=64).contains(&fan) && fan.is_power_of_two();
        range("fan", fan.into(), is_fan, "a power of two from 2 to 64")?;
        let first = self.first;
        range("first", first, first > 0.0 && first <= 1.0, "above 0, to 1")?;
        range("levels", self.levels.into(), (1..=16).contains(&self.levels), "1 to 16")?;
        range("keep", self.keep, self.keep > 0.0 && self.keep <= 1.0, "above 0, to 1")?;
        range("threads", self.threads as f64, (1..=1024).contains(&self.threads), "1 to 1024")
    }
}

/// Merges groups of a scene's instances. `go_on` is asked before each group, with the share of all
/// work that is done, and ends it where it says no: `None`.
///
/// Members are instances that are drawn just as their mesh says, in the same layers and with the
/// same flags, whose materials are not blended; those much larger than their neighbours, such as a
/// ground, are left alone. The levels that their meshes have are used, and are better there before.
/// Groups have parts by material. Vertices keep texture coordinates and colours where they have
/// some, and zeros and white where others of the group have some: where these differ at one place a
/// seam is kept, as in meshes. They have no normals.
///
/// With [`MergeInput::keep`], groups of many triangles are taken from there where instances, levels
/// and options are as they were, and kept there as soon as they are finished; the result is the
/// same.
///
/// Some 10 µs a triangle of all instances and level of the tree, of which there are some log₈ of
/// their number.
///
/// # Errors
/// If an option is out of range.
pub fn merge(
    scene: &Scene,
    input: &MergeInput<'_>,
    options: &MergeOptions,
    go_on: impl Fn(f64) -> bool + Sync,
) -> Result<Option<Vec<MergedGroup>>, LevelsError> {
    options.check()?;
    build::build(scene, input, options, &go_on)
}

/// Adds groups to the scene that they were merged of, whose slots are as they were: the slots of
/// their instances.
///
/// # Errors
/// If something does not fit the scene, as after a change; then some are added and others not.
pub fn add_to_scene(scene: &mut Scene, groups: &[MergedGroup]) -> Result<Vec<Handle>, MergedError> {
    let mut added: Vec<Handle> = Vec::with_capacity(groups.len());
    for group in groups {
        let (mesh, levels) = group.levels.clone().into_levels()?;
        let mesh = scene.add_mesh(mesh);
        scene.add_levels(mesh, mesh, levels).map_err(LevelsError::from)?;
        let members = group.members.iter().map(|member| match *member {
            Member::Instance(slot) => scene.handle(slot),
            Member::Group(number) => added.get(number as usize).copied(),
        });
        let members: Option<Vec<Handle>> = members.collect();
        let transform = Transform::from_translation(group.origin);
        let own = scene.add(Instance::new(mesh, transform))?;
        scene.stand_for(own, &members.ok_or(MergedError::NoMember)?)?;
        added.push(own);
    }
    Ok(added)
}

/// Why groups do not fit a scene.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MergedError {
    /// The levels of a group.
    #[error(transparent)]
    Levels(#[from] LevelsError),
    /// An instance of the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// There is no such instance or group any more.
    #[error("a group stands for an instance or a group that is not there")]
    NoMember,
}
