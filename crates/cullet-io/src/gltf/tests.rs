//! Whole documents, loaded.

use cullet::Projection;
use cullet::mesh::Alpha;
use serde_json::{Value, json};

use crate::{ErrorKind, LoadOptions, Model, Up};

/// Loads a file that is all in memory.
fn load_gltf_from_memory(bytes: &[u8], options: &LoadOptions) -> Result<Model, ErrorKind> {
    super::decode(bytes, crate::beside::Beside::Given(&[]), options, true)?.into_model()
}

/// A GLB under construction.
struct GltfBuilder {
    json: Value,
    bin: Vec<u8>,
}

impl GltfBuilder {
    fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "meshes": [],
            "nodes": [], "materials": [], "cameras": [], "animations": [], "skins": [],
        });
        Self { json, bin: Vec::new() }
    }

    fn push(&mut self, array: &str, item: Value) -> usize {
        let items = self.json[array].as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend(bytes);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}),
        )
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
        )
    }

    fn floats<const N: usize>(&mut self, kind: &str, v: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = v.as_flattened().iter().flat_map(|f| f.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, kind, v.len())
    }

    fn positions(&mut self, v: &[[f32; 3]]) -> usize {
        self.floats("VEC3", v)
    }

    fn mesh(&mut self, primitives: Value) -> usize {
        self.push("meshes", json!({"primitives": primitives}))
    }

    /// A mesh of one triangle.
    fn triangle(&mut self) -> usize {
        let positions = self.positions(&TRIANGLE);
        self.mesh(json!([{"attributes": {"POSITION": positions}}]))
    }

    fn node(&mut self, node: Value) -> usize {
        self.push("nodes", node)
    }

    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        if !bin.is_empty() && json["buffers"].is_null() {
            json["buffers"] = json!([{"byteLength": bin.len()}]);
        }
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((20 + text.len() as u32 + 8 + bin.len() as u32).to_le_bytes());
        out.extend((text.len() as u32).to_le_bytes());
        out.extend(b"JSON");
        out.extend(&text);
        out.extend((bin.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(&bin);
        out
    }

    fn load(&self) -> Result<Model, ErrorKind> {
        load_gltf_from_memory(&self.glb(), &LoadOptions::default())
    }

    fn error(&self) -> String {
        self.load().unwrap_err().to_string()
    }
}

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn warned(model: &Model, part: &str) -> bool {
    model.warnings.iter().any(|w| w.to_string().contains(part))
}

#[test]
fn a_mesh_of_two_nodes_is_one_mesh_with_two_instances() {
    let mut b = GltfBuilder::new();
    let mesh = b.triangle();
    let child = b.node(json!({"mesh": mesh, "translation": [1, 0, 0]}));
    b.node(json!({"mesh": mesh, "name": "top", "children": [child], "scale": [-2, 2, 2], "translation": [0, 1e7, 0]}));
    let model = b.load().unwrap();
    assert_eq!(model.scene.meshes().len(), 1);
    assert_eq!(model.instance_names, ["top", "node 0"]);
    assert_eq!(model.mesh_names, ["mesh 0"]);
    let is_second = |slot: &u32| model.scene.handle(*slot).is_some_and(|h| h.index == 1);
    let t = model.scene.transform(model.scene.slots().find(is_second).unwrap());
    // Composed in f64: f32 would lose the 2 beside 1e7.
    assert_eq!(t.translation, [-2.0, 1e7, 0.0]);
    assert!(t.determinant() < 0.0, "mirrors stay mirrors");
    let part = model.scene.meshes()[0].parts()[0];
    assert!(!part.two_sided, "the default of glTF is one-sided");
    assert_eq!(model.materials[part.material as usize].name, "default");
}

