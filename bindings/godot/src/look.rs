//! What one drawn node says of itself: where it may be drawn, whether it hides, whether it casts.

use godot::builtin::Aabb;
use godot::classes::geometry_instance_3d::ShadowCastingSetting;
use godot::classes::{
    CsgShape3D, GeometryInstance3D, Label3D, Mesh, MeshInstance3D, MultiMeshInstance3D, SoftBody3D,
    SpriteBase3D, label_3d, sprite_base_3d,
};
use godot::obj::InstanceId;
use godot::prelude::*;

use crate::convert::Grown;
use crate::marks::Mark;
use crate::material::{Facts, Materials, Reach};
use crate::meshes::MeshFacts;

/// Kinds of drawn nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A `MeshInstance3D`.
    Mesh,
    /// A `MultiMeshInstance3D`: one instance for Godot, whose parts may hide others.
    Multi,
    /// The root of a tree of CSG shapes.
    Csg,
    /// A sprite or a label, which makes its mesh by itself.
    Flat,
    /// A `GridMap`: Godot draws its cells by instances of its own, which cannot be hidden.
    Grid,
    /// Particles, soft bodies and whatever else draws: never hidden.
    Other,
}

/// What a node's bounds are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bounds {
    /// A box in the space of the node, grown.
    Box(Aabb, Grown),
    /// Unknown: it is never hidden.
    Unknown,
}

/// How a node casts shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Casts {
    Off,
    On,
    /// Hiding it from cameras alone would make its shadow one-sided.
    DoubleSided,
    /// It is drawn for shadows alone, by the user's own wish.
    Only,
}

/// What a node says of itself.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Look {
    /// The node's own box, as Godot has it.
    pub(crate) aabb: Aabb,
    pub(crate) bounds: Bounds,
    pub(crate) layers: u32,
    pub(crate) casts: Casts,
    /// The mesh, where it has one mesh.
    pub(crate) mesh: Option<InstanceId>,
    /// Whether its mesh hides what is behind it: `Some` with whether both sides are drawn.
    pub(crate) hides: Option<bool>,
}

impl Look {
    /// A node that is drawn whatever happens, and hides nothing.
    pub(crate) const UNKNOWN: Self = Self {
        aabb: Aabb { position: Vector3::ZERO, size: Vector3::ZERO },
        bounds: Bounds::Unknown,
        layers: u32::MAX,
        casts: Casts::On,
        mesh: None,
        hides: None,
    };
}

/// Returns the kind of a node; `None` for one that draws nothing by itself.
pub(crate) fn kind(node: &Gd<GeometryInstance3D>) -> Option<Kind> {
    if node.is_class("MeshInstance3D") {
        let is_soft = node.clone().try_cast::<SoftBody3D>().is_ok();
        return Some(if is_soft { Kind::Other } else { Kind::Mesh });
    }
    if node.is_class("MultiMeshInstance3D") {
        return Some(Kind::Multi);
    }
    if let Ok(shape) = node.clone().try_cast::<CsgShape3D>() {
        // Shapes below another are part of that one's mesh; they may become roots later, and are
        // asked again then, as they leave the tree for it.
        return shape.is_root_shape().then_some(Kind::Csg);
    }
    if node.is_class("SpriteBase3D") || node.is_class("Label3D") {
        return Some(Kind::Flat);
    }
    Some(Kind::Other)
}

/// Returns the mesh of a node.
pub(crate) fn mesh(node: &Gd<GeometryInstance3D>, kind: Kind) -> Option<Gd<Mesh>> {
    match kind {
        Kind::Mesh => node.clone().try_cast::<MeshInstance3D>().ok()?.get_mesh(),
        Kind::Multi => {
            node.clone().try_cast::<MultiMeshInstance3D>().ok()?.get_multimesh()?.get_mesh()
        }
        Kind::Csg => {
            let meshes = node.clone().try_cast::<CsgShape3D>().ok()?.get_meshes();
            meshes.get(1)?.try_to::<Gd<Mesh>>().ok()
        }
        Kind::Flat | Kind::Grid | Kind::Other => None,
    }
}

