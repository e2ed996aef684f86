//! Whether a mesh that names no parts is a body with an outside.

use alloc::vec;
use alloc::vec::Vec;

use glam::DVec3;

use crate::array::Each;

/// Whether triangles are the surface of bodies, each wound outward: every edge is used as often in
/// one direction as in the other, and what each set of triangles that share vertices encloses has a
/// volume above zero. Then no eye outside sees a back face.
///
/// Vertices are the same where their numbers are: of a body whose vertices are split along seams
/// this says no, as of one with a cavity, which is safe. O(n).
pub(super) fn encloses(positions: &[[f32; 3]], indices: &[u32]) -> bool {
    // A sum over all edges and their opposites, each by a number of its own in place of a sorted
    // list, which would take more memory than the mesh: it is zero where both are the same edges,
    // and for no other mesh that anyone will see.
    let mut sum = 0_u64;
    for t in indices.chunks_exact(3) {
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            sum = sum.wrapping_add(mixed(a, b)).wrapping_sub(mixed(b, a));
        }
    }
    !indices.is_empty() && sum == 0 && volumes(positions, indices).all(|v| v > 0.0)
}

/// A number for an edge that looks random: `splitmix64` (G. Steele, D. Lea and C. Flood, "Fast
/// splittable pseudorandom number generators", 2014).
fn mixed(from: u32, to: u32) -> u64 {
    let mut v = (u64::from(from) << 32 | u64::from(to)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    v = (v ^ (v >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    v = (v ^ (v >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    v ^ (v >> 31)
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
