//! Any surface in any view: drawn into an occlusion buffer, each pixel that it claims is covered, and as near as it says.
#![no_main]

use cullet::cull::occlusion::OcclusionBuffer;
use cullet::{Camera, Depth, Instance, Mesh, MeshData, Projection, Scene, Simd, Transform, View};
use cullet_lab::claims::{ClaimOptions, Claims, SceneOccluders, check_claims};
use libfuzzer_sys::fuzz_target;

const SIZE: [u32; 2] = [64, 48];

/// Coordinates on a coarse grid meet corners of pixels, the near plane and each other; others lie a few units in the last place
/// beside it, or anywhere.
fn number(byte: u8, fine: u8) -> f32 {
    let coarse = f32::from(byte as i8) * 0.125;
    match fine {
        0..=127 => coarse,
        128..=159 => f32::from_bits(coarse.to_bits().wrapping_add(u32::from(fine - 127))),
        160..=239 => coarse + f32::from(fine) * 1e-5,
        240..=250 => coarse * 1e4,
        _ => f32::from_bits(u32::from_le_bytes([byte, fine, byte, fine])),
    }
}

fn view(b: &[u8]) -> Option<View> {
    let at = |i: usize| f64::from(b[i] as i8) * 0.125;
    let (near, shift) = ([0.125, 0.5, 1.0, 0.01][b[0] as usize % 4], f64::from(b[1] % 4) * 0.25);
    let window = [shift - 1.0, shift + 1.0, -0.75, 0.75];
    let depth = if b[0] & 16 == 0 { Depth::Standard } else { Depth::Reversed };
    let projection = if b[0] & 4 == 0 {
        let far = if b[0] & 8 == 0 { f64::INFINITY } else { 100.0 };
        let [left, right, bottom, top] = window.map(|v| v * near);
        Projection::OffCentre { left, right, bottom, top, near, far }
    } else {
        let [left, right, bottom, top] = window.map(|v| v * 8.0);
        Projection::Orthographic { left, right, bottom, top, near, far: 40.0 }
    };
    let direction = [at(2) * 0.125, at(3) * 0.125, -1.0];
    let camera = Camera { eye: [at(4), at(5), at(6)], direction, up: [0.0, 1.0, 0.0], projection };
    View::new(&camera, depth, SIZE).ok()
}

fuzz_target!(|bytes: &[u8]| {
    let Some((head, rest)) = bytes.split_at_checked(12) else { return };
    let Some(view) = view(head) else { return };
    // A third of the bytes are triangles, the rest their corners.
    let (corners, triangles) = rest.split_at(rest.len() / 3 * 2);
    let positions: Vec<[f32; 3]> = corners
        .chunks_exact(6)
        .take(200)
        .map(|b| [number(b[0], b[1]), number(b[2], b[3]), number(b[4], b[5])])
        .collect();
    if positions.is_empty() {
        return;
    }
    let indices = triangles.as_chunks::<3>().0.iter().flatten();
    let indices: Vec<u32> = indices.map(|&i| u32::from(i) % positions.len() as u32).collect();
    let Ok(mut mesh) = Mesh::new(MeshData { positions, indices, ..MeshData::default() }) else {
        return;
    };
    mesh.set_two_sided(head[7] & 1 == 0);
    let mut linear = Transform::IDENTITY.linear;
    if head[7] & 2 != 0 {
        linear[0][0] = -1.0;
        linear[1] = [0.25, 1.5, f32::from(head[8]) / 256.0];
    }
    let translation = [0.0, 0.0, -f64::from(head[9]) * 0.125];
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh);
    scene.add(Instance::new(mesh, Transform { linear, translation })).expect("the mesh is there");
    scene.commit(&cullet::Culler::default());
    let occluders = SceneOccluders::new(&scene);
    let mut buffer = OcclusionBuffer::new(SIZE).expect("a size within the limit");
    occluders.draw(&view, Simd::best(), &mut buffer);
    let options = ClaimOptions { seed: u64::from(head[10]), threads: 1, ..ClaimOptions::default() };
    let check = check_claims(&view, &Claims::of(&buffer), &occluders.triangles(&view), &options);
    assert_eq!(check.wrong, 0, "{:?}", check.first);
});
