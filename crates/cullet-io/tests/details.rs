//! Attributes of vertices besides positions, and the tree of nodes: read on request, and saved again.

use cullet_io::{Attributes, ErrorKind, LoadOptions, Model, load, load_bytes, save};
use cullet_testkit::Folder;
use serde_json::{Value, json};

fn details() -> LoadOptions {
    LoadOptions { details: true, ..LoadOptions::default() }
}

fn read(name: &str, text: &str) -> Model {
    load_bytes(name, text.as_bytes(), &details()).unwrap()
}

fn near<const N: usize>(a: &[[f32; N]], b: &[[f32; N]], most: f32) {
    assert_eq!(a.len(), b.len());
    let apart = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
    assert!(apart.clone().all(|d| d <= most), "{a:?} is not {b:?}: {:?}", apart.reduce(f32::max));
}

/// A square of two triangles whose corners share positions, but not all texture coordinates.
const OBJ: &str = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nvt 0 0\nvt 1 0.25\nvt 0.5\n\
                   vn 0 0 2\nvn 0 1 0\nf 1/1/1 2/2/1 3/3/1\nf 1/1/-2 3/-3/2 4//1\n";

#[test]
fn corners_of_obj_become_vertices() {
    let model = read("a.obj", OBJ);
    let mesh = &model.scene.meshes()[0];
    // Position 3 comes with two pairs of others.
    assert_eq!(mesh.positions().len(), 5);
    let a = &model.attributes[0];
    assert_eq!(a.uvs, [[0.0, 1.0], [1.0, 0.75], [0.5, 1.0], [0.0, 1.0], [0.0, 0.0]]);
    assert_eq!(a.normals[2..], [[0.0, 0.0, 2.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]);
    assert_eq!(a.colors[1], [0.0, 1.0, 0.0, 1.0]);
    let bare = load_bytes("a.obj", OBJ.as_bytes(), &LoadOptions::default()).unwrap();
    assert!(bare.attributes.is_empty());
    assert_eq!(bare.scene.meshes()[0].positions().len(), 4);
}

#[test]
fn faces_of_obj_name_what_is_there() {
    for (from, to, told) in [
        ("3/3/1", "3/9/1", "line 10: a face refers to texture coordinates 9, but there are only 3"),
        ("2/2/1", "2/2/3", "line 10: a face refers to normal 3, but there are only 2"),
        ("4//1", "4//0", "line 11: expected a vertex of the form v, v/vt, v//vn or v/vt/vn"),
        ("4//1", "4/1/1/1", "line 11: expected a vertex"),
        ("4//1", "4/-9", "line 11: expected a vertex"),
        ("vt 0.5", "vt x", "line 7: expected a texture coordinate, found \"x\""),
        ("vn 0 1 0", "vn 0 1", "line 9: expected a number of the normal"),
    ] {
        let text = OBJ.replacen(from, to, 1);
        let error = load_bytes("a.obj", text.as_bytes(), &details()).unwrap_err().to_string();
        assert!(error.contains(told), "{error} is not {told}");
    }
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                   property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float z\n\
                   property float nx\nproperty float ny\nproperty float nz\nproperty float u\n\
                   property float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
                   0 0 255 0 0 0 0 0 1 0 0.25\n1 0 0 255 0 0 0 nan 1 1 0\n0 1 0 0 188 0 0 1 0 0.5 1\n\
                   3 0 1 2\n";

#[test]
fn properties_of_ply_are_found_by_name() {
    let model = read("a.ply", PLY);
    let a = &model.attributes[0];
    assert_eq!(a.normals, [[0.0, 0.0, 1.0], [0.0; 3], [0.0, 1.0, 0.0]]);
    assert_eq!(a.uvs, [[0.0, 0.75], [1.0, 1.0], [0.5, 0.0]]);
    near(&a.colors[2..], &[[0.0, 0.0, 0.5029, 1.0]], 1e-4);
    assert!(model.warnings.iter().any(|w| w.message.starts_with("1 normals")));
}

/// A glTF in one text: two nodes below a turned one, whose mesh has all attributes, and a node that draws
/// nothing.
fn gltf(change: impl FnOnce(&mut Value)) -> String {
    let floats: &[f32] = &[
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, // positions
        0.0, 0.0, 1.0, 0.0, 0.6, 0.8, 1.0, 0.0, 0.0, // normals
        0.0, 0.0, 1.0, 0.0, 0.0, 1.0, // texture coordinates
    ];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).collect();
    bytes.extend([255, 0, 0, 0, 0, 255, 0, 0, 51, 51, 51, 0]);
    let hex: String = bytes.iter().map(|b| format!("%{b:02X}")).collect();
    let view = |at: usize, size: usize| json!({"buffer": 0, "byteOffset": at, "byteLength": size});
    let accessor = |view: usize, component: u32, kind: &str| {
        json!({"bufferView": view, "componentType": component, "type": kind, "count": 3,
               "normalized": component == 5121})
    };
    let mut colors = view(96, 12);
    colors["byteStride"] = json!(4);
    let mut root = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "house", "children": [1, 2, 3], "rotation": [0.0, 0.6, 0.0, 0.8]},
            {"name": "roof", "mesh": 0, "translation": [1.0, 2.0, 3.0]},
            {"name": "floor", "mesh": 0, "children": [4]},
            {"name": "nothing"},
            {"name": "chair", "mesh": 0, "scale": [0.5, -0.5, 0.5]},
        ],
        "meshes": [{"name": "triangle", "primitives": [{"attributes":
            {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3}}]}],
        "accessors": [accessor(0, 5126, "VEC3"), accessor(1, 5126, "VEC3"),
            accessor(2, 5126, "VEC2"), accessor(3, 5121, "VEC3")],
        "bufferViews": [view(0, 36), view(36, 36), view(72, 24), colors],
        "buffers": [{"byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream,{hex}")}],
    });
    change(&mut root);
    root.to_string()
}

