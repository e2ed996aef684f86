//! Occluders: what is made of meshes, on threads of Bevy's, so that they can hide others.

use bevy_asset::{AssetEvent, AssetId, Assets};
use bevy_ecs::prelude::*;
use bevy_mesh::{Indices, Mesh, Mesh3d, PrimitiveTopology, VertexAttributeValues};
use bevy_tasks::{AsyncComputeTaskPool, Task, block_on, futures_lite::future};
use engine::mesh::Part;
use engine::{
    MeshData, MeshId,
    prepared::{Preparation, Prepared},
};
use std::collections::HashMap;

use crate::mirror::CulletScene;
use crate::seen::{OfMesh, Seen};

/// An entity whose mesh hides what is behind it, for cameras with
/// [`CulletOcclusion`](crate::CulletOcclusion).
///
/// Put it where the whole mesh is drawn opaque and as its vertices lie: no alpha mask, no blending,
/// no shader that moves vertices, no depth other than Bevy's. With the feature `pbr` entities of opaque `StandardMaterial`s get
/// it by themselves. It does nothing for skinned and morphed meshes, for an entity with a
/// `VisibilityRange`, with an `Aabb` other than its mesh's, or that is mirrored.
#[derive(Clone, Copy, Component, Debug, Default, PartialEq)]
pub struct CulletOccluder {
    /// Whether both sides of its triangles are drawn: a `StandardMaterial` with `cull_mode: None`.
    /// Default: false.
    pub double_sided: bool,
}

/// An entity that gets no [`CulletOccluder`] by itself.
#[derive(Clone, Copy, Component, Debug, Default)]
pub struct NoCulletOccluder;

/// When occluders are made of meshes: a resource.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Resource)]
pub enum CulletPrepare {
    /// On threads of Bevy's `AsyncComputeTaskPool`: a mesh begins to hide some frames after it
    /// came.
    #[default]
    Background,
    /// In the frame in which the mesh comes, which waits for it.
    AtOnce,
}

/// State of a mesh.
#[derive(Debug)]
enum Made {
    Soon(Task<Option<(engine::Mesh, Prepared)>>),
    /// In the engine's scene.
    Here(MeshId),
    /// It hides nothing, or is no list of triangles.
    Nothing,
}

/// The meshes that occluders are made of.
#[derive(Debug, Default, Resource)]
pub(crate) struct OccluderMeshes {
    made: HashMap<(AssetId<Mesh>, bool), Made>,
    /// Meshes of the engine's scene that no entity is to have any more.
    leaving: Vec<MeshId>,
}

impl OccluderMeshes {
    /// Forgets what was made of a mesh. Tells whether there was anything.
    fn forget(&mut self, id: AssetId<Mesh>) -> bool {
        let made = [false, true].map(|sides| self.made.remove(&(id, sides)));
        let is_known = made.iter().any(Option::is_some);
        self.leaving.extend(made.into_iter().flatten().filter_map(|made| match made {
            Made::Here(mesh) => Some(mesh),
            Made::Soon(_) | Made::Nothing => None,
        }));
        is_known
    }
}

/// Makes what is wanted of a mesh.
fn make(data: MeshData) -> Option<(engine::Mesh, Prepared)> {
    let mesh = engine::Mesh::new(data).ok()?;
    let wanted = Preparation { occluder: true, ..Preparation::NONE };
    let prepared = Prepared::of(&mesh, wanted);
    (!prepared.shapes().is_empty()).then_some((mesh, prepared))
}

