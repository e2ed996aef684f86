//! Welding: which vertices lie in the same place, or nearly so.

use crate::array::Each;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// For each vertex the first vertex at the same position (−0 equals 0; a NaN equals one with the same bits).
/// Expected O(n), 12 bytes a vertex on top of the result.
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

/// For each vertex the one that it is welded to: the nearest of those before it that stayed where they were and are
/// at most `tolerance` away (Euclidean, in units of the mesh), or itself where none is. So no vertex moves further
/// than the tolerance, and those that stay are further apart. With a tolerance of 0, below 0 or not finite it is
/// [`weld`]. Vertices that are not finite stay.
///
/// Expected O(n), with some 40 bytes a vertex that stays on top of the result.
///
/// ```
/// let positions = [[0.0; 3], [0.01, 0.0, 0.0], [1.0, 0.0, 0.0]];
/// assert_eq!(cullet::mesh::weld_within(&positions, 0.1), [0, 0, 2]);
/// ```
#[must_use]
pub fn weld_within(positions: &[[f32; 3]], tolerance: f32) -> Vec<u32> {
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return weld(positions);
    }
    let reach = f64::from(tolerance);
    // Cells are as wide as two tolerances, so what is near lies in the cell or in the next one on the side that the
    // point is on. Those that stay are further apart than the tolerance, so a cell has few.
    let size = reach * 2.0;
    let mut cells: HashMap<[u64; 3], u32, BuildHasherDefault<CellHash>> = HashMap::default();
    // The vertices that stay, each with the one before it in its cell.
    let mut stayed: Vec<[u32; 2]> = Vec::new();
    let place = |vertex: u32| {
        let p = positions[vertex as usize].each(f64::from);
        let cell = p.each(|v| (v / size).floor());
        if !cell.iter().all(|c| c.is_finite()) {
            return vertex;
        }
        let next = [0, 1, 2].each(|a| if p[a] / size - cell[a] < 0.5 { -1.0 } else { 1.0 });
        // −0 is 0, as a cell.
        let bits = |c: [f64; 3]| c.each(|v| (v + 0.0).to_bits());
        let mut nearest: Option<(f64, u32)> = None;
        for corner in 0..8 {
            let at = [0, 1, 2].each(|a| cell[a] + if corner >> a & 1 == 1 { next[a] } else { 0.0 });
            let mut other = cells.get(&bits(at)).copied();
            while let Some([v, before]) = other.and_then(|o| stayed.get(o as usize)) {
                let q = positions[*v as usize];
                let apart = (0..3).map(|a| (f64::from(q[a]) - p[a]).powi(2)).sum::<f64>().sqrt();
                if apart <= reach && nearest.is_none_or(|n| apart < n.0) {
                    nearest = Some((apart, *v));
                }
                other = Some(*before);
            }
        }
        if let Some((_, to)) = nearest {
            return to;
        }
        let number = stayed.len() as u32;
        let before = cells.insert(bits(cell), number).unwrap_or(u32::MAX);
        stayed.push([vertex, before]);
        vertex
    };
    (0..positions.len() as u32).map(place).collect()
}

/// A quick hash of the bits of cells: multiplies and folds. Crafted positions can make it slow, but no slower than a
/// list.
#[derive(Clone, Copy, Default)]
struct CellHash(u64);

impl Hasher for CellHash {
    fn finish(&self) -> u64 {
        // The map takes its buckets from the low bits and its tags from the high ones.
        self.0 ^ self.0 >> 32
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&b| self.write_u64(u64::from(b)));
    }

    fn write_u64(&mut self, v: u64) {
        let mixed = (self.0.rotate_left(26) ^ v).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = mixed ^ mixed >> 29;
    }

    fn write_usize(&mut self, v: usize) {
        self.write_u64(v as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::{weld, weld_within};

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

    #[test]
    fn what_is_near_moves_and_what_is_not_stays() {
        let positions = [
            [0.0, 0.0, 0.0],
            [0.5, 0.0, 0.0],
            [-0.5, 0.0, 0.0],
            [1.2, 0.0, 0.0],
            [f32::NAN, 0.0, 0.0],
            [1e30, 1e30, 0.0],
        ];
        assert_eq!(weld_within(&positions, 1.0), [0, 0, 0, 3, 4, 5]);
        assert_eq!(weld_within(&positions[..4], 0.0), [0, 1, 2, 3]);
        assert_eq!(weld_within(&positions[..4], f32::NAN), [0, 1, 2, 3]);
    }

    #[test]
    fn none_moves_further_than_the_tolerance_and_those_that_stay_are_apart() {
        let at = |i: u32| {
            let mixed = i.wrapping_mul(2_654_435_761);
            [0, 10, 20].map(|s| (mixed >> s & 1023) as f32 / 128.0)
        };
        let positions: Vec<[f32; 3]> = (0..3000).map(at).collect();
        let to = weld_within(&positions, 0.75);
        assert!((0..).zip(&to).filter(|(v, to)| v != *to).count() > 100);
        let welded: Vec<[f32; 3]> = to.iter().map(|&v| positions[v as usize]).collect();
        let apart = |p: [f32; 3], q: [f32; 3]| {
            (0..3).map(|a| f64::from(p[a] - q[a]).powi(2)).sum::<f64>().sqrt()
        };
        assert!(positions.iter().zip(&welded).all(|(p, w)| apart(*p, *w) <= 0.75));
        for (i, p) in welded.iter().enumerate() {
            assert!(welded[..i].iter().all(|q| p == q || apart(*p, *q) > 0.75));
        }
    }
}
