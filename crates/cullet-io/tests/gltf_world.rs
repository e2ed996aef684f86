//! Random glTF against a reading of its own: where every triangle is, in f64.

use cullet_io::{LoadOptions, Up, load_bytes};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::glb::Glb;

/// Numbers of a seed.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        ((self.0 >> 33) % n as u64) as usize
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// Within ±`most`, exact in f32.
    fn number(&mut self, most: f64) -> f64 {
        (self.below(4001) as f64 / 2000.0 - 1.0) as f32 as f64 * most
    }

    fn vector(&mut self, most: f64) -> DVec3 {
        DVec3::new(self.number(most), self.number(most), self.number(most))
    }

    fn rotation(&mut self) -> DQuat {
        let q = DQuat::from_xyzw(self.number(1.0), self.number(1.0), self.number(1.0), 1.0);
        q.normalize()
    }

    fn affine(&mut self, far: f64) -> DAffine3 {
        let matrix3 = DMat3::from_cols(self.vector(1.5), self.vector(1.5), self.vector(1.5));
        DAffine3 { matrix3, translation: self.vector(far) }
    }
}

fn f32s(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// A mesh, as whoever looks at it needs it.
#[derive(Default)]
struct Shape {
    positions: Vec<DVec3>,
    targets: Vec<Vec<DVec3>>,
    weights: Vec<f64>,
    triangles: Vec<[usize; 3]>,
    /// Joints and their shares, vertex by vertex.
    joints: Vec<Vec<(usize, f64)>>,
}

/// Vectors in one of the many ways to write them, and what they are.
fn vectors(g: &mut Glb, dice: &mut Dice, count: usize) -> (usize, Vec<DVec3>) {
    let mut values: Vec<DVec3> = (0..count).map(|_| dice.vector(4.0)).collect();
    let stored: Vec<[f32; 3]> = values.iter().map(|&v| f32s(v)).collect();
    match dice.below(4) {
        0 => (g.floats("VEC3", &stored), values),
        1 | 2 => {
            // Sparse: over others, or over nothing, which is zero.
            let base = dice.one_in(2).then(|| g.floats("VEC3", &stored));
            if base.is_none() {
                values.fill(DVec3::ZERO);
            }
            let places: Vec<usize> = (0..count).filter(|_| dice.one_in(2)).collect();
            let news: Vec<DVec3> = places.iter().map(|_| dice.vector(4.0)).collect();
            places.iter().zip(&news).for_each(|(&place, &v)| values[place] = v);
            let mut item = json!({"componentType": 5126, "type": "VEC3", "count": count});
            if let Some(base) = base {
                item["bufferView"] = g.json["accessors"][base]["bufferView"].clone();
            }
            if !places.is_empty() {
                let bytes: Vec<u8> =
                    places.iter().flat_map(|&p| (p as u16).to_le_bytes()).collect();
                let indices = g.view(&bytes);
                let bytes: Vec<u8> =
                    news.iter().flat_map(|&v| f32s(v)).flat_map(f32::to_le_bytes).collect();
                let values = g.view(&bytes);
                item["sparse"] = json!({"count": places.len(),
                    "indices": {"bufferView": indices, "componentType": 5123},
                    "values": {"bufferView": values}});
            }
            (g.push("accessors", item), values)
        }
        _ => {
            let normalized = dice.one_in(2);
            let (component, least, most, wide) = [
                (5120, -128i32, 127, false),
                (5121, 0, 255, false),
                (5122, -32768, 32767, true),
                (5123, 0, 65535, true),
            ][dice.below(4)];
            let mut bytes = Vec::new();
            values = (0..count)
                .map(|_| {
                    let mut number = || {
                        let n = least + dice.below((most - least + 1) as usize) as i32;
                        match wide {
                            true => bytes.extend((n as u16).to_le_bytes()),
                            false => bytes.push(n as u8),
                        }
                        if normalized {
                            (f64::from(n) / f64::from(most)).max(-1.0)
                        } else {
                            n.into()
                        }
                    };
                    let v = DVec3::new(number(), number(), number());
                    bytes.resize(bytes.len().next_multiple_of(4), 0);
                    v
                })
                .collect();
            let index = g.accessor(&bytes, component, "VEC3", count);
            g.json["accessors"][index]["normalized"] = normalized.into();
            let view = g.json["accessors"][index]["bufferView"].as_u64().unwrap() as usize;
            g.json["bufferViews"][view]["byteStride"] = (if wide { 8 } else { 4 }).into();
            (index, values)
        }
    }
}

fn weights(dice: &mut Dice, count: usize) -> Vec<f64> {
    (0..count).map(|_| if dice.one_in(3) { 0.0 } else { dice.number(1.0) }).collect()
}

fn mesh(g: &mut Glb, dice: &mut Dice) -> Shape {
    let count = 3 + dice.below(6);
    let (at, positions) = vectors(g, dice, count);
    let mut shape = Shape { positions, ..Shape::default() };
    let mut attributes = json!({"POSITION": at});
    shape.triangles = (0..1 + dice.below(4)).map(|_| [0; 3].map(|_| dice.below(count))).collect();
    let corners: Vec<u16> = shape.triangles.iter().flatten().map(|&v| v as u16).collect();
    let indices = g.indices(&corners);
    let mut targets = Vec::new();
    for _ in 0..dice.below(3) {
        let (target, moved) = vectors(g, dice, count);
        targets.push(json!({"POSITION": target}));
        shape.targets.push(moved);
    }
    if dice.one_in(2) {
        shape.joints = vec![Vec::new(); count];
        for set in 0..1 + dice.below(2) {
            let joints: Vec<[u8; 4]> =
                (0..count).map(|_| [0; 4].map(|_| dice.below(3) as u8)).collect();
            let shares: Vec<[f32; 4]> =
                (0..count).map(|_| [0; 4].map(|_| dice.below(5) as f32 + 0.125)).collect();
            attributes[format!("JOINTS_{set}")] =
                g.accessor(joints.as_flattened(), 5121, "VEC4", count).into();
            attributes[format!("WEIGHTS_{set}")] = g.floats("VEC4", &shares).into();
            for ((all, j), w) in shape.joints.iter_mut().zip(joints).zip(shares) {
                all.extend(j.map(usize::from).into_iter().zip(w.map(f64::from)));
            }
        }
        for all in &mut shape.joints {
            let sum: f64 = all.iter().map(|(_, w)| w).sum();
            all.iter_mut().for_each(|(_, w)| *w /= sum);
        }
    }
    let mut item = json!({"primitives": [{"attributes": attributes, "indices": indices}]});
    if !targets.is_empty() {
        item["primitives"][0]["targets"] = targets.into();
    }
    if dice.one_in(2) {
        shape.weights = weights(dice, shape.targets.len());
        item["weights"] = shape.weights.clone().into();
    }
    g.push("meshes", item);
    shape
}

/// A node, and what it draws.
struct Node {
    local: DAffine3,
    parent: Option<usize>,
    hidden: bool,
    mesh: Option<usize>,
    weights: Option<Vec<f64>>,
    skin: Option<usize>,
    inner: Option<Vec<DAffine3>>,
}

fn local(dice: &mut Dice, item: &mut Value) -> DAffine3 {
    match dice.below(4) {
        0 => DAffine3::IDENTITY,
        1 => {
            let m = dice.affine(10.0);
            let c = |v: DVec3, w: f64| [v.x, v.y, v.z, w];
            let l = m.matrix3;
            let columns =
                [c(l.x_axis, 0.0), c(l.y_axis, 0.0), c(l.z_axis, 0.0), c(m.translation, 1.0)];
            item["matrix"] = columns.as_flattened().into();
            m
        }
        _ => {
            let (t, r, s) = (dice.vector(10.0), dice.rotation(), dice.vector(2.0));
            item["translation"] = t.to_array()[..].into();
            item["rotation"] = r.to_array()[..].into();
            item["scale"] = s.to_array()[..].into();
            DAffine3::from_scale_rotation_translation(s, r, t)
        }
    }
}

fn instancing(g: &mut Glb, dice: &mut Dice) -> (Value, Vec<DAffine3>) {
    let count = 1 + dice.below(3);
    let places: Vec<DVec3> = (0..count).map(|_| dice.vector(5.0)).collect();
    let turns: Vec<DQuat> = (0..count).map(|_| dice.rotation()).collect();
    let scales: Vec<DVec3> = (0..count).map(|_| dice.vector(2.0)).collect();
    let mut attributes = json!({});
    let has = [dice.one_in(2), dice.one_in(2)];
    let stored: Vec<[f32; 3]> = places.iter().map(|&v| f32s(v)).collect();
    attributes["TRANSLATION"] = g.floats("VEC3", &stored).into();
    if has[0] {
        let stored: Vec<[f32; 4]> = turns.iter().map(|q| q.as_quat().to_array()).collect();
        attributes["ROTATION"] = g.floats("VEC4", &stored).into();
    }
    if has[1] {
        let stored: Vec<[f32; 3]> = scales.iter().map(|&v| f32s(v)).collect();
        attributes["SCALE"] = g.floats("VEC3", &stored).into();
    }
    let inner = (0..count).map(|i| {
        let scale = if has[1] { f32s(scales[i]).map(f64::from).into() } else { DVec3::ONE };
        let turn = if has[0] { turns[i] } else { DQuat::IDENTITY };
        DAffine3::from_scale_rotation_translation(
            scale,
            turn,
            f32s(places[i]).map(f64::from).into(),
        )
    });
    (json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}}), inner.collect())
}

