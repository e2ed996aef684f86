//! A glTF file to which levels are added stays what it was: textures, animations, skins, extras and extensions that nobody
//! here knows are in it as before, wherever they came from, and it can be baked again and again.

use crate::by_hand;

use std::path::Path;

use by_hand::bake;
use cullet::{Instance, Mesh, MeshData, Scene, Transform};
use cullet_io::baked::geometry_hash;
use cullet_io::{
    LoadOptions, Material, Model, SaveErrorKind, load, load_bytes_with, save, save_original,
};
use cullet_testkit::{Folder, soups};
use serde_json::{Value, json};

const PNG: &[u8] = b"\x89PNG\r\n\x1a\nand so on";

/// The JSON of a GLB, as text, and its binary chunk.
fn parts(bytes: &[u8]) -> (String, Vec<u8>) {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let text = std::str::from_utf8(&bytes[20..20 + length]).unwrap().trim_end().to_owned();
    (text, bytes.get(28 + length..).unwrap_or_default().to_vec())
}

fn glb(text: &str, bin: &[u8]) -> Vec<u8> {
    let mut text = text.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let total = (28 + text.len() + bin.len()) as u32;
    let chunk = |kind: &[u8; 4], bytes: &[u8]| {
        [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat()
    };
    let head = [&b"glTF"[..], &2u32.to_le_bytes(), &total.to_le_bytes()].concat();
    [head, chunk(b"JSON", &text), chunk(b"BIN\0", &bin)].concat()
}

/// Two balls and a node that moves, with much that is not read here; its images beside it.
fn rich() -> (Value, Vec<u8>) {
    let mut scene = Scene::new();
    for (k, rows) in [12, 8].into_iter().enumerate() {
        let (positions, indices) = soups::ball(rows, 2 * rows);
        let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap();
        let mesh = scene.add_mesh(mesh);
        let place = Transform::from_scale_translation([1.0; 3], [k as f64 * 5.0, 0.0, 0.0]);
        scene.add(Instance::new(mesh, place)).unwrap();
    }
    scene.sort();
    let materials = vec![Material { name: "wood".into(), color: [1.0; 4] }];
    let mesh_names = ["large", "small"].map(String::from).to_vec();
    let model = Model { scene, mesh_names, materials, ..Model::default() };
    let folder = Folder::new("rich");
    let path = folder.root().join("a.glb");
    save(&model, &path).unwrap();
    let (text, mut bin) = parts(&std::fs::read(&path).unwrap());
    let mut root: Value = serde_json::from_str(&text).unwrap();
    let start = bin.len();
    bin.extend([0.0f32, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0].iter().flat_map(|v| v.to_le_bytes()));
    let push = |list: &mut Value, item: Value| {
        list.as_array_mut().unwrap().push(item);
        list.as_array().unwrap().len() - 1
    };
    let view = push(
        &mut root["bufferViews"],
        json!({ "buffer": 0, "byteOffset": start, "byteLength": 32 }),
    );
    let time = json!({ "bufferView": view, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0.0], "max": [1.0] });
    let place = json!({ "bufferView": view, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "VEC3" });
    let (time, place) = (push(&mut root["accessors"], time), push(&mut root["accessors"], place));
    root["animations"] = json!([{ "name": "up and down",
        "samplers": [{ "input": time, "output": place }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }] }]);
    let node = root["nodes"][0].as_object_mut().unwrap();
    node.remove("matrix");
    root["images"] = json!([
        { "uri": "my%20wood.png", "name": "grain" },
        { "uri": "data:image/png;base64,iVBORw0KGgo=" },
        { "uri": "gone.png" },
        { "uri": "odd.png" },
    ]);
    root["textures"] = json!([{ "source": 0 }, { "source": 1 }]);
    root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    root["meshes"][0]["extras"] = json!({ "weight": 1.25, "tags": ["a", "é"] });
    root["meshes"][1]["extensions"] = json!({ "VENDOR_thing": { "deep": [{ "x": null }] } });
    root["extensions"] = json!({ "VENDOR_thing": { "much": true } });
    root["extensionsUsed"] = json!(["VENDOR_thing"]);
    root["extras"] = json!({ "large": 1e300 });
    root["buffers"][0]["byteLength"] = json!(bin.len());
    (root, bin)
}