/// Triangles of a mesh; `None` where it has none, or is not on the CPU.
fn data(mesh: &Mesh, double_sided: bool) -> Option<MeshData> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return None;
    }
    let positions = match mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION).ok()?? {
        VertexAttributeValues::Float32x3(positions) => positions.clone(),
        _ => return None,
    };
    // Bevy cuts attributes to the shortest, and may not draw a skin without joints.
    let deforms = mesh.contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX) || mesh.has_morph_targets();
    if deforms || mesh.count_vertices() != positions.len() {
        return None;
    }
    let indices = match mesh.try_indices_option().ok()? {
        Some(Indices::U16(indices)) => indices.iter().copied().map(u32::from).collect(),
        Some(Indices::U32(indices)) => indices.clone(),
        None => (0..positions.len() as u32).collect(),
    };
    let triangle_count = indices.len() as u32 / 3;
    let part = Part { triangle_count, two_sided: double_sided, ..Part::default() };
    Some(MeshData { positions, indices, parts: vec![part], ..MeshData::default() })
}

/// Makes occluders of the meshes that want one, and gives them to the instances.
pub(crate) fn prepare(
    mut mirror: ResMut<CulletScene>,
    mut meshes: ResMut<OccluderMeshes>,
    when: Res<CulletPrepare>,
    assets: Option<Res<Assets<Mesh>>>,
    mut events: Option<MessageReader<AssetEvent<Mesh>>>,
    wanting: Query<(Entity, &Mesh3d, &CulletOccluder), OfMesh>,
    fresh: Query<
        (Entity, &Mesh3d, &CulletOccluder),
        (OfMesh, Or<(Changed<Mesh3d>, Changed<CulletOccluder>)>),
    >,
    mut gone: RemovedComponents<CulletOccluder>,
    all: Query<Seen, OfMesh>,
) {
    let Some(assets) = assets else { return };
    let mirror = mirror.bypass_change_detection();
    let meshes = meshes.bypass_change_detection();
    for entity in gone.read() {
        mirror.set_mesh(entity, 0, all.get(entity).ok().as_ref());
    }
    let mut stale = Vec::new();
    for event in events.iter_mut().flat_map(|events| events.read()) {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id } =
            event
            && meshes.forget(*id)
        {
            stale.push(*id);
        }
    }
    let mut news = Vec::new();
    if !stale.is_empty() {
        for (entity, mesh, occluder) in &wanting {
            if stale.contains(&mesh.id()) {
                // What it hid may be seen through it now.
                mirror.set_mesh(entity, 0, all.get(entity).ok().as_ref());
                news.push((entity, mesh.id(), occluder.double_sided));
            }
        }
    }
    for (entity, mesh, occluder) in &fresh {
        mirror.set_mesh(entity, 0, all.get(entity).ok().as_ref());
        news.push((entity, mesh.id(), occluder.double_sided));
    }
    // One that an entity has until it is taken over again stays until then.
    meshes.leaving.retain(|&mesh| mirror.scene.remove_mesh(mesh).is_err());
    // One whose mesh changes in each frame would wait once for each.
    news.append(&mut mirror.waiting);
    news.sort_unstable();
    news.dedup();
    for (entity, id, sides) in news {
        // What waited may want another by now.
        let is_wanted = |(_, mesh, occluder): (Entity, &Mesh3d, &CulletOccluder)| {
            (mesh.id(), occluder.double_sided) == (id, sides)
        };
        if !wanting.get(entity).is_ok_and(is_wanted) {
            continue;
        }
        let made = meshes.made.entry((id, sides)).or_insert_with(|| {
            let Some(data) = assets.get(id).and_then(|mesh| data(mesh, sides)) else {
                return Made::Nothing;
            };
            match *when {
                CulletPrepare::Background => Made::Soon(
                    AsyncComputeTaskPool::get_or_init(Default::default)
                        .spawn(async move { make(data) }),
                ),
                CulletPrepare::AtOnce => mirror.take(make(data)).map_or(Made::Nothing, Made::Here),
            }
        });
        if let Made::Soon(task) = made
            && let Some(ready) = block_on(future::poll_once(task))
        {
            *made = mirror.take(ready).map_or(Made::Nothing, Made::Here);
        }
        match made {
            Made::Soon(_) => mirror.waiting.push((entity, id, sides)),
            Made::Here(mesh) => mirror.set_mesh(entity, *mesh, all.get(entity).ok().as_ref()),
            Made::Nothing => {}
        }
    }
}
