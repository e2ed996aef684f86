//! GLBs that move, made here: small enough to know where every vertex must be.

use serde_json::json;

use crate::glb::Glb;

/// Rings of a square tube about y, half a unit wide, at these heights, closed at both ends.
fn tube(heights: &[f32]) -> (Vec<[f32; 3]>, Vec<u16>) {
    let corner = |y: f32| [[-0.25, y, -0.25], [-0.25, y, 0.25], [0.25, y, 0.25], [0.25, y, -0.25]];
    let positions: Vec<[f32; 3]> = heights.iter().flat_map(|&y| corner(y)).collect();
    let mut indices = vec![0, 2, 1, 0, 3, 2];
    for ring in 0..heights.len() as u16 - 1 {
        for side in 0..4 {
            let (a, b) = (ring * 4 + side, ring * 4 + (side + 1) % 4);
            indices.extend([a, b, b + 4, a, b + 4, a + 4]);
        }
    }
    let top = heights.len() as u16 * 4 - 4;
    indices.extend([top, top + 1, top + 2, top, top + 2, top + 3]);
    (positions, indices)
}

const OCTAHEDRON: [[f32; 3]; 6] =
    [[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
const FACES: [u16; 24] = [0, 2, 4, 4, 2, 1, 1, 2, 5, 5, 2, 0, 4, 3, 0, 1, 3, 4, 5, 3, 1, 0, 3, 5];

/// For 4 s: `bar`, at x = 10, is 4 high and bends at its middle to the left and back, skinned; `blob`, an
/// octahedron at 0, has its top pulled up by 3 and let go, by cubic weights; `twin`, at z = 8, is the same
/// mesh, half pulled; `both`, at x = -10, is the bar with its top third pulled up as well; `cart`, at
/// x = 20, jumps by 6 at 2 s, below a node that does.
pub(crate) fn figures() -> Vec<u8> {
    let mut g = Glb::new();
    let heights = [0.0, 1.0, 2.0, 3.0, 4.0];
    let (positions, indices) = tube(&heights);
    let pulls: Vec<[f32; 3]> =
        positions.iter().map(|p| [0.0, if p[1] > 3.5 { 1.5 } else { 0.0 }, 0.0]).collect();
    // The ring at the bend is shared; the weights of the file add to 2, as careless programs have it.
    let mut joints = Vec::new();
    let mut weights = Vec::new();
    for p in &positions {
        joints.extend([0u8, 1, 0, 0]);
        let upper = (p[1] - 1.5).clamp(0.0, 1.0);
        weights.push([2.0 - 2.0 * upper, 2.0 * upper, 0.0, 0.0]);
    }
    let at = g.floats("VEC3", &positions);
    let pull = g.floats("VEC3", &pulls);
    let joints = g.accessor(&joints, 5121, "VEC4", positions.len());
    let weights = g.floats("VEC4", &weights);
    let corners = g.indices(&indices);
    let skinned = json!({"POSITION": at, "JOINTS_0": joints, "WEIGHTS_0": weights});
    let bar =
        g.push("meshes", json!({"primitives": [{"attributes": skinned, "indices": corners}]}));
    let both = g.push(
        "meshes",
        json!({"primitives": [{"attributes": skinned, "indices": corners, "targets": [{"POSITION": pull}]}]}),
    );
    let points = g.floats("VEC3", &OCTAHEDRON);
    let lifted =
        g.floats("VEC3", &OCTAHEDRON.map(|p| [0.0, if p[1] > 0.5 { 3.0 } else { 0.0 }, 0.0]));
    let faces = g.indices(&FACES);
    let blob = g.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": points}, "indices": faces, "targets": [{"POSITION": lifted}]}]}),
    );
    let cart = g.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": points}, "indices": faces}]}),
    );
    // Joint 1 is bound at the bend.
    let mut binds = [[0.0f32; 16]; 2];
    binds.iter_mut().for_each(|m| (0..4).for_each(|i| m[i * 5] = 1.0));
    binds[1][13] = -2.0;
    let binds = g.floats("MAT4", &binds);
    let mut elbows = Vec::new();
    for (name, mesh, x) in [("bar", bar, 10.0), ("both", both, -10.0)] {
        let elbow = g.push("nodes", json!({"translation": [0, 2, 0]}));
        let root = g.push("nodes", json!({"translation": [x, 0, 0], "children": [elbow]}));
        let skin = g.push("skins", json!({"joints": [root, elbow], "inverseBindMatrices": binds}));
        // The place of a skinned node does not matter.
        let node = json!({"name": name, "mesh": mesh, "skin": skin, "translation": [99, 99, 99]});
        elbows.push((elbow, g.push("nodes", node)));
    }
    let blob_node = g.push("nodes", json!({"name": "blob", "mesh": blob}));
    g.push(
        "nodes",
        json!({"name": "twin", "mesh": blob, "weights": [0.5], "translation": [0, 0, 8]}),
    );
    let cart = g.push("nodes", json!({"name": "cart", "mesh": cart, "translation": [1, 0, 0]}));
    let rail = g.push("nodes", json!({"children": [cart]}));

    let half = std::f32::consts::FRAC_1_SQRT_2;
    let four = g.floats("SCALAR", &[[0f32], [1.0], [3.0], [4.0]]);
    let turn = |s: f32, w: f32| [0.0, 0.0, s, w];
    // The length of the third is not 1, and its sign is that of the longer way.
    let turns = [turn(0., 1.), turn(half, half), turn(half * 1.5, -half * 1.5), turn(0., 1.)];
    let turns = g.floats("VEC4", &turns);
    let three = g.floats("SCALAR", &[[0f32], [2.0], [4.0]]);
    let pulled = g.floats("SCALAR", &[0f32, 0., 0., 0., 1., 0., 0., 0., 0.].map(|v| [v]));
    let straight = g.floats("SCALAR", &[0f32, 1., 0.].map(|v| [v]));
    let jumps = g.floats("VEC3", &[[20., 0., 0.], [26., 0., 0.], [20., 0., 0.]]);
    let mut channels = vec![
        json!({"sampler": 1, "target": {"node": blob_node, "path": "weights"}}),
        json!({"sampler": 2, "target": {"node": elbows[1].1, "path": "weights"}}),
        json!({"sampler": 3, "target": {"node": rail, "path": "translation"}}),
    ];
    for (elbow, _) in &elbows {
        channels.push(json!({"sampler": 0, "target": {"node": elbow, "path": "rotation"}}));
    }
    g.push(
        "animations",
        json!({"channels": channels, "samplers": [
            {"input": four, "output": turns},
            {"input": three, "output": pulled, "interpolation": "CUBICSPLINE"},
            {"input": three, "output": straight},
            {"input": three, "output": jumps, "interpolation": "STEP"},
        ]}),
    );
    g.finish()
}

/// A blob whose weight rises beyond f32 within a second.
pub(crate) fn twitching() -> Vec<u8> {
    let mut g = Glb::new();
    let points = g.floats("VEC3", &OCTAHEDRON);
    let faces = g.indices(&FACES);
    let pull = g.floats("VEC3", &[[0.0, 1e20, 0.0]; 6]);
    let mesh = g.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": points}, "indices": faces, "targets": [{"POSITION": pull}]}]}),
    );
    let node = g.push("nodes", json!({"name": "blob", "mesh": mesh}));
    let times = g.floats("SCALAR", &[[0f32], [1.0]]);
    let weights = g.floats("SCALAR", &[[0f32], [1e30]]);
    g.push(
        "animations",
        json!({"channels": [{"sampler": 0, "target": {"node": node, "path": "weights"}}],
               "samplers": [{"input": times, "output": weights}]}),
    );
    g.finish()
}