fn put(folder: &Folder, name: &str, bytes: &[u8]) -> String {
    let path = folder.path(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// Images as they lie beside a model.
fn images(folder: &Folder) {
    put(folder, "my wood.png", PNG);
    put(folder, "odd.png", b"no image");
}

fn opened(path: &str) -> Model {
    load(Path::new(path), &LoadOptions { details: true, ..LoadOptions::default() }).unwrap()
}

/// Bakes a file by hand; the written one, and the warnings.
fn baked(path: &str, out: &str) -> (Vec<u8>, Vec<String>) {
    let mut model = opened(path);
    bake(&mut model);
    let warnings = save_original(&model, Path::new(path), Path::new(out), false).unwrap();
    (std::fs::read(out).unwrap(), warnings.iter().map(ToString::to_string).collect())
}

/// All levels come back, and nothing is wrong with them.
fn has_levels(path: &str) -> Model {
    let model = opened(path);
    let found = model.baked.as_ref().unwrap();
    assert_eq!((found.problem.as_ref(), found.meshes.len()), (None, 2), "{:?}", model.warnings);
    assert!(found.meshes.iter().all(|m| m.problem.is_none() && m.levels.len() == 1));
    model
}

#[test]
fn all_else_is_as_it_was_to_the_byte() {
    let (root, bin) = rich();
    let folder = Folder::new("original");
    images(&folder);
    let original = put(&folder, "in.glb", &glb(&root.to_string(), &bin));
    let out = folder.path("out.glb");
    let (bytes, warnings) = baked(&original, &out);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("gone.png is not there"), "{warnings:?}");
    assert!(warnings[1].contains("no kind of image"), "{warnings:?}");
    let (text, new) = parts(&bytes);
    assert!(new.starts_with(&bin));
    let (before, after) = (root, serde_json::from_str::<Value>(&text).unwrap());
    // Members that stay are there as they were written.
    for name in ["animations", "textures", "materials", "nodes", "accessors", "extras", "asset"] {
        let member = format!("\"{name}\":{}", before[name]);
        assert!(text.contains(&member), "{name}");
    }
    let stays = |list: &str| {
        let old = before[list].as_array().unwrap();
        assert_eq!(&after[list].as_array().unwrap()[..old.len()], &old[..], "{list}");
    };
    stays("bufferViews");
    assert_eq!(after["meshes"][0]["extras"], before["meshes"][0]["extras"]);
    assert_eq!(
        after["meshes"][1]["extensions"]["VENDOR_thing"],
        before["meshes"][1]["extensions"]["VENDOR_thing"]
    );
    assert_eq!(after["extensions"]["VENDOR_thing"], before["extensions"]["VENDOR_thing"]);
    assert_eq!(after["extensionsUsed"], json!(["VENDOR_thing", "CULLET_baked"]));
    // The image is inside, and those that cannot be are where they were.
    let image = &after["images"][0];
    assert_eq!((&image["mimeType"], &image["name"]), (&json!("image/png"), &json!("grain")));
    let view = &after["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    assert_eq!(&new[start..start + PNG.len()], PNG);
    for k in 1..4 {
        assert_eq!(after["images"][k], before["images"][k]);
    }
    // Tables begin at multiples of 64 bytes of the file.
    let views = &after["extensions"]["CULLET_baked"]["bufferViews"];
    let bin_at = bytes.len() - new.len();
    for k in 0..views["count"].as_u64().unwrap() {
        let view = &after["bufferViews"][(views["first"].as_u64().unwrap() + k) as usize];
        assert_eq!((bin_at as u64 + view["byteOffset"].as_u64().unwrap()) % 64, 0);
    }
    let model = has_levels(&out);
    assert!(model.motion.is_some(), "it moves as before");
    assert_eq!(model.scene.triangle_count(), opened(&original).scene.triangle_count());
}

#[test]
fn what_is_baked_again_is_the_same_and_in_its_own_place() {
    let (root, bin) = rich();
    let folder = Folder::new("again");
    images(&folder);
    let out = put(&folder, "a.glb", &glb(&root.to_string(), &bin));
    let first = baked(&out, &out).0;
    assert!(baked(&out, &out).0 == first);
    assert!(baked(&out, &folder.path("b.glb")).0 == first);
    // With nothing baked nothing of it stays.
    let none = folder.path("none.glb");
    save_original(&Model::default(), Path::new(&out), Path::new(&none), false).unwrap();
    let (text, bin_of_none) = parts(&std::fs::read(&none).unwrap());
    assert!(!text.contains("CULLET_baked"), "{text}");
    assert!(bin_of_none.len() < bin.len() + PNG.len() + 128);
    // Tables that somebody else names stay, and new ones come behind them.
    let (text, bin) = parts(&first);
    let mut root: Value = serde_json::from_str(&text).unwrap();
    let last = root["bufferViews"].as_array().unwrap().len() - 1;
    root["images"][2] = json!({ "bufferView": last, "mimeType": "image/png" });
    let named = put(&folder, "named.glb", &glb(&root.to_string(), &bin));
    let more = baked(&named, &folder.path("more.glb")).0;
    assert!(more.len() > first.len());
    has_levels(&folder.path("more.glb"));
}

#[test]
fn buffers_of_other_files_are_taken_in() {
    let (mut root, bin) = rich();
    let folder = Folder::new("buffers");
    images(&folder);
    // Each view's bytes in the one or the other buffer, and a third in the text.
    let half = bin.len() / 8 * 4;
    let mut bins = [Vec::new(), Vec::new(), Vec::new()];
    for (k, view) in root["bufferViews"].as_array_mut().unwrap().iter_mut().enumerate() {
        let (start, length) = (
            view["byteOffset"].as_u64().unwrap() as usize,
            view["byteLength"].as_u64().unwrap() as usize,
        );
        let to = &mut bins[k % 3];
        view["buffer"] = json!(k % 3);
        view["byteOffset"] = json!(to.len());
        to.extend_from_slice(&bin[start..start + length]);
    }
    assert!(half > 0);
    // Of a length that is no multiple of anything.
    bins[0].push(7);
    put(&folder, "one file.bin", &bins[0]);
    put(&folder, "two.bin", &bins[1]);
    let text: String = bins[2].iter().map(|b| format!("%{b:02x}")).collect();
    root["buffers"] = json!([
        { "uri": "one%20file.bin", "byteLength": bins[0].len(), "name": "first" },
        { "uri": "two.bin", "byteLength": bins[1].len() },
        { "uri": format!("data:application/octet-stream,{text}"), "byteLength": bins[2].len() },
    ]);
    let original = put(&folder, "in.gltf", root.to_string().as_bytes());
    let before = opened(&original);
    let other = Folder::new("elsewhere");
    let out = other.path("out.glb");
    let (bytes, warnings) = baked(&original, &out);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    let after = has_levels(&out);
    for (a, b) in before.scene.meshes().iter().zip(after.scene.meshes()) {
        assert_eq!(geometry_hash(a), geometry_hash(b));
    }
    let (text, _) = parts(&bytes);
    let root: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(root["buffers"].as_array().unwrap().len(), 1);
    assert_eq!(root["buffers"][0]["name"], "first");
    // It needs nothing beside it.
    load_bytes_with("out.glb", &bytes, &[], &LoadOptions::default()).unwrap();
    // A GLB may have buffers of other files too, and a placeholder that has no bytes.
    let mut root: Value =
        serde_json::from_str(&std::fs::read_to_string(&original).unwrap()).unwrap();
    root["buffers"][0].as_object_mut().unwrap().remove("uri");
    let placeholder = json!({ "byteLength": 400, "extensions": { "EXT_meshopt_compression": { "fallback": true } } });
    root["buffers"].as_array_mut().unwrap().insert(1, placeholder.clone());
    for view in root["bufferViews"].as_array_mut().unwrap() {
        let buffer = view["buffer"].as_u64().unwrap();
        view["buffer"] = json!(if buffer > 0 { buffer + 1 } else { 0 });
    }
    let mixed = put(&folder, "mixed.glb", &glb(&root.to_string(), &bins[0]));
    let (bytes, _) = baked(&mixed, &out);
    has_levels(&out);
    let root: Value = serde_json::from_str(&parts(&bytes).0).unwrap();
    assert_eq!(root["buffers"].as_array().unwrap().len(), 2);
    assert_eq!(root["buffers"][1], placeholder);
}

#[test]
fn meshes_that_deform_keep_how_and_have_no_levels() {
    let (mut root, bin) = rich();
    let positions = root["meshes"][0]["primitives"][0]["attributes"]["POSITION"].clone();
    root["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": positions }]);
    root["meshes"][0]["weights"] = json!([0.5]);
    let folder = Folder::new("morph");
    images(&folder);
    let original = put(&folder, "in.glb", &glb(&root.to_string(), &bin));
    let out = folder.path("out.glb");
    let (bytes, _) = baked(&original, &out);
    let after: Value = serde_json::from_str(&parts(&bytes).0).unwrap();
    assert_eq!(after["meshes"][0], root["meshes"][0]);
    let model = opened(&out);
    assert!(model.scene.meshes()[0].is_deformable());
    let meshes: Vec<u32> = model.baked.unwrap().meshes.iter().map(|m| m.mesh).collect();
    assert_eq!(meshes, [1]);
}