#[test]
fn indices_of_every_type_and_parts_of_every_material() {
    let mut b = GltfBuilder::new();
    let square = b.positions(&[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
    let u8s = b.accessor(&[0, 1, 2], 5121, "SCALAR", 3);
    let u16s = b.accessor(&[0, 0, 2, 0, 3, 0], 5123, "SCALAR", 3);
    let u32s = b.accessor(&[3, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0], 5125, "SCALAR", 3);
    let opaque = b.push(
        "materials",
        json!({"doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}),
    );
    let mask = b.push("materials", json!({"alphaMode": "MASK", "name": "leaf"}));
    let glass = b.push(
        "materials",
        json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.9}}}),
    );
    let attributes = json!({"POSITION": square});
    let mesh = b.mesh(json!([
        {"attributes": attributes, "indices": u8s, "material": opaque},
        {"attributes": attributes, "indices": u16s, "material": mask},
        {"attributes": attributes, "mode": 0},
        {"attributes": attributes, "indices": u32s, "material": glass},
    ]));
    b.node(json!({"mesh": mesh}));
    let model = b.load().unwrap();
    let mesh = &model.scene.meshes()[0];
    assert_eq!(mesh.positions().len(), 4, "primitives of a mesh share vertices");
    let mut triangles: Vec<(u32, [u32; 3])> =
        (0..3).map(|t| (mesh.original_triangle()[t as usize], mesh.triangle(t))).collect();
    triangles.sort_unstable();
    assert_eq!(triangles, [(0, [0, 1, 2]), (1, [0, 2, 3]), (2, [3, 1, 2])]);
    let parts: Vec<_> = mesh.parts().iter().map(|p| (p.material, p.two_sided, p.alpha)).collect();
    let expected =
        [(0, true, Alpha::Opaque), (1, false, Alpha::Masked), (2, false, Alpha::Blended)];
    assert_eq!(parts, expected);
    assert_eq!(model.materials[0].color, [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(model.materials.len(), 3);
    assert!(warned(&model, "primitive 2: is of points"));
    assert!(warned(&model, "lets light through"));
}

#[test]
fn quantised_interleaved_and_sparse_positions() {
    let mut b = GltfBuilder::new();
    // Three positions of normalised i16, each with two bytes of padding; then u8 as they are.
    let i16s = [[0, 0, 0, 7], [32767, 0, 0, 7], [0, -32768, 0, 7i16]];
    let bytes: Vec<u8> = i16s.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let a = b.accessor(&bytes, 5122, "VEC3", 3);
    b.json["accessors"][a]["normalized"] = true.into();
    b.json["bufferViews"][0]["byteStride"] = 8.into();
    let u8s = b.accessor(&[0, 0, 0, 9, 200, 0, 0, 9, 0, 200, 0, 9], 5121, "VEC3", 3);
    let view = b.json["accessors"][u8s]["bufferView"].as_u64().unwrap() as usize;
    b.json["bufferViews"][view]["byteStride"] = 4.into();
    // All zeros but for two elements.
    let at = b.view(&[1, 2]);
    let values = b
        .view(&[4f32, 0., 0., 0., 5., 0.].iter().flat_map(|f| f.to_le_bytes()).collect::<Vec<_>>());
    let sparse = b.push(
        "accessors",
        json!({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": {
            "count": 2, "indices": {"bufferView": at, "componentType": 5121},
            "values": {"bufferView": values}}}),
    );
    for positions in [a, u8s, sparse] {
        let mesh = b.mesh(json!([{"attributes": {"POSITION": positions}}]));
        b.node(json!({"mesh": mesh}));
    }
    let model = b.load().unwrap();
    let got: Vec<&[[f32; 3]]> = model.scene.meshes().iter().map(cullet::Mesh::positions).collect();
    assert_eq!(got[0], [[0., 0., 0.], [1., 0., 0.], [0., -1., 0.]]);
    assert_eq!(got[1], [[0., 0., 0.], [200., 0., 0.], [0., 200., 0.]]);
    assert_eq!(got[2], [[0., 0., 0.], [4., 0., 0.], [0., 5., 0.]]);
}

#[test]
fn packed_geometry_is_the_geometry() {
    let points: Vec<[f32; 3]> =
        (0..100).map(|i| [(i % 10) as f32, (i / 10) as f32, (i * i % 17) as f32]).collect();
    let list: Vec<u32> = (0..9)
        .flat_map(|y| (0..9).map(move |x| y * 10 + x))
        .flat_map(|v| [v, v + 1, v + 10, v + 1, v + 11, v + 10])
        .collect();
    let mut b = GltfBuilder::new();
    let packed = [
        (meshopt::encode_vertex_buffer_level(&points, 2, Some(0)).unwrap(), 12, 100, "ATTRIBUTES"),
        (meshopt::encode_index_buffer(&list, 100).unwrap(), 4, list.len(), "TRIANGLES"),
    ];
    for (bytes, stride, count, mode) in &packed {
        let view = b.view(bytes);
        let inner = json!({"buffer": 0, "byteOffset": b.json["bufferViews"][view]["byteOffset"],
            "byteLength": bytes.len(), "byteStride": stride, "count": count, "mode": mode});
        b.json["bufferViews"][view] = json!({"buffer": 1, "byteLength": stride * count,
            "extensions": {"EXT_meshopt_compression": inner}});
    }
    let a = b.push(
        "accessors",
        json!({"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 100}),
    );
    let i = b.push(
        "accessors",
        json!({"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": list.len()}),
    );
    let mesh = b.mesh(json!([{"attributes": {"POSITION": a}, "indices": i}]));
    b.node(json!({"mesh": mesh}));
    let len = b.bin.len();
    b.json["buffers"] = json!([{"byteLength": len}, {"byteLength": 4000,
        "extensions": {"EXT_meshopt_compression": {"fallback": true}}}]);
    b.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    let check = |b: &GltfBuilder| {
        let model = b.load().unwrap();
        let mesh = &model.scene.meshes()[0];
        assert_eq!(mesh.positions(), points);
        assert_eq!(mesh.triangle_count(), 162);
    };
    check(&b);
    // Nobody who unpacks needs the bytes of the fallback, wherever they are said to be.
    b.json["buffers"][1]["uri"] = "gone.fallback.bin".into();
    check(&b);
    // The other extension of the same form, with another name.
    let views = b.json["bufferViews"].to_string();
    b.json["bufferViews"] = serde_json::from_str(&views.replace("EXT_mesh", "KHR_mesh")).unwrap();
    b.json["extensionsRequired"] = json!(["KHR_meshopt_compression"]);
    check(&b);
    b.json["bufferViews"] = serde_json::from_str(&views).unwrap();
    b.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    // A count that the compressed bytes cannot hold is refused before it is allocated.
    b.json["buffers"][1]["byteLength"] = 4_000_000_000_000u64.into();
    b.json["bufferViews"][0]["byteLength"] = 1_200_000_000_000u64.into();
    b.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["count"] =
        100_000_000_000u64.into();
    assert!(b.error().contains("compressed bytes or more"), "{}", b.error());
}

#[test]
fn gpu_instancing_places_below_the_node() {
    let mut b = GltfBuilder::new();
    let mesh = b.triangle();
    let t = b.positions(&[[1., 0., 0.], [0., 2., 0.]]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let r = b.floats("VEC4", &[[0., 0., 0., 1.], [0., half, 0., half]]);
    let s = b.positions(&[[1., 1., 1.], [3., 3., 3.]]);
    b.node(json!({"mesh": mesh, "name": "tree", "translation": [10, 0, 0], "extensions": {
        "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": t, "ROTATION": r, "SCALE": s}}}}));
    b.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let model = b.load().unwrap();
    assert_eq!(model.instance_names, ["tree[0]", "tree[1]"]);
    assert_eq!(model.scene.transform(0).translation, [11.0, 0.0, 0.0]);
    let second = model.scene.transform(1);
    assert_eq!(second.translation, [10.0, 2.0, 0.0]);
    // A quarter turn about y sends x to −z, three times as long.
    assert!((second.linear[0][2] + 3.0).abs() < 1e-5, "{second:?}");

    let options = LoadOptions { max_instances: 1, ..LoadOptions::default() };
    let error = load_gltf_from_memory(&b.glb(), &options).unwrap_err();
    assert_eq!(error.to_string(), "instances: 2 exceeds the limit of 1");
    b.json["accessors"][s]["count"] = 1.into();
    assert!(b.error().contains("has 1 elements, another 2"), "{}", b.error());
}

#[test]
fn z_up_turns_transforms_not_vertices() {
    let mut b = GltfBuilder::new();
    let mesh = b.triangle();
    b.node(json!({"mesh": mesh, "translation": [1, 2, 3]}));
    let options = LoadOptions { up: Some(Up::Z), ..LoadOptions::default() };
    let model = load_gltf_from_memory(&b.glb(), &options).unwrap();
    assert_eq!(model.scene.transform(0).translation, [1.0, 3.0, -2.0]);
    assert!(model.scene.transform(0).determinant() > 0.0);
    assert_eq!(model.scene.meshes()[0].positions()[2], TRIANGLE[2]);
}

#[test]
fn only_the_scene_that_was_chosen() {
    let mut b = GltfBuilder::new();
    let mesh = b.triangle();
    for name in ["a", "b", "c"] {
        b.node(json!({"mesh": mesh, "name": name}));
    }
    let names = |b: &GltfBuilder| b.load().unwrap().instance_names;
    assert_eq!(names(&b), ["a", "b", "c"]);
    b.json["scenes"] = json!([{"nodes": [1]}, {"nodes": [2, 0]}]);
    assert_eq!(names(&b), ["b"]);
    b.json["scene"] = 1.into();
    assert_eq!(names(&b), ["c", "a"]);
    b.json["nodes"][2]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    assert_eq!(names(&b), ["a"]);
}

#[test]
fn meshes_that_share_vertices_get_their_own() {
    let mut b = GltfBuilder::new();
    let shared = b.positions(&[
        [0.; 3],
        [1., 0., 0.],
        [0., 1., 0.],
        [9., 9., 9.],
        [8., 9., 9.],
        [9., 8., 9.],
    ]);
    let first = b.accessor(&[2, 0, 1], 5121, "SCALAR", 3);
    let second = b.accessor(&[3, 4, 5, 5, 4, 3], 5121, "SCALAR", 6);
    for indices in [first, second] {
        let mesh = b.mesh(json!([{"attributes": {"POSITION": shared}, "indices": indices}]));
        b.node(json!({"mesh": mesh}));
    }
    let model = b.load().unwrap();
    let [a, c] = model.scene.meshes() else { panic!() };
    assert_eq!(a.positions(), [[0., 1., 0.], [0., 0., 0.], [1., 0., 0.]]);
    assert_eq!(a.corners(0), [[0., 1., 0.], [0., 0., 0.], [1., 0., 0.]]);
    assert_eq!(c.positions(), [[9., 9., 9.], [8., 9., 9.], [9., 8., 9.]]);
    assert_eq!(c.triangle_count(), 2);
}

#[test]
fn a_bad_vertex_is_named_and_a_bad_transform_kept() {
    let mut b = GltfBuilder::new();
    let positions = b.positions(&[[0.; 3], [1., f32::NAN, 0.], [0., 1., 0.]]);
    let mesh = b.push(
        "meshes",
        json!({"name": "Wall", "primitives": [{"attributes": {"POSITION": positions}}]}),
    );
    b.node(json!({"mesh": mesh}));
    let error = b.error();
    assert!(
        error.starts_with("mesh 0 `Wall`, primitive 0: vertex 1 is [1.0, NaN, 0.0]"),
        "{error}"
    );

    let mut b = GltfBuilder::new();
    let mesh = b.triangle();
    b.node(json!({"mesh": mesh, "name": "far", "translation": [7, 0, 0]}));
    // serde_json writes no number beyond f64, so the text is patched.
    b.json["nodes"][0]["translation"] = json!([70_007, 0, 0]);
    let mut bytes = b.glb();
    let at = bytes.windows(5).position(|w| w == b"70007").unwrap();
    bytes[at..at + 5].copy_from_slice(b"1e999");
    let model = load_gltf_from_memory(&bytes, &LoadOptions::default()).unwrap();
    assert!(model.scene.flags(0).always_visible);
    assert_eq!(model.scene.bounds(0), cullet::bounds::Aabb::EVERYTHING);
    assert!(warned(&model, "far: has a transform that is not finite"));
}

#[test]
fn skinned_and_morphed_meshes_may_deform() {
    let mut b = GltfBuilder::new();
    let positions = b.positions(&TRIANGLE);
    let joints = b.accessor(&[0; 12], 5121, "VEC4", 3);
    let skinned = b.mesh(json!([{"attributes": {"POSITION": positions, "JOINTS_0": joints}}]));
    let morphed = b.mesh(
        json!([{"attributes": {"POSITION": positions}, "targets": [{"POSITION": positions}]}]),
    );
    let plain = b.triangle();
    b.push("skins", json!({"joints": [1]}));
    b.node(json!({"mesh": skinned, "skin": 0, "translation": [9, 9, 9]}));
    b.node(json!({"mesh": morphed, "translation": [0, 0, 5]}));
    b.node(json!({"mesh": plain, "skin": 0, "translation": [7, 0, 0]}));
    let model = b.load().unwrap();
    let is_deformable: Vec<bool> =
        model.scene.meshes().iter().map(cullet::Mesh::is_deformable).collect();
    assert_eq!(is_deformable, [true, true, false]);
    // The skin is where its joint is, not where its node is; what has no joints is at its node.
    let min = |index| {
        let slot = (model.scene.slots()).find(|&s| model.scene.handle(s).unwrap().index == index);
        model.scene.bounds(slot.unwrap()).min.map(f32::round)
    };
    assert_eq!(min(0), [0.0, 0.0, 5.0]);
    assert_eq!(min(1), [0.0, 0.0, 5.0]);
    assert_eq!(min(2), [7.0, 0.0, 0.0]);
    assert!(!warned(&model, "node 0"), "{:?}", model.warnings);
    assert!(warned(&model, "node 2: is skinned, but drawn where the node is"));
}

#[test]
fn cameras_stand_or_move_with_their_ancestors() {
    let mut b = GltfBuilder::new();
    b.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}));
    b.push("cameras", json!({"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0, "zfar": 9}}));
    b.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 9.0, "znear": 0.1}}));
    let eye = b.node(json!({"camera": 0, "name": "eye", "translation": [0, 0, 5]}));
    let arm = b.node(json!({"children": [eye], "name": "arm"}));
    b.node(json!({"children": [arm], "scale": [2, 2, 2]}));
    b.node(json!({"camera": 1}));
    b.node(json!({"camera": 2, "name": "wide"}));
    let times = b.floats("SCALAR", &[[0f32], [1.0], [2.0]]);
    let s = std::f32::consts::FRAC_1_SQRT_2;
    let turns = b.floats("VEC4", &[[0., 0., 0., 1.], [0., s, 0., s], [0., 1., 0., 0.]]);
    let jump_times = b.floats("SCALAR", &[[0.5f32], [1.5]]);
    let jumps = b.positions(&[[0., 0., 5.], [0., 0., 10.]]);
    b.push(
        "animations",
        json!({"name": "swing", "channels": [
            {"sampler": 0, "target": {"node": arm, "path": "rotation"}},
            {"sampler": 1, "target": {"node": eye, "path": "translation"}},
            {"sampler": 9, "target": {"node": eye, "path": "scale"}},
            {"sampler": 0, "target": {"path": "pointer"}},
        ], "samplers": [
            {"input": times, "output": turns},
            {"input": jump_times, "output": jumps, "interpolation": "STEP"},
        ]}),
    );
    let model = b.load().unwrap();
    let [moving, still] = &model.cameras[..] else { panic!("{:?}", model.cameras) };
    assert_eq!(moving.name, "eye");
    let expected =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 0.0, near: 0.1, far: f64::INFINITY };
    assert_eq!(moving.projection, expected);
    let at: Vec<(f64, [f64; 3])> = moving
        .keys
        .iter()
        .map(|(t, m)| (*t, m.translation.map(|v| (v * 1e4).round() / 1e4)))
        .collect();
    let diagonal = |r: f64, t: f64| {
        let a = t * std::f64::consts::FRAC_PI_2;
        [r * a.sin(), 0.0, r * a.cos()].map(|v| (v * 1e4).round() / 1e4)
    };
    let before = 1.5f64.next_down();
    let expected = [
        (0.0, diagonal(10.0, 0.0)),
        (0.5, diagonal(10.0, 0.5)),
        (1.0, diagonal(10.0, 1.0)),
        (before, diagonal(10.0, 1.5)),
        (1.5, diagonal(20.0, 1.5)),
        (2.0, diagonal(20.0, 2.0)),
    ];
    for (got, want) in at.iter().zip(expected) {
        assert_eq!(got.0, want.0);
        assert!((0..3).all(|i| (got.1[i] - want.1[i]).abs() < 2e-3), "{got:?} {want:?}");
    }
    assert_eq!(at.len(), expected.len());
    assert_eq!(still.keys.len(), 1);
    let Projection::Orthographic { left, top, .. } = still.projection else { panic!() };
    assert_eq!((left, top), (-2.0, 1.0));
    assert!(warned(&model, "wide: is a camera whose numbers"));
    assert!(warned(&model, "channel 2: names a sampler"));
}

