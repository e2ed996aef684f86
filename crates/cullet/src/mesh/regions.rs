//! Connected regions of a surface: which of some chosen triangles hang together.

use super::surface::{Shells, Surface, for_each_edge};

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

/// The connected regions of the triangles of a list for which `chosen` holds. Two triangles are
/// neighbours if they share an edge once equal positions are welded (−0 equals 0); a shared corner is
/// not enough.
///
/// Triangles whose corners are not three different positions, or have an index out of range, are in no
/// region; `chosen` is called once for each of the others. Expected O(n), as
/// [`Topology::of`](super::Topology::of).
#[must_use]
pub fn connected_regions(
    positions: &[[f32; 3]],
    indices: &[u32],
    mut chosen: impl FnMut(usize) -> bool,
) -> Regions {
    let surface = Surface::welded(positions, indices);
    let sources: Vec<usize> = surface.sources().collect();
    let chosen: Vec<bool> = sources.iter().map(|&t| chosen(t)).collect();
    let mut shells = Shells::new(sources.len());
    for_each_edge(&surface, |uses| {
        let mut uses = uses.iter().map(|u| u.triangle()).filter(|&t| chosen[t]);
        if let Some(first) = uses.next() {
            // Which way neighbours run does not matter here.
            uses.for_each(|t| {
                shells.join(first, t, false);
            });
        }
    });
    let (sets, set_of) = shells.number();
    let mut number = vec![Regions::NONE; sets];
    let mut regions = Regions { of: vec![Regions::NONE; indices.len() / 3], triangles: Vec::new() };
    for (t, &source) in sources.iter().enumerate().filter(|(t, _)| chosen[*t]) {
        let region = &mut number[set_of[t] as usize];
        if *region == Regions::NONE {
            *region = regions.triangles.len() as u32;
            regions.triangles.push(0);
        }
        regions.of[source] = *region;
        regions.triangles[*region as usize] += 1;
    }
    regions
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
