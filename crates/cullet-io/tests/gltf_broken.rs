//! Damaged files: where the reference validator finds an error that touches geometry, so do we; every
//! other file loads. None panics.

use std::path::{Path, PathBuf};

use cullet_io::{LoadOptions, load};
use cullet_testkit::data;
use serde_json::Value;

/// Errors of the validator that touch geometry wherever they are.
const GEOMETRY: [&str; 38] = [
    "ACCESSOR_INVALID_FLOAT",
    "ACCESSOR_MATRIX_ALIGNMENT",
    "ACCESSOR_NORMALIZED_INVALID",
    "ACCESSOR_OFFSET_ALIGNMENT",
    "ACCESSOR_SMALL_BYTESTRIDE",
    "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
    "ACCESSOR_TOO_LONG",
    "ACCESSOR_TOTAL_OFFSET_ALIGNMENT",
    "BUFFER_BYTE_LENGTH_MISMATCH",
    "BUFFER_DATA_URI_MIME_TYPE_INVALID",
    "BUFFER_MISSING_GLB_DATA",
    "BUFFER_VIEW_INVALID_BYTE_STRIDE",
    "BUFFER_VIEW_TOO_BIG_BYTE_STRIDE",
    "BUFFER_VIEW_TOO_LONG",
    "GLB_CHUNK_TOO_BIG",
    "GLB_DUPLICATE_CHUNK",
    "GLB_EMPTY_CHUNK",
    "GLB_INVALID_MAGIC",
    "GLB_INVALID_VERSION",
    "GLB_LENGTH_MISMATCH",
    "GLB_LENGTH_TOO_SMALL",
    "GLB_UNEXPECTED_BIN_CHUNK",
    "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
    "GLB_UNEXPECTED_END_OF_CHUNK_HEADER",
    "GLB_UNEXPECTED_END_OF_HEADER",
    "GLB_UNEXPECTED_FIRST_CHUNK",
    "INVALID_JSON",
    "INVALID_URI",
    "IO_ERROR",
    "NODE_LOOP",
    "NODE_MATRIX_NON_TRS",
    "NODE_MATRIX_TRS",
    "NODE_PARENT_OVERRIDE",
    "ROTATION_NON_UNIT",
    "SCENE_NON_ROOT_NODE",
    "UNDEFINED_PROPERTY",
    "UNRESOLVED_REFERENCE",
    "VALUE_MULTIPLE_OF",
];

/// Errors that touch geometry only at these places of the document; `""` is the whole of it.
const GEOMETRY_AT: [(&str, &[&str]); 3] = [
    ("TYPE_MISMATCH", &["", "/accessors", "/bufferViews", "/buffers", "/meshes", "/materials"]),
    ("UNSATISFIED_DEPENDENCY", &["/accessors"]),
    // An infinite translation keeps its instance, always visible, and warns.
    ("VALUE_NOT_IN_RANGE", &["/accessors", "/bufferViews", "/buffers"]),
];

/// Errors that do not, and why.
const OTHER: [(&str, &str); 11] = [
    ("ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND", "declared bounds are not used; a warning for positions"),
    ("ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND", "declared bounds are not used; a warning for positions"),
    ("ACCESSOR_MAX_MISMATCH", "declared bounds are not used"),
    ("ACCESSOR_MIN_MISMATCH", "declared bounds are not used"),
    ("DUPLICATE_ELEMENTS", "of extension names"),
    ("EMPTY_ENTITY", "an empty array changes nothing; a warning"),
    ("GLB_CHUNK_LENGTH_UNALIGNED", "the chunk after it is found all the same; a warning"),
    ("NODE_SKIN_WITH_NON_SKINNED_MESH", "a bad skin is left out; a warning"),
    ("NODE_WEIGHTS_INVALID", "those left out are 0"),
    ("UNDECLARED_EXTENSION", "bookkeeping of extensions"),
    ("UNUSED_EXTENSION_REQUIRED", "bookkeeping of extensions"),
];

/// Valid files that we refuse all the same.
const REFUSED: [(&str, &str); 3] = [
    ("buffer/non_relative_uri.gltf", "nothing is fetched from the net"),
    ("root/named_objects.gltf", "draws a mesh whose data are not in the file"),
    ("root/unused_objects.gltf", "draws a mesh whose data are not in the file"),
];

