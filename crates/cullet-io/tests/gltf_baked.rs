//! Levels in glTF: what is written comes back and fits the schema; what is damaged, of another version or of another mesh is
//! left out with a warning, and the plain mesh stays.

use crate::by_hand;
use crate::schema;

use by_hand::{MEASURED, tables};
use cullet::bounds::Aabb;
use cullet::lod::{Group, NO_GROUP};
use cullet::mesh::Part;
use cullet::{Instance, Mesh, MeshData, Projection, Scene, Transform};
use cullet_io::baked::{
    Baked, BakedError, BakedLevels, BakedMesh, LevelKind, LevelTables, OccluderSheet, Occluders,
    geometry_hash,
};
use cullet_io::{CameraNode, LoadOptions, Material, Model, load_bytes, save};
use cullet_testkit::{Folder, soups};
use proptest::prelude::*;
use serde_json::{Value, json};

const NAME: &str = "CULLET_baked";

/// A ball of two materials with levels of both kinds, and a triangle that has none; a camera and cells.
fn model() -> Model {
    let mut scene = Scene::new();
    let (positions, indices) = soups::ball(12, 24);
    let half = (indices.len() / 6) as u32;
    let rest = (indices.len() / 3) as u32 - half;
    let part = |first_triangle, triangle_count, material| Part {
        first_triangle,
        triangle_count,
        material,
        ..Part::default()
    };
    // One without triangles is not written.
    let parts = vec![part(0, half, 0), part(half, 0, 1), part(half, rest, 1)];
    let ball = Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).unwrap();
    let single = MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        indices: vec![0, 1, 2],
        ..MeshData::default()
    };
    let ball = scene.add_mesh(ball);
    let single = scene.add_mesh(Mesh::new(single).unwrap());
    for (mesh, x) in [(single, -5.0), (ball, 0.0), (ball, 5.0)] {
        let place = Transform::from_scale_translation([1.0; 3], [x, 0.0, 0.0]);
        scene.add(Instance::new(mesh, place)).unwrap();
    }
    scene.sort();
    let mut baked = Baked { generator: "by hand 1".into(), ..Baked::default() };
    let geometry = geometry_hash(&scene.meshes()[ball as usize]);
    let mut of_ball = BakedMesh { mesh: ball, geometry, ..BakedMesh::default() };
    for kind in [LevelKind::Chain, LevelKind::Hierarchy] {
        let base = &scene.meshes()[ball as usize];
        let (mesh, levels) = tables(base).build(base).unwrap();
        let held_by = scene.add_mesh(mesh);
        scene.add_levels(ball, held_by, levels).unwrap();
        of_ball.levels.push(BakedLevels { kind, held_by, measured: MEASURED });
    }
    baked.meshes.push(of_ball);
    let material = |name: &str| Material { name: name.into(), color: [0.5; 4] };
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 0.0, near: 0.1, far: f64::INFINITY };
    let place = Transform::from_scale_translation([1.0; 3], [0.0, 0.0, 9.0]);
    Model {
        name: "two".into(),
        scene,
        mesh_names: ["ball", "single"].map(String::from).to_vec(),
        materials: vec![material("red"), material("blue")],
        cameras: vec![CameraNode { name: "eye".into(), projection, keys: vec![(0.0, place)] }],
        baked: Some(baked),
        ..Model::default()
    }
}

fn bytes_of(model: &Model) -> Vec<u8> {
    let folder = Folder::new("baked");
    let path = folder.root().join("a.glb");
    save(model, &path).unwrap();
    std::fs::read(&path).unwrap()
}

fn loaded(bytes: &[u8]) -> Model {
    load_bytes("a.glb", bytes, &LoadOptions::default()).unwrap()
}

/// The JSON of a GLB, and where its binary chunk begins.
fn json_of(bytes: &[u8]) -> (Value, usize) {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&bytes[20..20 + length]).unwrap(), 28 + length)
}

/// A GLB with another JSON, of any length.
fn with_json(bytes: &[u8], json: &str) -> Vec<u8> {
    let (_, bin) = json_of(bytes);
    let mut text = json.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = bytes[..12].to_vec();
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    out.extend(&bytes[bin - 8..]);
    let total = (out.len() as u32).to_le_bytes();
    out[8..12].copy_from_slice(&total);
    out
}