/// Makes a file; returns with it the corners of all triangles of each instance, in the order in
/// which a walk comes to them, and the size of all numbers that go into one.
fn world(seed: u64, up: Up) -> (Vec<u8>, Vec<Vec<[DVec3; 3]>>, f64) {
    let dice = &mut Dice(seed);
    let g = &mut Glb::new();
    let shapes: Vec<Shape> = (0..1 + dice.below(3)).map(|_| mesh(g, dice)).collect();
    let count = 1 + dice.below(7);
    let mut skins: Vec<(Vec<usize>, Vec<DAffine3>)> = Vec::new();
    for _ in 0..2 {
        let joints: Vec<usize> = (0..3).map(|_| dice.below(count)).collect();
        let mut item = json!({"joints": joints});
        let mut binds = vec![DAffine3::IDENTITY; 3];
        if dice.one_in(2) {
            binds.fill_with(|| dice.affine(4.0));
            let matrix = |m: &DAffine3| glam::DMat4::from(*m).as_mat4().to_cols_array();
            let stored: Vec<[f32; 16]> = binds.iter().map(matrix).collect();
            item["inverseBindMatrices"] = g.floats("MAT4", &stored).into();
        }
        g.push("skins", item);
        skins.push((joints, binds));
    }
    let mut nodes: Vec<Node> = Vec::new();
    for i in 0..count {
        let mut item = json!({});
        let local = local(dice, &mut item);
        let parent = (i > 0 && !dice.one_in(3)).then(|| dice.below(i));
        let mesh = (!dice.one_in(4)).then(|| dice.below(shapes.len()));
        let mut node = Node {
            local,
            parent,
            hidden: dice.one_in(12),
            mesh,
            weights: None,
            skin: None,
            inner: None,
        };
        if let Some(mesh) = mesh {
            item["mesh"] = mesh.into();
            if dice.one_in(3) {
                let own = weights(dice, shapes[mesh].targets.len());
                item["weights"] = own.clone().into();
                node.weights = Some(own);
            }
            if dice.one_in(2) {
                let skin = dice.below(2);
                item["skin"] = skin.into();
                // A mesh without joints is not moved by any.
                node.skin = Some(skin).filter(|_| !shapes[mesh].joints.is_empty());
            } else if dice.one_in(3) {
                let (extension, inner) = instancing(g, dice);
                item["extensions"] = extension;
                node.inner = Some(inner);
            }
        }
        if node.hidden {
            item["extensions"]["KHR_node_visibility"] = json!({"visible": false});
        }
        g.push("nodes", item);
        nodes.push(node);
    }
    for (i, node) in nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            let parent = &mut g.json["nodes"][parent];
            if parent["children"].is_null() {
                parent["children"] = json!([]);
            }
            parent["children"].as_array_mut().unwrap().push(i.into());
        }
    }
    let mut roots: Vec<usize> = (0..count).filter(|&i| nodes[i].parent.is_none()).collect();
    if dice.one_in(2) {
        roots.reverse();
        g.json["scenes"] = json!([{"nodes": []}, {"nodes": roots}]);
        g.json["scene"] = 1.into();
    }
    let mut base = DAffine3::IDENTITY;
    if dice.one_in(3) {
        base.translation = dice.vector(6e6);
        g.json["extensions"] = json!({"CESIUM_RTC": {"center": base.translation.to_array()}});
    }
    if up == Up::Z {
        base = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y)) * base;
    }
    let bytes = std::mem::replace(g, Glb::new()).finish();
    let (all, size) = look(&shapes, &skins, &nodes, roots, base);
    (bytes, all, size)
}

