//! Tilesets in the forms that other programs write.

mod packed;

use cullet::mesh::MeshData;
use cullet::{Instance, Mesh, Transform};
use cullet_io::{LoadOptions, Model, Up, save, world_box};
use cullet_maps::{WriteTiles, load, write_tiles};
use cullet_testkit::Folder;

/// Writes a box of some size from zero up, as a GLB.
fn box_file(folder: &Folder, name: &str, size: [f32; 3]) -> Vec<u8> {
    let path = folder.root().join(name);
    save(&box_at(size, [0.0; 3]), &path).unwrap();
    std::fs::read(path).unwrap()
}

fn box_at(size: [f32; 3], at: [f64; 3]) -> Model {
    let corner = |i: u8| [0, 1, 2].map(|a| f32::from(i >> a & 1) * size[a]);
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    let data = MeshData { positions: (0..8).map(corner).collect(), indices, ..MeshData::default() };
    let mut model = Model::default();
    let mesh = model.scene.add_mesh(Mesh::new(data).unwrap());
    model.scene.add(Instance::new(mesh, Transform::from_translation(at))).unwrap();
    model.scene.commit(&cullet::Culler::default());
    model
}

/// A tileset whose root has a box, and what else is given; `asset` follows the version.
fn tileset(asset: &str, root: &str) -> String {
    let volume = r#""boundingVolume":{"box":[0,0,0,5,0,0,0,5,0,0,0,5]}"#;
    format!(
        r#"{{"asset":{{"version":"1.0"{asset}}},"geometricError":1,"root":{{{volume},"geometricError":0,"refine":"ADD"{root}}}}}"#
    )
}

fn content(uri: &str) -> String {
    format!(r#","content":{{"uri":"{uri}"}}"#)
}

fn open(folder: &Folder, text: &str) -> Model {
    open_with(folder, text, &LoadOptions::default())
}

fn open_with(folder: &Folder, text: &str, options: &LoadOptions) -> Model {
    load(folder.file("tileset.json", text).as_ref(), options).unwrap_or_else(|e| panic!("{e}"))
}

/// Low and high corner of all instances, in f64.
fn bounds(model: &Model) -> [[f64; 3]; 2] {
    let boxes = model.scene.slots().filter_map(|slot| world_box(&model.scene, slot));
    boxes.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], [l, h]| {
        let of = |a: [f64; 3], b: [f64; 3], f: fn(f64, f64) -> f64| {
            std::array::from_fn(|k| f(a[k], b[k]))
        };
        [of(low, l, f64::min), of(high, h, f64::max)]
    })
}

fn size(model: &Model) -> [f64; 3] {
    let [low, high] = bounds(model);
    // Hundredths tell all that is looked for.
    std::array::from_fn(|a| ((high[a] - low[a]) * 100.0).round() * 0.01)
}

fn assert_at(model: &Model, low: [f64; 3]) {
    let found = bounds(model)[0];
    assert!((0..3).all(|a| (found[a] - low[a]).abs() < 1e-4), "{found:?} for {low:?}");
}

