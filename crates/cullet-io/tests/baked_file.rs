//! A baked file that is mapped: its tables are those that were baked, and slices of the file; whatever is wrong with it is a
//! typed error when it is opened or when a mesh is first asked for, never a panic.

use crate::by_hand;

use std::path::Path;
use std::time::Instant;

use by_hand::bake;
use cullet::mesh::Clustering;
use cullet::{Instance, Mesh, MeshData, Scene, Transform};
use cullet_io::baked::{BakedError, LevelTables, TABLE_ALIGNMENT};
use cullet_io::{BakedFile, BakedFileError, LoadOptions, Model, load_bytes, save};
use cullet_testkit::{Folder, soups};
use serde_json::{Value, json};

/// A baked file of two meshes.
fn file() -> Vec<u8> {
    let mut scene = Scene::new();
    for rows in [12, 8] {
        let (positions, indices) = soups::ball(rows, 2 * rows);
        let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap();
        let mesh = scene.add_mesh(mesh);
        let place = Transform::from_scale_translation([1.0; 3], [f64::from(mesh) * 5.0, 0.0, 0.0]);
        scene.add(Instance::new(mesh, place)).unwrap();
    }
    scene.sort();
    let mesh_names = ["large", "small"].map(String::from).to_vec();
    let mut model = Model { scene, mesh_names, ..Model::default() };
    bake(&mut model);
    let folder = Folder::new("mapped");
    let path = folder.root().join("a.glb");
    save(&model, &path).unwrap();
    std::fs::read(&path).unwrap()
}

/// Bytes that begin as far from a multiple of 8 as `odd`.
fn placed(bytes: &[u8], odd: usize) -> Vec<u64> {
    let mut words = vec![0u64; bytes.len() / 8 + 2];
    bytemuck::cast_slice_mut(&mut words)[odd..odd + bytes.len()].copy_from_slice(bytes);
    words
}

/// Opens bytes where a mapping would have them, and reads all of it.
fn read(bytes: &[u8]) -> Result<Vec<LevelTables>, BakedFileError> {
    let words = placed(bytes, 0);
    let file = BakedFile::of(&bytemuck::cast_slice::<u64, u8>(&words)[..bytes.len()])?;
    let mut all = Vec::new();
    for (at, mesh) in file.meshes().iter().enumerate() {
        if let Some(problem) = &mesh.problem {
            return Err(problem.clone().into());
        }
        for levels in 0..mesh.levels.len() {
            all.push(file.levels(at, levels)?.to_tables()?);
        }
    }
    Ok(all)
}

/// Returns the file with its JSON edited.
fn edited(bytes: &[u8], edit: impl FnOnce(&mut Value)) -> Vec<u8> {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut root = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    edit(&mut root);
    let mut text = root.to_string().into_bytes();
    let before = 28 + text.len();
    text.resize(before.next_multiple_of(TABLE_ALIGNMENT) - 28, b' ');
    let bin = &bytes[20 + length..];
    let total = (20 + text.len() + bin.len()) as u32;
    let head = [&b"glTF"[..], &2u32.to_le_bytes(), &total.to_le_bytes()].concat();
    [head, (text.len() as u32).to_le_bytes().to_vec(), b"JSON".to_vec(), text, bin.to_vec()]
        .concat()
}

