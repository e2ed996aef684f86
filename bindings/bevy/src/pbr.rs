//! Occluders by material: what is drawn with an opaque `StandardMaterial` hides what is behind it.

use bevy_asset::{AssetEvent, AssetId, Assets, VisitAssetDependencies};
use bevy_core_pipeline::prepass::DeferredPrepass;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_image::Image;
use bevy_material::{AlphaMode, OpaqueRendererMethod};
use bevy_mesh::Mesh3d;
use bevy_pbr::{DefaultOpaqueRendererMethod, MeshMaterial3d, StandardMaterial};
use bevy_reflect::tuple_struct::GetTupleStructField;
use bevy_render::render_resource::Face;

use crate::receivers::Transmits;
use crate::{CulletOccluder, CulletOcclusion, NoCulletOccluder, NoCulletOcclusion};

/// Marker of entities that got their [`CulletOccluder`] here.
#[derive(Component)]
pub(crate) struct ByMaterial;

/// Marker of entities that got their [`NoCulletOcclusion`] here.
#[derive(Component)]
pub(crate) struct ByBias;

type Meshes<'w, 's, F> = Query<
    'w,
    's,
    (
        Entity,
        &'static MeshMaterial3d<StandardMaterial>,
        Option<&'static CulletOccluder>,
        Has<ByMaterial>,
        Has<NoCulletOcclusion>,
        Has<ByBias>,
        Has<NoCulletOccluder>,
    ),
    (With<Mesh3d>, F),
>;

/// Renderer and assets, as far as they decide what is drawn.
#[derive(SystemParam)]
pub(crate) struct Drawn<'w, 's> {
    images: Option<Res<'w, Assets<Image>>>,
    default_method: Option<Res<'w, DefaultOpaqueRendererMethod>>,
    views: Query<'w, 's, Has<DeferredPrepass>, With<CulletOcclusion>>,
}

impl Drawn<'_, '_> {
    /// Whether opaque materials of a method are drawn in every view, `Forward` ones apart: a view
    /// without `DeferredPrepass` leaves deferred ones out.
    ///
    /// `last` counts, since Bevy keeps the method of a material that is not changed when the default
    /// is.
    fn draws(&self, last: Option<Draws>) -> Draws {
        let default = self.default_method.as_deref();
        let method = default.and_then(|m| m.get_field::<OpaqueRendererMethod>(0)).copied();
        Draws {
            deferred: self.views.iter().all(|has_prepass| has_prepass),
            auto_was_deferred: method == Some(OpaqueRendererMethod::Deferred)
                || last.is_some_and(|last| last.auto_was_deferred),
        }
    }

    /// Whether all images of a material are there. Until then Bevy does not draw it.
    fn has_images(&self, material: &StandardMaterial) -> bool {
        let mut all = true;
        let mut find = |image: AssetId<Image>| {
            all &= self.images.as_ref().is_some_and(|images| images.contains(image));
        };
        material.visit_dependencies(&mut |id| {
            if let Ok(image) = id.try_typed() {
                find(image);
            }
        });
        material.depth_map.iter().for_each(|image| find(image.id()));
        all
    }
}

/// Methods of rendering by which every view draws.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Draws {
    deferred: bool,
    auto_was_deferred: bool,
}

/// How the mesh under a material hides what is behind it; `None` where it may not. Of the fields of
/// a material the alpha mode, the transmissions, the bias of depth, the method and the culled face
/// decide; the others change colours alone.
fn occluder(material: &StandardMaterial, draws: Draws) -> Option<CulletOccluder> {
    let is_drawn = match material.opaque_render_method {
        OpaqueRendererMethod::Forward => true,
        OpaqueRendererMethod::Deferred => draws.deferred,
        OpaqueRendererMethod::Auto => draws.deferred || !draws.auto_was_deferred,
    };
    let is_opaque = is_drawn
        && material.alpha_mode == AlphaMode::Opaque
        && material.depth_bias == 0.0
        && material.specular_transmission <= 0.0
        && material.diffuse_transmission <= 0.0;
    match material.cull_mode {
        None => is_opaque.then_some(CulletOccluder { double_sided: true }),
        Some(Face::Back) => is_opaque.then_some(CulletOccluder { double_sided: false }),
        Some(Face::Front) => None,
    }
}