fn touches_geometry(error: &Value) -> bool {
    let code = error["code"].as_str().unwrap();
    let pointer = error["pointer"].as_str().unwrap_or_default();
    if let Some((_, places)) = GEOMETRY_AT.iter().find(|(c, _)| *c == code) {
        return places
            .iter()
            .any(|p| pointer == *p || pointer.starts_with(&format!("{p}/")) && !p.is_empty());
    }
    let known = OTHER.iter().any(|(c, _)| *c == code);
    let geometry = GEOMETRY.contains(&code);
    assert!(known != geometry, "the code {code} is not judged yet");
    geometry
}

fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, out);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            out.push(path);
        }
    }
    out.sort();
}

#[test]
fn errors_that_touch_geometry_are_found_and_no_others() {
    let Some(broken) = data("broken") else { return };
    let root = broken.join("gltf-validator");
    let mut all = Vec::new();
    files(&root, &mut all);
    assert_eq!(all.len(), 129);
    let (mut refused, mut loaded) = (0, 0);
    for file in all {
        let name = file.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
        let report = std::fs::read(format!("{}.report.json", file.display())).unwrap();
        let report: Value = serde_json::from_slice(&report).unwrap();
        let messages = report["issues"]["messages"].as_array().unwrap();
        let errors: Vec<&Value> = messages.iter().filter(|m| m["severity"] == 0).collect();
        let expected = errors.iter().any(|e| touches_geometry(e));
        // The validator looks no further into a file whose extension it would have to know.
        let unknown_extension = name == "root/undefined_used_extensions.gltf";
        let refusal = REFUSED.iter().any(|(f, _)| *f == name) || unknown_extension;
        match load(&file, &LoadOptions::default()) {
            Ok(_) => {
                assert!(!expected && !refusal, "{name} loads, in spite of {errors:?}");
                loaded += 1;
            }
            Err(e) => {
                assert!(expected || refusal, "{e}");
                let message = e.to_string();
                assert!(message.starts_with(file.to_str().unwrap()), "{message}");
                refused += 1;
            }
        }
    }
    println!("{refused} refused, {loaded} loaded");
}

#[test]
fn traps_of_other_suites_end_in_an_error_that_names_the_item() {
    let Some(broken) = data("broken") else { return };
    for (file, part) in [
        ("assimp/RecursiveNodes/RecursiveNodes.gltf", "node 0: "),
        ("assimp/MissingBin/BoxTextured.gltf", "buffer 0: BoxTextured0.bin"),
        ("assimp/IndexOutOfRange/IndexOutOfRange.gltf", "index 0 is 255, but there are 24"),
        ("assimp/IndexOutOfRange/AllIndicesOutOfRange.gltf", "index 0 is 65535"),
        ("assimp/IncorrectVertexArrays/Cube.gltf", "bufferView 2: 432 bytes at 504"),
        (
            "tinygltf/integer-out-of-bounds.gltf",
            "bufferView 0: invalid value: floating point `1e300`",
        ),
        ("tinygltf/invalid-buffer-index.gltf", "bufferView 1: names buffer 1 of 1"),
        ("tinygltf/invalid-buffer-view-index.gltf", "bufferView 0: names buffer 0 of 0"),
        ("tinygltf/invalid-primitive-indices.gltf", "bufferView 0: names buffer 0 of 0"),
        ("gltf-asset-generator/Compatibility/Compatibility_05.gltf", ""),
    ] {
        match load(&broken.join(file), &LoadOptions::default()) {
            Err(e) => assert!(e.to_string().contains(part), "{e}"),
            // A material of an unknown vendor moves no triangle.
            Ok(model) => assert!(part.is_empty() && !model.warnings.is_empty(), "{file} loads"),
        }
    }
}

