//! Tiles of 3D Tiles 1.0: tables before a glTF, instances, several in one file, and packed by gzip.

use std::io::Write as _;

use cullet_io::LoadOptions;
use cullet_maps::{load, load_bytes_with};
use cullet_testkit::Folder;

use super::{assert_at, bounds, box_file, content, floats, open, size, tileset};

/// A tile of 1.0: its features as JSON and as numbers, and what follows its tables.
fn packed(magic: &[u8; 4], features: &str, numbers: &[u8], rest: &[u8]) -> Vec<u8> {
    let head = if magic == b"i3dm" { 32 } else { 28 };
    let size = head + features.len() + numbers.len() + rest.len();
    let mut out = magic.to_vec();
    let words = [1, size, features.len(), numbers.len(), 0, 0];
    words.iter().for_each(|&v| out.extend((v as u32).to_le_bytes()));
    if magic == b"i3dm" {
        let is_inside = u32::from(rest.starts_with(b"glTF"));
        out.extend(is_inside.to_le_bytes());
    }
    [&out[..], features.as_bytes(), numbers, rest].concat()
}

fn composite(tiles: &[&[u8]]) -> Vec<u8> {
    let size = 16 + tiles.iter().map(|tile| tile.len()).sum::<usize>();
    let mut out = b"cmpt".to_vec();
    [1, size, tiles.len()].iter().for_each(|&v| out.extend((v as u32).to_le_bytes()));
    tiles.iter().for_each(|tile| out.extend(*tile));
    out
}

fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

