//! Small files written here, and every model of the data folder in these formats.

use std::fmt::Write as _;

use cullet::mesh::Alpha;
use cullet_io::{LoadOptions, Model, Up, load, load_bytes};
use cullet_testkit::data;
use proptest::prelude::*;

/// A model from memory that must load.
fn of(name: &str, bytes: &[u8]) -> Model {
    load_bytes(name, bytes, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Vertices, triangles and polygons of all meshes.
fn counts(model: &Model) -> [usize; 3] {
    model.scene.meshes().iter().fold([0; 3], |[v, t, p], m| {
        [v + m.positions().len(), t + m.triangle_count() as usize, p + m.polygon_count() as usize]
    })
}

fn warnings(model: &Model) -> String {
    model.warnings.iter().map(|w| format!("{w}\n")).collect()
}

/// The corners of every triangle in the order of the file, so that models can be compared.
fn surface(model: &Model) -> Vec<[[f32; 3]; 3]> {
    let mut out = Vec::new();
    for mesh in model.scene.meshes() {
        let start = out.len();
        out.resize(start + mesh.triangle_count() as usize, [[0.0; 3]; 3]);
        for t in 0..mesh.triangle_count() {
            out[start + mesh.original_triangle()[t as usize] as usize] = mesh.corners(t);
        }
    }
    out
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn obj_keeps_polygons_and_triangles() {
    let model = of("cube.obj", CUBE.as_bytes());
    assert_eq!(counts(&model), [8, 12, 6]);
    assert_eq!(model.name, "cube.obj");
    assert_eq!(model.mesh_names, ["cube.obj"]);
    assert_eq!(model.instance_names, ["cube.obj"]);
    assert_eq!(warnings(&model), "");
}

#[test]
fn obj_groups_are_meshes_and_materials_are_parts() {
    let text = "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\no chair\nusemtl wood\nf 1 2 3\n\
                usemtl steel\nf 1 2 4\nusemtl wood\nf 2 3 4\ng seat\nf 1 3 4\no lamp\nf 4 3 2\n\
                o chair\nf 3 2 1\n";
    let model = of("room.obj", text.as_bytes());
    assert_eq!(model.mesh_names, ["chair", "chair/seat", "lamp"]);
    let chair = &model.scene.meshes()[0];
    let parts: Vec<_> =
        chair.parts().iter().map(|p| (p.first_triangle, p.triangle_count, p.material)).collect();
    assert_eq!(parts, [(0, 3, 0), (3, 1, 1)]);
    let names: Vec<_> = model.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["wood", "steel"]);
    // Each mesh has the vertices that it uses.
    assert_eq!(
        model.scene.meshes().iter().map(|m| m.positions().len()).collect::<Vec<_>>(),
        [4, 3, 3]
    );
    assert_eq!(surface(&model)[0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert!(warnings(&model).contains("none.mtl"), "{}", warnings(&model));
}

#[test]
fn obj_reads_materials_beside_it() {
    let folder = std::env::temp_dir().join(format!("cullet-mtl-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("a.obj");
    std::fs::write(folder.join("my paints.mtl"), "newmtl red\nKd 1 0 0\nnewmtl glass\nd 0.3\n")
        .unwrap();
    let text = "mtllib my paints.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl glass\nf 3 2 1\n";
    std::fs::write(&path, text).unwrap();
    let model = load(&path, &LoadOptions::default());
    std::fs::remove_dir_all(&folder).unwrap();
    let model = model.unwrap();
    assert_eq!(warnings(&model), "");
    assert_eq!(model.materials[0].color, [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(model.materials[1].color[3], 0.3);
    let alphas: Vec<_> = model.scene.meshes()[0].parts().iter().map(|p| p.alpha).collect();
    assert_eq!(alphas, [Alpha::Opaque, Alpha::Blended]);
}

#[test]
fn obj_indices_of_every_kind() {
    // Negative, ahead of their vertices, with texture and normal, over joined lines, with a comment.
    let text = "# C:\\models\\\nf 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nf 1/7/9 2//4 \\\n 3/1 # end\n\
                vt 1 2\nvn 0 0 1\nf 3/1/1 2/1/1 1/1/1\nl 1 2\np 1\nf 1 2\ncurv 0 1 1 2\nwhat 3\n";
    let model = of("a.obj", text.as_bytes());
    assert_eq!(counts(&model), [3, 4, 4]);
    let s = surface(&model);
    assert_eq!(s[0], s[1]);
    assert_eq!(s[0], s[2]);
    let w = warnings(&model);
    for part in ["1 point", "1 line", "fewer than 3", "free-form", "\"what\""] {
        assert!(w.contains(part), "{part}: {w}");
    }
}

#[test]
fn concave_polygons_cover_what_they_should() {
    let text = "v 2 1 0\nv 0 2 0\nv 0.5 1 0\nv 0 0 0\nf 1 2 3 4\n";
    let model = of("arrow.obj", text.as_bytes());
    let area: f64 = surface(&model)
        .iter()
        .map(|t| {
            let e = |k: usize, a: usize| f64::from(t[k][a] - t[0][a]);
            (e(1, 0) * e(2, 1) - e(1, 1) * e(2, 0)) / 2.0
        })
        .inspect(|&a| assert!(a > 0.0))
        .sum();
    assert!((area - 1.5).abs() < 1e-9, "{area}");
}

#[test]
fn sides_follow_solids_unless_told() {
    let doubled = CUBE.replace("f ", "f 1 2 3\nf 3 2 1\nf ").replacen("f 1 2 3\nf 3 2 1\n", "", 1);
    for (name, text, solid) in [
        ("cube.obj", CUBE, true),
        ("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", false),
        ("doubled.obj", &doubled, false),
    ] {
        let two_sided = |option| {
            let options = LoadOptions { two_sided: option, ..LoadOptions::default() };
            let model = load_bytes(name, text.as_bytes(), &options).unwrap();
            model.scene.meshes()[0].parts()[0].two_sided
        };
        assert_eq!(two_sided(None), !solid, "{name}");
        assert!(two_sided(Some(true)), "{name}");
        assert!(!two_sided(Some(false)), "{name}");
    }
}

#[test]
fn z_up_turns_the_instance_and_not_the_vertices() {
    let options = LoadOptions { up: Some(Up::Z), ..LoadOptions::default() };
    let model = load_bytes("a.obj", b"v 1 2 3\nv 1 2 4\nv 1 3 3\nf 1 2 3\n", &options).unwrap();
    assert_eq!(model.scene.meshes()[0].positions()[0], [1.0, 2.0, 3.0]);
    let extent = model.scene.extent();
    for (axis, low) in [1.0, 3.0, -3.0].into_iter().enumerate() {
        assert!((extent.min[axis] - low).abs() < 1e-5, "{extent:?}");
    }
    for (axis, high) in [1.0, 4.0, -2.0].into_iter().enumerate() {
        assert!((extent.max[axis] - high).abs() < 1e-5, "{extent:?}");
    }
}

#[test]
fn triangles_have_a_limit() {
    let options = LoadOptions { max_triangles: 11, ..LoadOptions::default() };
    let error = load_bytes("cube.obj", CUBE.as_bytes(), &options).unwrap_err().to_string();
    assert_eq!(error, "cube.obj: triangles: 12 exceeds the limit of 11");
}

#[test]
fn ply_of_every_type_and_order() {
    let ascii = of(
        "a.ply",
        b"ply\nformat ascii 1.0\ncomment made by hand\nelement material 1\nproperty int ambient\n\
          property list uchar float stuff\nelement face 2\nproperty uchar red\n\
          property list uchar int vertex_index\nproperty float quality\nelement vertex 4\n\
          property double z\nproperty short y\nproperty float x\nend_header\n7 2 0.5 nan\n\
          255 4 0 1 2 3 1e9\n0 3 2 1 0 inf\n0 0 0\n0 0 1\n0.0 1 1e0\n0 1 0\n",
    );
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(counts(&ascii), [4, 3, 2]);
    assert_eq!(ascii.scene.meshes()[0].positions(), square);
    for big in [false, true] {
        let mut file = format!(
            "ply\r\nformat binary_{}_endian 1.0\r\nelement vertex 4\r\nproperty double z\r\n\
             property list ushort double w\r\nproperty int16 y\r\nproperty float32 x\r\n\
             element face 2\r\nproperty list int uint8 vertex_indices\r\nend_header\r\n",
            if big { "big" } else { "little" }
        )
        .into_bytes();
        let mut put = |mut little: Vec<u8>| {
            if big {
                little.reverse();
            }
            file.extend(little);
        };
        for [x, y, z] in square {
            put(f64::from(z).to_le_bytes().to_vec());
            put(1u16.to_le_bytes().to_vec());
            put(f64::NAN.to_le_bytes().to_vec());
            put((y as i16).to_le_bytes().to_vec());
            put(x.to_le_bytes().to_vec());
        }
        for face in [&[0u8, 1, 2, 3][..], &[2, 1, 0]] {
            put((face.len() as i32).to_le_bytes().to_vec());
            face.iter().for_each(|&v| put(vec![v]));
        }
        let binary = of("a.ply", &file);
        assert_eq!(surface(&binary), surface(&ascii), "big {big}");
        assert_eq!(warnings(&binary), "");
        // Cut short at any place, it is an error and nothing worse.
        for end in 0..file.len() {
            load_bytes("a.ply", &file[..end], &LoadOptions::default()).unwrap_err();
        }
    }
}

#[test]
fn ply_strips_alternate_and_restart() {
    let model = of(
        "a.ply",
        b"ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
          property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n\
          0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 2 3 4 -1\n",
    );
    let s = surface(&model);
    assert_eq!(s.len(), 3);
    for t in &s {
        let e = |k: usize, a: usize| t[k][a] - t[0][a];
        assert!(e(1, 0) * e(2, 1) - e(1, 1) * e(2, 0) > 0.0, "all wound alike: {t:?}");
    }
}

#[test]
fn ply_refuses_with_places() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (body, expected) in [
        (
            "0 0 0\n0 nan 0\n1 1 1\n3 0 1 2\n",
            "vertex 1, property y (line 11): not finite in 32 bits: NaN",
        ),
        (
            "0 0 0\n0 1 0\n1 1 1\n3 0 1 3\n",
            "face 0, property vertex_indices (line 13): refers to vertex 3, but there are only 3",
        ),
        (
            "0 0 0\n0 1 0\n1 1 1\n200 0 1 2\n",
            "a list of 200 values, but the bytes left hold at most",
        ),
        (
            "0 0 0\n0 1 0\n1 x 1\n3 0 1 2\n",
            "vertex 2, property y (line 12): expected a number, found \"x\"",
        ),
        ("0 0\n", "element vertex has 3 rows of at least 6 bytes, but only"),
        ("0 0 0\n0 1 0\n1 1 1e39\n3 0 1 2\n", "not finite in 32 bits: inf"),
    ] {
        let file = format!("{head}{body}");
        let error =
            load_bytes("a.ply", file.as_bytes(), &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(expected), "{body:?}: {error}");
    }
}

fn stl_binary(head: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut file = head.to_vec();
    file.resize(80, b' ');
    file.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        file.extend([0; 12]);
        file.extend(t.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        file.extend([0; 2]);
    }
    file
}

#[test]
fn stl_binary_may_begin_with_solid() {
    let cube = surface(&of("cube.obj", CUBE.as_bytes()));
    for head in [&b"solid facet endsolid"[..], b"COLOR=", b"\0"] {
        let file = stl_binary(head, &cube);
        for name in ["a.stl", "a.STL", "a"] {
            let model = of(name, &file);
            assert_eq!(counts(&model), [8, 12, 12]);
            assert_eq!(surface(&model), cube);
        }
        for end in 0..file.len() {
            load_bytes("a.stl", &file[..end], &LoadOptions::default()).unwrap_err();
        }
    }
    let mut longer = stl_binary(b"x", &cube);
    longer.extend([1, 2, 3]);
    assert!(warnings(&of("a.stl", &longer)).contains("3 bytes after the last triangle"));
    let mut bad = cube.clone();
    bad[7][2][0] = f32::INFINITY;
    let error = load_bytes("a.stl", &stl_binary(b"x", &bad), &LoadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("triangle 7, vertex 2: not finite"), "{error}");
}

#[test]
fn stl_ascii_equals_binary() {
    let cube = surface(&of("cube.obj", CUBE.as_bytes()));
    let mut text = String::from("solid my cube\r\n");
    for t in &cube {
        text += "  facet normal nan nan nan\r\n OUTER LOOP\r\n";
        for [x, y, z] in t {
            write!(text, "Vertex {x} {y} {z:e}\r\n").unwrap();
        }
        text += "endloop\r\n endfacet\r\n";
    }
    text += "endsolid my cube";
    let model = of("a.stl", text.as_bytes());
    assert_eq!(surface(&model), cube);
    assert_eq!((counts(&model), &model.mesh_names[..]), ([8, 12, 12], &["my cube".to_owned()][..]));
    for (from, to, expected) in [
        ("endfacet", "facet", "line 8: a facet begins inside another"),
        ("Vertex 0 1 0e0\r\n", "", "vertices, expected 3"),
        ("endsolid my cube", "vertex 1 2 3", "the file ends inside a solid"),
        ("Vertex 0 1 0e0", "Vertex 0 inf 0", "is not finite in 32 bits: inf"),
    ] {
        let broken = text.replacen(from, to, 1);
        assert_ne!(broken, text, "{from}");
        let error = load_bytes("a.stl", broken.as_bytes(), &LoadOptions::default()).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
}

#[test]
fn off_of_every_spelling() {
    let body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 2 1 0 255 0 0\n";
    let plain = of("a.off", format!("OFF\n4 2 0\n{body}").as_bytes());
    assert_eq!(counts(&plain), [4, 3, 2]);
    let coloured =
        "0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n1 1 0 1 0 0 1\n0 1 0 1 0 0 1\n4 0 1 2 3 0.5\n3 2 1 0\n";
    for text in [
        format!("OFF 4 2 0\n{body}"),
        // As all files of ModelNet.
        format!("OFF4 2 0\n{body}"),
        format!("OFF\n# counts\n\n4 2\n{body}"),
        format!("4 2 0\n{body}"),
        format!("OFF\r\n4 2 5\r\n{}", body.replace('\n', "\r\n")),
        format!("COFF\n4 2 0\n{coloured}"),
        format!("STCNOFF\n4 2 0\n{coloured}"),
        format!("OFF\n4 2 0\n{}", body.replace("1 0 0\n", "1 0 0 # here\n# and here\n")),
        format!("OFF\n4 2 0\n{}", body.trim_end()),
    ] {
        let model = of("a.off", text.as_bytes());
        assert_eq!(surface(&model), surface(&plain), "{text}");
        assert_eq!(warnings(&model), "", "{text}");
    }
    for (text, expected) in [
        (
            "OFF\n4 1 0\n",
            "line 2: the number of vertices is 4, but the 5 bytes left hold at most 1",
        ),
        ("OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "line 4: face 0 refers to vertex 1, but there are only 1"),
        ("OFF\n1 1 0\n0 0 0\n3 0 0 -1\n", "face 0 refers to vertex -1"),
        (
            "OFF\n1 1 0\n0 0\n",
            "line 4: expected a coordinate of vertex 0, found the end of the file",
        ),
        (
            "OFF\n3 1 0\n0 0 1\n0 0 inf\n0 1 0\n3 0 1 2\n",
            "line 4: vertex 1 is not finite in 32 bits: inf",
        ),
        ("OFF BINARY\nxxx", "binary OFF is not loaded"),
        ("4OFF\n0 0 0\n", "four or more dimensions"),
        ("OFF\n-1 0 0\n", "expected the number of vertices, found \"-1\""),
    ] {
        let error =
            load_bytes("a.off", text.as_bytes(), &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(expected), "{text:?}: {error}");
    }
}

#[test]
fn files_that_are_none_of_these() {
    let error =
        load(std::path::Path::new("/nonexistent/a.obj"), &LoadOptions::default()).unwrap_err();
    assert!(error.to_string().starts_with("/nonexistent/a.obj: cannot be read"), "{error}");
    let folder = std::env::temp_dir();
    let error = load(&folder, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.ends_with("it is a folder: name a file in it"), "{error}");
    #[cfg(unix)]
    {
        let error = load(std::path::Path::new("/dev/null"), &LoadOptions::default()).unwrap_err();
        assert!(error.to_string().ends_with("it is not a regular file"), "{error}");
    }
    let error =
        load_bytes("a.obj", b"hello world\n", &LoadOptions::default()).unwrap_err().to_string();
    assert_eq!(
        error,
        "a.obj: line 1: expected a statement of OBJ, such as v or f, found \"hello\""
    );
    let error = load_bytes("house.fbx", b"?", &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("`FBX2glTF -b -i house.fbx -o house.glb`"), "{error}");
}

/// Vertices and triangles of the README's table, polygons where it has them, and whether it is closed.
const MODELS: &[(&str, usize, usize, usize, bool)] = &[
    ("stanford-bunny/bun_zipper.ply", 35_947, 69_451, 69_451, false),
    ("stanford-bunny/bun_zipper_res2.ply", 8_171, 16_301, 16_301, false),
    ("stanford-bunny/bun_zipper_res3.ply", 1_889, 3_851, 3_851, false),
    ("stanford-bunny/bun_zipper_res4.ply", 453, 948, 948, false),
    ("stanford-bunny/bunny-closed-7k.off", 3_485, 6_966, 6_966, true),
    ("happy-buddha/buddha-100k.obj", 49_950, 100_000, 100_000, false),
    ("armadillo/armadillo.obj", 43_243, 86_482, 86_482, true),
    ("classic-meshes/spot.obj", 2_930, 5_856, 5_856, true),
    ("classic-meshes/cow.obj", 2_903, 5_804, 5_804, true),
    ("classic-meshes/fandisk.obj", 6_475, 12_946, 12_946, true),
    ("classic-meshes/rocker-arm.obj", 10_044, 20_088, 20_088, true),
    ("classic-meshes/teapot.obj", 3_644, 6_320, 6_320, false),
    ("classic-meshes/suzanne.obj", 507, 968, 500, false),
    ("classic-meshes/beetle.obj", 1_148, 2_053, 2_053, false),
    ("classic-meshes/woody.obj", 694, 1_267, 1_267, false),
    ("crytek-sponza/crytek-sponza.ply", 184_402, 262_267, 262_267, false),
    ("broken/truck-misoriented.obj", 2_956, 4_770, 4_770, false),
];

#[test]
fn models_have_the_counts_of_their_table() {
    for &(file, vertices, triangles, polygons, closed) in MODELS {
        let Some(path) = data(file) else { continue };
        let model = load(&path, &LoadOptions::default()).unwrap();
        assert_eq!(counts(&model), [vertices, triangles, polygons], "{file}");
        assert_eq!(model.scene.instance_count(), 1, "{file}");
        assert_eq!(model.scene.triangle_count(), triangles as u64, "{file}");
        let part = model.scene.meshes()[0].parts()[0];
        assert_eq!(part.two_sided, !closed, "{file}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cullet_testkit::cases(64), failure_persistence: None, ..ProptestConfig::default() })]

    /// One surface, written in every format, is one surface.
    #[test]
    fn formats_agree(
        positions in prop::collection::vec(prop::array::uniform3(-1e5f32..1e5), 3..20),
        picks in prop::collection::vec(prop::array::uniform3(0usize..1000), 1..30),
    ) {
        let faces: Vec<[usize; 3]> = picks.iter().map(|t| t.map(|v| v % positions.len())).collect();
        let expected: Vec<[[f32; 3]; 3]> = faces.iter().map(|t| t.map(|v| positions[v])).collect();
        let (mut obj, mut off) = (String::new(), format!("OFF\n{} {} 0\n", positions.len(), faces.len()));
        let mut ply = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
            positions.len(), faces.len()
        );
        for [x, y, z] in &positions {
            writeln!(obj, "v {x} {y} {z}").unwrap();
            writeln!(off, "{x} {y} {z}").unwrap();
            writeln!(ply, "{x:e} {y:e} {z:e}").unwrap();
        }
        for [a, b, c] in &faces {
            writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
            writeln!(off, "3 {a} {b} {c}").unwrap();
            writeln!(ply, "3 {a} {b} {c}").unwrap();
        }
        for (name, bytes) in [
            ("a.obj", obj.into_bytes()),
            ("a.off", off.into_bytes()),
            ("a.ply", ply.into_bytes()),
            ("a.stl", stl_binary(b"", &expected)),
        ] {
            prop_assert_eq!(&surface(&of(name, &bytes)), &expected, "{}", name);
        }
    }
}

#[test]
fn the_origin_follows_a_model_that_is_far_away() {
    let obj = |x: f64| format!("v {x} 0 0\nv {} 0 0\nv {x} 1 0\nf 1 2 3\n", x + 4.0);
    let load = |text: String| {
        let options = LoadOptions::default();
        load_bytes("far.obj", text.as_bytes(), &options).unwrap().scene
    };
    assert_eq!(load(obj(3.0)).origin(), [0.0; 3]);
    let far = load(obj(4_000_000.0));
    assert_eq!(far.origin(), [4_000_002.0, 1.0, 0.0].map(|v: f64| v.round()));
    assert!(far.extent().half_extent()[0] < 2.001, "bounds stay tight");
}

/// The corners of every triangle in the world.
fn in_the_world(model: &Model) -> Vec<[f64; 3]> {
    assert_eq!(model.scene.meshes().len(), 1);
    let origin = model.scene.transform(0).translation;
    let corners = surface(model).into_flattened();
    corners.iter().map(|p| std::array::from_fn(|a| origin[a] + f64::from(p[a]))).collect()
}

#[test]
fn coordinates_of_a_national_grid_keep_their_digits() {
    let corners: [[f64; 3]; 4] = [
        [1_842_000.123, 5_176_000.456, 212.5],
        [1_842_001.124, 5_176_000.455, 212.25],
        [1_842_000.125, 5_176_001.454, 213.125],
        [1_842_001.126, 5_176_001.453, 213.5],
    ];
    let text: String = corners.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let lines =
        |before: &str| -> String { text.lines().map(|l| format!("{before}{l}\n")).collect() };
    let ply = |kind: &str, body: &[u8]| {
        let (format, kind) = kind.split_once(' ').expect("two words");
        let head = format!(
            "ply\nformat {format} 1.0\nelement vertex 4\nproperty {kind} x\nproperty {kind} y\n\
             property {kind} z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n"
        );
        [head.as_bytes(), body].concat()
    };
    let mut doubles: Vec<u8> =
        corners.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    doubles.extend([4, 0, 1, 3, 2]);
    let written = format!("{text}4 0 1 3 2\n");
    for (name, file) in [
        ("a.obj", format!("{}f 1 2 4 3\n", lines("v ")).into_bytes()),
        ("a.off", format!("OFF\n4 1 0\n{written}").into_bytes()),
        ("a.ply", ply("ascii double", written.as_bytes())),
        ("a.ply", ply("ascii float", written.as_bytes())),
        ("a.ply", ply("binary_little_endian double", &doubles)),
    ] {
        let model = of(name, &file);
        let order = [0, 1, 3, 0, 3, 2];
        for (found, wanted) in in_the_world(&model).iter().zip(order.map(|i| corners[i])) {
            for axis in 0..3 {
                let off = (found[axis] - wanted[axis]).abs();
                assert!(off < 1e-6, "{name}: {found:?} for {wanted:?}");
            }
        }
        assert_eq!(counts(&model), [4, 2, 1]);
        assert_eq!(warnings(&model), "", "{name}");
    }
}

#[test]
fn vertices_that_no_face_uses_may_be_anything() {
    let head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (name, file) in [
        ("a.obj", "v 0 0 0\nv nan 0 inf\nv 1 0 0\nv 0 1 0\nf 1 3 4\n".to_owned()),
        ("a.off", "OFF\n4 1 0\n0 0 0\nnan 0 inf\n1 0 0\n0 1 0\n3 0 2 3\n".to_owned()),
        ("a.ply", format!("{head}0 0 0\n1e39 0 0\n1 0 0\n0 1 0\n3 0 2 3\n")),
    ] {
        let model = of(name, file.as_bytes());
        assert_eq!(surface(&model), [[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]], "{name}");
        assert!(warnings(&model).contains("1 vertices that no face uses are not finite"));
        assert!(model.scene.bounds(0).max[0] < 1.001, "what is unused makes no bounds larger");
    }
}

#[test]
fn rows_of_a_ply_longer_than_declared_are_one_element_each() {
    let head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                property float z\nelement face 2\nproperty list uchar int vertex_indices\n\
                property uchar red\nend_header\n";
    let vertices = "0 0 0 7\n1 0 0\n1 1 0 8 9\n0 1 0\n";
    let model =
        of("a.ply", format!("{head}{vertices}3 0 1 2 9 1 1 1\n3 0 2 3 9 1 1 1\n").as_bytes());
    assert_eq!(counts(&model), [4, 2, 2]);
    assert!(warnings(&model).contains("4 rows are longer than the header declares"));
    // Several rows a line, and a row on several lines, are as good as one.
    let body = "0 0 0 1 0 0 1 1\n0 0 1 0 3 0 1 2\n9 3 0 2 3 9";
    let model = of("a.ply", format!("{head}{body}").as_bytes());
    assert_eq!((counts(&model), warnings(&model)), ([4, 2, 2], String::new()));
}

#[test]
fn obj_lines_are_joined_however_the_backslash_stands() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 1 1\\\n 0\nv 0 1 \\\r\n0\n";
    for face in ["f 1 2 3\\\n 4\n", "f 1 2 3\\\n4\n", "f 1 \\\n2\\\r\n3 4\\\n\n"] {
        let model = of("a.obj", format!("{vertices}g a\\\nb\n{face}").as_bytes());
        assert_eq!((counts(&model), warnings(&model)), ([4, 2, 1], String::new()), "{face:?}");
        assert_eq!(model.mesh_names, ["a b"]);
    }
}