#[test]
fn a_deep_chain_of_nodes_is_no_recursion() {
    let mut b = GltfBuilder::new();
    let mesh = b.triangle();
    let depth = 50_000;
    let mut nodes: Vec<Value> = (1..depth).map(|i| json!({"children": [i]})).collect();
    nodes.push(json!({"mesh": mesh, "translation": [0, 0, 1]}));
    b.json["nodes"] = nodes.into();
    let model = b.load().unwrap();
    assert_eq!(model.scene.instance_count(), 1);
    let last = b.json["nodes"].as_array().unwrap().len() - 1;
    b.json["nodes"][last]["children"] = json!([0]);
    assert!(b.error().contains("loop"));
}

#[test]
fn counts_that_the_file_cannot_back_are_refused() {
    let mut b = GltfBuilder::new();
    let mesh = b.triangle();
    b.node(json!({"mesh": mesh}));
    for count in [4u64, 1 << 40, u64::MAX] {
        b.json["accessors"][0]["count"] = count.into();
        assert!(b.error().starts_with("accessor 0: "), "{}", b.error());
    }
    b.json["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": 1u64 << 24});
    assert!(b.error().contains("bytes of zeros"), "{}", b.error());
    let options = LoadOptions { max_triangles: 0, ..LoadOptions::default() };
    b.json["accessors"][0]["count"] = 3.into();
    let error = load_gltf_from_memory(&b.glb(), &options).unwrap_err().to_string();
    assert_eq!(error, "triangles of all meshes: 1 exceeds the limit of 0");
}