#[test]
fn a_centre_that_tiles_are_relative_to_is_read_in_each_of_its_forms() {
    let folder = Folder::new("rtc");
    let glb = box_file(&folder, "a.glb", [1.0, 2.0, 3.0]);
    let place = floats(&[0.0, 5.0, 6.0, 7.0]);
    let one = floats(&[0.0, 0.0, 0.0]);
    for (name, bytes) in [
        ("a.b3dm", packed(b"b3dm", r#"{"BATCH_LENGTH":0,"RTC_CENTER":[5,6,7]}"#, &[], &glb)),
        ("c.b3dm", packed(b"b3dm", "{\"RTC_CENTER\":[5,6,7]}\0\0\0", &[], &glb)),
        (
            "b.b3dm",
            packed(b"b3dm", r#"{"BATCH_LENGTH":0,"RTC_CENTER":{"byteOffset":4}}"#, &place, &glb),
        ),
        (
            "a.i3dm",
            packed(
                b"i3dm",
                r#"{"INSTANCES_LENGTH":1,"RTC_CENTER":[5,6,7],"POSITION":{"byteOffset":0}}"#,
                &one,
                &glb,
            ),
        ),
        (
            "b.i3dm",
            packed(
                b"i3dm",
                r#"{"INSTANCES_LENGTH":1,"RTC_CENTER":{"byteOffset":4},"POSITION":[0,0,0]}"#,
                &place,
                &glb,
            ),
        ),
    ] {
        std::fs::write(folder.root().join(name), bytes).unwrap();
        let model = open(&folder, &tileset("", &content(name)));
        // Tiles are z-up: y goes to -z.
        assert_at(&model, [5.0, 7.0, -6.0]);
        assert_eq!(size(&model), [1.0, 2.0, 3.0], "{name}");
    }
    for features in [r#"{"RTC_CENTER":{"byteOffset":8}}"#, r#"{"RTC_CENTER":[1,2]}"#, "{"] {
        let bytes = packed(b"b3dm", features, &place, &glb);
        std::fs::write(folder.root().join("a.b3dm"), bytes).unwrap();
        let error = load(
            folder.file("tileset.json", &tileset("", &content("a.b3dm"))).as_ref(),
            &LoadOptions::default(),
        );
        let error = error.unwrap_err().to_string();
        assert!(error.contains("a.b3dm, features"), "{error}");
    }
}

#[test]
fn instances_of_a_tile_are_placed_in_each_of_its_forms() {
    let folder = Folder::new("i3dm");
    let glb = box_file(&folder, "a.glb", [1.0, 2.0, 3.0]);
    let show = |features: &str, numbers: &[u8], rest: &[u8]| {
        let bytes = packed(b"i3dm", features, numbers, rest);
        std::fs::write(folder.root().join("a.i3dm"), bytes).unwrap();
        open(&folder, &tileset("", &content("a.i3dm")))
    };
    let two = floats(&[0.0, 0.0, 0.0, 10.0, 20.0, 30.0, 2.0, 3.0]);
    let plain = r#"{"INSTANCES_LENGTH":2,"POSITION":{"byteOffset":0},"SCALE":{"byteOffset":24}}"#;
    for rest in [&glb[..], b"a.glb  \0"] {
        let model = show(plain, &two, rest);
        assert_eq!((model.scene.instance_count(), model.scene.meshes().len()), (2, 1));
        // From the second instance's place, thrice as large.
        assert_eq!(bounds(&model), [[0.0, 0.0, -20.0], [13.0, 36.0, 6.0]]);
    }
    let quantised = r#"{"INSTANCES_LENGTH":1,"POSITION_QUANTIZED":{"byteOffset":0},
        "QUANTIZED_VOLUME_OFFSET":[10,0,0],"QUANTIZED_VOLUME_SCALE":[4,8,16]}"#;
    let model = show(quantised, &shorts(&[65_535, 0, 65_535]), &glb);
    assert_at(&model, [14.0, 16.0, 0.0]);
    // Right is the tile's y and up its z: x of the box goes to -z of the scene. Its y, which is the tile's z once it is turned
    // to z-up, goes to where the cross product of both is, x; its z to the tile's -y, and so down.
    let turned = r#"{"INSTANCES_LENGTH":1,"POSITION":[0,0,0],"NORMAL_RIGHT":{"byteOffset":0},"NORMAL_UP":{"byteOffset":12}}"#;
    let vectors = floats(&[0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let expected = [[0.0, -3.0, -1.0], [2.0, 0.0, 0.0]];
    let near = |found: [[f64; 3]; 2]| {
        let off = found.as_flattened().iter().zip(expected.as_flattened());
        assert!(off.map(|(a, b): (&f64, &f64)| (a - b).abs()).all(|d| d < 1e-3), "{found:?}");
    };
    near(bounds(&show(turned, &vectors, &glb)));
    let folded =
        turned.replace("RIGHT", "RIGHT_OCT32P").replace("UP", "UP_OCT32P").replace("12", "4");
    near(bounds(&show(&folded, &shorts(&[32_768, 65_535, 32_768, 32_768]), &glb)));
    let stretched = r#"{"INSTANCES_LENGTH":1,"POSITION":[0,0,0],"SCALE_NON_UNIFORM":[2,1,5]}"#;
    assert_eq!(size(&show(stretched, &[], &glb)), [2.0, 10.0, 3.0]);
    let east = r#"{"INSTANCES_LENGTH":1,"POSITION":[6378137,0,0],"EAST_NORTH_UP":true}"#;
    // East is the tile's y, north its z, and up its x.
    let model = show(east, &[], &glb);
    assert_eq!(size(&model), [2.0, 3.0, 1.0]);
    for wrong in [
        r#"{"POSITION":[0,0,0]}"#,
        r#"{"INSTANCES_LENGTH":1}"#,
        r#"{"INSTANCES_LENGTH":4000000000,"POSITION":{"byteOffset":0}}"#,
        r#"{"INSTANCES_LENGTH":2,"POSITION":[0,0,0]}"#,
    ] {
        std::fs::write(folder.root().join("a.i3dm"), packed(b"i3dm", wrong, &two, &glb)).unwrap();
        let error = load(folder.root().join("tileset.json").as_ref(), &LoadOptions::default());
        let error = error.unwrap_err().to_string();
        assert!(error.contains("a.i3dm, features"), "{error}");
    }
}

#[test]
fn tiles_within_one_file_are_all_shown() {
    let folder = Folder::new("cmpt");
    let glb = box_file(&folder, "a.glb", [1.0; 3]);
    let b3dm = packed(b"b3dm", r#"{"BATCH_LENGTH":0}"#, &[], &glb);
    let i3dm = packed(b"i3dm", r#"{"INSTANCES_LENGTH":1,"POSITION":[9,0,0]}"#, &[], &glb);
    let all = composite(&[&b3dm, &composite(&[&i3dm])]);
    std::fs::write(folder.root().join("a.cmpt"), &all).unwrap();
    let text = tileset("", &content("a.cmpt"));
    assert_eq!(size(&open(&folder, &text)), [10.0, 1.0, 1.0]);
    let mut deep = b3dm.clone();
    for _ in 0..20 {
        deep = composite(&[&deep]);
    }
    std::fs::write(folder.root().join("a.cmpt"), &deep).unwrap();
    let path = folder.root().join("tileset.json");
    let error = load(&path, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("cmpt within each other"), "{error}");
    for end in 0..all.len() {
        std::fs::write(folder.root().join("a.cmpt"), &all[..end]).unwrap();
        assert!(load(&path, &LoadOptions::default()).is_err(), "cut at {end}");
    }
}

#[test]
fn files_that_servers_keep_packed_are_unpacked() {
    let folder = Folder::new("gzip");
    let glb = box_file(&folder, "a.glb", [1.0, 2.0, 3.0]);
    let pack = |name: &str, bytes: &[u8]| {
        let file = std::fs::File::create(folder.root().join(name)).unwrap();
        let mut out = flate2::write::GzEncoder::new(file, flate2::Compression::default());
        out.write_all(bytes).unwrap();
        out.finish().unwrap();
    };
    pack("a.b3dm", &packed(b"b3dm", r#"{"RTC_CENTER":[5,6,7]}"#, &[], &glb));
    pack("inner.json", tileset("", &content("a.b3dm")).as_bytes());
    let text = tileset("", &content("inner.json"));
    assert_at(&open(&folder, &text), [5.0, 7.0, -6.0]);
    let path = folder.root().join("a.b3dm");
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let error = load(folder.root().join("tileset.json").as_ref(), &LoadOptions::default());
    let error = error.unwrap_err().to_string();
    assert!(error.contains("a.b3dm, gzip: it is packed and cannot be unpacked"), "{error}");
}

#[test]
fn packed_tiles_that_are_changed_end_in_an_error_or_a_model() {
    let folder = Folder::new("changed");
    let glb = box_file(&folder, "a.glb", [1.0; 3]);
    let features =
        r#"{"INSTANCES_LENGTH":2,"RTC_CENTER":{"byteOffset":0},"POSITION":{"byteOffset":12}}"#;
    let numbers = floats(&[1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 9.0, 0.0, 0.0]);
    let i3dm = packed(b"i3dm", features, &numbers, &glb);
    let all = composite(&[&packed(b"b3dm", r#"{"RTC_CENTER":[1,2,3]}"#, &[], &glb), &i3dm]);
    let text = tileset("", &content("a.cmpt"));
    let load = |bytes: Vec<u8>| {
        let beside = [("a.cmpt".to_owned(), bytes)];
        load_bytes_with("t.json", text.as_bytes(), &beside, &LoadOptions::default())
    };
    assert_eq!(load(all.clone()).unwrap().scene.instance_count(), 3);
    let mut refused = 0;
    for at in 0..all.len() {
        for by in [1, 0x80, 0xff] {
            let mut changed = all.clone();
            changed[at] ^= by;
            refused += u32::from(load(changed).is_err());
        }
    }
    assert!(refused > 300, "{refused}");
}
