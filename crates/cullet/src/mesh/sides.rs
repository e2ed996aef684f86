//! Whether a mesh that names no parts is a body with an outside.

use glam::DVec3;

use crate::array::Each;

/// Whether triangles are the surface of bodies, each wound outward: every edge is used as often in one direction as in
/// the other, and what each set of triangles that share vertices encloses has a volume above zero. Then no eye outside
/// sees a back face.
///
/// Vertices are the same where their numbers are: of a body whose vertices are split along seams this says no, as of one
/// with a cavity, which is safe. O(n log n).
pub(super) fn encloses(positions: &[[f32; 3]], indices: &[u32]) -> bool {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(indices.len());
    for t in indices.chunks_exact(3) {
        edges.extend([[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    }
    // The reversed edges are the same edges.
    edges.sort_unstable();
    let mut turned: Vec<[u32; 2]> = edges.iter().map(|&[a, b]| [b, a]).collect();
    turned.sort_unstable();
    !edges.is_empty() && edges == turned && volumes(positions, indices).all(|v| v > 0.0)
}

/// Six times the volume that each set of triangles with vertices in common encloses.
fn volumes(positions: &[[f32; 3]], indices: &[u32]) -> impl Iterator<Item = f64> {
    let mut above: Vec<u32> = (0..positions.len() as u32).collect();
    fn top(above: &mut [u32], mut v: u32) -> u32 {
        while above[v as usize] != v {
            above[v as usize] = above[above[v as usize] as usize];
            v = above[v as usize];
        }
        v
    }
    for t in indices.chunks_exact(3) {
        for v in &t[1..] {
            let [a, b] = [t[0], *v].map(|v| top(&mut above, v));
            above[a.max(b) as usize] = a.min(b);
        }
    }
    // From a corner of each set: far from the origin the differences are what is exact.
    let mut sums = vec![0.0; positions.len()];
    let mut is_used = vec![false; positions.len()];
    for t in indices.chunks_exact(3) {
        let of = top(&mut above, t[0]);
        let from = DVec3::from(positions[of as usize].each(f64::from));
        let [a, b, c] =
            [0, 1, 2].each(|i| DVec3::from(positions[t[i] as usize].each(f64::from)) - from);
        sums[of as usize] += a.dot(b.cross(c));
        is_used[of as usize] = true;
    }
    sums.into_iter().zip(is_used).filter(|(_, is_used)| *is_used).map(|(sum, _)| sum)
}