#[test]
fn tables_are_slices_of_the_file_and_those_that_are_loaded() {
    let bytes = file();
    let model = load_bytes("a.glb", &bytes, &LoadOptions::default()).unwrap();
    let folder = Folder::new("open");
    let path = folder.path("a.glb");
    std::fs::write(&path, &bytes).unwrap();
    let file = BakedFile::open(Path::new(&path)).unwrap();
    assert_eq!((file.generator(), file.bytes()), ("by hand 1", &bytes[..]));
    assert_eq!(file.meshes().len(), 2);
    let baked = model.baked.unwrap();
    for (at, mesh) in file.meshes().iter().enumerate() {
        let loaded = baked.of(mesh.number).unwrap();
        assert_eq!((mesh.geometry, mesh.bytes), (loaded.geometry, loaded.bytes));
        assert_eq!((mesh.name.as_str(), mesh.levels.len()), (["large", "small"][at], 1));
        let slices = file.levels(at, 0).unwrap();
        let of = &model.scene.levels(mesh.number)[0];
        let held_by = &model.scene.meshes()[of.mesh as usize];
        let own = LevelTables::of(held_by, &of.levels).unwrap();
        assert_eq!(slices.to_tables().unwrap(), own);
        assert_eq!(slices.indices.as_flattened(), own.indices);
        assert_eq!(mesh.levels[0].errors, Some([0.5, 0.5]));
        assert_eq!(mesh.levels[0].measured, loaded.levels[0].measured);
        let start = file.bytes().as_ptr() as usize;
        for table in [
            slices.indices.as_ptr() as usize,
            slices.clusters.as_ptr() as usize,
            slices.groups.as_ptr() as usize,
        ] {
            assert!(table % TABLE_ALIGNMENT == 0 && (start..start + bytes.len()).contains(&table));
        }
        assert_eq!(file.levels_unchecked(at, 0).unwrap(), slices);
        assert!(matches!(file.levels(at, 1), Err(BakedError::Form(_))));
    }
    assert!(matches!(file.check(2), Err(BakedError::Form(_))));
    // Replaced as files are, it stays what it was for who has it mapped.
    std::fs::write(folder.path("b.glb"), b"other").unwrap();
    std::fs::rename(folder.path("b.glb"), &path).unwrap();
    assert_eq!(file.bytes(), &bytes[..]);
}

