//! Impostors in glTF: what is written comes back where it is asked for, and fits the schema; what is damaged is left out with
//! a warning, and the plain mesh stays.

use crate::schema;

use cullet::bounds::Aabb;
use cullet::{Instance, Scene, Transform};
use cullet_io::baked::{
    Baked, BakedError, BakedLevels, BakedMesh, LevelKind, Measured, OccluderPolygon, OccluderSheet,
    Occluders, geometry_hash,
};
use cullet_io::{BakedFile, LoadOptions, Model, load_bytes, save};
use cullet_mesh::Impostor;
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
    let held_by = impostor.add_to(&mut scene, block).unwrap();
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
    let [a, b] = [&before, &after].map(|m| Impostor::of(&m.scene.levels(0)[0]).unwrap());
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
fn a_mapped_file_has_impostors_and_occluders_as_they_lie() {
    let mut before = model();
    let sheet =
        OccluderSheet { triangles: vec![[[0.0; 3], [1.0; 3], [2.0; 3]]; 2], two_sided: true };
    let occluders = Occluders {
        boxes: vec![Aabb { min: [0.0; 3], max: [1.0, 2.0, 3.0] }],
        sealed: vec![Aabb { min: [-1.0; 3], max: [4.0; 3] }],
        polygons: vec![OccluderPolygon {
            points: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
            two_sided: false,
            tolerance: 0.25,
        }],
        sheets: vec![sheet.clone()],
        near: vec![sheet.clone()],
        efficiency: 0.75,
    };
    before.baked.as_mut().unwrap().meshes[0].occluders = Some(occluders.clone());
    let bytes = bytes_of(&before);
    let mapped = |bytes: &[u8]| {
        let mut words = vec![0u64; bytes.len().div_ceil(8)];
        bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
        words
    };
    let words = mapped(&bytes);
    let file = BakedFile::of(&bytemuck::cast_slice::<u64, u8>(&words)[..bytes.len()]).unwrap();
    let listed = &file.meshes()[0];
    assert_eq!(listed.impostor.as_ref().map(|i| i.measured), Some(MEASURED));
    let (own, impostor) = (file.occluders(0).unwrap().unwrap(), file.impostor(0).unwrap().unwrap());
    assert_eq!(own.to_tables().unwrap(), occluders);
    let corners = |boxes: &[Aabb]| boxes.iter().map(|b| [b.min, b.max]).collect::<Vec<_>>();
    assert_eq!(own.boxes, corners(&occluders.boxes));
    assert_eq!(own.sealed, corners(&occluders.sealed));
    assert_eq!(own.polygons, [[3, 1, 0.25_f32.to_bits()]]);
    assert_eq!(own.corners, occluders.polygons[0].points);
    assert_eq!((own.sheets, own.far().count()), (&[[2, 2]; 2][..], 1));
    assert_eq!((&own.triangles[..2], own.triangles.len()), (&sheet.triangles[..], 4));
    let made = Impostor::of(&before.scene.levels(0)[0]).unwrap();
    assert_eq!((impostor.grid, impostor.texels, impostor.error), (3, 2, made.error()));
    assert_eq!((impostor.shape, impostor.normals), (made.shape(), made.normals()));
    assert_eq!(impostor.to_impostor().unwrap(), *made);
    assert_eq!((file.groups().unwrap().len(), file.groups_measured()), (0, None));
    // A byte of either is noticed, and nothing of the mesh is given out.
    let tables =
        [&listed.occluders.as_ref().unwrap().bytes, &listed.impostor.as_ref().unwrap().table.bytes];
    for table in tables {
        let mut odd = bytes.clone();
        odd[table.end - 1] ^= 4;
        let words = mapped(&odd);
        let file = BakedFile::of(&bytemuck::cast_slice::<u64, u8>(&words)[..bytes.len()]).unwrap();
        assert!(matches!(file.occluders(0), Err(BakedError::Damaged { .. })));
        assert!(matches!(file.impostor(0), Err(BakedError::Damaged { .. })));
    }
    // Counts that the bytes do not hold are errors with the sum left aside, at every word of the head.
    let start = listed.occluders.as_ref().unwrap().bytes.start;
    for word in 0..5 {
        let mut odd = bytes.clone();
        odd[start + word * 4..][..4].copy_from_slice(&u32::MAX.to_le_bytes());
        let words = mapped(&odd);
        let file = BakedFile::of(&bytemuck::cast_slice::<u64, u8>(&words)[..bytes.len()]).unwrap();
        assert!(file.occluders_unchecked(0).is_err(), "word {word}");
    }
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
