//! Finds what changed of the entities, and hands it to the engine's scene.

use std::ops::Range;
use std::sync::Mutex;

use bevy_camera::primitives::{Aabb, Sphere};
use bevy_camera::visibility::{
    InheritedVisibility, NoCpuCulling, NoFrustumCulling, RenderLayers, ViewVisibility,
    VisibilityClass, VisibilityRange,
};
use bevy_ecs::change_detection::{ContiguousRef, Tick};
use bevy_ecs::prelude::*;
use bevy_ecs::query::ContiguousQueryData;
use bevy_ecs::system::{SystemChangeTick, SystemParam};
use bevy_mesh::Mesh3d;
use bevy_mesh::morph::{MeshMorphWeights, MorphWeights};
use bevy_mesh::skinning::SkinnedMesh;
use bevy_transform::components::GlobalTransform;

use crate::mirror::{CulletScene, Found};
use crate::seen::{NoCulletOcclusion, OfMesh, Seen, SeenItem, world_box};
use crate::ticks::{MANY, ROWS, RUN, Since};

/// Components whose going makes an entity another one for visibility.
#[derive(SystemParam)]
pub(crate) struct Gone<'w, 's> {
    mesh: RemovedComponents<'w, 's, Mesh3d>,
    aabb: RemovedComponents<'w, 's, Aabb>,
    sphere: RemovedComponents<'w, 's, Sphere>,
    layers: RemovedComponents<'w, 's, RenderLayers>,
    inherited: RemovedComponents<'w, 's, InheritedVisibility>,
    view: RemovedComponents<'w, 's, ViewVisibility>,
    class: RemovedComponents<'w, 's, VisibilityClass>,
    transform: RemovedComponents<'w, 's, GlobalTransform>,
    no_frustum_culling: RemovedComponents<'w, 's, NoFrustumCulling>,
    no_cpu_culling: RemovedComponents<'w, 's, NoCpuCulling>,
    range: RemovedComponents<'w, 's, VisibilityRange>,
    shines: RemovedComponents<'w, 's, NoCulletOcclusion>,
}

impl Gone<'_, '_> {
    fn read(&mut self) -> impl Iterator<Item = Entity> {
        let all = self.mesh.read().chain(self.aabb.read()).chain(self.sphere.read());
        let all = all.chain(self.layers.read()).chain(self.inherited.read());
        let all = all.chain(self.view.read()).chain(self.class.read());
        let all = all.chain(self.transform.read()).chain(self.no_frustum_culling.read());
        let all = all.chain(self.no_cpu_culling.read()).chain(self.range.read());
        all.chain(self.shines.read())
    }
}

/// Components that an entity's place in the scene follows from: any of these changed.
type Rows = (
    Entity,
    (Ref<'static, GlobalTransform>, Option<Ref<'static, Aabb>>),
    (
        Ref<'static, InheritedVisibility>,
        Option<Ref<'static, VisibilityClass>>,
        Option<Ref<'static, RenderLayers>>,
        Option<Ref<'static, Sphere>>,
        Option<Ref<'static, NoFrustumCulling>>,
        Option<Ref<'static, VisibilityRange>>,
        Option<Ref<'static, SkinnedMesh>>,
        Option<Ref<'static, MeshMorphWeights>>,
        Option<Ref<'static, MorphWeights>>,
        Option<Ref<'static, NoCulletOcclusion>>,
    ),
);

