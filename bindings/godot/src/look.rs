//! The look of a drawn node: where it may be drawn, whether it hides, whether it casts.

use godot::builtin::Aabb;
use godot::classes::geometry_instance_3d::ShadowCastingSetting;
use godot::classes::{
    CsgShape3D, GeometryInstance3D, Label3D, Mesh, MeshInstance3D, MultiMeshInstance3D, SoftBody3D,
    SpriteBase3D, label_3d, sprite_base_3d,
};
use godot::obj::InstanceId;
use godot::prelude::*;

use crate::convert::Grown;
use crate::inbox::Inbox;
use crate::marks::Mark;
use crate::material::{Facts, Hiding, Materials, Reach};
use crate::meshes::Meshes;

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

/// Bounds of a node.
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

/// Everything that a node says of itself.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Look {
    /// The node's own box, as Godot has it.
    pub(crate) aabb: Aabb,
    pub(crate) bounds: Bounds,
    /// How far a pass or an overlay draws beyond the mesh, in its units.
    pub(crate) grow: f32,
    pub(crate) layers: u32,
    pub(crate) casts: Casts,
    /// The mesh, where it has one mesh, and its version.
    pub(crate) mesh: Option<(InstanceId, u64)>,
    /// Number by which Godot's server draws it: that of the mesh, or of the MultiMesh.
    pub(crate) base: Rid,
    /// The surfaces of its mesh that hide what is behind them.
    pub(crate) hides: Option<Hiding>,
}

impl Look {
    /// A node that is drawn whatever happens, and hides nothing.
    pub(crate) const UNKNOWN: Self = Self {
        aabb: Aabb { position: Vector3::ZERO, size: Vector3::ZERO },
        bounds: Bounds::Unknown,
        grow: 0.0,
        layers: u32::MAX,
        casts: Casts::On,
        mesh: None,
        base: Rid::Invalid,
        hides: None,
    };
}

/// Returns the kind of a node; `None` for one that draws nothing by itself.
pub(crate) fn kind(node: &Gd<GeometryInstance3D>) -> Option<Kind> {
    if node.clone().try_cast::<MeshInstance3D>().is_ok() {
        let is_soft = node.clone().try_cast::<SoftBody3D>().is_ok();
        return Some(if is_soft { Kind::Other } else { Kind::Mesh });
    }
    if node.clone().try_cast::<MultiMeshInstance3D>().is_ok() {
        return Some(Kind::Multi);
    }
    if let Ok(shape) = node.clone().try_cast::<CsgShape3D>() {
        // Shapes below another are part of that one's mesh; they may become roots later, and are
        // asked again then, as they leave the tree for it.
        return shape.is_root_shape().then_some(Kind::Csg);
    }
    let is_sprite = node.clone().try_cast::<SpriteBase3D>().is_ok();
    if is_sprite || node.clone().try_cast::<Label3D>().is_ok() {
        return Some(Kind::Flat);
    }
    Some(Kind::Other)
}

/// A drawn node by its own class, so that asking it takes no cast.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    pub(crate) node: Gd<GeometryInstance3D>,
    instance: Option<Gd<MeshInstance3D>>,
    pub(crate) multi: Option<Gd<MultiMeshInstance3D>>,
    csg: Option<Gd<CsgShape3D>>,
}

impl Drawn {
    pub(crate) fn new(node: Gd<GeometryInstance3D>) -> Self {
        let instance = node.clone().try_cast::<MeshInstance3D>().ok();
        let multi = node.clone().try_cast::<MultiMeshInstance3D>().ok();
        let csg = node.clone().try_cast::<CsgShape3D>().ok();
        Self { node, instance, multi, csg }
    }

    /// Returns the mesh of the node.
    pub(crate) fn mesh(&self) -> Option<Gd<Mesh>> {
        if let Some(instance) = &self.instance {
            return instance.get_mesh();
        }
        if let Some(multi) = &self.multi {
            return multi.get_multimesh()?.get_mesh();
        }
        self.csg.as_ref()?.get_meshes().get(1)?.try_to::<Gd<Mesh>>().ok()
    }
}

/// Meshes and materials that are known.
pub(crate) struct Known<'a> {
    pub(crate) meshes: &'a mut Meshes,
    pub(crate) materials: &'a mut Materials,
    pub(crate) inbox: &'a Inbox,
}