#[test]
fn levels_fit_however_the_file_is_loaded() {
    // Two primitives of the same positions and different normals: as many vertices with normals as without.
    let (mut root, bin) = rich();
    let primitive = root["meshes"][0]["primitives"][0].clone();
    let mut other = primitive.clone();
    let normals = &mut root["accessors"].as_array_mut().unwrap();
    let copy = normals[primitive["attributes"]["POSITION"].as_u64().unwrap() as usize].clone();
    normals.push(copy);
    other["attributes"]["NORMAL"] = json!(normals.len() - 1);
    root["meshes"][0]["primitives"] = json!([primitive, other]);
    let folder = Folder::new("details");
    images(&folder);
    let original = put(&folder, "in.glb", &glb(&root.to_string(), &bin));
    let out = folder.path("out.glb");
    baked(&original, &out);
    for details in [false, true] {
        let options = LoadOptions { details, ..LoadOptions::default() };
        let model = load(Path::new(&out), &options).unwrap();
        let found = model.baked.unwrap();
        assert!(found.meshes.iter().all(|m| m.problem.is_none()), "{:?}", model.warnings);
    }
}

#[test]
fn what_is_no_original_is_a_typed_error_and_nothing_is_written() {
    let folder = Folder::new("wrong");
    let out = folder.path("out.glb");
    let save = |path: &str, out: &str| {
        save_original(&Model::default(), Path::new(path), Path::new(out), false).unwrap_err().kind
    };
    let gone = save(&folder.path("gone.glb"), &out);
    assert!(matches!(&gone, SaveErrorKind::Original { path, .. } if path.ends_with("gone.glb")));
    let (root, bin) = rich();
    let good = glb(&root.to_string(), &bin);
    let path = put(&folder, "good.glb", &good);
    assert!(matches!(save(&path, &folder.path("out.ply")), SaveErrorKind::Unsupported));
    for end in (0..good.len()).step_by(97) {
        let cut = put(&folder, "cut.glb", &good[..end]);
        assert!(matches!(save(&cut, &out), SaveErrorKind::Original { .. }), "cut at {end}");
    }
    for (from, to) in [
        ("\"buffers\":[{", "\"buffers\":[7,{"),
        ("\"byteLength\"", "\"byteLenght\""),
        ("\"meshes\":[", "\"meshes\":{\"a\":["),
    ] {
        let odd = root.to_string().replacen(from, to, 1);
        let odd = put(&folder, "odd.glb", &glb(&odd, &bin));
        let _ = save_original(
            &Model::default(),
            Path::new(&odd),
            Path::new(&folder.path("odd-out.glb")),
            false,
        );
    }
    assert!(!Path::new(&out).exists());
    // Of another file: mesh 1 of a file that has none.
    let empty = put(&folder, "empty.gltf", br#"{"asset":{"version":"2.0"}}"#);
    let mut model = opened(&path);
    bake(&mut model);
    let other = save_original(&model, Path::new(&empty), Path::new(&out), false).unwrap_err();
    assert!(other.to_string().contains("not the file of this model"), "{other}");
    let plain = save_original(&Model::default(), Path::new(&empty), Path::new(&out), false);
    assert!(plain.unwrap().is_empty());
    assert!(opened(&out).scene.meshes().is_empty());
}

#[test]
fn chains_are_nodes_of_their_own_where_that_is_asked_for() {
    let (mut root, bin) = rich();
    // Drawn twice, and once by a node with a child; the first moves.
    root["nodes"].as_array_mut().unwrap().extend([
        json!({ "mesh": 0, "translation": [1.0, 2.0, 3.0], "extras": { "own": true } }),
        json!({ "mesh": 1, "children": [4] }),
        json!({ "name": "child" }),
    ]);
    root["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let folder = Folder::new("lods");
    images(&folder);
    let original = put(&folder, "in.glb", &glb(&root.to_string(), &bin));
    let out = folder.path("out.glb");
    let mut model = opened(&original);
    bake(&mut model);
    let write = |model: &Model, from: &str, to: &str| {
        let warnings = save_original(model, Path::new(from), Path::new(to), true).unwrap();
        (std::fs::read(to).unwrap(), warnings.iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    let (bytes, warnings) = write(&model, &original, &out);
    assert!(warnings.iter().any(|w| w.starts_with("2 nodes: MSFT_lod")), "{warnings:?}");
    let (text, bin) = parts(&bytes);
    let after: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(after["scenes"], root["scenes"]);
    for at in [0, 3, 4] {
        assert_eq!(after["nodes"][at], root["nodes"][at]);
    }
    for (at, of) in [(1, 1), (2, 0)] {
        let node = &after["nodes"][at];
        let ids = node["extensions"]["MSFT_lod"]["ids"].as_array().unwrap();
        let coverage = node["extras"]["MSFT_screencoverage"].as_array().unwrap();
        assert_eq!((ids.len(), coverage.len()), (1, 2));
        assert!(coverage[0].as_f64().unwrap() > 0.0 && coverage[1] == 0.0);
        let level = &after["nodes"][ids[0].as_u64().unwrap() as usize];
        assert_eq!(level["translation"], node["translation"]);
        // Its triangles are those of the coarsest level, by positions.
        let mesh = &after["meshes"][level["mesh"].as_u64().unwrap() as usize];
        let primitive = &mesh["primitives"][0];
        let base = &after["meshes"][of]["primitives"][0];
        assert_eq!(primitive["attributes"], base["attributes"]);
        assert_eq!(primitive["material"], base["material"]);
        let accessor = &after["accessors"][primitive["indices"].as_u64().unwrap() as usize];
        let view = &after["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = (view["byteOffset"].as_u64().unwrap()
            + accessor["byteOffset"].as_u64().unwrap()) as usize;
        let count = accessor["count"].as_u64().unwrap() as usize;
        let indices: Vec<u32> = bytemuck::pod_collect_to_vec(&bin[start..start + count * 4]);
        let file = opened(&out);
        let held = &file.scene.levels(of as u32)[0];
        let mesh = &file.scene.meshes()[held.mesh as usize];
        let coarse: Vec<u32> = mesh
            .clusters()
            .iter()
            .zip(held.levels.made_from())
            .filter(|(_, from)| **from == 0)
            .flat_map(|(c, _)| c.triangles().flat_map(|t| mesh.triangle(t)))
            .collect();
        assert_eq!(indices, coarse);
    }
    assert_eq!(after["nodes"][2]["extras"]["own"], true);
    assert_eq!(after["extensionsUsed"], json!(["VENDOR_thing", "MSFT_lod", "CULLET_baked"]));
    // Again, and nothing more comes of it.
    let mut again = opened(&out);
    assert_eq!(again.scene.triangle_count(), model.scene.triangle_count());
    bake(&mut again);
    assert!(write(&again, &out, &folder.path("again.glb")).0 == bytes);
}
