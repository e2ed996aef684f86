//! The built-in city as entities: one for each building and each small object in the streets.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_cullet::engine;
use cullet_io::Model;

/// Buildings along each side, and objects between them.
pub(crate) const SPEC: &str = "city:cells=40,objects=20000";

/// Where a walker stands, and looks down a street.
pub(crate) fn street() -> Transform {
    Transform::from_xyz(0.7, 1.7, 84.0).looking_at(Vec3::new(-1.0, 3.0, 0.0), Vec3::Y)
}

/// Spawns the city and a sun without shadows.
pub(crate) fn spawn(world: &mut World, spec: &str) {
    let model = cullet_scenes::build(spec).expect("a built-in scene");
    let meshes: Vec<Handle<Mesh>> = model
        .scene
        .meshes()
        .iter()
        .map(|mesh| world.resource_mut::<Assets<Mesh>>().add(flat_shaded(mesh)))
        .collect();
    let materials = materials(world, &model);
    for slot in model.scene.slots() {
        let mesh = model.scene.mesh_id(slot) as usize;
        let material = model.scene.mesh(slot).parts()[0].material as usize;
        let matrix = model.scene.transform(slot).to_matrix().map(|x| x as f32);
        let at = Transform::from_matrix(Mat4::from_cols_array(&matrix));
        let material = materials[material.min(materials.len() - 1)].clone();
        world.spawn((Mesh3d(meshes[mesh].clone()), MeshMaterial3d(material), at));
    }
    let sun = DirectionalLight { illuminance: 6000.0, ..default() };
    world.spawn((sun, Transform::default().looking_to(Vec3::new(-0.5, -1.0, -0.7), Vec3::Y)));
}

fn flat_shaded(mesh: &engine::Mesh) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, mesh.positions().to_vec())
        .with_inserted_indices(Indices::U32(mesh.indices().to_vec()))
        .with_duplicated_vertices()
        .with_computed_flat_normals()
}

fn materials(world: &mut World, model: &Model) -> Vec<Handle<StandardMaterial>> {
    let mut all = world.resource_mut::<Assets<StandardMaterial>>();
    let colors = model.materials.iter().map(|m| LinearRgba::from_f32_array(m.color));
    let colors = colors.chain([LinearRgba::gray(0.6)]);
    colors
        .map(|color| {
            let base_color = color.into();
            all.add(StandardMaterial { base_color, perceptual_roughness: 0.95, ..default() })
        })
        .collect()
}
