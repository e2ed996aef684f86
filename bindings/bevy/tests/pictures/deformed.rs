//! Meshes whose vertices the device moves: a skin and a morph, at rest behind a wall, and then beside it.

use bevy::asset::RenderAssetUsages;
use bevy::camera::visibility::DynamicSkinnedMeshBounds;
use bevy::mesh::morph::{MeshMorphWeights, MorphAttributes};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

use crate::kit::{Kit, Probe};

/// A joint that swings.
#[derive(Component)]
struct Joint;

/// A mesh with a morph that grows.
#[derive(Component)]
struct Morphed;

pub(crate) fn build(kit: &mut Kit) {
    kit.yard();
    kit.daylight(true);
    let column = kit.world.resource_mut::<Assets<Mesh>>().add(skinned_column());
    let bind = [Mat4::IDENTITY, Mat4::from_translation(Vec3::new(0.0, -2.0, 0.0))];
    let bind = SkinnedMeshInverseBindposes::from(bind.to_vec());
    let bind = kit.world.resource_mut::<Assets<SkinnedMeshInverseBindposes>>().add(bind);
    let paint = kit.paints[6].clone();
    for (i, at) in [[-6.0, 0.0, -16.0], [1.5, 0.5, -7.0], [9.0, 0.0, -24.0]].into_iter().enumerate()
    {
        let foot =
            kit.world.spawn((Transform::from_translation(at.into()), Visibility::default())).id();
        let knee = (Transform::from_xyz(0.0, 2.0, 0.0), Joint, ChildOf(foot));
        let knee = kit.world.spawn(knee).id();
        let skin = SkinnedMesh { inverse_bindposes: bind.clone(), joints: vec![foot, knee] };
        let parts = (Mesh3d(column.clone()), MeshMaterial3d(paint.clone()), skin);
        let mut skinned = kit.world.spawn((parts, Transform::from_translation(at.into())));
        // Bounds that follow the joints, and bounds that stay at rest, as they are without the component.
        if i == 1 {
            skinned.insert(DynamicSkinnedMeshBounds);
        }
    }
    let growing = kit.world.resource_mut::<Assets<Mesh>>().add(growing_box());
    for at in [[-3.0, 1.0, -14.0], [-4.0, 3.0, -15.0]] {
        let parts = (Mesh3d(growing.clone()), MeshMaterial3d(paint.clone()), Morphed);
        let weights = MeshMorphWeights::Value { weights: vec![0.0] };
        // What a plugin loses that tests the box of the mesh at rest, which is behind the wall.
        kit.world.spawn((parts, weights, Transform::from_translation(at.into()), Probe));
    }
    kit.eye();
}

/// Bends the joints and grows the boxes.
pub(crate) fn step(world: &mut World, step: u32) {
    let amount = step as f32;
    let mut joints = world.query_filtered::<&mut Transform, With<Joint>>();
    for mut at in joints.iter_mut(world) {
        at.translation.x = amount * 3.0;
        at.rotation = Quat::from_rotation_z(amount * 0.4);
    }
    let mut morphs = world.query_filtered::<&mut MeshMorphWeights, With<Morphed>>();
    for mut weights in morphs.iter_mut(world) {
        *weights = MeshMorphWeights::Value { weights: vec![amount] };
    }
}

/// A column of height 4 whose upper half hangs on the second joint.
fn skinned_column() -> Mesh {
    let mut positions = Vec::new();
    let mut weights = Vec::new();
    let mut joints = Vec::new();
    for ring in 0..5_u8 {
        for [x, z] in [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]] {
            let upper = (f32::from(ring) / 4.0 - 0.25).clamp(0.0, 0.5) * 2.0;
            positions.push([x, f32::from(ring), z]);
            joints.push([0, 1, 0, 0]);
            weights.push([1.0 - upper, upper, 0.0, 0.0]);
        }
    }
    let mut indices = vec![0_u32, 1, 2, 0, 2, 3, 16, 18, 17, 16, 19, 18];
    for ring in 0..4 {
        for side in 0..4 {
            let [a, b] = [ring * 4 + side, ring * 4 + (side + 1) % 4];
            indices.extend([a, a + 4, b, b, a + 4, b + 4]);
        }
    }
    let joints = VertexAttributeValues::Uint16x4(joints);
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights)
        .with_inserted_indices(Indices::U32(indices))
        .with_computed_smooth_normals()
        .with_generated_skinned_mesh_bounds()
        .expect("positions, joints and weights")
}

/// A box that grows to the right by 2.5 for each unit of its one weight.
fn growing_box() -> Mesh {
    let mesh = Mesh::from(Cuboid::new(1.0, 1.0, 1.0));
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|a| a.as_float3());
    let side = |p: &[f32; 3]| if p[0] > 0.0 { Vec3::X * 2.5 } else { Vec3::ZERO };
    let targets = positions.expect("positions").iter();
    let targets = targets.map(|p| MorphAttributes::new(side(p), Vec3::ZERO, Vec3::ZERO)).collect();
    mesh.with_morph_targets(targets)
}
