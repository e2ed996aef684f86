//! Models far from zero, or without a place, in files that are written.

use cullet::mesh::MeshData;
use cullet::{Instance, Mesh, Transform};
use cullet_io::{LoadOptions, Model, SaveErrorKind, load, save, world};
use cullet_testkit::Folder;

/// Geographic places of public reports, where f32 has steps of 32 units.
const FAR: [f64; 3] = [-299_510_456.25, 98_424_296.5, -975_000.125];

fn cube() -> Mesh {
    let positions = (0..8u8).map(|i| [0, 1, 2].map(|a| f32::from(i >> a & 1))).collect();
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap()
}

/// Cubes at some places, turned and scaled a little.
fn cubes(places: &[[f64; 3]]) -> Model {
    let mut model = Model { mesh_names: vec!["cube".into()], ..Model::default() };
    let mesh = model.scene.add_mesh(cube());
    for (k, &translation) in places.iter().enumerate() {
        let linear = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.5]];
        model.scene.add(Instance::new(mesh, Transform { linear, translation })).unwrap();
        model.instance_names.push(format!("cube {k}"));
    }
    model.scene.commit(&cullet::Culler::default());
    model
}

/// Vertices of all instances, sorted.
fn vertices(model: &Model) -> Vec<[f64; 3]> {
    let scene = &model.scene;
    let of = |slot| scene.mesh(slot).positions().iter().map(move |&p| (slot, p));
    sorted(scene.slots().flat_map(of).map(|(slot, p)| world(scene.transform(slot), p)).collect())
}

fn sorted(mut all: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    all.sort_by(|a, b| {
        (0..3)
            .map(|k| a[k].total_cmp(&b[k]))
            .find(|o| o.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    all.dedup();
    all
}

fn assert_near(found: &[[f64; 3]], expected: &[[f64; 3]], most: f64, name: &str) {
    assert_eq!(found.len(), expected.len(), "{name}");
    for (f, e) in found.iter().zip(expected) {
        assert!((0..3).all(|a| (f[a] - e[a]).abs() <= most), "{name}: {f:?} for {e:?}");
    }
}

#[test]
fn what_is_far_from_zero_keeps_its_shape_in_every_format() {
    let folder = Folder::new("far");
    let near = FAR.map(|v| v + 7.5);
    let model = cubes(&[FAR, near]);
    let expected = vertices(&model);
    for name in ["a.glb", "a.obj", "a.ply", "a.stl"] {
        let path = folder.root().join(name);
        let saved = save(&model, &path).unwrap();
        assert_eq!((saved.instances, saved.triangles), (2, 24), "{name}");
        let bytes = std::fs::read(&path).unwrap();
        let found = match name {
            // Read by hand: what a reader of this crate makes of it is not the question.
            "a.obj" => {
                let text = String::from_utf8(bytes).unwrap();
                let numbers = |line: &str| -> [f64; 3] {
                    let all: Vec<f64> =
                        line.split(' ').skip(1).map(|v| v.parse().unwrap()).collect();
                    all.try_into().unwrap()
                };
                text.lines().filter(|l| l.starts_with("v ")).map(numbers).collect()
            }
            "a.ply" => {
                let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
                let head = String::from_utf8_lossy(&bytes[..end]);
                assert!(head.contains("property double x"), "{head}");
                let numbers =
                    bytes[end..].as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b));
                let all: Vec<f64> = numbers.take(16 * 3).collect();
                all.as_chunks::<3>().0.to_vec()
            }
            "a.stl" => {
                let [x, y, z] = saved.origin;
                assert!((0..3).all(|a| (saved.origin[a] - FAR[a]).abs() < 10.0), "{saved:?}");
                assert!(saved.rounding < 1e-5, "{saved:?}");
                let head = String::from_utf8_lossy(&bytes[..80]).trim_end().to_owned();
                assert_eq!(head, format!("written by cullet, from {x} {y} {z}"));
                // Our own reader knows that place.
                let again = load(&path, &LoadOptions::default()).unwrap();
                assert_near(&vertices(&again)[..1], &expected[..1], 2e-6, name);
                let note = saved.notes[0].to_string();
                assert!(note.contains("32-bit") && note.contains(&format!("({x}, {y}, {z})")));
                let float = |b: &[u8]| f64::from(f32::from_le_bytes(*b.first_chunk().unwrap()));
                let corners = bytes[84..].as_chunks::<50>().0.iter().flat_map(|t| {
                    t[12..48]
                        .as_chunks::<12>()
                        .0
                        .iter()
                        .map(|c| std::array::from_fn(|a| float(&c[4 * a..]) + saved.origin[a]))
                });
                corners.collect()
            }
            _ => vertices(&load(&path, &LoadOptions::default()).unwrap()),
        };
        let most = if name == "a.stl" { 2e-6 } else { 1e-7 };
        // Triangles of an STL share no vertices, so rounding may part them.
        let mut found = sorted(found);
        if name == "a.stl" {
            found.dedup_by(|a, b| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-5));
        }
        assert_near(&found, &expected, most, name);
        if name != "a.stl" {
            assert!(saved.notes.is_empty() && saved.origin == [0.0; 3], "{name}: {saved:?}");
        }
    }
}