/// File, triangles and instances.
const UNUSUAL: [(&str, u64, u32); 14] = [
    ("trimesh/mode5.gltf", 2_786, 54),
    ("trimesh/nested.glb", 36, 3),
    ("trimesh/no_indices_3storybuilding.glb", 72, 3),
    ("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf", 0, 0),
    ("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_03.gltf", 0, 0),
    ("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_04.gltf", 2, 1),
    ("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_05.gltf", 2, 1),
    ("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_06.gltf", 2, 1),
    ("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_11.gltf", 2, 1),
    ("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_12.gltf", 2, 1),
    ("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_13.gltf", 2, 1),
    ("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_15.gltf", 2, 1),
    ("gltf-asset-generator/Buffer_Interleaved/Buffer_Interleaved_00.gltf", 2, 1),
    ("gltf-asset-generator/Node_NegativeScale/Node_NegativeScale_12.gltf", 54, 2),
];

#[test]
fn unusual_but_valid_files_load_whole() {
    let Some(broken) = data("broken") else { return };
    for (file, triangles, instances) in UNUSUAL {
        let model = load(&broken.join(file), &LoadOptions::default()).unwrap();
        assert_eq!(model.scene.triangle_count(), triangles, "{file}");
        assert_eq!(model.scene.instance_count(), instances, "{file}");
        // Points and lines are skipped, but not in silence.
        assert_eq!(model.warnings.is_empty(), triangles > 0, "{file}");
    }
}

/// All forms of one square must cover the same: area and direction.
#[test]
fn every_form_of_a_square_is_the_same_square() {
    let Some(broken) = data("broken") else { return };
    let mut normals = Vec::new();
    for number in [4, 5, 6, 11, 12, 13, 14, 15] {
        let file =
            format!("gltf-asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_{number:02}.gltf");
        let model = load(&broken.join(file), &LoadOptions::default()).unwrap();
        let mesh = &model.scene.meshes()[0];
        let mut sum = [0.0; 3];
        for t in 0..mesh.triangle_count() {
            let [a, b, c] = mesh.corners(t);
            let u: [f32; 3] = std::array::from_fn(|i| b[i] - a[i]);
            let v: [f32; 3] = std::array::from_fn(|i| c[i] - a[i]);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                sum[i] += u[j] * v[k] - u[k] * v[j];
            }
        }
        normals.push(sum);
    }
    assert!(normals[0][2] > 0.1, "{:?}", normals[0]);
    for n in &normals {
        assert!((0..3).all(|i| (n[i] - normals[0][i]).abs() < 1e-6), "{normals:?}");
    }
}

#[test]
fn double_sided_is_believed_and_overridden() {
    let Some(broken) = data("broken") else { return };
    let sides = |number: u32, two_sided| {
        let file = format!(
            "gltf-asset-generator/Material_DoubleSided/Material_DoubleSided_{number:02}.gltf"
        );
        let options = LoadOptions { two_sided, ..LoadOptions::default() };
        let model = load(&broken.join(file), &options).unwrap();
        model.scene.meshes()[0].parts()[0].two_sided
    };
    for number in 0..4 {
        let file = broken.join(format!(
            "gltf-asset-generator/Material_DoubleSided/Material_DoubleSided_{number:02}.gltf"
        ));
        let text = std::fs::read_to_string(file).unwrap();
        let json: Value = serde_json::from_str(&text).unwrap();
        let declared = json["materials"][0]["doubleSided"] == true;
        assert_eq!(sides(number, None), declared, "{number}");
        assert!(sides(number, Some(true)));
        assert!(!sides(number, Some(false)));
    }
}

/// Every file of a kind read here, whole and cut short at many places, ends without a panic.
#[test]
fn truncation_never_panics() {
    let Some(broken) = data("broken") else { return };
    let mut all = Vec::new();
    files(&broken, &mut all);
    let options = LoadOptions::default();
    for file in all {
        let bytes = std::fs::read(&file).unwrap();
        let step = (bytes.len() / 60).max(1);
        for len in (0..bytes.len()).step_by(step) {
            let cut = cullet_io::load_bytes("cut.glb", &bytes[..len], &options);
            // A GLB knows its length, and the last brace of a JSON comes last.
            let text = bytes[len..].iter().all(u8::is_ascii_whitespace);
            let extra = bytes.starts_with(b"glTF") && file.ends_with("extra_data.glb");
            assert!(cut.is_err() || text || extra, "{} cut at {len}", file.display());
        }
    }
}
