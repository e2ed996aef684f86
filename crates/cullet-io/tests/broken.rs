//! Every broken or unusual file of the data folder in the formats without a specification to validate
//! against: each ends in a clear error or a correct load, within the memory that is promised.

use std::path::{Path, PathBuf};

use cullet_io::{ErrorKind, LoadOptions, load, load_bytes};
use cullet_testkit::data;
use cullet_testkit::memory::{Counting, peak_of};

/// Memory that loading may take beyond the file's size.
const ALLOWANCE: usize = 256 << 20;

fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            walk(&path, out);
        } else {
            out.push(path);
        }
    }
}

enum Expect {
    /// A part of the error's text.
    Error(&'static str),
    /// Vertices, triangles and polygons of each mesh, and a part of some warning ("" for none at all).
    Meshes(&'static [[u32; 3]], &'static str),
}
use Expect::{Error, Meshes};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const NO_TRIANGLES: &str = "it has no triangles";

/// Result for each file. A file of these formats that is not listed fails the test.
const FILES: &[(&str, Expect)] = &[
    // One face names the box's first four corners over and over, on a line of 2,000 characters.
    ("assimp/OBJ-box_longline.obj", Meshes(&[[8, 944, 6]], "")),
    ("assimp/OBJ-box_without_lineending.obj", Meshes(&[[8, 12, 6]], "")),
    ("assimp/OBJ-concave_polygon.obj", Meshes(&[[64, 64, 1]], "concave_polygon.mtl")),
    ("assimp/OBJ-multiple_spaces.obj", Meshes(&[[4, 1, 1]], "")),
    ("assimp/OBJ-number_formats.obj", Error("line 11: expected z as a number, found \"3.1+e2\"")),
    ("assimp/OBJ-only_a_part_of_vertexcolors.obj", Meshes(&[[5, 3, 3]], "")),
    ("assimp/OBJ-point_cloud.obj", Meshes(&[], "3 vertices are in no face")),
    ("assimp/OBJ-testmixed.obj", Meshes(&[[8, 12, 6]], "6 point statements were skipped")),
    ("assimp/OBJ-testpoints.obj", Meshes(&[], "6 point statements were skipped")),
    ("assimp/PLY-cube_binary_starts_with_nl.ply", Meshes(&[[8, 12, 6]], "")),
    // Its element line of the faces was lost, so that the first row lacks a list.
    (
        "assimp/PLY-issue623.ply",
        Error("vertex 0, property vertex_indices (line 15): a list of 7.941797 values"),
    ),
    ("assimp/PLY-points.ply", Meshes(&[], "its 4 vertices are in no face")),
    ("assimp/STL-triangle_with_empty_solid.stl", Meshes(&[[3, 1, 1]], "")),
    ("assimp/STL-triangle_with_two_solids.stl", Meshes(&[[3, 1, 1], [3, 1, 1]], "")),
    (
        "assimp/invalid-OutOfMemory.off",
        Error(
            "line 2: the number of vertices is 353535235358, but the 293 bytes left hold at most 49",
        ),
    ),
    (
        "assimp/invalid-crash-30d6d0f7c529b3b66b4131700b7a4580cd7082df.ply",
        Error("line 7: expected a type"),
    ),
    ("assimp/invalid-empty.obj", Error("it is empty (0 bytes)")),
    ("assimp/invalid-empty.ply", Error("it is empty (0 bytes)")),
    (
        "assimp/invalid-malformed.obj",
        Error("line 28: a face refers to vertex 0, but vertices count from 1"),
    ),
    ("manifold/Cray_left.obj", Meshes(&[[292, 576, 576]], "")),
    ("manifold/Cray_right.obj", Meshes(&[[8, 12, 12]], "")),
    ("manifold/openscad-nonmanifold-crash.obj", Meshes(&[[717, 1_442, 1_442]], "")),
    ("manifold/self_intersectA.obj", Meshes(&[[8_582, 17_160, 17_160]], "")),
    ("manifold/self_intersectB.obj", Meshes(&[[8_582, 17_160, 17_160]], "")),
    ("trimesh/busted.STL", Meshes(&[[1_941, 3_878, 3_878]], "")),
    ("trimesh/comments.off", Meshes(&[[8, 12, 6]], "")),
    ("trimesh/empty.obj", Meshes(&[], NO_TRIANGLES)),
    ("trimesh/empty.ply", Meshes(&[], NO_TRIANGLES)),
    ("trimesh/empty.stl", Meshes(&[], NO_TRIANGLES)),
    ("trimesh/face_in_group_name.obj", Meshes(&[], NO_TRIANGLES)),
    ("trimesh/jacked.obj", Meshes(&[[8, 12, 12]], "nonexistent.mtl")),
    ("trimesh/mirror.ply", Meshes(&[[143, 286, 286]], "")),
    ("trimesh/multibody.stl", Meshes(&[[8, 12, 12], [12, 20, 20]], "")),
    ("trimesh/nancolor.obj", Meshes(&[[8, 12, 12]], "")),
    ("trimesh/negative_indices.obj", Meshes(&[[8, 12, 6]], "")),
    ("trimesh/not_convex.obj", Meshes(&[[288, 96, 96]], "")),
    ("trimesh/points_ascii_with_lists.ply", Meshes(&[], "its 5 vertices are in no face")),
    ("trimesh/points_emptyface.ply", Meshes(&[], "its 1024 vertices are in no face")),
    ("trimesh/polygonfaces.obj", Meshes(&[[5, 3, 1]], "surface.mtl")),
    ("trimesh/soup.stl", Meshes(&[[300, 100, 100]], "")),
    ("trimesh/wallhole.obj", Meshes(&[[92, 66, 13]], "00.mtl")),
    ("truck-misoriented.obj", Meshes(&[[2_956, 4_770, 4_770]], "")),
];

fn check(folder: &Path, file: &str, expect: &Expect) {
    let path = folder.join(file);
    let size = std::fs::metadata(&path).unwrap_or_else(|e| panic!("{file}: {e}")).len() as usize;
    let (result, peak) = peak_of(|| load(&path, &LoadOptions::default()));
    assert!(peak <= size + ALLOWANCE, "{file}: {peak} bytes");
    match (result, expect) {
        (Ok(model), Meshes(meshes, warning)) => {
            let counts: Vec<[u32; 3]> = model
                .scene
                .meshes()
                .iter()
                .map(|m| [m.positions().len() as u32, m.triangle_count(), m.polygon_count()])
                .collect();
            assert_eq!(&counts[..], *meshes, "{file}");
            let warnings: Vec<String> = model.warnings.iter().map(ToString::to_string).collect();
            let found = warnings.iter().any(|w| w.contains(warning));
            assert!(found || (warning.is_empty() && warnings.is_empty()), "{file}: {warnings:?}");
            assert!(!warning.is_empty() || warnings.is_empty(), "{file}: {warnings:?}");
        }
        (Err(error), Error(part)) => {
            let text = error.to_string();
            assert!(text.contains(part), "{text}");
            assert!(text.starts_with(&path.display().to_string()), "{text}");
        }
        (Ok(_), Error(part)) => panic!("{file}: loaded, expected {part}"),
        (Err(error), Meshes(..)) => panic!("{error}"),
    }
}

// One test for all that measures memory: its counter is shared by the whole program.
#[test]
fn each_file_ends_as_it_should() {
    claims_cost_no_memory();
    let Some(folder) = data("broken") else { return };
    for (file, expect) in FILES {
        check(&folder, file, expect);
    }
    let mut files = Vec::new();
    walk(&folder, &mut files);
    for path in files {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        if ["obj", "ply", "stl", "off"].contains(&ending.as_str()) {
            let name = path.strip_prefix(&folder).expect("below the folder");
            assert!(
                FILES.iter().any(|(f, _)| Path::new(f) == name),
                "{} is not listed",
                name.display()
            );
        }
    }
}

/// Files of a few bytes that claim to be huge.
fn claims_cost_no_memory() {
    let ply = |format: &str, element: &str| {
        format!("ply\nformat {format} 1.0\n{element}\nend_header\n").into_bytes()
    };
    let xyz = "property float x\nproperty float y\nproperty float z";
    let mut files: Vec<(&str, Vec<u8>)> = vec![
        ("a.off", b"OFF\n4000000000 1 0\n".to_vec()),
        ("a.off", b"OFF\n1 4000000000 0\n0 0 0\n".to_vec()),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n9000000000000000000 0 1 2\n".to_vec()),
        ("a.obj", b"v 0 0 0\nf 1 2 4000000000\n".to_vec()),
        ("a.obj", b"v 0 0 0\nf 1 -1 9223372036854775807\n".to_vec()),
        ("a.obj", b"v 0 0 0\nf 1 1 99999999999999999999999\n".to_vec()),
    ];
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for count in ["4000000000", "9223372036854775807"] {
            files.push(("a.ply", ply(format, &format!("element vertex {count}\n{xyz}"))));
            let rest = format!("element vertex 0\n{xyz}\nelement face {count}\n");
            files.push((
                "a.ply",
                ply(format, &format!("{rest}property list uchar int vertex_indices")),
            ));
            files.push(("a.ply", ply(format, &format!("{rest}property double x"))));
        }
        let list = "property list uint int vertex_indices";
        let mut long = ply(format, &format!("element vertex 0\n{xyz}\nelement face 1\n{list}"));
        long.extend(if format == "ascii" { *b"4294967295 0" } else { [0xff; 12] });
        files.push(("a.ply", long));
    }
    let mut stl = vec![0u8; 80];
    stl.extend(u32::MAX.to_le_bytes());
    files.push(("a.stl", stl));
    for (name, bytes) in &files {
        let shown = String::from_utf8_lossy(bytes);
        let (result, peak) = peak_of(|| load_bytes(name, bytes, &LoadOptions::default()));
        let error = result.map(drop).expect_err(&shown);
        assert!(
            matches!(error.kind, ErrorKind::Invalid { .. } | ErrorKind::OverLimit { .. }),
            "{error}"
        );
        assert!(peak < 1 << 20, "{shown}: {peak} bytes");
    }
    // Rows of no properties take no bytes, so any count is fine and must cost no time.
    let empty =
        ply("ascii", &format!("element nothing 9223372036854775807\nelement vertex 0\n{xyz}"));
    load_bytes("a.ply", &empty, &LoadOptions::default()).expect("an empty model");
}
