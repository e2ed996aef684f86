//! Components of an entity that its visibility depends on.

use std::any::TypeId;

use bevy_camera::primitives::{Aabb, Sphere};
use bevy_camera::visibility::{
    DynamicSkinnedMeshBounds, InheritedVisibility, NoCpuCulling, NoFrustumCulling, RenderLayers,
    ViewVisibility, VisibilityClass, VisibilityRange,
};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_math::{Affine3A, Vec3A};
use bevy_mesh::Mesh3d;
use bevy_mesh::morph::{MeshMorphWeights, MorphWeights};
use bevy_mesh::skinning::SkinnedMesh;
use bevy_transform::components::GlobalTransform;
use engine::{Transform, scene::BoundsOverride};

/// An entity that is listed whatever is in front of it, for cameras with
/// [`CulletOcclusion`](crate::CulletOcclusion).
///
/// Put it where a material of yours draws through what is in front: by a `depth_compare` other than
/// Bevy's, or a bias of depth. With the feature `pbr` a `StandardMaterial` with a `depth_bias` has
/// this by itself.
#[derive(Clone, Copy, Component, Debug, Default)]
pub struct NoCulletOcclusion;

/// The layer of the engine that stands for all layers of Bevy from this one on.
const LAST_LAYER: u32 = 31;

/// Entities that are culled on the CPU as meshes.
pub(crate) type OfMesh = (With<Mesh3d>, With<ViewVisibility>, Without<NoCpuCulling>);

/// All of an entity that its visibility depends on.
#[derive(QueryData)]
pub(crate) struct Seen {
    pub(crate) entity: Entity,
    pub(crate) inherited: &'static InheritedVisibility,
    pub(crate) class: Option<&'static VisibilityClass>,
    pub(crate) layers: Option<&'static RenderLayers>,
    pub(crate) aabb: Option<&'static Aabb>,
    pub(crate) sphere: Option<&'static Sphere>,
    pub(crate) transform: &'static GlobalTransform,
    pub(crate) no_frustum_culling: Has<NoFrustumCulling>,
    pub(crate) ranged: Has<VisibilityRange>,
    pub(crate) is_skinned: Has<SkinnedMesh>,
    has_dynamic_bounds: Has<DynamicSkinnedMeshBounds>,
    shines_through: Has<NoCulletOcclusion>,
    is_morphed: Has<MeshMorphWeights>,
    has_weights: Has<MorphWeights>,
}

impl SeenItem<'_, '_> {
    /// Whether more is to be asked than box and layers: ranges, layers beyond those of the engine,
    /// a sphere in place of a box, or lists of other classes.
    pub(crate) fn needs_check(&self) -> bool {
        let is_plain = |class: &VisibilityClass| class.0[..] == [TypeId::of::<Mesh3d>()];
        self.ranged
            || self.aabb.is_none() && self.sphere.is_some()
            || !self.class.is_some_and(is_plain)
            || self.layers.is_some_and(|layers| mask(layers) >> LAST_LAYER != 0)
    }

    pub(crate) fn has_morphs(&self) -> bool {
        self.is_morphed || self.has_weights
    }

    /// Whether it is tested against the frustum, as Bevy does, but never taken for hidden: it says
    /// so, or its vertices may lie outside its `Aabb`, which is that of the pose in which it was
    /// made.
    pub(crate) fn is_never_hidden(&self) -> bool {
        self.shines_through || self.has_morphs() || self.is_skinned && !self.has_dynamic_bounds
    }

    pub(crate) fn transform(&self) -> Transform {
        let at = self.transform.affine();
        let linear = [at.matrix3.x_axis, at.matrix3.y_axis, at.matrix3.z_axis];
        let translation = at.translation.as_dvec3().to_array();
        Transform { linear: linear.map(|axis| axis.to_array()), translation }
    }

    pub(crate) fn layers(&self) -> u32 {
        if self.inherited.get() { mask(self.layers.unwrap_or_default()) } else { 0 }
    }

    pub(crate) fn bounds(&self) -> BoundsOverride {
        let bounds = match (self.aabb, self.sphere) {
            (Some(aabb), _) => world_box(aabb, &self.transform.affine()),
            (None, Some(s)) => around(s.center, Vec3A::splat(s.radius)),
            (None, None) => return BoundsOverride::None,
        };
        if bounds.is_finite() && !bounds.is_empty() {
            BoundsOverride::World(bounds)
        } else {
            BoundsOverride::None
        }
    }
}

/// Layers of Bevy as those of the engine: the first 31 are themselves, all others are the last.
pub(crate) fn mask(layers: &RenderLayers) -> u32 {
    let words = layers.bits();
    let first = words.first().copied().unwrap_or(0);
    let low = first as u32 & !(1 << LAST_LAYER);
    let others = first >> LAST_LAYER != 0 || words.iter().skip(1).any(|&word| word != 0);
    low | u32::from(others) << LAST_LAYER
}

/// A box in world space that holds a box of an entity, whatever f32 rounds.
pub(crate) fn world_box(aabb: &Aabb, at: &Affine3A) -> engine::bounds::Aabb {
    let m = &at.matrix3;
    let e = aabb.half_extents.abs();
    let extents = m.x_axis.abs() * e.x + m.y_axis.abs() * e.y + m.z_axis.abs() * e.z;
    let c = aabb.center.abs();
    let sizes = m.x_axis.abs() * c.x + m.y_axis.abs() * c.y + m.z_axis.abs() * c.z;
    // Four terms and their sums, each rounded by half of f32::EPSILON.
    let slack = (sizes + at.translation.abs() + extents) * (4.0 * f32::EPSILON);
    around(at.transform_point3a(aabb.center), extents + slack)
}

fn around(center: Vec3A, extents: Vec3A) -> engine::bounds::Aabb {
    // What cannot be told from a point still has to lie inside.
    let slack = (center.abs() + extents) * (2.0 * f32::EPSILON);
    let extents = extents + slack;
    engine::bounds::Aabb::new((center - extents).to_array(), (center + extents).to_array())
}
