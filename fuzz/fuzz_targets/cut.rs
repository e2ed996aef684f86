//! Any triangles and planes: an error, or a cut that has no open edge where the mesh had none.
#![no_main]

use cullet::bounds::Plane;
use cullet_cut::{CapOptions, CutInput, CutOptions, Keep, cut};
use cullet_mesh::Topology;
use libfuzzer_sys::fuzz_target;

/// Coordinates on a coarse grid meet planes, edges and each other; the rest are any bits.
fn number(byte: u8, fine: u8) -> f32 {
    match fine {
        0..=199 => f32::from(byte as i8 / 16),
        200..=250 => f32::from(byte as i8) * 0.37 + f32::from(fine) * 1e-6,
        _ => f32::from_bits(u32::from_le_bytes([byte, fine, byte, fine])),
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((head, rest)) = bytes.split_at_checked(12) else { return };
    let plane = |b: &[u8]| {
        let n = [0, 1, 2].map(|i| f64::from(b[i] as i8));
        Plane::new(n, f64::from(b[3] as i8) / 4.0)
    };
    let count = usize::from(head[0] % 3) + 1;
    let planes: Vec<Plane> = head.chunks_exact(4).take(count).map(plane).collect();
    let positions: Vec<[f32; 3]> = rest
        .chunks_exact(6)
        .take(64)
        .map(|b| [number(b[0], b[1]), number(b[2], b[3]), number(b[4], b[5])])
        .collect();
    // Tetrahedra are closed, however they lie.
    let corners = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
    let whole = (0..positions.len() as u32 / 4 * 4).step_by(4);
    let indices: Vec<u32> = whole.flat_map(|t| corners.map(|i| t + i)).collect();
    let input = CutInput { positions: &positions, indices: &indices, ..CutInput::default() };
    for keep in [Keep::Inside, Keep::Outside] {
        let options = CutOptions { keep, caps: Some(CapOptions::default()) };
        let Ok(done) = cut(&input, &planes, &options) else { continue };
        assert!(done.indices.iter().all(|&i| (i as usize) < done.positions.len()));
        assert_eq!(done.report.open_chains, 0, "{:?}", done.report);
        let open = Topology::of(&done.positions, &done.indices).boundary_edges;
        assert_eq!(open, 0, "{:?}", done.report);
    }
});