/// Asks the rows of a part of a table.
fn ask(
    found: &mut Found,
    mirror: &CulletScene,
    since: Since,
    (entities, (transforms, boxes), others): <Rows as ContiguousQueryData>::Contiguous<'_, '_>,
) {
    let (inherited, class, layers, sphere, culling, range, skin, morphs, weights, shines) = others;
    /// Returns the ticks of a component that an entity may lack.
    fn changed<'w, T>(of: &Option<ContiguousRef<'w, T>>) -> Option<&'w [Tick]> {
        of.as_ref().map(ContiguousRef::changed_ticks_slice)
    }
    // Of these the value says nothing, or is read each frame: only their coming counts.
    fn added<'w, T>(of: &Option<ContiguousRef<'w, T>>) -> Option<&'w [Tick]> {
        of.as_ref().map(ContiguousRef::added_ticks_slice)
    }
    let others: Vec<&[Tick]> = [
        Some(inherited.changed_ticks_slice()),
        changed(&boxes),
        changed(&class),
        changed(&layers),
        changed(&sphere),
        added(&culling),
        added(&range),
        added(&skin),
        added(&morphs),
        added(&weights),
        added(&shines),
    ]
    .into_iter()
    .flatten()
    .collect();
    let moves = transforms.changed_ticks_slice();
    let any_other =
        |rows: &Range<usize>| others.iter().any(|ticks| since.any(&ticks[rows.clone()]));
    let any = |rows: &Range<usize>| since.any(&moves[rows.clone()]) || any_other(rows);
    let parts = |of: Range<usize>, len: usize| {
        of.clone().step_by(len).map(move |start| start..(start + len).min(of.end))
    };
    let runs = parts(0..entities.len(), RUN).filter(any);
    for rows in runs.flat_map(|run| parts(run, ROWS)) {
        let start = rows.start;
        // Row by row only where there is something: that takes far longer.
        let of_others = if any_other(&rows) { &others[..] } else { &[] };
        let whole = of_others.iter().fold(0, |bits, ticks| bits | since.bits(&ticks[rows.clone()]));
        let mut bits = whole | since.bits(&moves[rows]);
        while bits != 0 {
            let bit = bits.trailing_zeros();
            bits &= bits - 1;
            let row = start + bit as usize;
            let only_moves = boxes.as_ref().filter(|_| whole >> bit & 1 == 0).and_then(|boxes| {
                let bounds = world_box(&boxes[row], &transforms[row].affine());
                mirror.moved(entities[row].index_u32(), bounds)
            });
            match only_moves {
                Some(moved) => found.moved.push(moved),
                None => found.changed.push(entities[row]),
            }
        }
    }
}

/// Takes over into the engine's scene what changed.
pub(crate) fn follow(
    mut mirror: ResMut<CulletScene>,
    ticks: SystemChangeTick,
    rows: Query<Rows, OfMesh>,
    all: Query<Seen, OfMesh>,
    mut gone: Gone,
    off_cpu: Query<Entity, Added<NoCpuCulling>>,
) {
    let mirror = mirror.bypass_change_detection();
    mirror.begin();
    let mut found = Vec::new();
    let mut count = 0;
    if let Ok(tables) = rows.contiguous_iter() {
        let lens = tables.map(|(entities, ..)| entities.len());
        let (sum, most) = lens.fold((0, 0), |(sum, most), len| (sum + len, len.max(most)));
        count = sum;
        let since = Since::new(&ticks);
        let spare = Mutex::new(std::mem::take(&mut mirror.spare));
        let parts = Mutex::new(Vec::new());
        let mirror = &*mirror;
        let of_part = |part: <Rows as ContiguousQueryData>::Contiguous<'_, '_>| {
            let mut found = spare.lock().map_or(None, |mut s| s.pop()).unwrap_or_default();
            ask(&mut found, mirror, since, part);
            if let Ok(mut parts) = parts.lock() {
                parts.push(found);
            }
        };
        if most < MANY {
            rows.contiguous_iter().into_iter().flatten().for_each(of_part);
        } else if let Ok(tables) = rows.contiguous_par_iter() {
            tables.for_each(of_part);
        }
        found = parts.into_inner().unwrap_or_default();
        found.append(&mut spare.into_inner().unwrap_or_default());
    }
    let changed = found.iter().flat_map(|part| part.changed.iter().copied());
    for entity in gone.read().chain(&off_cpu).chain(changed) {
        match all.get(entity) {
            Ok(seen) => mirror.put(&seen),
            Err(_) => mirror.remove(entity),
        }
    }
    // Who lost one of the components that make an entity one of ours, and got it back, changed in
    // nothing else.
    if mirror.len() != count {
        let is_missing = |seen: &SeenItem<'_, '_>| mirror.handle(seen.entity).is_none();
        let missing: Vec<Entity> = all.iter().filter(is_missing).map(|seen| seen.entity).collect();
        missing.into_iter().filter_map(|entity| all.get(entity).ok()).for_each(|s| mirror.put(&s));
    }
    mirror.settle(found.iter().map(|part| &part.moved[..]));
    for part in &mut found {
        part.moved.clear();
        part.changed.clear();
    }
    mirror.spare = found;
}