#[test]
fn every_cut_is_an_error_and_every_changed_byte_is_noticed_or_of_no_matter() {
    let good = file();
    let tables = read(&good).unwrap();
    assert_eq!(tables.len(), 2);
    for end in 0..good.len() {
        assert!(read(&good[..end]).is_err(), "{end} of {} bytes", good.len());
    }
    let words = placed(&good, 0);
    let of = BakedFile::of(&bytemuck::cast_slice::<u64, u8>(&words)[..good.len()]).unwrap();
    let within: Vec<_> =
        of.meshes().iter().flat_map(|m| m.levels.iter().flat_map(|l| l.tables.clone())).collect();
    for at in 0..good.len() {
        let mut bytes = good.clone();
        bytes[at] ^= 0x11;
        match read(&bytes) {
            Ok(found) => {
                assert!(!within.iter().any(|t| t.contains(&at)), "byte {at} is of a table");
                // A name, a view of something else, or the number of a mesh that is gone.
                assert!(found.iter().all(|t| tables.contains(t)), "byte {at}");
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

#[test]
fn lies_are_typed_errors() {
    let good = file();
    let first = |root: &mut Value, table: &str| {
        let levels = &root["meshes"][0]["extensions"]["CULLET_baked"]["levels"][0];
        levels[table].as_u64().unwrap() as usize
    };
    type Case<'a> = (&'a str, &'a dyn Fn(&mut Value), &'a str);
    let cases: [Case<'_>; 13] = [
        (
            "beyond the file",
            &|r| {
                let v = first(r, "indices");
                r["bufferViews"][v]["byteLength"] = json!(12_000_000_000_000u64);
            },
            "do not fit",
        ),
        (
            "beyond all numbers",
            &|r| {
                let v = first(r, "indices");
                r["bufferViews"][v]["byteOffset"] = json!(u64::MAX);
            },
            "do not fit",
        ),
        (
            "no rows",
            &|r| {
                let v = first(r, "groups");
                r["bufferViews"][v]["byteLength"] = json!(19);
            },
            "no multiple of 20",
        ),
        (
            "nothing",
            &|r| {
                let v = first(r, "groups");
                r["bufferViews"][v]["byteLength"] = json!(0);
            },
            "do not fit",
        ),
        (
            "out of line",
            &|r| {
                let v = first(r, "clusters");
                let o = r["bufferViews"][v]["byteOffset"].as_u64().unwrap();
                r["bufferViews"][v]["byteOffset"] = json!(o + 4);
            },
            "no multiple of 64",
        ),
        (
            "strided",
            &|r| {
                let v = first(r, "clusters");
                r["bufferViews"][v]["byteStride"] = json!(16);
            },
            "one after another",
        ),
        (
            "of another buffer",
            &|r| {
                let v = first(r, "clusters");
                r["bufferViews"][v]["buffer"] = json!(1);
            },
            "one after another",
        ),
        (
            "no view",
            &|r| {
                r["meshes"][0]["extensions"]["CULLET_baked"]["levels"][0]["groups"] = json!(99);
            },
            "bufferView 99 of",
        ),
        (
            "more triangles",
            &|r| {
                r["meshes"][0]["extensions"]["CULLET_baked"]["levels"][0]["parts"] =
                    json!([4_000_000_000u32]);
            },
            "triangles of all levels",
        ),
        (
            "shared",
            &|r| {
                let same = r["meshes"][0]["extensions"]["CULLET_baked"]["levels"][0].clone();
                r["meshes"][0]["extensions"]["CULLET_baked"]["levels"] =
                    json!([same.clone(), same]);
            },
            "bytes of its tables",
        ),
        (
            "another kind",
            &|r| {
                r["meshes"][0]["extensions"]["CULLET_baked"]["levels"][0]["kind"] = json!("stairs");
            },
            "stairs",
        ),
        (
            "not of the mesh",
            &|r| {
                r["meshes"][0]["extensions"] = json!({});
            },
            "nothing baked",
        ),
        (
            "no mesh",
            &|r| {
                r.as_object_mut().unwrap().remove("meshes");
            },
            "mesh 0 of 0",
        ),
    ];
    for (what, edit, words) in cases {
        let error = read(&edited(&good, |root| edit(root))).unwrap_err().to_string();
        assert!(error.contains(words), "{what}: {error}");
    }
    let twice = edited(&good, |root| {
        // The same tables for both meshes.
        let (small, large) = (root["meshes"][1].clone(), root["meshes"][0].clone());
        let own = &large["extensions"]["CULLET_baked"]["levels"][0];
        root["meshes"][1]["extensions"]["CULLET_baked"]["levels"][0] = own.clone();
        assert!(small != root["meshes"][1]);
        let bytes = root["extensions"]["CULLET_baked"]["chunks"][0]["bytes"].clone();
        root["extensions"]["CULLET_baked"]["chunks"][1]["bytes"] = bytes;
    });
    assert!(matches!(read(&twice), Err(BakedFileError::Baked(BakedError::Damaged { .. }))));
    let other = edited(&good, |root| root["extensions"]["CULLET_baked"]["version"] = json!(2));
    assert!(matches!(read(&other), Err(BakedFileError::Baked(BakedError::Version { found: 2 }))));
    let plain = edited(&good, |root| root["extensions"] = json!({}));
    assert!(matches!(read(&plain), Err(BakedFileError::NothingBaked)));
    assert!(matches!(read(b"{\"asset\":{\"version\":\"2.0\"}}"), Err(BakedFileError::File(_))));
    assert!(matches!(read(b""), Err(BakedFileError::File(_))));
    let gone = BakedFile::open(Path::new("no such file.glb"));
    assert!(matches!(gone, Err(BakedFileError::Map { .. })));
    assert!(matches!(BakedFile::open(Path::new(".")), Err(BakedFileError::Map { .. })));
    // In memory where no number of four bytes can be.
    let words = placed(&good, 1);
    let odd = BakedFile::of(&bytemuck::cast_slice::<u64, u8>(&words)[1..=good.len()]).unwrap();
    assert!(matches!(odd.levels(0, 0), Err(BakedError::Unaligned { .. })));
}

/// How long a file of 1 GB takes to open, and to be read once. Run alone:
/// `cargo test --release -p cullet-testkit --test io baked_file -- --ignored --nocapture`.
#[test]
#[ignore = "writes a file of 1 GB and prints times"]
fn opening_a_gigabyte() {
    let small = file();
    let length = u32::from_le_bytes(small[12..16].try_into().unwrap()) as usize;
    let mut root: Value = serde_json::from_slice(&small[20..20 + length]).unwrap();
    let (meshes, triangles) = (1000, 80_000);
    // Tables of zeros but for their sums, which opening does not look at.
    let mut at = 0usize;
    let (mut views, mut all, mut chunks) = (Vec::new(), Vec::new(), Vec::new());
    for mesh in 0..meshes {
        let mut own = root["meshes"][0].clone();
        let mut bytes = 0;
        for (table, length) in
            [("indices", triangles * 12), ("clusters", triangles / 4), ("groups", triangles / 8)]
        {
            let length = if table == "groups" { length / 20 * 20 } else { length };
            own["extensions"]["CULLET_baked"]["levels"][0][table] = json!(views.len());
            views.push(json!({ "buffer": 0, "byteOffset": at, "byteLength": length }));
            at = (at + length).next_multiple_of(TABLE_ALIGNMENT);
            bytes += length;
        }
        own["extensions"]["CULLET_baked"]["levels"][0]["parts"] = json!([triangles]);
        all.push(own);
        chunks.push([mesh as u64, bytes as u64, 7]);
    }
    root["bufferViews"] = json!(views);
    root["meshes"] = json!(all);
    let rows = chunks.iter().map(
        |[mesh, bytes, _]| json!({ "mesh": mesh, "bytes": bytes, "hash": format!("{:016x}", 7) }),
    );
    root["extensions"]["CULLET_baked"]["chunks"] = rows.collect();
    let words: Vec<u8> = chunks.as_flattened().iter().flat_map(|w| w.to_le_bytes()).collect();
    let sum = root_sum(&words, meshes as u64);
    root["extensions"]["CULLET_baked"]["hash"] = json!(format!("{sum:016x}"));
    let mut text = root.to_string().into_bytes();
    text.resize((28 + text.len()).next_multiple_of(TABLE_ALIGNMENT) - 28, b' ');
    let total = 28 + text.len() + at;
    let word = |n: usize| (n as u32).to_le_bytes();
    let head = [&b"glTF"[..], &word(2), &word(total), &word(text.len()), b"JSON"].concat();
    let folder = Folder::new("gigabyte");
    let path = folder.root().join("a.glb");
    let head = [head, text, word(at).to_vec(), b"BIN\0".to_vec()].concat();
    let mut out = std::fs::File::create(&path).unwrap();
    std::io::Write::write_all(&mut out, &head).unwrap();
    let zeros = vec![0; 1 << 20];
    let mut left = at;
    while left > 0 {
        let now = left.min(zeros.len());
        std::io::Write::write_all(&mut out, &zeros[..now]).unwrap();
        left -= now;
    }
    drop(out);
    for _ in 0..5 {
        let start = Instant::now();
        let file = BakedFile::open(&path).unwrap();
        let opened = start.elapsed();
        assert_eq!(file.meshes().len(), meshes);
        let start = Instant::now();
        let problems = (0..meshes).filter(|&at| file.check(at).is_err()).count();
        println!(
            "{} bytes: opened in {:.1} ms, all sums in {:.0} ms ({problems} are others)",
            file.bytes().len(),
            opened.as_secs_f64() * 1e3,
            start.elapsed().as_secs_f64() * 1e3
        );
    }
}

/// The sum of a table of chunks, as the book has it.
fn root_sum(words: &[u8], count: u64) -> u64 {
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let words = words.as_chunks::<8>().0.iter().map(|w| u64::from_le_bytes(*w));
    mix(words.fold(STEP ^ count, |state, word| mix(state ^ word).wrapping_add(STEP)))
}

#[test]
fn a_file_of_another_hand_is_read() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/baked/file");
    let file = BakedFile::open(Path::new(path)).unwrap();
    assert_eq!(file.generator(), "make_seeds");
    let tables = file.levels(0, 0).unwrap();
    assert_eq!(tables.indices, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    assert_eq!(tables.clusters, [[0, 2, u32::MAX, 0], [2, 1, 0, u32::MAX]]);
    assert_eq!(tables.groups, [[0.5, 0.5, 0.0, 1.0, 0.75]]);
    assert_eq!(tables.parts, [3]);
}

/// How long it takes to make a mesh, and of that to put its triangles in order: what a file that had the order would save. Run alone, as
/// above.
#[test]
#[ignore = "prints times"]
fn making_meshes_whose_clusters_are_known() {
    for name in ["armadillo/armadillo.obj", "happy-buddha/buddha-100k.obj"] {
        let Some(path) = cullet_testkit::data(name) else { continue };
        let model = cullet_io::load(&path, &LoadOptions::default()).unwrap();
        let mesh = &model.scene.meshes()[0];
        let data = mesh.to_data();
        let clusters = mesh.clusters().to_vec();
        let drawn = (mesh.triangle_count() - mesh.degenerate_count()) as usize;
        let order = mesh.original_triangle()[..drawn].to_vec();
        let clustering = Clustering { order, clusters };
        let time = |make: &dyn Fn(MeshData) -> Mesh| {
            let run = || {
                let data = data.clone();
                let start = Instant::now();
                let made = make(data);
                (start.elapsed().as_secs_f64() * 1e3, made)
            };
            (0..15).map(|_| run().0).fold(f64::INFINITY, f64::min)
        };
        let plain = time(&|data| Mesh::new(data).unwrap());
        let known = time(&|data| Mesh::with_clusters(data, &clustering).unwrap());
        println!("{name}: {plain:.1} ms, with its clusters known {known:.1} ms");
    }
}
