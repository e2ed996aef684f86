//! Instances: what is added to a scene, and what the scene answers with.

use thiserror::Error;

use crate::bounds::Aabb;
use crate::hierarchy::{Handle, HierarchyError};
use crate::transform::Transform;

/// The number of a mesh in its scene.
pub type MeshId = u32;

/// The mesh of an [instance of bounds alone](Instance::of_bounds).
const NO_MESH: MeshId = MeshId::MAX;

/// Flags of an instance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct InstanceFlags {
    /// No stage but the layer mask may cull it.
    pub always_visible: bool,
    /// The instance never serves as an occluder.
    pub no_occlusion: bool,
    /// Both sides of its triangles are drawn, whatever its mesh says.
    pub double_sided: bool,
    /// The instance is blended, whatever its mesh says.
    pub transparent: bool,
    /// The instance will move: a commit puts it next to others that will, so that it does not
    /// enlarge the nodes of static ones. This is only a hint: any instance may move.
    pub dynamic: bool,
}

/// Bounds that the caller gives an instance in place of those of its mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum BoundsOverride {
    /// The box of the mesh, transformed.
    #[default]
    Mesh,
    /// There are no bounds: the instance is visible to every stage.
    None,
    /// A box in world space, relative to the scene's origin.
    World(Aabb),
    /// The box of the mesh, grown on every side by this distance in world units: for vertices that
    /// a shader displaces. A distance below 0 counts as 0; one that is NaN or infinite means that
    /// there are no bounds.
    Margin(f32),
}

/// An instance to add to a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Instance {
    /// Number of its mesh.
    pub mesh: MeshId,
    /// Transform from the space of the mesh to the world.
    pub transform: Transform,
    /// Layers of the instance, one bit each. With 0 it is in no layer and never drawn.
    pub layers: u32,
    /// Flags of the instance.
    pub flags: InstanceFlags,
    /// Bounds of the instance.
    pub bounds: BoundsOverride,
    /// Factor by which its size on the screen counts for [`Culler::detail`](crate::Culler::detail).
    /// A factor of 2 culls it where an instance of twice its size and weight 1 would be. One that
    /// is infinite, NaN or below 0 means that it is never culled for its size. Default 1.
    pub size_weight: f32,
    /// A number of the caller's, such as the entity that it stands for. The engine only keeps it.
    pub user_data: u64,
}

impl Instance {
    /// An instance of `mesh` at `transform`, in layer 0 alone.
    #[must_use]
    pub fn new(mesh: MeshId, transform: Transform) -> Self {
        Self {
            mesh,
            transform,
            layers: 1,
            flags: InstanceFlags::default(),
            bounds: BoundsOverride::Mesh,
            size_weight: 1.0,
            user_data: 0,
        }
    }
}

/// State of a scene in which slots and clusters have the numbers that a result gives them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneVersion {
    /// Id of the scene; 0 is no scene.
    pub scene: u64,
    /// [Version of its order](super::Scene::order_version).
    pub order: u64,
    /// Rises whenever its meshes or their levels are edited.
    pub meshes: u64,
}

impl core::fmt::Display for SceneVersion {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { scene, order, meshes } = self;
        match scene {
            0 => f.write_str("no scene"),
            _ => write!(f, "scene {scene} (order {order}, meshes {meshes})"),
        }
    }
}

impl Instance {
    /// An instance without a mesh, in layer 0 alone: something of the caller's that lies within
    /// `bounds`, relative to the scene's origin. It hides nothing, has no triangles and no draws;
    /// [`Visible::slots`](crate::Visible::slots) lists it where it is visible. Bounds that are
    /// empty or not finite say nothing: such an instance is always visible. Move it by
    /// [`Scene::set_bounds`] or [`Scene::write_bounds`].
    ///
    /// All of a scene share one empty mesh, which takes one [`MeshId`].
    ///
    /// [`Scene::set_bounds`]: super::Scene::set_bounds
    /// [`Scene::write_bounds`]: super::Scene::write_bounds
    #[must_use]
    pub fn of_bounds(bounds: Aabb) -> Self {
        let is_known = bounds.is_finite() && !bounds.is_empty();
        let bounds = if is_known { BoundsOverride::World(bounds) } else { BoundsOverride::None };
        Self { bounds, ..Self::new(NO_MESH, Transform::IDENTITY) }
    }

    /// Whether it is of bounds alone.
    pub(super) fn has_no_mesh(&self) -> bool {
        self.mesh == NO_MESH
    }
}

/// Why a scene refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The handle's instance was removed, or the handle is of another scene.
    #[error("handle {0:?} names no instance of this scene")]
    NoInstance(Handle),
    /// The instance stands for others, and so is in no layer.
    #[error("{0:?} stands for others: set the layers of those")]
    StandIn(Handle),
    /// The mesh of what was to [stand for others](super::Scene::stand_for) has nothing that could
    /// be drawn in their place.
    #[error("the mesh of {0:?} has no levels of detail")]
    NoLevels(Handle),
    /// An instance that nothing can stand for: it is not drawn just as its mesh says, or must be
    /// drawn always.
    #[error(
        "{0:?} deforms, has bounds of its own or none, or is always visible: it is drawn as itself"
    )]
    NotRigid(Handle),
    /// One instance at the most stands for another.
    #[error("{0:?} is stood for already, or stands for others or itself")]
    Taken(Handle),
    /// There is no such mesh.
    #[error("mesh {mesh} of {meshes}")]
    NoMesh {
        /// The requested mesh.
        mesh: MeshId,
        /// How many there are.
        meshes: usize,
    },
    /// An instance has the mesh that was to be [removed](super::Scene::remove_mesh).
    #[error("mesh {mesh} is that of {instance:?}: remove its instances first")]
    MeshInUse {
        /// The mesh.
        mesh: MeshId,
        /// One of its instances.
        instance: Handle,
    },
    /// A result is of another scene, or its slots or clusters have other numbers by now.
    #[error("a result of {result} does not fit {scene}: cull the scene as it is now")]
    Stale {
        /// Versions that the result is of.
        result: SceneVersion,
        /// Versions of the scene as it is.
        scene: SceneVersion,
    },
    /// Slots are u32.
    #[error("a scene holds at most {0} instances")]
    Full(u32),
    /// Current positions given to [`Scene::audit`](super::Scene::audit) do not fit the mesh.
    #[error("{given} positions were given for {handle:?}, but its mesh has {vertices} vertices")]
    Positions {
        /// The instance.
        handle: Handle,
        /// How many positions were given.
        given: usize,
        /// How many vertices its mesh has.
        vertices: usize,
    },
}

impl From<HierarchyError> for SceneError {
    fn from(error: HierarchyError) -> Self {
        match error {
            HierarchyError::NoItem(handle) => Self::NoInstance(handle),
            HierarchyError::Full(limit) => Self::Full(limit),
        }
    }
}
