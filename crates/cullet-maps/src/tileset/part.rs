//! Parts of models, as tiles are written.

use std::collections::BTreeMap;

use cullet::{Instance, Scene};

use super::cut::Item;
use cullet_io::baked::{Baked, BakedLevels, BakedMesh};
use cullet_io::{Attributes, Model};

/// Some instances of a model as a model.
pub(super) fn part(model: &Model, items: &[Item]) -> Model {
    let from = &model.scene;
    let mut scene = Scene::new();
    let mut made =
        Model { name: model.name.clone(), materials: model.materials.clone(), ..Model::default() };
    let mut meshes: BTreeMap<u32, u32> = BTreeMap::new();
    let mut baked = Baked::default();
    for item in items {
        let mesh = from.mesh_id(item.slot);
        let own = *meshes.entry(mesh).or_insert_with(|| {
            made.mesh_names.push(model.mesh_names.get(mesh as usize).cloned().unwrap_or_default());
            let attributes = model.attributes.get(mesh as usize).cloned().unwrap_or_default();
            made.attributes.push(attributes);
            let own = scene.add_mesh(from.meshes()[mesh as usize].clone());
            let of = model.baked.iter().flat_map(|baked| &baked.meshes).find(|of| of.mesh == mesh);
            if let Some(of) = of {
                baked.meshes.push(with_levels(from, of, own, &mut scene));
                made.mesh_names.resize(scene.meshes().len(), String::new());
                made.attributes.resize(scene.meshes().len(), Attributes::default());
            }
            own
        });
        let instance = Instance {
            layers: from.layers(item.slot),
            flags: from.flags(item.slot),
            size_weight: from.size_weight(item.slot),
            ..Instance::new(own, *from.transform(item.slot))
        };
        // It is one that a scene had.
        if scene.add(instance).is_ok() {
            let name =
                from.handle(item.slot).map(|handle| model.instance_name(handle).into_owned());
            made.instance_names.push(name.unwrap_or_default());
        }
    }
    scene.commit(&cullet::Culler::default());
    made.scene = scene;
    if let Some(whole) = model.baked.as_ref().filter(|_| !baked.meshes.is_empty()) {
        made.baked = Some(Baked { generator: whole.generator.clone(), ..baked });
    }
    made
}

/// Gives a mesh of another scene the levels that its own has; what is baked of it there.
fn with_levels(from: &Scene, of: &BakedMesh, own: u32, scene: &mut Scene) -> BakedMesh {
    let mut baked = BakedMesh { mesh: own, levels: Vec::new(), ..of.clone() };
    for levels in from.levels(of.mesh) {
        let Some(&kind) = of.levels.iter().find(|l| l.held_by == levels.mesh) else { continue };
        // Pictures would be written with each tile again.
        if levels.impostor.is_some() {
            continue;
        }
        let held_by = scene.add_mesh(from.meshes()[levels.mesh as usize].clone());
        if scene.add_levels(own, held_by, levels.levels.clone()).is_ok() {
            baked.levels.push(BakedLevels { held_by, ..kind });
        }
    }
    baked
}
