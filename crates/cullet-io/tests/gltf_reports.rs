//! Files after reports of other readers' users: each is read as the people of those reports expect.

use cullet_io::{LoadOptions, Model, Up, load_bytes, load_bytes_with};
use serde_json::{Value, json};

use crate::glb::Glb;

fn load(bytes: &[u8]) -> Model {
    load_bytes("report.glb", bytes, &LoadOptions::default()).unwrap()
}

/// The lowest and highest corner of all, to a thousandth.
#[track_caller]
fn assert_extent(model: &Model, low: [f64; 3], high: [f64; 3]) {
    let found = cullet_io::extent(&model.scene).expect("something with bounds");
    for (found, expected) in found.into_iter().flatten().zip([low, high].into_iter().flatten()) {
        assert!((found - expected).abs() < 1e-3, "{found} is not {expected}");
    }
}

fn warnings(model: &Model) -> Vec<String> {
    model.warnings.iter().map(ToString::to_string).collect()
}

/// A figure with a tetrahedron; its node stands far away, which does not matter.
fn figure(skin: Value) -> Glb {
    let mut g = Glb::new();
    let positions =
        g.floats("VEC3", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let indices = g.indices(&[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
    let joints = g.accessor(&[0; 16], 5121, "VEC4", 4);
    let weights = g.floats("VEC4", &[[1.0, 0.0, 0.0, 0.0]; 4]);
    let attributes = json!({"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights});
    g.push("meshes", json!({"primitives": [{"attributes": attributes, "indices": indices}]}));
    g.push("skins", skin);
    g.push("nodes", json!({"name": "figure", "mesh": 0, "skin": 0, "translation": [99, 99, 99]}));
    g
}

#[test]
fn a_skin_stands_by_its_joints_whatever_its_node_says() {
    let model = load(include_bytes!("reports/skin-mixamo-001.glb"));
    assert_extent(&model, [0.0; 3], [1.0, 6.0, 1.0]);
    assert_eq!(model.warnings, []);
    let both = load(include_bytes!("reports/skin-and-cube.glb"));
    assert_extent(&both, [-5.0, 0.0, 0.0], [4.0, 1.0, 1.0]);
    assert!(both.scene.slots().all(|s| both.scene.bounds(s).is_finite()));
}

#[test]
fn joints_outside_of_the_scene_and_below_turned_parents_place_a_skin() {
    let mut g = figure(json!({"joints": [2]}));
    g.push("nodes", json!({"children": [2], "scale": [2, 2, 2], "translation": [10, 0, 0]}));
    g.push("nodes", json!({"translation": [0, 3, 0]}));
    g.json["scenes"] = json!([{"nodes": [0]}]);
    assert_extent(&load(&g.finish()), [10.0, 6.0, 0.0], [12.0, 8.0, 2.0]);
}

#[test]
fn a_skin_without_a_finite_pose_is_kept_as_it_is_stored_and_said_so() {
    let mut g = figure(json!({"joints": [1]}));
    g.push("nodes", json!({"scale": [1e300, 1e300, 1e300]}));
    g.push("nodes", json!({"mesh": 0}));
    let model = load(&g.finish());
    let said = warnings(&model);
    assert!(said.iter().any(|w| w.starts_with("figure: keeps its stored shape")), "{said:?}");
    let unbounded = model.scene.slots().filter(|&s| !model.scene.bounds(s).is_finite());
    assert_eq!(unbounded.count(), 1);
}

#[test]
fn default_weights_of_meshes_and_nodes_are_the_static_shape() {
    let sparse = load(include_bytes!("reports/morph-sparse-nobase.glb"));
    assert_eq!(sparse.warnings, []);
    let [low, high] = cullet_io::extent(&sparse.scene).unwrap();
    assert_eq!((low[1], high[1]), (0.0, 6.0));

    let mut g = Glb::new();
    let positions = g.floats("VEC3", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let up = g.floats("VEC3", &[[0.0; 3], [0.0; 3], [0.0, 4.0, 0.0]]);
    let back = g.floats("VEC3", &[[0.0; 3], [0.0; 3], [0.0, 0.0, -2.0]]);
    let primitive = json!({"attributes": {"POSITION": positions}, "targets": [{"POSITION": up}, {"POSITION": back}]});
    g.push("meshes", json!({"primitives": [primitive], "weights": [1.0, 0.0]}));
    g.push("nodes", json!({"mesh": 0}));
    g.push("nodes", json!({"mesh": 0, "weights": [0.0, 0.5], "translation": [10, 0, 0]}));
    let model = load(&g.finish());
    assert_extent(&model, [0.0, 0.0, -1.0], [11.0, 5.0, 0.0]);
}

#[test]
fn what_moves_stands_as_stored_until_it_is_posed() {
    let mut g = figure(json!({"joints": [1]}));
    g.push("nodes", json!({"translation": [5, 0, 0]}));
    let times = g.floats("SCALAR", &[[0f32], [1.0]]);
    let places = g.floats("VEC3", &[[7.0, 0.0, 0.0], [9.0, 0.0, 0.0]]);
    g.push(
        "animations",
        json!({"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
               "samplers": [{"input": times, "output": places}]}),
    );
    let mut model = load(&g.finish());
    assert_extent(&model, [5.0, 0.0, 0.0], [6.0, 1.0, 1.0]);
    model.pose(0.5).unwrap();
    assert_extent(&model, [8.0, 0.0, 0.0], [9.0, 1.0, 1.0]);
}

#[test]
fn the_centre_of_cesium_rtc_moves_all_of_a_file() {
    let bytes = include_bytes!("reports/x-used-CESIUM_RTC.glb");
    let model = load(bytes);
    assert_extent(&model, [5.0, 6.0, 7.0], [6.0, 7.0, 8.0]);
    assert_eq!(model.warnings, []);
    // In the axes of the file, whichever of them points up.
    let options = LoadOptions { up: Some(Up::Z), ..LoadOptions::default() };
    let turned = load_bytes("report.glb", bytes, &options).unwrap();
    assert_extent(&turned, [5.0, 7.0, -7.0], [6.0, 8.0, -6.0]);

    let mut g = figure(json!({"joints": [1]}));
    g.push("nodes", json!({}));
    g.json["extensions"] = json!({"CESIUM_RTC": {"center": [4e6, 1.25, -5e6]}});
    assert_extent(&load(&g.finish()), [4e6, 1.25, -5e6], [4e6 + 1.0, 2.25, -5e6 + 1.0]);
    let mut g = figure(json!({"joints": [0]}));
    g.json["extensions"] = json!({"CESIUM_RTC": {"center": [1, 2]}});
    let error = load_bytes("a.glb", &g.finish(), &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("CESIUM_RTC"), "{error}");
}

#[test]
fn pointers_to_nodes_are_played_and_others_are_named() {
    let mut model = load(include_bytes!("reports/anim-pointer.glb"));
    assert_eq!(model.warnings, []);
    let slot = |model: &Model| {
        let mut slots = model.scene.slots();
        slots.find(|&s| model.scene.handle(s).unwrap().index == 0).unwrap()
    };
    let at = |model: &Model| model.scene.transform(slot(model)).translation;
    let start = at(&model);
    model.pose(0.5).unwrap();
    assert_ne!(at(&model), start);

    let mut g = Glb::new();
    let times = g.floats("SCALAR", &[[0f32], [1.0]]);
    let values = g.floats("SCALAR", &[[0f32], [1.0]]);
    let pointer = |to: &str| {
        json!({"sampler": 0, "target": {"path": "pointer",
            "extensions": {"KHR_animation_pointer": {"pointer": to}}}})
    };
    let channels = [
        pointer("/materials/0/alphaCutoff"),
        pointer("/nodes/0/extensions/KHR_node_visibility/visible"),
        pointer("/materials/0/alphaCutoff"),
    ];
    let samplers = json!([{"input": times, "output": values}]);
    g.push("animations", json!({"channels": channels, "samplers": samplers}));
    g.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    let model = load(&g.finish());
    assert!(model.motion.is_none());
    let [unread] = &model.unread[..] else { panic!("{:?}", model.unread) };
    assert!(unread.may_move && !unread.may_draw);
    assert!(unread.meaning.contains("KHR_node_visibility/visible stands still"), "{unread:?}");
}

#[test]
fn each_extension_that_is_not_read_is_named_once_with_what_it_means() {
    let mut g = Glb::new();
    let positions = g.floats("VEC3", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    g.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}, "mode": 0}]}));
    g.push("nodes", json!({"mesh": 0}));
    g.json["extensionsUsed"] = json!([
        "KHR_materials_unlit",
        "KHR_gaussian_splatting",
        "KHR_mesh_quantization",
        "NOBODY_knows",
        "KHR_materials_unlit"
    ]);
    g.json["extensionsRequired"] = json!(["KHR_materials_unlit"]);
    g.json["extensions"] = json!({"KHR_lights_punctual": {"lights": []}, "NOBODY_knows": {}});
    let model = load(&g.finish());
    let said = warnings(&model);
    let not_read: Vec<&str> = said.iter().filter_map(|w| w.strip_prefix("not read: ")).collect();
    assert_eq!(
        not_read,
        [
            "KHR_materials_unlit, how surfaces look: no triangle is moved by it",
            "KHR_gaussian_splatting, splats, which are no triangles",
            "NOBODY_knows, which is unknown here: it may change what is drawn, where, and how it moves",
            "KHR_lights_punctual, lamps",
        ]
    );
    assert!(!said.contains(&"scene: draws nothing".to_owned()), "{said:?}");
    assert!(
        said.iter()
            .any(|w| w
                == "scene: draws nothing but what KHR_gaussian_splatting, NOBODY_knows may draw"),
        "{said:?}"
    );
}

#[test]
fn chunks_of_any_length_are_read_with_a_warning() {
    let model = load(include_bytes!("reports/glb-json-unaligned.glb"));
    assert_eq!(model.scene.triangle_count(), 12);
    let said = warnings(&model);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains("its length of 529 bytes is not a multiple of 4"), "{said:?}");
}

