//! Connected regions of a surface: which of some chosen triangles hang together.

use alloc::vec;
use alloc::vec::Vec;

use super::weld::weld;
use crate::array::Each;
use crate::sort::sort;

/// Components of some triangles of a list, each connected by edges.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Regions {
    /// The region of each triangle of the list, numbered in the order of their first triangles;
    /// [`Regions::NONE`] for those that were not chosen.
    pub of: Vec<u32>,
    /// How many triangles each region has.
    pub triangles: Vec<u32>,
}

impl Regions {
    /// The region of triangles that are in none.
    pub const NONE: u32 = u32::MAX;

    /// How many regions there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.triangles.len()
    }
}

/// Returns the connected regions of the triangles of a list for which `chosen` holds. Two triangles
/// are neighbours if they share an edge once equal positions are welded (−0 equals 0); a shared
/// corner is not enough.
///
/// Triangles whose corners are not three different positions, or have an index out of range, are in
/// no region; `chosen` is called once for each of the others. O(n) apart from a sort of the edges
/// at each vertex.
#[must_use]
pub fn connected_regions(
    positions: &[[f32; 3]],
    indices: &[u32],
    mut chosen: impl FnMut(usize) -> bool,
) -> Regions {
    let first = weld(positions);
    let edges = |t: usize| {
        let corner = |i: usize| first.get(indices[t * 3 + i] as usize).copied();
        let (a, b, c) = (corner(0)?, corner(1)?, corner(2)?);
        let is_whole = a != b && b != c && c != a;
        is_whole.then(|| [(a, b), (b, c), (c, a)].each(|(p, q)| (p.min(q) as usize, p.max(q))))
    };
    let triangles = indices.len() / 3;
    // A lower triangle of the same region, or itself.
    let mut parents = vec![Regions::NONE; triangles];
    // Where the half edges of each lower vertex begin; once they are written, where they end.
    let mut place = vec![0u32; positions.len()];
    for t in 0..triangles {
        if let Some(edges) = edges(t)
            && chosen(t)
        {
            parents[t] = t as u32;
            edges.iter().for_each(|&(low, _)| place[low] += 1);
        }
    }
    let mut total = 0;
    for p in &mut place {
        total += *p;
        *p = total - *p;
    }
    // Higher vertex and triangle of each half edge.
    let mut halves = vec![0u64; total as usize];
    for t in (0..triangles).filter(|&t| parents[t] != Regions::NONE) {
        for (low, high) in edges(t).into_iter().flatten() {
            halves[place[low] as usize] = u64::from(high) << 32 | t as u64;
            place[low] += 1;
        }
    }
    let mut rest = halves.as_mut_slice();
    let mut begin = 0;
    for end in place {
        let (at_vertex, behind) = core::mem::take(&mut rest).split_at_mut((end - begin) as usize);
        sort(at_vertex);
        for pair in at_vertex.windows(2).filter(|pair| pair[0] >> 32 == pair[1] >> 32) {
            // Which way neighbours run does not matter here.
            let [a, b] = [pair[0], pair[1]].each(|half| find(&mut parents, half as u32));
            parents[a.max(b) as usize] = a.min(b);
        }
        (rest, begin) = (behind, end);
    }
    let mut regions = Regions { of: vec![Regions::NONE; triangles], triangles: Vec::new() };
    for t in 0..triangles {
        if parents[t] == Regions::NONE {
            continue;
        }
        let root = find(&mut parents, t as u32) as usize;
        if root == t {
            regions.of[t] = regions.triangles.len() as u32;
            regions.triangles.push(0);
        }
        // The root is the lowest triangle of its region, so it was numbered before.
        regions.of[t] = regions.of[root];
        regions.triangles[regions.of[t] as usize] += 1;
    }
    regions
}

/// Returns the lowest triangle of the region of `t`.
fn find(parents: &mut [u32], mut t: u32) -> u32 {
    while parents[t as usize] != t {
        // Path halving: link to the grandparent.
        parents[t as usize] = parents[parents[t as usize] as usize];
        t = parents[t as usize];
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_join_and_corners_do_not() {
        // Two squares that touch at a corner; the second has vertices of its own.
        let p = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [2.0, 1.0, 0.0],
            [2.0, 2.0, 0.0],
            [1.0, 2.0, 0.0],
        ];
        let indices = [0, 1, 2, 0, 2, 3, 4, 5, 6, 1, 1, 2, 4, 6, 7, 0, 1, 99];
        let all = connected_regions(&p, &indices, |_| true);
        let none = Regions::NONE;
        assert_eq!(all.of, [0, 0, 1, none, 1, none]);
        assert_eq!((all.count(), all.triangles), (2, vec![2, 2]));
        let some = connected_regions(&p, &indices, |t| t != 0);
        assert_eq!(some.of, [none, 0, 1, none, 1, none]);
        assert_eq!(connected_regions(&[], &[], |_| true), Regions::default());
    }
}