#[test]
fn what_no_origin_can_bring_near_is_refused_as_stl_and_leaves_the_old_file() {
    let folder = Folder::new("far");
    let apart = cubes(&[[-3e8; 3], [3e8; 3]]);
    let path = folder.root().join("a.stl");
    std::fs::write(&path, "old").unwrap();
    let error = save(&apart, &path).unwrap_err();
    assert!(matches!(error.kind, SaveErrorKind::TooFar { triangles: 24 }), "{error}");
    assert!(error.to_string().contains("none of its 24 triangles"), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    // With something near, that is there, and the rest is told.
    let some = cubes(&[[-3e8; 3], [3e8; 3], [1.0, 2.0, 3.0]]);
    let saved = save(&some, &path).unwrap();
    let notes: Vec<String> = saved.notes.iter().map(ToString::to_string).collect();
    assert!(notes.len() == 1 && notes[0].contains("24 triangles lose their area"), "{notes:?}");
    assert!(saved.rounding > 1.0);
}

#[test]
fn numbers_near_zero_are_as_short_as_they_were() {
    let folder = Folder::new("near");
    let mut model = Model::default();
    let mesh = model.scene.add_mesh(cube());
    let at = Transform::from_scale_translation([0.1; 3], [0.0, 0.5, 0.0]);
    model.scene.add(Instance::new(mesh, at)).unwrap();
    model.scene.commit(&cullet::Culler::default());
    save(&model, &folder.root().join("a.obj")).unwrap();
    let text = std::fs::read_to_string(folder.root().join("a.obj")).unwrap();
    assert!(text.contains("v 0.1 0.5 0\n") && text.contains("v 0 0.5 0.1\n"), "{text}");
    save(&model, &folder.root().join("a.ply")).unwrap();
    let ply = std::fs::read(folder.root().join("a.ply")).unwrap();
    assert!(String::from_utf8_lossy(&ply[..150]).contains("property float x"));
}

#[test]
fn instances_without_a_place_are_named_and_the_others_counted() {
    let folder = Folder::new("nowhere");
    let mut model = cubes(&[[0.0; 3], [5.0, 0.0, 0.0]]);
    for (k, v) in [f64::NAN, f64::INFINITY].into_iter().enumerate() {
        model.scene.add(Instance::new(0, Transform::from_translation([0.0, v, 0.0]))).unwrap();
        model.instance_names.push(format!("lost {k}"));
    }
    model.scene.commit(&cullet::Culler::default());
    for name in ["a.glb", "a.obj", "a.ply", "a.stl"] {
        let path = folder.root().join(name);
        let saved = save(&model, &path).unwrap();
        assert_eq!((saved.instances, saved.triangles), (2, 24), "{name}");
        let notes: Vec<String> = saved.notes.iter().map(ToString::to_string).collect();
        let expected = "2 instances: left out, for they have a transform that is not finite";
        assert!(notes.len() == 1 && notes[0].starts_with(expected), "{name}: {notes:?}");
        assert!(notes[0].contains("\"lost 0\", \"lost 1\""), "{name}: {notes:?}");
        let again = load(&path, &LoadOptions::default()).unwrap();
        assert_eq!(again.scene.triangle_count(), 24, "{name}");
    }
}

#[test]
fn what_a_format_has_no_place_for_is_named() {
    let folder = Folder::new("left-out");
    let model = cullet_scenes::build("office").unwrap();
    assert!(!model.cells.cells.is_empty());
    let notes = |name: &str| {
        let saved = save(&model, &folder.root().join(name)).unwrap();
        saved.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    for name in ["a.obj", "a.ply", "a.stl"] {
        assert!(notes(name).contains("cells and portals"), "{name}: {}", notes(name));
    }
    assert!(!notes("a.glb").contains("cells and portals"), "{}", notes("a.glb"));
    // Textures of glTF and OBJ are not read, and so not written.
    let gltf =
        r#"{"asset":{"version":"2.0"},"textures":[{"source":0}],"images":[{"uri":"a.png"}]}"#;
    let _ = folder.file("a.mtl", "newmtl a\nmap_Kd a.png\n");
    let obj = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (name, text) in [("t.gltf", gltf), ("t.obj", obj)] {
        let model = load(folder.file(name, text).as_ref(), &LoadOptions::default()).unwrap();
        assert_eq!(model.textures, 1, "{name}");
        let saved = save(&model, &folder.root().join("t.glb")).unwrap();
        assert_eq!(saved.notes[0].to_string(), "model: left out: textures (not read)", "{name}");
    }
}