fn warned(model: &Model) -> String {
    model.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn moved(x: f64, y: f64, z: f64) -> String {
    format!(r#","transform":[1,0,0,0,0,1,0,0,0,0,1,0,{x},{y},{z},1]"#)
}

#[test]
fn a_projected_system_is_not_the_globe_and_the_ellipsoid_is() {
    let folder = Folder::new("globe");
    box_file(&folder, "a.glb", [1.0, 2.0, 3.0]);
    let at = |x: f64, y: f64, z: f64, options: &LoadOptions| {
        open_with(&folder, &tileset("", &(content("a.glb") + &moved(x, y, z))), options)
    };
    let plain = LoadOptions::default();
    // Lyon in EPSG:3946; UTM in the north; Sweden, where the northing is the globe's radius.
    for (x, y, z) in [(1_841_000.0, 5_175_000.0, 170.0), (5e5, 5.6e6, 80.0), (3.25e5, 6.375e6, 9.0)]
    {
        let model = at(x, y, z, &plain);
        assert_eq!(size(&model), [1.0, 2.0, 3.0]);
        assert_at(&model, [x, z, -y]);
        assert!(warned(&model).contains("map's coordinates"), "{}", warned(&model));
    }
    // On the ellipsoid at 45 degrees north: up is between its x and z.
    let here = 6_378_137.0 / (1.0 + (1.0 - 0.003_352_81_f64).powi(2)).sqrt();
    let (x, z) = (here, here * (1.0 - 0.003_352_81_f64).powi(2));
    let model = at(x, 0.0, z, &plain);
    assert!(size(&model) != [1.0, 2.0, 3.0], "it is turned");
    assert!(bounds(&model)[1].iter().all(|v| v.abs() < 5.0), "{:?}", bounds(&model));
    assert!(warned(&model).contains("WGS 84") && warned(&model).contains("--up z"));
    let as_it_lies = at(x, 0.0, z, &LoadOptions { up: Some(Up::Z), ..LoadOptions::default() });
    assert_eq!((size(&as_it_lies), warned(&as_it_lies)), ([1.0, 2.0, 3.0], String::new()));
    // Upright on the equator.
    let upright = r#","transform":[0,1,0,0,0,0,1,0,1,0,0,0,6378137,0,0,1]"#;
    let model = open(&folder, &tileset("", &(content("a.glb") + upright)));
    assert_eq!(size(&model), [1.0, 2.0, 3.0]);
    assert!(warned(&model).contains("WGS 84"), "{}", warned(&model));
}

#[test]
fn a_tileset_that_is_written_comes_back_as_it_was_wherever_it_was() {
    for at in [
        [0.0; 3],
        [5e5, 80.0, -5.6e6],
        [3.25e5, 9.0, -6.375e6],
        [-299_510_456.5, 98_424_296.0, -975_000.0],
    ] {
        let folder = Folder::new("utm");
        let model = box_at([40.0, 8.0, 10.0], at);
        let written = write_tiles(&model, folder.root(), &WriteTiles::default(), |_| true);
        let written = written.unwrap().unwrap();
        assert_eq!((written.instances, written.triangles), (1, 12));
        let again = load(&folder.root().join("tileset.json"), &LoadOptions::default()).unwrap();
        assert_eq!((size(&again), warned(&again)), ([40.0, 8.0, 10.0], String::new()), "{at:?}");
        assert_eq!(bounds(&again), bounds(&model));
    }
    // One that somebody has put on the globe since is there.
    let folder = Folder::new("put");
    write_tiles(
        &box_at([40.0, 8.0, 10.0], [0.0; 3]),
        folder.root(),
        &WriteTiles::default(),
        |_| true,
    )
    .unwrap();
    let path = folder.root().join("tileset.json");
    let text = std::fs::read_to_string(&path).unwrap();
    let put = r#""root":{"transform":[0,1,0,0,0,0,1,0,1,0,0,0,6378137,0,0,1],"#;
    std::fs::write(&path, text.replace(r#""root":{"#, put)).unwrap();
    let model = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(size(&model), [40.0, 8.0, 10.0]);
    assert!(warned(&model).contains("WGS 84"), "{}", warned(&model));
}

#[test]
fn instances_that_tiles_do_not_have_are_named_and_not_counted() {
    let folder = Folder::new("nowhere");
    let mut model = box_at([1.0; 3], [0.0; 3]);
    let nowhere = Transform::from_translation([f64::NAN, 0.0, 0.0]);
    model.scene.add(Instance::new(0, nowhere)).unwrap();
    model.instance_names = vec!["here".into(), "nowhere".into()];
    // One whose bounds are not known is drawn all the same.
    let bounds = cullet::scene::BoundsOverride::None;
    let at = Transform::from_translation([4.0, 0.0, 0.0]);
    model.scene.add(Instance { bounds, ..Instance::new(0, at) }).unwrap();
    model.scene.commit(&cullet::Culler::default());
    let written = write_tiles(&model, folder.root(), &WriteTiles::default(), |_| true);
    let written = written.unwrap().unwrap();
    assert_eq!((written.instances, written.triangles), (2, 24));
    let notes: Vec<String> = written.notes.iter().map(ToString::to_string).collect();
    assert!(notes.len() == 1 && notes[0].contains("1 left out: \"nowhere\""), "{notes:?}");
    let again = load(&folder.root().join("tileset.json"), &LoadOptions::default()).unwrap();
    assert_eq!(again.scene.instance_count(), 2);
}

#[test]
fn the_axis_of_gltf_contents_is_the_one_that_the_asset_names() {
    let folder = Folder::new("up");
    box_file(&folder, "a.glb", [1.0, 2.0, 3.0]);
    for (asset, expected) in [
        ("", [1.0, 2.0, 3.0]),
        (r#","gltfUpAxis":"Y""#, [1.0, 2.0, 3.0]),
        (r#","gltfUpAxis":"Z""#, [1.0, 3.0, 2.0]),
        (r#","gltfUpAxis":"X""#, [3.0, 1.0, 2.0]),
    ] {
        let model = open(&folder, &tileset(asset, &content("a.glb")));
        assert_eq!(size(&model), expected, "{asset}");
        // A tileset within another is of the outer one's axis, unless it says its own.
        let inner = folder.file("inner.json", &tileset("", &content("a.glb")));
        assert!(inner.ends_with("inner.json"));
        let model = open(&folder, &tileset(asset, &content("inner.json")));
        assert_eq!(size(&model), expected, "{asset}, within another");
    }
}

#[test]
fn the_centre_of_cesium_rtc_is_in_the_axes_of_the_tile() {
    let folder = Folder::new("rtc");
    let mut bytes = box_file(&folder, "a.glb", [1.0, 2.0, 3.0]);
    let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut json: serde_json::Value = serde_json::from_slice(&bytes[20..end]).unwrap();
    json["extensions"] = serde_json::json!({"CESIUM_RTC": {"center": [5e6, 60.0, 7.0]}});
    json["extensionsUsed"] = serde_json::json!(["CESIUM_RTC", "KHR_materials_unlit"]);
    let text = json.to_string();
    bytes.splice(
        12..end,
        (text.len() as u32).to_le_bytes().into_iter().chain(*b"JSON").chain(text.bytes()),
    );
    let size = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&size.to_le_bytes());
    for name in ["a.glb", "b.glb"] {
        std::fs::write(folder.root().join(name), &bytes).unwrap();
    }
    // Whatever turns the glTF to z-up comes before.
    for (up, low) in [("Y", [5e6, 7.0, -60.0]), ("Z", [5e6, 7.0, -62.0])] {
        let asset = format!(r#","gltfUpAxis":"{up}""#);
        let model = open(&folder, &tileset(&asset, &content("a.glb")));
        assert_at(&model, low);
    }
    // What two tiles do not have read is named once.
    let both = r#","contents":[{"uri":"a.glb"},{"uri":"b.glb"}]"#;
    let said = warned(&open(&folder, &tileset("", both)));
    assert_eq!(said.matches("not read: KHR_materials_unlit").count(), 1, "{said}");
}

#[test]
fn several_contents_of_either_version_are_all_shown() {
    let folder = Folder::new("contents");
    box_file(&folder, "a.glb", [1.0; 3]);
    box_file(&folder, "b.glb", [2.0; 3]);
    for contents in [
        r#","contents":[{"uri":"a.glb"},{"uri":"b.glb"}]"#,
        r#","extensions":{"3DTILES_multiple_contents":{"content":[{"uri":"a.glb"},{"uri":"b.glb"}]}}"#,
        r#","extensions":{"3DTILES_multiple_contents":{"contents":[{"uri":"a.glb"},{"uri":"b.glb"}]}}"#,
    ] {
        let model = open(&folder, &tileset("", contents));
        assert_eq!(model.scene.instance_count(), 2, "{contents}");
        assert_eq!((size(&model), warned(&model)), ([2.0; 3], String::new()));
    }
}

#[test]
fn implicit_tiles_of_the_extension_are_those_of_1_1() {
    let folder = Folder::new("implicit");
    for name in ["0-0-0.glb", "1-1-0.glb"] {
        box_file(&folder, name, [1.0; 3]);
    }
    // The root and the second of its four children.
    std::fs::write(folder.root().join("bits.bin"), [0b0_0101]).unwrap();
    let availability = r#"{"bufferView":0}"#;
    let subtree = format!(
        r#"{{"buffers":[{{"uri":"bits.bin","byteLength":1}}],"bufferViews":[{{"buffer":0,"byteLength":1}}],
        "tileAvailability":{availability},"contentAvailability":{availability},"childSubtreeAvailability":{{"constant":0}}}}"#
    );
    let _ = folder.file("0.0.0.json", &subtree);
    let tiling = r#","extensions":{"3DTILES_implicit_tiling":{"subdivisionScheme":"QUADTREE","subtreeLevels":2,
        "maximumLevel":1,"subtrees":{"uri":"{level}.{x}.{y}.json"}}}"#;
    let text = tileset("", &(content("{level}-{x}-{y}.glb") + tiling));
    let used = r#"{"extensionsUsed":["3DTILES_implicit_tiling"],"extensionsRequired":["3DTILES_implicit_tiling"],"#;
    let model = open(&folder, &text.replacen('{', used, 1));
    assert_eq!((model.scene.instance_count(), warned(&model)), (2, String::new()));
}

#[test]
fn what_is_not_read_of_a_tileset_is_named() {
    let folder = Folder::new("unread");
    box_file(&folder, "a.glb", [1.0; 3]);
    let text = tileset("", &(content("a.glb") + r#","viewerRequestVolume":{"sphere":[9,0,0,1]}"#));
    let model = open(&folder, &text);
    assert!(warned(&model).contains("viewerRequestVolume"), "{}", warned(&model));
    let with = r#"{"extensionsUsed":["VENDOR_tiles","3DTILES_metadata"],"#;
    let model = open(&folder, &tileset("", "").replacen('{', with, 1));
    assert_eq!(warned(&model), "tileset: not read: VENDOR_tiles; what they add is not there");
    std::fs::write(folder.root().join("p.pnts"), b"pnts\x01\0\0\0").unwrap();
    let both = r#","contents":[{"uri":"a.glb"},{"uri":"p.pnts"}]"#;
    let model = open(&folder, &tileset("", both));
    assert_eq!(model.scene.triangle_count(), 12);
    assert!(warned(&model).contains("tiles of points (pnts) left out"), "{}", warned(&model));
}

#[test]
fn a_tileset_is_known_by_its_root_however_long_its_schema() {
    let folder = Folder::new("schema");
    box_file(&folder, "a.glb", [1.0; 3]);
    let text = tileset("", &content("a.glb"));
    for length in [10, 65_500, 65_536, 200_000] {
        let schema = format!(r#"{{"schema":{{"nodes":"{}"}},"#, "x".repeat(length));
        let model = open(&folder, &text.replacen('{', &schema, 1));
        assert_eq!(model.scene.triangle_count(), 12, "{length}");
    }
}

#[test]
fn paths_may_go_up_within_the_folder_of_the_outermost_tileset() {
    let folder = Folder::new("parent");
    box_file(&folder, "x.glb", [1.0; 3]);
    std::fs::create_dir_all(folder.root().join("ext/deep")).unwrap();
    let inner = |uri: &str| folder.file("ext/deep/e.json", &tileset("", &content(uri)));
    for uri in ["../../x.glb", "./.././../x.glb", "../../ext/../x.glb"] {
        let _ = inner(uri);
        let model = open(&folder, &tileset("", &content("./ext/deep/../deep/e.json")));
        assert_eq!(model.scene.triangle_count(), 12, "{uri}");
    }
    let _ = inner("../../../x.glb");
    let text = tileset("", &content("ext/deep/e.json"));
    let error = load(folder.file("tileset.json", &text).as_ref(), &LoadOptions::default());
    let error = error.unwrap_err().to_string();
    assert!(error.contains("leaves the folder") && error.contains("e.json"), "{error}");
    // A tileset within itself is known by whatever name.
    let _ = inner("../deep/./e.json");
    let error = load(folder.root().join("tileset.json").as_ref(), &LoadOptions::default());
    assert!(error.unwrap_err().to_string().contains("within itself"));
}

#[test]
fn buffers_of_a_tile_may_lie_beside_the_folder_that_it_is_in() {
    let folder = Folder::new("buffers");
    std::fs::create_dir_all(folder.root().join("tiles")).unwrap();
    std::fs::write(folder.root().join("x.bin"), floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]))
        .unwrap();
    let gltf = |uri: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":"{uri}"}}]}}"#
        )
    };
    let text = tileset("", &content("tiles/a.gltf"));
    let _ = folder.file("tiles/a.gltf", &gltf("../x.bin"));
    assert_eq!(open(&folder, &text).scene.triangle_count(), 1);
    // Its ending says nothing.
    let _ = folder.file("a.json", &gltf("x.bin"));
    assert_eq!(open(&folder, &tileset("", &content("a.json"))).scene.triangle_count(), 1);
    let _ = folder.file("inner", &tileset("", ""));
    let inner = folder.file("tileset.json", &tileset("", &content("inner")));
    let error = load(inner.as_ref(), &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("inner: it is a tileset"), "{error}");
    let _ = folder.file("tileset.json", &text);
    let _ = folder.file("tiles/a.gltf", &gltf("../../x.bin"));
    let error = load(folder.root().join("tileset.json").as_ref(), &LoadOptions::default());
    assert!(error.unwrap_err().to_string().contains("leaves the folder"));
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}