/// The oracle.
fn look(
    shapes: &[Shape],
    skins: &[(Vec<usize>, Vec<DAffine3>)],
    nodes: &[Node],
    roots: Vec<usize>,
    base: DAffine3,
) -> (Vec<Vec<[DVec3; 3]>>, f64) {
    let global = |mut at: usize| {
        let mut m = nodes[at].local;
        while let Some(parent) = nodes[at].parent {
            (m, at) = (nodes[parent].local * m, parent);
        }
        base * m
    };
    let mut size = 1.0f64;
    let mut all = Vec::new();
    let mut stack: Vec<usize> = roots.into_iter().rev().collect();
    while let Some(at) = stack.pop() {
        let node = &nodes[at];
        if node.hidden {
            continue;
        }
        stack.extend((0..nodes.len()).rev().filter(|&i| nodes[i].parent == Some(at)));
        let Some(mesh) = node.mesh else { continue };
        let shape = &shapes[mesh];
        let weights = node.weights.as_ref().unwrap_or(&shape.weights);
        let morphed: Vec<DVec3> = (0..shape.positions.len())
            .map(|v| {
                let pulls = shape.targets.iter().zip(weights);
                pulls.fold(shape.positions[v], |p, (target, &w)| p + target[v] * w)
            })
            .collect();
        for inner in node.inner.as_deref().unwrap_or(&[DAffine3::IDENTITY]) {
            let place = global(at) * *inner;
            let mut vertex = |v: usize| {
                let p = morphed[v];
                let mut measure = |m: &DAffine3, p: DVec3| {
                    size = size.max(m.matrix3.x_axis.length() * p.length() * 3.0);
                    size = size.max((m.translation - base.translation).length());
                    size = size.max(p.length());
                };
                let Some(skin) = node.skin else {
                    measure(&place, p);
                    return place.transform_point3(p);
                };
                let (joints, binds) = &skins[skin];
                shape.joints[v].iter().fold(DVec3::ZERO, |sum, &(j, w)| {
                    let bound = binds[j].transform_point3(p);
                    let joint = global(joints[j]);
                    measure(&joint, bound.abs() + binds[j].translation.abs());
                    sum + joint.transform_point3(bound) * w
                })
            };
            all.push(shape.triangles.iter().map(|t| t.map(&mut vertex)).collect());
        }
    }
    (all, size)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cullet_testkit::cases(1000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_triangle_of_a_random_file_is_where_the_oracle_has_it(seed: u64, z_up: bool) {
        let up = if z_up { Up::Z } else { Up::Y };
        let (bytes, expected, size) = world(seed, up);
        let options = LoadOptions { up: Some(up), ..LoadOptions::default() };
        let model = load_bytes("random.glb", &bytes, &options).unwrap();
        let scene = &model.scene;
        prop_assert_eq!(scene.instance_count() as usize, expected.len());
        let most = 2e-6 * size;
        let mut corners = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for slot in scene.slots() {
            let expected = &expected[scene.handle(slot).unwrap().index as usize];
            let mesh = scene.mesh(slot);
            let m = glam::DMat4::from_cols_array(&scene.transform(slot).to_matrix());
            let bounds = scene.bounds(slot);
            prop_assert!(bounds.is_finite());
            prop_assert_eq!(mesh.triangle_count() as usize, expected.len());
            for t in 0..mesh.triangle_count() {
                let original = expected[mesh.original_triangle()[t as usize] as usize];
                for (corner, expected) in mesh.corners(t).into_iter().zip(original) {
                    let found = m.transform_point3(corner.map(f64::from).into());
                    let off = found.distance(expected);
                    prop_assert!(off <= most, "{found} is not {expected}, of {size}");
                    if t >= mesh.triangle_count() - mesh.degenerate_count() {
                        continue;
                    }
                    corners = [corners[0].min(expected), corners[1].max(expected)];
                    let at = expected - DVec3::from(scene.origin());
                    let low = DVec3::from(bounds.min.map(f64::from)) - most;
                    let high = DVec3::from(bounds.max.map(f64::from)) + most;
                    prop_assert!(at.cmpge(low).all() && at.cmple(high).all(), "out of bounds");
                }
            }
        }
        if let Some([low, high]) = cullet_io::extent(scene) {
            // Meshes that are all degenerate are a point at their origin.
            let all_drawn = scene.slots().all(|s| !scene.mesh(s).clusters().is_empty());
            let near = |a: [f64; 3], b: DVec3| DVec3::from(a).distance(b) <= most;
            prop_assert!(!all_drawn || near(low, corners[0]) && near(high, corners[1]));
        }
    }
}