/// Gives [`CulletOccluder`] to what is opaque, and takes it from what is so no more.
pub(crate) fn by_material(
    mut commands: Commands,
    materials: Option<Res<Assets<StandardMaterial>>>,
    mut events: Option<MessageReader<AssetEvent<StandardMaterial>>>,
    mut of_images: Option<MessageReader<AssetEvent<Image>>>,
    drawn: Drawn,
    changed: Meshes<Changed<MeshMaterial3d<StandardMaterial>>>,
    all: Meshes<()>,
    vetoed: Query<
        Entity,
        (
            With<ByMaterial>,
            With<CulletOccluder>,
            Or<(With<NoCulletOccluder>, Without<MeshMaterial3d<StandardMaterial>>)>,
        ),
    >,
    mut last: Local<Option<Draws>>,
) {
    let touched: Vec<AssetId<StandardMaterial>> = events
        .iter_mut()
        .flat_map(|events| events.read())
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id } => {
                Some(*id)
            }
            _ => None,
        })
        .collect();
    // An image that is only changed, as a video's, is there before and after.
    let images = of_images.iter_mut().flat_map(|events| events.read());
    let images_came_or_went = images
        .filter(|event| matches!(event, AssetEvent::Added { .. } | AssetEvent::Removed { .. }))
        .count()
        > 0;
    // Where no camera asks, no entity is moved to another table.
    let Some(materials) = materials.filter(|_| last.is_some() || !drawn.views.is_empty()) else {
        return;
    };
    let draws = drawn.draws(*last);
    let is_new = last.replace(draws) != Some(draws) || images_came_or_went;
    for entity in &vetoed {
        commands.entity(entity).remove::<(CulletOccluder, ByMaterial)>();
    }
    let mut judge = |(entity, material, known, is_ours, shines, by_bias, is_vetoed): (
        Entity,
        &MeshMaterial3d<StandardMaterial>,
        Option<&CulletOccluder>,
        bool,
        bool,
        bool,
        bool,
    )| {
        let material = materials.get(material.id());
        // It is drawn nearer or farther than it lies.
        let is_biased = material.is_some_and(|material| material.depth_bias != 0.0);
        match (is_biased, shines, by_bias) {
            (true, false, _) => {
                commands.entity(entity).try_insert((NoCulletOcclusion, ByBias));
            }
            (false, _, true) => {
                commands.entity(entity).try_remove::<(NoCulletOcclusion, ByBias)>();
            }
            _ => {}
        }
        if is_vetoed || known.is_some() && !is_ours {
            return;
        }
        let wanted = material.filter(|material| drawn.has_images(material));
        let wanted = wanted.and_then(|material| occluder(material, draws));
        match wanted {
            Some(wanted) if known != Some(&wanted) => {
                commands.entity(entity).try_insert((wanted, ByMaterial));
            }
            None if is_ours => {
                commands.entity(entity).try_remove::<(CulletOccluder, ByMaterial)>();
            }
            _ => {}
        }
    };
    if is_new {
        all.iter().for_each(judge);
        return;
    }
    changed.iter().for_each(&mut judge);
    if !touched.is_empty() {
        all.iter().filter(|(_, material, ..)| touched.contains(&material.id())).for_each(judge);
    }
}

/// Notes whether some material is lit from behind at a depth of its own: Bevy asks for light and
/// shadows at a place beside the surface then, farther than anybody knows.
pub(crate) fn transmits(
    materials: Option<Res<Assets<StandardMaterial>>>,
    mut events: Option<MessageReader<AssetEvent<StandardMaterial>>>,
    mut transmits: ResMut<Transmits>,
) {
    let Some(materials) = materials else { return };
    if events.iter_mut().flat_map(|events| events.read()).count() > 0 {
        let is_deep = |material: &StandardMaterial| {
            material.diffuse_transmission != 0.0 && material.thickness != 0.0
        };
        transmits.0 = materials.iter().any(|(_, material)| is_deep(material));
    }
}