#[test]
fn draco_is_refused_with_the_way_out_unless_there_is_a_fallback() {
    let mut b = GltfBuilder::new();
    let mesh = b.triangle();
    b.node(json!({"mesh": mesh}));
    b.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}});
    assert_eq!(b.load().unwrap().scene.triangle_count(), 1);
    b.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(b.error().contains("gltf-transform"), "{}", b.error());
    b.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    assert!(matches!(b.load(), Err(ErrorKind::Unsupported(_))));
}

#[test]
fn bounds_that_lie_are_noted() {
    let mut b = GltfBuilder::new();
    let mesh = b.triangle();
    b.node(json!({"mesh": mesh}));
    b.json["accessors"][0]["min"] = json!([0, 0, 0]);
    b.json["accessors"][0]["max"] = json!([1, 1, 0]);
    assert_eq!(b.load().unwrap().warnings.iter().filter(|w| w.item == "accessor 0").count(), 0);
    b.json["accessors"][0]["max"] = json!([0.5, 1, 0]);
    assert!(warned(&b.load().unwrap(), "1 vertices lie outside its min and max"));
}

#[test]
fn buffers_of_other_files_are_not_read_from_memory() {
    let mut b = GltfBuilder::new();
    b.json["buffers"] = json!([{"uri": "x.bin", "byteLength": 4}]);
    assert!(b.error().contains("x.bin"), "{}", b.error());
}
