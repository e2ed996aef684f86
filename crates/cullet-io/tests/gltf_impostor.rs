//! Impostors in glTF: what is written comes back where it is asked for, and fits the schema; what is damaged is left out with
//! a warning, and the plain mesh stays.

mod schema;

use cullet::lod::Impostor;
use cullet::{Instance, Scene, Transform};
use cullet_io::baked::{
    Baked, BakedError, BakedLevels, BakedMesh, LevelKind, Measured, geometry_hash,
};
use cullet_io::{LoadOptions, Model, load_bytes, save};
use cullet_testkit::{Folder, meshes};
use serde_json::Value;

const MEASURED: Measured =
    Measured { points: 256, reverse_points: 0, quantile: 0.999, most_over: 1.2, seed: 7 };

/// A block with an impostor by hand, and no other level.
fn model() -> Model {
    let mut scene = Scene::new();
    let block = scene.add_mesh(meshes::block([0.0; 3], [1.0, 2.0, 3.0]));
    scene.add(Instance::new(block, Transform::IDENTITY)).unwrap();
    scene.sort();
    let count = Impostor::texel_count([3, 2]).unwrap();
    let shape: Vec<u16> = (0..count as u16).map(|i| 0xf000 | i).collect();
    let normals = (0..count as u16).map(|i| i * 300).collect();
    let bounds = scene.meshes()[0].bounds();
    let impostor = Impostor::new([3, 2], (bounds, 1.9), 0.125, shape, normals).unwrap();
    let held_by = scene.add_impostor(block, impostor).unwrap();
    let geometry = geometry_hash(&scene.meshes()[0]);
    let levels = vec![BakedLevels { kind: LevelKind::Impostor, held_by, measured: MEASURED }];
    let one = BakedMesh { mesh: block, geometry, levels, ..BakedMesh::default() };
    let baked = Baked { meshes: vec![one], ..Baked::default() };
    Model { scene, mesh_names: vec!["block".into()], baked: Some(baked), ..Model::default() }
}

fn bytes_of(model: &Model) -> Vec<u8> {
    let folder = Folder::new("baked-impostor");
    let path = folder.root().join("a.glb");
    save(model, &path).unwrap();
    std::fs::read(&path).unwrap()
}

fn loaded(bytes: &[u8]) -> Model {
    let options = LoadOptions { impostors: true, ..LoadOptions::default() };
    load_bytes("a.glb", bytes, &options).unwrap()
}

fn json_of(bytes: &[u8]) -> Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

#[test]
fn an_impostor_comes_back_where_it_is_asked_for() {
    let before = model();
    let bytes = bytes_of(&before);
    let after = loaded(&bytes);
    assert!(after.warnings.is_empty(), "{:?}", after.warnings);
    let [a, b] = [&before, &after].map(|m| m.scene.levels(0)[0].impostor.clone().unwrap());
    assert_eq!(a, b);
    assert_eq!(after.scene.levels(0)[0].levels, before.scene.levels(0)[0].levels);
    let own = &after.baked.as_ref().unwrap().meshes[0];
    assert_eq!(own.levels, before.baked.as_ref().unwrap().meshes[0].levels);
    assert_eq!(own.bytes, 64 + 36 * 4);
    // The same again.
    assert_eq!(bytes_of(&after), bytes);
    let plain = load_bytes("a.glb", &bytes, &LoadOptions::default()).unwrap();
    assert!(plain.warnings.is_empty() && plain.scene.levels(0).is_empty());
    assert_eq!(plain.scene.meshes().len(), 1);
}

#[test]
fn it_fits_the_schema() {
    let json = json_of(&bytes_of(&model()));
    let object = &json["meshes"][0]["extensions"]["CULLET_baked"];
    assert_eq!(object["impostor"]["grid"], 3);
    let schema = schema::of("CULLET_baked");
    let found = schema::held(&schema, object, "");
    assert!(found.is_empty(), "{found:?}");
    let mut odd = object.clone();
    odd["impostor"]["atlas"] = "one".into();
    assert!(!schema::held(&schema, &odd, "").is_empty());
}

#[test]
fn what_is_damaged_is_left_out_and_the_mesh_stays() {
    let bytes = bytes_of(&model());
    let json = json_of(&bytes);
    let view = json["meshes"][0]["extensions"]["CULLET_baked"]["impostor"]["atlas"].as_u64();
    let view = &json["bufferViews"][view.unwrap() as usize];
    let binary = 28 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let first = binary + view["byteOffset"].as_u64().unwrap() as usize;
    for at in (0..view["byteLength"].as_u64().unwrap() as usize).step_by(5) {
        let mut odd = bytes.clone();
        odd[first + at] ^= 16;
        let model = loaded(&odd);
        assert_eq!(model.scene.triangle_count(), 12);
        assert!(model.scene.levels(0).is_empty() && model.warnings.len() == 1, "{at}");
        let problem = model.baked.unwrap().meshes.swap_remove(0).problem;
        assert!(matches!(problem, Some(BakedError::Damaged { .. })), "{at}: {problem:?}");
    }
}
