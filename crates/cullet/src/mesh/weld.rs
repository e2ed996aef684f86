//! Welding: which vertices lie in the same place.

use alloc::vec;
use alloc::vec::Vec;

use crate::array::Each;

/// For each vertex the first vertex at the same position (−0 equals 0; a NaN equals one with the
/// same bits). Expected O(n), 12 bytes a vertex on top of the result.
///
/// ```
/// let positions = [[0.0, 1.0, 2.0], [3.0; 3], [-0.0, 1.0, 2.0]];
/// assert_eq!(cullet::mesh::weld(&positions), [0, 1, 0]);
/// ```
#[must_use]
pub fn weld(positions: &[[f32; 3]]) -> Vec<u32> {
    const FREE: u32 = u32::MAX;
    // Open addressing at a load of at most one half.
    let slots = (positions.len() * 2).next_power_of_two().max(2);
    let shift = 64 - slots.trailing_zeros();
    let mut table = vec![FREE; slots];
    // Adding 0 turns −0 into 0. Bits, so that even a NaN equals itself.
    let key = |p: &[f32; 3]| p.each(|v| (v + 0.0).to_bits());
    let mut first = Vec::with_capacity(positions.len());
    for (v, p) in positions.iter().enumerate() {
        let k = key(p);
        let mut slot = (hash(k) >> shift) as usize;
        let found = loop {
            match table[slot] {
                FREE => {
                    table[slot] = v as u32;
                    break v as u32;
                }
                w if key(&positions[w as usize]) == k => break w,
                _ => slot = (slot + 1) & (slots - 1),
            }
        };
        first.push(found);
    }
    first
}

/// The high bits are the good ones.
fn hash([x, y, z]: [u32; 3]) -> u64 {
    const ODD: u64 = 0x9E37_79B9_7F4A_7C15;
    let mix = |h: u64, v: u64| {
        let h = (h ^ v).wrapping_mul(ODD);
        h ^ h >> 32
    };
    mix(mix(u64::from(x) | u64::from(y) << 32, 0), u64::from(z)).wrapping_mul(ODD)
}

#[cfg(test)]
mod tests {
    use super::weld;

    #[test]
    fn equal_positions_share_their_first_vertex() {
        let p = [[0.0, 1.0, 2.0], [-0.0, 1.0, 2.0], [0.0, 2.0, 1.0], [0.0, 1.0, 2.0]];
        assert_eq!(weld(&p), [0, 0, 2, 0]);
        assert!(weld(&[]).is_empty());
    }

    #[test]
    fn a_grid_of_distinct_points_stays_distinct() {
        let p: Vec<[f32; 3]> =
            (0..32768u32).map(|i| [i & 31, i >> 5 & 31, i >> 10].map(|v| v as f32)).collect();
        assert!(weld(&p).into_iter().eq(0..p.len() as u32));
    }
}
