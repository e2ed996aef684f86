//! Sorting facets by place, fast enough to be done in a frame: one pass of counting.

use alloc::vec::Vec;

use super::facet::Facet;
use crate::array::Each;
use crate::bounds::Aabb;

/// Facets of a cell on average: some cells make a chunk.
const CELL: usize = 8;

/// The most bits of the number of a cell, so that counters stay in a near cache.
const BITS: usize = 16;

/// The order of the cells of a grid in which they are halved along the longest axis, again and
/// again, the halves one after the other: what is near in it is near in space.
#[derive(Clone, Debug, Default)]
pub(super) struct Curve {
    /// For each axis the bits of its cells, where they are in the number of a cell.
    spread: [Vec<u32>; 3],
    /// The cell of each facet; where the next facet of a cell comes.
    cells: Vec<u32>,
    next: Vec<u32>,
}

impl Curve {
    /// Sorts facets by their middles; those of a cell stay as they come. Positions are finite.
    pub(super) fn sort(
        &mut self,
        positions: &[[f32; 3]],
        facets: &[Facet],
        sorted: &mut Vec<Facet>,
    ) {
        let bits = ((facets.len() / CELL).max(1).ilog2() as usize).min(BITS);
        let all = bounds(positions);
        self.begin(&all, bits);
        // A quarter, for the sum of four corners. What has no extent has one cell.
        let scale = [0, 1, 2].each(|a| {
            let extent = all.max[a] - all.min[a];
            if extent > 0.0 { self.spread[a].len() as f32 / extent * 0.25 } else { 0.0 }
        });
        self.next.clear();
        self.next.resize((1 << bits) + 1, 0);
        self.cells.clear();
        let (spread, next) = (&self.spread, &mut self.next);
        self.cells.extend(facets.iter().map(|facet| {
            let places = facet.corners.each(|v| positions[v as usize]);
            let mut cell = 0;
            for a in 0..3 {
                let sum: f32 = places.iter().map(|p| p[a] - all.min[a]).sum();
                // An extent beyond f32 makes a NaN, which is taken as 0.
                cell |= spread[a][((sum * scale[a]) as usize).min(spread[a].len() - 1)];
            }
            next[cell as usize + 1] += 1;
            cell
        }));
        let mut sum = 0;
        for next in &mut self.next {
            sum += *next;
            *next = sum;
        }
        sorted.clear();
        sorted.resize(facets.len(), Facet::triangle([0; 3]));
        for (facet, &cell) in facets.iter().zip(&self.cells) {
            let next = &mut self.next[cell as usize];
            sorted[*next as usize] = *facet;
            *next += 1;
        }
    }

    /// Divides a box into 2^bits cells.
    fn begin(&mut self, all: &Aabb, bits: usize) {
        let mut extent = [0, 1, 2].each(|a| f64::from(all.max[a]) - f64::from(all.min[a]));
        let mut axes = [0; BITS];
        for axis in &mut axes[..bits] {
            *axis = (0..3).fold(0, |best, a| if extent[a] > extent[best] { a } else { best });
            extent[*axis] *= 0.5;
        }
        for (a, spread) in self.spread.iter_mut().enumerate() {
            spread.clear();
            spread.push(0);
            // The axis that was halved last has the least bit.
            for (bit, _) in axes[..bits].iter().rev().enumerate().filter(|(_, axis)| **axis == a) {
                for k in 0..spread.len() {
                    spread.push(spread[k] | 1 << bit);
                }
            }
        }
    }
}

fn bounds(positions: &[[f32; 3]]) -> Aabb {
    let mut all = Aabb::EMPTY;
    for p in positions {
        for a in 0..3 {
            // `min` and `max` would look for NaN.
            all.min[a] = if p[a] < all.min[a] { p[a] } else { all.min[a] };
            all.max[a] = if p[a] > all.max[a] { p[a] } else { all.max[a] };
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_in_a_row_of_a_grid_of_triangles_lie_in_a_square() {
        // A triangle of its own for each of 64 × 64 places, row by row.
        let place = |i: u32| [(i % 64) as f32, (i / 64) as f32, 7.0];
        let positions: Vec<[f32; 3]> = (0..64 * 64).map(place).collect();
        let facets: Vec<Facet> = (0..64 * 64).map(|i| Facet::triangle([i; 3])).collect();
        let mut sorted = Vec::new();
        Curve::default().sort(&positions, &facets, &mut sorted);
        let mut numbers: Vec<u32> = sorted.iter().map(|f| f.corners[0]).collect();
        for row in numbers.chunks(16) {
            let places: Vec<_> = row.iter().map(|&i| place(i)).collect();
            let b = Aabb::from_points(&places);
            let [x, y] = [0, 1].each(|a| b.max[a] - b.min[a]);
            assert!(x <= 4.0 && y <= 4.0, "{row:?}");
        }
        numbers.sort_unstable();
        assert!(numbers.iter().copied().eq(0..64 * 64), "each is there once");
    }

    #[test]
    fn sixteen_in_a_row_of_a_cube_of_triangles_lie_in_a_small_box() {
        let place = |i: u32| [(i % 16) as f32, (i / 16 % 16) as f32, (i / 256) as f32];
        let positions: Vec<[f32; 3]> = (0..4096).map(place).collect();
        let facets: Vec<Facet> = (0..4096).map(|i| Facet::triangle([i; 3])).collect();
        let mut sorted = Vec::new();
        Curve::default().sort(&positions, &facets, &mut sorted);
        for row in sorted.chunks(16) {
            let places: Vec<_> = row.iter().map(|f| place(f.corners[0])).collect();
            let b = Aabb::from_points(&places);
            assert!((0..3).all(|a| b.max[a] - b.min[a] <= 4.0), "{places:?}");
        }
    }

    #[test]
    fn places_of_any_size_are_sorted() {
        let facets: Vec<Facet> = (0..300).map(|i| Facet::triangle([i; 3])).collect();
        for size in [0.0, 1e-45, 1e-30, 1.0, 3e38] {
            let positions: Vec<[f32; 3]> =
                (0..300).map(|i| [((i % 7) as f32 - 3.0) / 3.0 * size, 0.0, size]).collect();
            let mut sorted = Vec::new();
            Curve::default().sort(&positions, &facets, &mut sorted);
            let mut numbers: Vec<u32> = sorted.iter().map(|f| f.corners[0]).collect();
            numbers.sort_unstable();
            assert!(numbers.iter().copied().eq(0..300), "{size}");
        }
    }
}