/// Why the levels of the ball were left out.
fn problem(bytes: &[u8]) -> BakedError {
    let model = loaded(bytes);
    assert!(model.scene.levels(0).is_empty() && model.scene.meshes().len() == 2);
    assert!(model.warnings.iter().any(|w| w.to_string().contains(NAME)), "{:?}", model.warnings);
    model.baked.unwrap().meshes[0].problem.clone().unwrap()
}

fn same_mesh(a: &Mesh, b: &Mesh) -> bool {
    // A file has a material for each pair of colour and sides.
    let parts = |m: &Mesh| -> Vec<(u32, u32, bool)> {
        let drawn = m.parts().iter().filter(|p| p.triangle_count > 0);
        drawn.map(|p| (p.first_triangle, p.triangle_count, p.two_sided)).collect()
    };
    let clusters = |m: &Mesh| -> Vec<[u32; 2]> {
        m.clusters().iter().map(|c| [c.first_triangle, c.triangle_count]).collect()
    };
    a.positions() == b.positions()
        && a.indices() == b.indices()
        && a.original_triangle() == b.original_triangle()
        && parts(a) == parts(b)
        && clusters(a) == clusters(b)
}

#[test]
fn levels_come_back_as_they_were_made() {
    let model = model();
    let bytes = bytes_of(&model);
    let back = loaded(&bytes);
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    assert_eq!(back.scene.meshes().len(), 4);
    let pairs = back.scene.meshes().iter().zip(model.scene.meshes());
    pairs.for_each(|(a, b)| assert!(same_mesh(a, b)));
    assert_eq!(back.scene.levels(0).len(), 2);
    for (a, b) in back.scene.levels(0).iter().zip(model.scene.levels(0)) {
        assert_eq!((a.mesh, &a.levels), (b.mesh, &b.levels));
    }
    assert!(back.scene.levels(1).is_empty());
    assert_eq!(back.mesh_names, ["ball", "single", "ball, chain", "ball, hierarchy"]);
    let baked = back.baked.as_ref().unwrap();
    assert_eq!(baked.generator, "by hand 1");
    assert_eq!(baked.meshes[0].levels, model.baked.as_ref().unwrap().meshes[0].levels);
    assert!(baked.holds_levels(2) && baked.holds_levels(3) && !baked.holds_levels(0));
    assert_eq!((baked.held_count(), baked.of(1)), (2, None));
    assert_eq!(back.cameras, model.cameras);
    // Once more, and it is the same.
    let (first, _) = json_of(&bytes);
    let (again, _) = json_of(&bytes_of(&back));
    assert_eq!(again["extensions"], first["extensions"]);
    assert_eq!(again["meshes"][0]["extensions"], first["meshes"][0]["extensions"]);
}