/// Looks at a node.
pub(crate) fn look(drawn: &Drawn, kind: Kind, mark: Mark, known: &mut Known) -> Look {
    let node = &drawn.node;
    let layers = node.get_layer_mask();
    let casts = casts(node);
    let nothing = Look { layers, casts, ..Look::UNKNOWN };
    if kind == Kind::Other || node.is_ignoring_occlusion_culling() {
        return nothing;
    }
    let own = node.get_custom_aabb();
    let margin = node.get_extra_cull_margin();
    let has_own = own.size != Vector3::ZERO;
    let mesh = drawn.mesh();
    let of_mesh = mesh.as_ref().map(|mesh| known.meshes.facts(mesh, known.inbox));
    let mesh = mesh.zip(of_mesh).map(|(mesh, facts)| (mesh.instance_id(), facts.version));
    let surface = surfaces(drawn, kind, mesh.map(|mesh| mesh.0), known);
    let is_deformed = of_mesh.is_some_and(|facts| facts.deforms);
    // Who puts a `CulletOccluder` says that shaders move nothing.
    let reach = match surface.reach {
        Reach::Moved if mark.hides.is_some() => Reach::Mesh(0.0),
        reach => reach,
    };
    let grow = if let Reach::Mesh(grow) = reach { grow.max(0.0) } else { 0.0 };
    let plain = node.get_aabb();
    let aabb = if has_own { plain.abs().merge(own.abs()) } else { plain };
    let bounds = match reach {
        Reach::Through => Bounds::Unknown,
        // Bounds of the user's say how far vertices may go.
        Reach::Moved if !has_own && margin <= 0.0 => Bounds::Unknown,
        _ if is_deformed && !has_own => Bounds::Unknown,
        Reach::Mesh(_) => {
            let aabb = if grow > 0.0 { aabb.grow(grow) } else { aabb };
            Bounds::Box(aabb, Grown { margin, is_ball: false })
        }
        Reach::Moved => Bounds::Box(aabb, Grown { margin, is_ball: false }),
        Reach::Ball => Bounds::Box(aabb, Grown { margin, is_ball: true }),
    };
    // Bounds of the user's tell of vertices that move.
    let is_solid = matches!(bounds, Bounds::Box(_, Grown { is_ball: false, .. }))
        && !has_own
        && margin <= 0.0
        && node.get_visibility_parent().is_empty();
    let hides = of_mesh.filter(|_| is_solid && is_solid_now(node, mark));
    let hides = hides.filter(|facts| facts.hides && !facts.deforms);
    let hides = hides.and_then(|_| mark.hides.map(Hiding::all).or(surface.hides));
    Look { aabb: plain, bounds, grow, mesh, base: node.get_base(), hides, ..nothing }
}

fn casts(node: &Gd<GeometryInstance3D>) -> Casts {
    match node.get_cast_shadows_setting() {
        ShadowCastingSetting::OFF => Casts::Off,
        ShadowCastingSetting::DOUBLE_SIDED => Casts::DoubleSided,
        ShadowCastingSetting::SHADOWS_ONLY => Casts::Only,
        _ => Casts::On,
    }
}

/// Whether a node's own settings let it hide: those that scripts may change at any time.
fn is_solid_now(node: &Gd<GeometryInstance3D>, mark: Mark) -> bool {
    !mark.never_hides
        && node.get_transparency() == 0.0
        && node.get_visibility_range_end() <= 0.0
        && node.get_visibility_range_begin() <= 0.0
        && casts(node) != Casts::Only
}

/// Whether a node that hid others hides as it did, by the same mesh: for as few calls as can be, for
/// each takes some 0.2 µs.
pub(crate) fn still_hides(drawn: &Drawn, look: &Look, mark: Mark, known: &mut Known) -> bool {
    let node = &drawn.node;
    let Some(mesh) = look.mesh else { return false };
    // What the server draws for it is a number; its mesh would have to be counted in and out.
    node.get_base() == look.base
        && known.meshes.is_as_it_was(mesh)
        && is_solid_now(node, mark)
        && node.get_layer_mask() == look.layers
        && look.hides
            == mark.hides.map(Hiding::all).or_else(|| own(drawn, Some(mesh.0), known)?.hides)
}

/// Returns the facts of the materials of a node's surfaces, without an overlay; `mesh` is one whose facts
/// are known.
fn own(drawn: &Drawn, mesh: Option<InstanceId>, known: &mut Known) -> Option<Facts> {
    if let Some(material) = drawn.node.get_material_override() {
        return Some(known.materials.facts(Some(material)));
    }
    let of_mesh = known.meshes.own_materials(mesh?, known.materials);
    let Some(instance) = &drawn.instance else {
        return of_mesh.iter().copied().reduce(Facts::beside);
    };
    let of_surface = |(surface, &of_mesh): (i32, &Facts)| {
        let own = instance.get_surface_override_material(surface);
        own.map_or(of_mesh, |own| known.materials.facts(Some(own)).of_surface(surface))
    };
    (0..).zip(of_mesh).map(of_surface).reduce(Facts::beside)
}

/// Returns the facts of all that a node draws.
fn surfaces(drawn: &Drawn, kind: Kind, mesh: Option<InstanceId>, known: &mut Known) -> Facts {
    let node = &drawn.node;
    let own = own(drawn, mesh, known);
    let mut facts = match (kind, own) {
        (Kind::Flat, own) => {
            let flat = flat(node);
            Facts { reach: own.map_or(flat.reach, |own| flat.reach.and(own.reach)), ..flat }
        }
        (_, own) => own.unwrap_or(Facts::PLAIN),
    };
    if let Some(overlay) = node.get_material_overlay() {
        facts.reach = facts.reach.and(known.materials.facts(Some(overlay)).reach);
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