fn triangle() -> Attributes {
    let fifth = 51.0 / 255.0;
    Attributes {
        normals: vec![[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [1.0, 0.0, 0.0]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        colors: vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [fifth, fifth, fifth, 1.0]],
    }
}

#[test]
fn attributes_of_gltf_survive_every_format_that_has_them() {
    let folder = Folder::new("details");
    let model = read("a.gltf", &gltf(|_| {}));
    assert_eq!(model.attributes, [triangle()]);
    let bare = load_bytes("a.gltf", gltf(|_| {}).as_bytes(), &LoadOptions::default()).unwrap();
    assert!(bare.attributes.is_empty() && bare.node_tree.locals.is_empty());
    save(&model, &folder.root().join("a.glb")).unwrap();
    let again = load(&folder.root().join("a.glb"), &details()).unwrap();
    assert_eq!(again.attributes, [triangle()]);
    assert!(again.warnings.is_empty(), "{:?}", again.warnings);
    // One instance, so that the space of the mesh is that of the world.
    let mut one = model;
    for slot in one.scene.slots().collect::<Vec<_>>() {
        let handle = one.scene.handle(slot).unwrap();
        one.scene.remove(handle).unwrap();
    }
    one.scene.add(cullet::Instance::new(0, cullet::Transform::IDENTITY)).unwrap();
    one.scene.commit(&cullet::Culler::default());
    for name in ["b.ply", "b.obj"] {
        save(&one, &folder.root().join(name)).unwrap();
        let again = load(&folder.root().join(name), &details()).unwrap();
        let (a, t) = (&again.attributes[0], triangle());
        near(&a.normals, &t.normals, 1e-6);
        near(&a.uvs, &t.uvs, 1e-6);
        // Through bytes of the screen.
        near(&a.colors, &t.colors, 0.005);
    }
}

#[test]
fn accessors_that_do_not_fit_are_named() {
    type Change = (&'static str, fn(&mut Value));
    let changes: [Change; 4] = [
        ("NORMAL has 2 elements, but POSITION has 3", |g| g["accessors"][1]["count"] = json!(2)),
        ("primitive 0, TEXCOORD_0: accessor 1 has 1x3 components", |g| {
            g["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(1);
        }),
        ("primitive 0, COLOR_0: accessor 2 has 1x2 components", |g| {
            g["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(2);
        }),
        ("NORMAL is accessor 9 of 4", |g| {
            g["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(9);
        }),
    ];
    for (told, change) in changes {
        let error = load_bytes("a.gltf", gltf(change).as_bytes(), &details()).unwrap_err();
        assert!(matches!(error.kind, ErrorKind::Invalid { .. }));
        assert!(error.to_string().contains(told), "{error} is not {told}");
    }
}

/// Name, parent and instances' transforms of each node.
fn tree(model: &Model) -> Vec<(String, Option<String>, Vec<[f64; 16]>)> {
    let tree = &model.node_tree;
    let name = |n: u32| tree.name(n);
    let drawn = |n: usize| {
        let slots = model.scene.slots().filter(move |&s| {
            let handle = model.scene.handle(s).unwrap();
            tree.node_of_instance[handle.index as usize] == n as u32
        });
        slots.map(|s| model.scene.transform(s).to_matrix()).collect()
    };
    let parent = |n: usize| {
        let parent = tree.parents[n];
        ((parent as usize) < tree.len()).then(|| name(parent))
    };
    (0..tree.len()).map(|n| (name(n as u32), parent(n), drawn(n))).collect()
}

#[test]
fn the_tree_of_nodes_is_kept() {
    let folder = Folder::new("details");
    let model = read("a.gltf", &gltf(|_| {}));
    save(&model, &folder.root().join("tree.glb")).unwrap();
    let again = load(&folder.root().join("tree.glb"), &details()).unwrap();
    let (before, after) = (tree(&model), tree(&again));
    let names: Vec<&str> = after.iter().map(|n| n.0.as_str()).collect();
    // Nodes that lead to nothing drawn are left out.
    assert_eq!(names, ["house", "roof", "floor", "chair"]);
    for node in &after {
        assert!(before.contains(node), "{node:?} is none of {before:?}");
    }
}

#[test]
fn what_moved_from_its_node_stays_where_it_is() {
    let folder = Folder::new("details");
    let mut model = read("a.gltf", &gltf(|_| {}));
    let moved = cullet::Transform::from_scale_translation([2.0; 3], [7.0, 8.0, 9.0]);
    let handles: Vec<_> = model.scene.slots().filter_map(|s| model.scene.handle(s)).collect();
    for &handle in &handles {
        model.scene.set_transform(handle, moved).unwrap();
    }
    model.scene.commit(&cullet::Culler::default());
    save(&model, &folder.root().join("moved.glb")).unwrap();
    let again = load(&folder.root().join("moved.glb"), &details()).unwrap();
    assert_eq!(again.scene.instance_count(), 3);
    for slot in again.scene.slots() {
        let (found, wanted) = (again.scene.transform(slot).to_matrix(), moved.to_matrix());
        assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
    }
    // A tree that is none loses nothing either.
    model.node_tree.parents[0] = 4;
    model.node_tree.parents[2] = 0;
    save(&model, &folder.root().join("loop.glb")).unwrap();
    assert_eq!(
        load(&folder.root().join("loop.glb"), &details()).unwrap().scene.instance_count(),
        3
    );
}