#[test]
fn json_that_is_padded_with_nul_is_read_with_a_warning() {
    let mut bytes = include_bytes!("reports/skin-and-cube.glb").to_vec();
    let end = 20 + u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let text = bytes[..end].trim_ascii_end().len();
    assert!(text < end, "the file has padding");
    bytes[text..end].fill(0);
    let model = load(&bytes);
    assert_eq!(model.scene.triangle_count(), 24);
    assert!(warnings(&model)[0].contains("padded with NUL"), "{:?}", model.warnings);
}

#[test]
fn version_1_with_its_maps_gets_the_advice_for_version_1() {
    let text = include_bytes!("reports/gltf10-real-form.gltf");
    let error = load_bytes("a.gltf", text, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("glTF version 1.0; only 2.x is read"), "{error}");
    let binary = b"glTF\x01\0\0\0\x1c\0\0\0\x08\0\0\0\0\0\0\0{}      ";
    let error = load_bytes("a.glb", binary, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("only 2.x is read"), "{error}");
}

#[test]
fn percent_signs_and_dots_in_names_of_files_lead_to_them() {
    let bytes: Vec<u8> = [[0f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        .as_flattened()
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let text = |uri: &str| {
        json!({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
            "buffers": [{"byteLength": 36, "uri": uri}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]})
        .to_string()
    };
    let load = |uri: &str, name: &str| {
        let beside = [(name.to_owned(), bytes.clone())];
        load_bytes_with("a.gltf", text(uri).as_bytes(), &beside, &LoadOptions::default())
    };
    for (uri, name) in [
        ("100%.bin", "100%.bin"),
        ("50%of.bin", "50%of.bin"),
        ("a%20b.bin", "a b.bin"),
        ("a%20b.bin", "a%20b.bin"),
        ("parts/../a.bin", "a.bin"),
        ("./parts/./a.bin", "parts/a.bin"),
    ] {
        let model = load(uri, name).unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert_eq!(model.scene.triangle_count(), 1, "{uri}");
    }
    let error = load("../a.bin", "a.bin").unwrap_err().to_string();
    assert!(error.contains("leaves the folder"), "{error}");
}

#[test]
fn bounds_that_culling_cannot_hold_are_none_for_everyone() {
    let model = load(include_bytes!("reports/scale-1e30.glb"));
    assert!(model.scene.slots().all(|s| !model.scene.bounds(s).is_finite()));
    assert!(model.scene.extent().is_empty());
    assert_eq!(cullet_io::extent(&model.scene), None);
}
