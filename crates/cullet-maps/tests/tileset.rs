//! 3D Tiles, written by hand around models with known answers.

use std::path::Path;

use cullet_io::{LoadOptions, Model, save};
use cullet_maps::load;
use cullet_maps::load_bytes_with;
use cullet_testkit::Folder;

/// Writes a model of one box, from 0 to 1 along x, y and z after its own place.
fn box_glb(path: &Path) {
    let off = "OFF\n8 12 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n\
               3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 2 3 7\n3 2 7 6\n3 1 2 6\n3 1 6 5\n3 0 4 7\n3 0 7 3\n";
    let model =
        cullet_maps::load_bytes("box.off", off.as_bytes(), &LoadOptions::default()).unwrap();
    save(&model, path).unwrap();
}

fn tileset(root: &str) -> String {
    format!(r#"{{"asset":{{"version":"1.1"}},"geometricError":100,"root":{root}}}"#)
}

fn tile(rest: &str) -> String {
    format!(r#"{{"boundingVolume":{{"box":[0,0,0,9,0,0,0,9,0,0,0,9]}},"geometricError":1{rest}}}"#)
}

fn try_load(folder: &Folder, text: &str) -> Result<Model, String> {
    let path = folder.root().join("tileset.json");
    std::fs::write(&path, text).unwrap();
    load(&path, &LoadOptions::default()).map_err(|e| e.to_string())
}

/// Low corners of all instances, rounded, sorted.
fn places(model: &Model) -> Vec<[i64; 3]> {
    let origin = model.scene.origin();
    let low = |slot| {
        let low = model.scene.bounds(slot).min;
        std::array::from_fn(|a| (f64::from(low[a]) + origin[a]).round() as i64)
    };
    let mut places: Vec<_> = model.scene.slots().map(low).collect();
    places.sort_unstable();
    places
}

fn moved(x: f64, y: f64, z: f64) -> String {
    format!(r#","transform":[1,0,0,0,0,1,0,0,0,0,1,0,{x},{y},{z},1]"#)
}

#[test]
fn the_finest_tiles_are_loaded_where_their_transforms_say() {
    let folder = Folder::new("tileset");
    box_glb(&folder.root().join("a.glb"));
    let content = r#","content":{"uri":"a.glb"}"#;
    // Tiles are z-up: 10 along their y is 10 to the north, −z of the scene; 5 along z is up.
    let far = tile(&(moved(100.0, 10.0, 5.0) + content));
    let near = tile(content);
    let root = |refine: &str| {
        let children = format!(r#","refine":"{refine}","children":[{far},{near}]"#);
        tileset(&tile(&(content.to_owned() + &moved(0.0, 0.0, 1.0) + &children)))
    };
    let replaced = try_load(&folder, &root("REPLACE")).unwrap();
    assert_eq!(places(&replaced), [[0, 1, 0], [100, 6, -10]]);
    assert_eq!(replaced.scene.triangle_count(), 24);
    assert!(
        replaced.instance_names.iter().all(|n| n.starts_with("a ")),
        "{:?}",
        replaced.instance_names
    );
    let added = try_load(&folder, &root("ADD")).unwrap();
    assert_eq!(places(&added), [[0, 1, 0], [0, 1, 0], [100, 6, -10]]);
    // Children that show nothing replace nothing.
    let empty = tile(&(content.to_owned() + r#","children":["# + &tile("") + "]"));
    assert_eq!(places(&try_load(&folder, &tileset(&empty)).unwrap()), [[0, 0, 0]]);
}

#[test]
fn a_saved_model_comes_back_as_a_tile() {
    let folder = Folder::new("tileset");
    let solids = cullet_scenes::build("solids").unwrap();
    save(&solids, &folder.root().join("s.glb")).unwrap();
    let whole = load(&folder.root().join("s.glb"), &LoadOptions::default()).unwrap();
    let model = try_load(&folder, &tileset(&tile(r#","content":{"uri":"s.glb"}"#))).unwrap();
    assert_eq!(model.scene.triangle_count(), whole.scene.triangle_count());
    assert_eq!(model.scene.instance_count(), whole.scene.instance_count());
    assert_eq!(model.materials, whole.materials);
    assert_eq!(places(&model), places(&whole));
}

#[test]
fn tilesets_within_tilesets_and_old_tiles_are_read() {
    let folder = Folder::new("tileset");
    let inner = folder.root().join("inner");
    std::fs::create_dir_all(&inner).unwrap();
    box_glb(&inner.join("a.glb"));
    let glb = std::fs::read(inner.join("a.glb")).unwrap();
    let features = br#"{"BATCH_LENGTH":0,"RTC_CENTER":[7,0,0]}  "#;
    let mut old = b"b3dm".to_vec();
    let sizes = [1, (28 + features.len() + glb.len()) as u32, features.len() as u32, 0, 0, 0];
    sizes.iter().for_each(|v| old.extend(v.to_le_bytes()));
    old.extend(features);
    old.extend(&glb);
    std::fs::write(inner.join("b.b3dm"), &old).unwrap();
    let contents = r#","contents":[{"uri":"a.glb"},{"url":"b.b3dm?v=2"}]"#;
    std::fs::write(inner.join("more.json"), tileset(&tile(contents))).unwrap();
    let outer =
        tile(&(r#","content":{"uri":"inner/more.json"}"#.to_owned() + &moved(0.0, 0.0, 3.0)));
    let model = try_load(&folder, &tileset(&outer)).unwrap();
    assert_eq!(places(&model), [[0, 3, 0], [7, 3, 0]]);

    for cut in [4, 20, 30] {
        std::fs::write(inner.join("b.b3dm"), &old[..cut]).unwrap();
        let error = try_load(&folder, &tileset(&outer)).unwrap_err();
        assert!(error.contains("b.b3dm") && error.contains("b3dm header"), "{error}");
    }
}

fn implicit(scheme: &str, subtree: u32, levels: u32) -> String {
    format!(
        r#","content":{{"uri":"{{level}}-{{x}}-{{y}}-{{z}}.glb"}},"implicitTiling":{{"subdivisionScheme":"{scheme}",
        "subtreeLevels":{subtree},"availableLevels":{levels},"subtrees":{{"uri":"{{level}}-{{x}}-{{y}}-{{z}}.json"}}}}"#
    )
}

/// Implicit tiles of four levels in subtrees of two, with a box at the root and in one branch of each level; at each place the box lies
/// where its name says.
#[test]
fn implicit_tiles_are_those_of_their_bits() {
    let folder = Folder::new("tileset");
    let file = |name: &str| folder.root().join(name);
    for name in ["0-0-0-0", "1-1-0-0", "2-2-1-0", "2-3-0-0", "3-5-2-0"] {
        box_glb(&file(&format!("{name}.glb")));
    }
    // Bits of the first subtree: the root, then 0,0 1,0 0,1 1,1: of these only 1,0. Below it 2,0 3,0 2,1 3,1 of sixteen subtrees: in Morton
    // order 2,1 is the sixth and 3,0 the fifth.
    std::fs::write(file("bits.bin"), [0b0_0101, 0b1110_0000, 0]).unwrap();
    let subtree = |tiles: &str, children: &str| {
        format!(
            r#"{{"buffers":[{{"uri":"bits.bin","byteLength":3}}],"bufferViews":[{{"buffer":0,"byteLength":1}},{{"buffer":0,"byteOffset":1,
            "byteLength":2}}],"tileAvailability":{tiles},"contentAvailability":[{tiles}],"childSubtreeAvailability":{children}}}"#
        )
    };
    let (none, bits) = (r#"{"constant":0}"#, |k: u32| format!(r#"{{"bitstream":{k}}}"#));
    std::fs::write(file("0-0-0-0.json"), subtree(&bits(0), &bits(1))).unwrap();
    // Those at 2,0 hold a root alone; that at 2,1 has 5,2 below it; that at 3,1 nothing, not even itself.
    std::fs::write(file("one.bin"), [0b1]).unwrap();
    let only =
        |bits: &str| subtree(bits, none).replace("bits.bin", "one.bin").replace(":3}", ":1}");
    std::fs::write(file("two.bin"), [0b0_0101, 0, 0]).unwrap();
    let one = r#"{"bitstream":0}"#;
    std::fs::write(file("2-2-1-0.json"), subtree(one, none).replace("bits.bin", "two.bin"))
        .unwrap();
    std::fs::write(file("2-3-0-0.json"), only(one)).unwrap();
    std::fs::write(file("2-3-1-0.json"), only(r#"{"constant":0}"#)).unwrap();
    let load = |refine: &str| {
        try_load(&folder, &tileset(&tile(&(implicit("QUADTREE", 2, 4) + refine)))).unwrap()
    };
    let names = |model: &Model| {
        let mut names: Vec<String> = model
            .mesh_names
            .iter()
            .map(|n| n.split(' ').next().unwrap_or_default().to_owned())
            .collect();
        names.sort();
        names
    };
    assert_eq!(names(&load("")), ["2-3-0-0", "3-5-2-0"], "what is finest");
    let all = names(&load(r#","refine":"ADD""#));
    assert_eq!(all, ["0-0-0-0", "1-1-0-0", "2-2-1-0", "2-3-0-0", "3-5-2-0"]);
    let tree = cullet_maps::TileTree::open(&file("tileset.json"), &LoadOptions::default()).unwrap();
    let errors: Vec<f64> = tree.tiles().iter().map(|node| node.error).collect();
    assert_eq!(errors[..4], [1.0, 0.5, 0.25, 0.25]);
    // The box of 9 around 0 is halved along x and y, which is −z of the scene; its height stays.
    let finest = tree.tiles().iter().find(|node| node.error == 0.125).unwrap();
    assert_eq!(finest.bounds, [[2.25, -9.0, 2.25], [4.5, 9.0, 4.5]]);
}

#[test]
fn what_is_wrong_is_named() {
    let folder = Folder::new("tileset");
    box_glb(&folder.root().join("a.glb"));
    std::fs::write(folder.root().join("p.pnts"), b"pnts0000").unwrap();
    let with = |uri: &str| tileset(&tile(&format!(r#","content":{{"uri":"{uri}"}}"#)));
    let good = with("a.glb");
    let cases = [
        (with("gone.glb"), "gone.glb: it is named by the tileset and is missing"),
        (with("../a.glb"), "leaves the folder"),
        (with("https://tiles.example/a.glb"), "nothing is fetched"),
        (with("tileset.json"), "within itself"),
        (with("p.pnts"), "a tile of the kind pnts is not read"),
        (good.replace("1.1", "2.0"), "asset.version: \"2.0\""),
        (good.replace("\"box\":[0,0", "\"box\":[0"), "boundingVolume: it has 11 numbers; 12"),
        (good.replace("\"box\"", "\"cone\""), "neither a box, a sphere nor a region"),
        (tileset(&tile(r#","transform":[1,2]"#)), "transform: it has 2 numbers; 16"),
        (tileset(&tile(&moved(1.0, 0.0, 0.0).replace(",1]", ",0]"))), "no affine matrix"),
        (tileset(&tile(r#","implicitTiling":{}"#)), "missing field `subdivisionScheme`"),
        (tileset(&tile(&implicit("QUADTREE", 30, 2))), "subtreeLevels"),
        (tileset(&tile(&implicit("QUADTREE", 0, 2))), "must be 1 or more"),
        (
            tileset(&tile(&implicit("QUADTREE", 2, 2))),
            "0-0-0-0.json: it is named by the tileset and is missing",
        ),
        (good.replace("\"root\"", "\"extensionsRequired\":[\"X_y\"],\"root\""), "extension X_y"),
        (good.replace("\"asset\"", "\"assets\""), "missing field `asset`"),
        (format!("{}{}", &good[..good.len() - 3], ""), "EOF"),
    ];
    for (text, expected) in cases {
        let error = try_load(&folder, &text).unwrap_err();
        assert!(
            error.contains(expected) && error.contains("tileset.json"),
            "{error}\nnot: {expected}"
        );
    }
    let options = LoadOptions { max_triangles: 11, ..LoadOptions::default() };
    std::fs::write(folder.root().join("tileset.json"), &good).unwrap();
    let error = load(&folder.root().join("tileset.json"), &options).unwrap_err().to_string();
    assert!(error.contains("triangles") && error.contains("11"), "{error}");
}

#[test]
fn bytes_that_are_cut_or_changed_end_in_an_error_or_a_model() {
    let folder = Folder::new("tileset");
    box_glb(&folder.root().join("a.glb"));
    let glb = std::fs::read(folder.root().join("a.glb")).unwrap();
    let text = tileset(&tile(
        &(r#","content":{"uri":"a.glb"},"refine":"ADD","children":["#.to_owned()
            + &tile(&moved(1e7, 0.0, 0.0))
            + "]"),
    ));
    let beside = [("a.glb".to_owned(), glb)];
    let load = |bytes: &[u8]| load_bytes_with("t.json", bytes, &beside, &LoadOptions::default());
    assert_eq!(load(text.as_bytes()).unwrap().scene.instance_count(), 1);
    let mut wrong = 0;
    for at in 0..text.len() {
        wrong += u32::from(load(&text.as_bytes()[..at]).is_err());
        let mut changed = text.clone().into_bytes();
        changed[at] = b"0{}[]\",:x9e-"[at % 12];
        let _ = load(&changed);
    }
    assert_eq!(wrong as usize, text.len());
}

/// Tiles of a model, without what their tileset says of their sizes.
fn unsaid(folder: &Folder, model: &Model) -> cullet_maps::TileTree {
    let mut options = cullet_maps::WriteTiles::default();
    (options.triangles, options.instances) = (3000, 60);
    cullet_maps::write_tiles(model, folder.root(), &options, |_| true).unwrap().unwrap();
    let path = folder.root().join("tileset.json");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("\"extras\":", "\"extra\":")).unwrap();
    cullet_maps::TileTree::open(&path, &LoadOptions::default()).unwrap()
}

#[test]
fn headers_of_files_say_what_a_tile_takes_and_the_rest_of_them_is_not_read() {
    let folder = Folder::new("tileset");
    let tree = unsaid(&folder, &cullet_scenes::build("city:cells=6,objects=400").unwrap());
    let mut contents = 0;
    for tile in 0..tree.tiles().len() as u32 {
        assert_eq!(tree.tiles()[tile as usize].size, None);
        let counted = tree.counted(tile).unwrap();
        let scene = tree.load(tile).unwrap().scene;
        assert_eq!(counted.instances, scene.instance_count());
        let meshes = scene.meshes();
        let vertices: u64 = meshes.iter().map(|m| m.positions().len() as u64).sum();
        let triangles: u64 = meshes.iter().map(|m| u64::from(m.triangle_count())).sum();
        assert_eq!((counted.vertices, counted.triangles), (vertices, triangles));
        if tree.tiles()[tile as usize].is_empty() {
            continue;
        }
        contents += 1;
        let path = folder.root().join(format!("tiles/{tile}.glb"));
        let bytes = std::fs::read(&path).unwrap();
        let json = u32::from_le_bytes(*bytes[12..].first_chunk().unwrap()) as usize;
        std::fs::write(&path, &bytes[..20 + json]).unwrap();
        assert_eq!(tree.counted(tile), Some(counted), "by the header alone");
        assert!(tree.load(tile).is_err());
        // Behind the tables of a b3dm it is the same.
        let mut old = b"b3dm".to_vec();
        [1, 28 + bytes.len() as u32, 8, 0, 0, 0].iter().for_each(|v| old.extend(v.to_le_bytes()));
        old.extend(b"{}      ");
        old.extend(&bytes[..20 + json]);
        std::fs::write(&path, &old).unwrap();
        assert_eq!(tree.counted(tile), Some(counted));
        std::fs::write(&path, &old[..30]).unwrap();
        assert_eq!(tree.counted(tile), None);
    }
    assert!(contents > 10);
}