#[test]
fn the_file_fits_its_schema_and_tables_are_aligned_in_it() {
    let bytes = bytes_of(&model());
    let (root, bin) = json_of(&bytes);
    let schema = schema::of(NAME);
    for object in [&root["extensions"][NAME], &root["meshes"][0]["extensions"][NAME]] {
        let found = schema::held(&schema, object, "");
        assert!(found.is_empty(), "{found:?}");
    }
    assert!(!schema::held(&schema, &json!({ "version": 1 }), "").is_empty());
    assert_eq!(root["extensionsUsed"], json!([NAME]));
    assert_eq!(bin % 64, 0);
    let levels = root["meshes"][0]["extensions"][NAME]["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 2);
    for of in levels {
        for table in ["indices", "clusters", "groups"] {
            let view = &root["bufferViews"][of[table].as_u64().unwrap() as usize];
            assert_eq!(view["byteOffset"].as_u64().unwrap() % 64, 0);
            assert_eq!(view.get("target"), None);
        }
        assert_eq!(of["errors"], json!([0.5, 0.5]));
    }
    // A mesh without levels is as ever.
    assert_eq!(root["meshes"][1].get("extensions"), None);
}

#[test]
fn occluders_come_back_also_of_meshes_without_levels_and_damage_is_told() {
    let mut model = model();
    let sheet =
        OccluderSheet { triangles: vec![[[0.0; 3], [1.0; 3], [0.0, 1.0, 0.0]]], two_sided: true };
    let some = Occluders {
        boxes: vec![Aabb { min: [-0.5; 3], max: [0.5; 3] }],
        sheets: vec![sheet],
        efficiency: 0.75,
        ..Occluders::default()
    };
    let geometry = geometry_hash(&model.scene.meshes()[1]);
    let none = Some(Occluders::default());
    let single = BakedMesh { mesh: 1, geometry, occluders: none, ..BakedMesh::default() };
    let baked = model.baked.as_mut().unwrap();
    baked.meshes[0].occluders = Some(some);
    baked.meshes.push(single);
    let good = bytes_of(&model);
    let back = loaded(&good);
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    let found = back.baked.unwrap();
    for (a, b) in found.meshes.iter().zip(&model.baked.as_ref().unwrap().meshes) {
        assert_eq!((a.mesh, &a.occluders, &a.levels), (b.mesh, &b.occluders, &b.levels));
    }
    let (root, bin) = json_of(&good);
    let schema = schema::of(NAME);
    for mesh in 0..2 {
        let object = &root["meshes"][mesh]["extensions"][NAME];
        assert!(schema::held(&schema, object, "").is_empty());
        let view = object["occluders"]["table"].as_u64().unwrap() as usize;
        let start = root["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!((bin + start) % 64, 0);
        for at in 0..root["bufferViews"][view]["byteLength"].as_u64().unwrap() as usize {
            let mut odd = good.clone();
            odd[bin + start + at] ^= 0x20;
            let baked = loaded(&odd).baked.unwrap();
            let damaged = baked.meshes[mesh].problem.as_ref();
            assert!(matches!(damaged, Some(BakedError::Damaged { .. })), "byte {at}");
            assert!(baked.meshes[1 - mesh].problem.is_none());
        }
    }
}

#[test]
fn the_plain_mesh_is_there_without_them() {
    let bytes = bytes_of(&model());
    let options = LoadOptions { levels: false, ..LoadOptions::default() };
    let plain = load_bytes("a.glb", &bytes, &options).unwrap();
    assert_eq!((plain.scene.meshes().len(), plain.baked.is_none()), (2, true));
    let without = Model { baked: None, ..model() };
    let other = bytes_of(&without);
    assert!(!String::from_utf8_lossy(&other).contains(NAME));
    let other = loaded(&other);
    let pairs = plain.scene.meshes().iter().zip(other.scene.meshes());
    pairs.for_each(|(a, b)| assert!(same_mesh(a, b)));
}

#[test]
fn levels_of_a_mesh_that_was_changed_are_not_written() {
    let mut model = model();
    let other = model.scene.meshes()[1].clone();
    model.scene.edit_mesh(0, |mesh| *mesh = other);
    let bytes = bytes_of(&model);
    assert!(!String::from_utf8_lossy(&bytes).contains(NAME));
}

#[test]
fn another_version_another_mesh_and_damage_are_told_apart() {
    let good = bytes_of(&model());
    let (root, bin) = json_of(&good);
    let edited = |pointer: &str, value: Value| {
        let mut root = root.clone();
        *root.pointer_mut(pointer).unwrap() = value;
        with_json(&good, &root.to_string())
    };
    let at = |member: &str| format!("/meshes/0/extensions/{NAME}/{member}");

    let newer = loaded(&edited(&format!("/extensions/{NAME}/version"), json!(2)));
    assert!(newer.scene.levels(0).is_empty() && newer.baked.as_ref().unwrap().meshes.is_empty());
    let problem_of_all = newer.baked.as_ref().unwrap().problem.clone();
    assert_eq!(problem_of_all, Some(BakedError::Version { found: 2 }));
    let told = newer.warnings[0].to_string();
    assert!(told.contains("version 2") && told.contains("bake the model again"), "{told}");

    let view = |of: u64| root["bufferViews"][of as usize]["byteOffset"].as_u64().unwrap() as usize;
    let mut moved = good.clone();
    moved[bin + view(0)] ^= 1;
    assert!(matches!(problem(&moved), BakedError::Geometry { .. }));

    let groups = root.pointer(&at("levels/1/groups")).unwrap().as_u64().unwrap();
    let mut damaged = good.clone();
    damaged[bin + view(groups) + 17] ^= 0x40;
    assert!(matches!(problem(&damaged), BakedError::Damaged { .. }));

    for (member, value, told) in [
        ("levels/0/groups", json!(999), "bufferView 999 of"),
        ("levels/0/indices", json!(0), "damaged"),
        ("levels/0/parts", json!([1, 2]), "damaged"),
        ("levels/0/parts", json!([1e300, 2]), "invalid value"),
        ("levels/0/kind", json!("impostor"), "kind \"impostor\""),
        ("levels/0/measured/seed", json!(8), "damaged"),
        ("levels/0/measured/quantile", json!(0.9), "damaged"),
        ("levels/0", json!(3), "expected an object"),
        ("geometry", json!("12"), "sixteen hexadecimal digits"),
        ("geometry", json!("0000000000000000"), "another geometry"),
    ] {
        let found = problem(&edited(&at(member), value)).to_string();
        assert!(found.contains(told), "{member}: {found}");
    }
    let chunk = |member: &str| format!("/extensions/{NAME}/{member}");
    for (member, value) in [
        ("hash", json!("0123456789abcdef")),
        ("chunks/0/hash", json!("0123456789abcdef")),
        ("chunks/0/bytes", json!(1)),
        ("chunks/0/mesh", json!(1)),
        ("chunks", json!([])),
        ("chunks", json!({})),
    ] {
        let model = loaded(&edited(&chunk(member), value));
        assert!(model.scene.levels(0).is_empty(), "{member}");
        assert!(!model.warnings.is_empty(), "{member}");
    }
    // The table says that the mesh has something baked.
    let mut without = root.clone();
    without["meshes"][0].as_object_mut().unwrap().remove("extensions");
    let found = problem(&with_json(&good, &without.to_string())).to_string();
    assert!(found.contains("nothing baked"), "{found}");
}

#[test]
fn every_byte_of_the_tables_is_under_the_sum_and_every_cut_is_noticed() {
    let good = bytes_of(&model());
    let (root, bin) = json_of(&good);
    for of in root["meshes"][0]["extensions"][NAME]["levels"].as_array().unwrap() {
        for table in ["indices", "clusters", "groups"] {
            let view = &root["bufferViews"][of[table].as_u64().unwrap() as usize];
            let [start, len] = ["byteOffset", "byteLength"].map(|k| view[k].as_u64().unwrap());
            for at in (start..start + len).step_by(53) {
                let mut odd = good.clone();
                odd[bin + at as usize] ^= 0x11;
                let found = problem(&odd);
                assert!(matches!(found, BakedError::Damaged { .. }), "{table} {at}: {found}");
            }
        }
    }
    let options = LoadOptions::default();
    for cut in (0..good.len()).step_by(61).chain(good.len() - 9..good.len()) {
        assert!(load_bytes("a.glb", &good[..cut], &options).is_err(), "{cut}");
    }
}

/// The file was written by another program, whose sums follow the book.
#[test]
fn a_file_of_another_hand_is_read() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/gltf/baked");
    let bytes = std::fs::read(path).unwrap();
    let model = load_bytes("a.gltf", &bytes, &LoadOptions::default()).unwrap();
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    let [of] = model.scene.levels(0) else { panic!("{:?}", model.baked) };
    assert_eq!(of.levels.group(0), Group { centre: [0.5, 0.5, 0.0], radius: 1.0, error: 0.75 });
    assert_eq!(
        (of.levels.made_from(), of.levels.replaced_by()),
        (&[NO_GROUP, 0][..], &[0, NO_GROUP][..])
    );
    let root: Value = serde_json::from_slice(&bytes).unwrap();
    let schema = schema::of(NAME);
    for object in [&root["extensions"][NAME], &root["meshes"][0]["extensions"][NAME]] {
        assert!(schema::held(&schema, object, "").is_empty());
    }
}

#[test]
fn tables_that_are_no_levels_are_refused_in_words() {
    let model = model();
    let base = &model.scene.meshes()[0];
    let good = tables(base);
    assert!(good.clone().build(base).is_ok());
    let refused = |edit: &dyn Fn(&mut LevelTables)| {
        let mut tables = good.clone();
        edit(&mut tables);
        tables.build(base).map(drop).unwrap_err().to_string()
    };
    let last = good.clusters.len() - 1;
    type Case<'a> = (&'a str, &'a dyn Fn(&mut LevelTables), &'a str);
    let cases: [Case<'_>; 10] = [
        ("a part", &|t| t.parts.truncate(2), "parts of the levels: 2, expected 3"),
        ("triangles", &|t| t.parts[0] += 1, "triangles of all levels"),
        ("a vertex", &|t| t.indices[5] = 1 << 30, "index 5 is 1073741824"),
        ("a count", &|t| t.clusters[0].triangle_count = u32::MAX, "cluster"),
        ("a start", &|t| t.clusters[1].first_triangle = u32::MAX, "cluster 1"),
        ("a cluster", &|t| t.clusters.truncate(last), "clusters end at"),
        ("a group", &|t| t.clusters[0].replaced_by = 5, "group"),
        ("itself", &|t| t.clusters[last].replaced_by = 0, "are its own"),
        ("an error", &|t| t.groups[0].error = f32::NAN, "negative or not finite"),
        ("a radius", &|t| t.groups[0].radius = -1.0, "negative or not finite"),
    ];
    for (what, edit, told) in cases {
        let found = refused(edit);
        assert!(found.contains(told), "{what}: {found}");
    }
    let bytes = good.to_bytes();
    let [indices, clusters, groups] = bytes.each_ref().map(Vec::as_slice);
    let whole = LevelTables::from_bytes(good.parts.clone(), [indices, clusters, groups]);
    assert_eq!(whole, Ok(good));
    let short = LevelTables::from_bytes(vec![], [indices, &clusters[1..], groups]).unwrap_err();
    assert!(short.to_string().starts_with("its clusters has"), "{short}");
}