/// Looks at a node.
pub(crate) fn look(
    node: &Gd<GeometryInstance3D>,
    kind: Kind,
    mark: Mark,
    materials: &mut Materials,
    facts_of: &mut dyn FnMut(&Gd<Mesh>) -> MeshFacts,
) -> Look {
    let layers = node.get_layer_mask();
    let casts = match node.get_cast_shadows_setting() {
        ShadowCastingSetting::OFF => Casts::Off,
        ShadowCastingSetting::DOUBLE_SIDED => Casts::DoubleSided,
        ShadowCastingSetting::SHADOWS_ONLY => Casts::Only,
        _ => Casts::On,
    };
    let nothing = Look { layers, casts, ..Look::UNKNOWN };
    if kind == Kind::Other || node.is_ignoring_occlusion_culling() {
        return nothing;
    }
    let own = node.get_custom_aabb();
    let margin = node.get_extra_cull_margin();
    let has_own = own.size != Vector3::ZERO;
    let mesh = mesh(node, kind);
    let of_mesh = mesh.as_ref().map(&mut *facts_of);
    let surface = surfaces(node, kind, mesh.as_ref(), of_mesh, materials);
    let is_deformed = of_mesh.is_some_and(|facts| facts.deforms);
    // Who puts a `CulletOccluder` says that shaders move nothing.
    let reach = match surface.reach {
        Reach::Moved if mark.hides.is_some() => Reach::Mesh(0.0),
        reach => reach,
    };
    let plain = node.get_aabb();
    let aabb = if has_own { plain.abs().merge(own.abs()) } else { plain };
    let bounds = match reach {
        Reach::Through => Bounds::Unknown,
        // Bounds of the user's say how far vertices may go.
        Reach::Moved if !has_own && margin <= 0.0 => Bounds::Unknown,
        _ if is_deformed && !has_own => Bounds::Unknown,
        Reach::Mesh(grow) => {
            let size = grow.max(0.0);
            let aabb = if size > 0.0 { aabb.grow(size) } else { aabb };
            Bounds::Box(aabb, Grown { margin, is_ball: false })
        }
        Reach::Moved => Bounds::Box(aabb, Grown { margin, is_ball: false }),
        Reach::Ball => Bounds::Box(aabb, Grown { margin, is_ball: true }),
    };
    let is_solid = matches!(bounds, Bounds::Box(..))
        && !mark.never_hides
        && !has_own
        && margin <= 0.0
        && !is_deformed
        && casts != Casts::Only
        && node.get_transparency() == 0.0
        && node.get_visibility_range_begin() <= 0.0
        && node.get_visibility_range_end() <= 0.0
        && node.get_visibility_parent().is_empty()
        && of_mesh.is_some_and(|facts| facts.hides);
    let hides = is_solid.then(|| mark.hides.or(surface.hides)).flatten();
    Look { aabb: plain, bounds, mesh: mesh.map(|mesh| mesh.instance_id()), hides, ..nothing }
}

/// Returns the facts of all that a node draws.
fn surfaces(
    node: &Gd<GeometryInstance3D>,
    kind: Kind,
    mesh: Option<&Gd<Mesh>>,
    of_mesh: Option<MeshFacts>,
    materials: &mut Materials,
) -> Facts {
    let mut facts = if kind == Kind::Flat { flat(node) } else { Facts::PLAIN };
    let count = of_mesh.map_or(0, |facts| facts.surfaces);
    // Two-sided where every surface is.
    let mut all: Option<Facts> = None;
    let mut add = |one: Facts| all = Some(all.map_or(one, |all| all.and(one)));
    match (node.get_material_override(), mesh) {
        (Some(material), _) => add(materials.facts(Some(material))),
        (None, Some(mesh)) => {
            let instance = node.clone().try_cast::<MeshInstance3D>().ok();
            for surface in 0..count {
                let own = instance.as_ref().and_then(|i| i.get_surface_override_material(surface));
                add(materials.facts(own.or_else(|| mesh.surface_get_material(surface))));
            }
        }
        (None, None) => {}
    }
    if let Some(all) = all {
        facts = if kind == Kind::Flat { facts.and(all) } else { all };
    }
    if let Some(overlay) = node.get_material_overlay() {
        let reach = materials.facts(Some(overlay)).reach;
        facts = facts.and(Facts { hides: facts.hides, reach });
    }
    facts
}

/// Returns the facts of a sprite's or label's own material.
fn flat(node: &Gd<GeometryInstance3D>) -> Facts {
    let mut is_through = true;
    if let Ok(sprite) = node.clone().try_cast::<SpriteBase3D>() {
        use sprite_base_3d::DrawFlags;
        is_through = sprite.get_draw_flag(DrawFlags::DISABLE_DEPTH_TEST)
            || sprite.get_draw_flag(DrawFlags::FIXED_SIZE);
    } else if let Ok(label) = node.clone().try_cast::<Label3D>() {
        use label_3d::DrawFlags;
        is_through = label.get_draw_flag(DrawFlags::DISABLE_DEPTH_TEST)
            || label.get_draw_flag(DrawFlags::FIXED_SIZE);
    }
    Facts { hides: None, reach: if is_through { Reach::Through } else { Reach::Ball } }
}