#[test]
fn a_file_that_cannot_be_written_leaves_the_one_before() {
    let folder = Folder::new("whole");
    let folder = folder.root();
    let path = folder.join("a.glb");
    std::fs::write(&path, "before").unwrap();
    // In the place where it is written first.
    let beside = folder.join(format!("a.glb.{}.part", std::process::id()));
    std::fs::create_dir_all(&beside).unwrap();
    assert!(save(&model(), &path).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), b"before");
    std::fs::remove_dir(&beside).unwrap();
    save(&model(), &path).unwrap();
    assert!(std::fs::read(&path).unwrap().starts_with(b"glTF"));
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// Some bytes of the JSON of the extension are others: no panic, and levels are the right ones or none.
    #[test]
    fn nonsense_in_the_json_is_no_levels(
        edits in prop::collection::vec((0.0..1.0f64, any::<prop::sample::Index>()), 1..4),
        root in any::<bool>(),
    ) {
        let model = model();
        let good = bytes_of(&model);
        let (json, _) = json_of(&good);
        let pointer =
            if root { "/extensions".to_owned() } else { "/meshes/0/extensions".to_owned() };
        let own = json.pointer(&pointer).unwrap().to_string();
        let mut odd = own.clone().into_bytes();
        for (at, what) in edits {
            let at = (at * odd.len() as f64) as usize;
            let marks = b"0123456789abcdef{}[],:\"-.e";
            odd[at] = marks[what.index(marks.len())];
        }
        let odd = String::from_utf8(odd).unwrap();
        let text = json.to_string();
        prop_assume!(text.matches(&own).count() == 1);
        let bytes = with_json(&good, &text.replacen(&own, &odd, 1));
        if let Ok(back) = load_bytes("a.glb", &bytes, &LoadOptions::default()) {
            let (found, made) = (back.scene.levels(0), model.scene.levels(0));
            prop_assert!(found.len() <= made.len());
            prop_assert!(found.iter().all(|f| made.iter().any(|m| m.levels == f.levels)));
        }
    }
}
