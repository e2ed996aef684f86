//! Sets of tiles that were baked apart, joined when they are loaded together.

use alloc::collections::BTreeMap;
use alloc::vec;
use alloc::vec::Vec;

use super::{JoinedSets, SetsError, Targets, VisibleSets};
use crate::bits;

/// Low and high corner of a box in the world.
type Bounds = [[f64; 3]; 2];

/// View cells that were baked with what stands around them, and without the other tiles.
#[derive(Clone, Debug)]
pub struct Tile<'a> {
    /// Sets of instances.
    pub sets: &'a VisibleSets<'a>,
    /// The cells, as boxes in the world.
    pub cells: &'a [Bounds],
    /// Number of each target among those of all tiles; `u32::MAX` for one that is no more.
    pub targets: &'a [u32],
    /// A box around each target, in the world.
    pub bounds: &'a [Bounds],
}

/// Joins the sets of tiles, each baked as if it were alone.
///
/// A line from outside of a tile to something within the box around its cells enters that box
/// through a cell on its border, on a side that is turned to the eye; so it may be seen if such a
/// cell sees it, or one that touches the eye's own cell. What reaches out of that box is kept, and
/// so is all of a tile whose cells do not fill it, and whatever of `target_count` is of no tile.
///
/// Sets keep what other tiles hide: they are as large as if those hid nothing.
///
/// # Errors
/// If a tile has not a set for each cell, or not a number and a box for each target.
pub fn join_tiles(tiles: &[Tile<'_>], target_count: u32) -> Result<JoinedSets, SetsError> {
    let words = (target_count as usize).div_ceil(64);
    let mut of_any = vec![0_u64; words];
    for (part, tile) in (0..).zip(tiles) {
        let count = tile.sets.target_count() as usize;
        let fits = tile.sets.targets() == Targets::Instances
            && tile.sets.cell_count() as usize == tile.cells.len()
            && (tile.targets.len(), tile.bounds.len()) == (count, count);
        if !fits {
            let problem =
                "it has not a set for each cell, or not a number and a box for each target";
            return Err(SetsError::Part { part, problem });
        }
        for &target in tile.targets.iter().filter(|&&target| target < target_count) {
            bits::set(&mut of_any, target as usize, true);
        }
    }
    let outside: Vec<Outside> = tiles.iter().map(|tile| Outside::new(tile, words)).collect();
    let mut first_cells = Vec::with_capacity(tiles.len());
    let (mut rows, mut unknown) = (Vec::new(), 0);
    for (number, tile) in tiles.iter().enumerate() {
        first_cells.push(rows.len() as u32);
        let mut known: BTreeMap<(usize, Vec<u32>), Vec<u64>> = BTreeMap::new();
        for (cell, bounds) in (0..).zip(tile.cells) {
            let mut row = vec![0_u64; words];
            tile.add(&[cell], &mut row);
            // What is of no tile may stand anywhere.
            let mut unsure: Vec<u64> = of_any.iter().map(|word| !word).collect();
            for (other, out) in outside.iter().enumerate().filter(|&(other, _)| other != number) {
                let through = out.cells_between(&tiles[other], bounds);
                let seen = known.entry((other, through)).or_insert_with_key(|(_, through)| {
                    let mut seen = vec![0_u64; words];
                    tiles[other].add(through, &mut seen);
                    seen
                });
                row.iter_mut().zip(seen).for_each(|(row, seen)| *row |= *seen);
                unsure.iter_mut().zip(&out.unsure).for_each(|(all, of)| *all |= *of);
            }
            for (at, (row, unsure)) in row.iter_mut().zip(&unsure).enumerate() {
                let left = target_count as usize - at * 64;
                let mask = if left < 64 { (1 << left) - 1 } else { u64::MAX };
                unknown += u64::from((unsure & !*row & mask).count_ones());
                *row |= unsure & mask;
            }
            rows.push(row);
        }
    }
    let rows = rows.iter().map(Vec::as_slice);
    let sets = VisibleSets::from_rows(Targets::Instances, target_count, rows);
    Ok(JoinedSets { sets, first_cells, unknown })
}

impl Tile<'_> {
    /// Adds what some cells see to a row of all targets.
    fn add(&self, cells: &[u32], row: &mut [u64]) {
        for &cell in cells {
            self.sets.visit(cell, |word, bits| {
                for bit in bits::ones(bits) {
                    let target = self.targets[word * 64 + bit] as usize;
                    if target / 64 < row.len() {
                        bits::set(row, target, true);
                    }
                }
            });
        }
    }
}

/// A tile as it is seen from outside.
struct Outside {
    /// The box that the cells fill; `None` where they fill none.
    region: Option<Bounds>,
    /// Cells on each side of it: low and high of each axis.
    sides: [Vec<u32>; 6],
    /// A bit for each target that its border cells do not tell of.
    unsure: Vec<u64>,
}

impl Outside {
    fn new(tile: &Tile<'_>, words: usize) -> Self {
        let region = filled(tile.cells);
        let mut sides: [Vec<u32>; 6] = Default::default();
        for (cell, bounds) in (0..).zip(tile.cells) {
            for (side, cells) in sides.iter_mut().enumerate() {
                let [end, axis] = [side % 2, side / 2];
                if region.is_some_and(|region| region[end][axis] == bounds[end][axis]) {
                    cells.push(cell);
                }
            }
        }
        let mut unsure = vec![0; words];
        for (&target, bounds) in tile.targets.iter().zip(tile.bounds) {
            let is_within = region.is_some_and(|[low, high]| {
                (0..3).all(|a| low[a] <= bounds[0][a] && bounds[1][a] <= high[a])
            });
            if !is_within && target as usize / 64 < words {
                bits::set(&mut unsure, target as usize, true);
            }
        }
        Self { region, sides, unsure }
    }

    /// The cells of the tile that a line from within a box enters it by; ascending.
    fn cells_between(&self, tile: &Tile<'_>, from: &Bounds) -> Vec<u32> {
        let Some(region) = self.region else { return Vec::new() };
        let mut cells = Vec::new();
        for (side, of_side) in self.sides.iter().enumerate() {
            let axis = side / 2;
            let is_before = match side % 2 {
                0 => from[0][axis] < region[0][axis],
                _ => from[1][axis] > region[1][axis],
            };
            if is_before {
                cells.extend_from_slice(of_side);
            }
        }
        // Boxes that touch or overlap: the eye may be in both.
        let touches = |b: &Bounds| (0..3).all(|a| from[0][a] <= b[1][a] && b[0][a] <= from[1][a]);
        if touches(&region) {
            cells.extend((0..).zip(tile.cells).filter(|(_, b)| touches(b)).map(|(cell, _)| cell));
        }
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

/// The box that cells fill without a gap, where planes that cut none part them one by one; `None`
/// where they do not. O(n log² n) for cells that were cut from a box.
fn filled(cells: &[Bounds]) -> Option<Bounds> {
    let around = |group: &[u32]| {
        group.iter().map(|&cell| cells[cell as usize]).reduce(|a, b| {
            [0, 1].map(|end| {
                core::array::from_fn(|axis| match end {
                    0 => a[0][axis].min(b[0][axis]),
                    _ => a[1][axis].max(b[1][axis]),
                })
            })
        })
    };
    let all: Vec<u32> = (0..cells.len() as u32).collect();
    let region = around(&all)?;
    let mut left = vec![(all, region)];
    while let Some((mut group, bounds)) = left.pop() {
        // To the last bit: so no NaN passes either.
        if around(&group) != Some(bounds) {
            return None;
        }
        if group.len() == 1 {
            continue;
        }
        let mut best: Option<(usize, usize, f64)> = None;
        for axis in 0..3 {
            let low = |cell: u32| cells[cell as usize][0][axis];
            group.sort_by(|&a, &b| low(a).total_cmp(&low(b)));
            let mut end = f64::NEG_INFINITY;
            for (count, &cell) in group.iter().enumerate() {
                let even = count.min(group.len() - count);
                if count > 0 && low(cell) >= end && best.is_none_or(|(most, ..)| even > most) {
                    best = Some((even, axis, low(cell)));
                }
                end = end.max(cells[cell as usize][1][axis]);
            }
        }
        let (_, axis, at) = best?;
        let (below, above) = group.iter().partition(|&&cell| cells[cell as usize][0][axis] < at);
        let (mut under, mut over) = (bounds, bounds);
        (under[1][axis], over[0][axis]) = (at, at);
        left.extend([(below, under), (above, over)]);
    }
    Some(region)
}

#[cfg(test)]
mod tests {
    use cullet_testkit::Rng;

    use super::*;
    use crate::pvs::testing::sets_of;

    /// Cells that a box is cut into by lot.
    fn cut(mut cells: Vec<Bounds>, count: usize, rng: &mut Rng) -> Vec<Bounds> {
        while cells.len() < count {
            let (cell, axis) = (rng.index(cells.len()), rng.index(3));
            let [low, high] = cells[cell];
            let at = low[axis] + (high[axis] - low[axis]) * rng.range(0.2, 0.8);
            let mut above = cells[cell];
            (cells[cell][1][axis], above[0][axis]) = (at, at);
            cells.push(above);
        }
        cells
    }

    #[test]
    fn cells_fill_a_box_where_they_were_cut_from_one() {
        let mut rng = Rng(52);
        let region = [[0.0, 1.0, -2.0], [4.0, 2.0, 3.0]];
        for count in 1..30 {
            let cells = cut(vec![region], count, &mut rng);
            assert_eq!(filled(&cells), Some(region));
            let one = rng.index(count);
            let mut holed = cells.clone();
            holed[one][1][rng.index(3)] -= 1e-9;
            assert_ne!(filled(&holed), Some(region), "a gap");
            let mut twice = cells.clone();
            twice.push(cells[one]);
            assert_eq!(filled(&twice), None);
            if count > 1 {
                holed.remove(one);
                assert_ne!(filled(&holed), Some(region));
            }
        }
        assert_eq!(filled(&[]), None);
        assert_eq!(filled(&[[[f64::NAN; 3], [1.0; 3]]]), None);
    }

    /// In empty space every line is one of sight: whatever may be met on the way must be in the set
    /// of the cell that a line begins in, whichever tile that is of.
    #[test]
    fn lines_between_tiles_pass_border_cells() {
        let mut rng = Rng(53);
        let (mut crossed, mut hidden) = (0, 0);
        for _ in 0..cullet_testkit::cases(60) {
            // Two tiles side by side, apart, or overlapping.
            let x = [4.0, 5.0, 3.5][rng.index(3)];
            let regions = [[[0.0; 3], [4.0, 2.0, 4.0]], [[x, 0.0, 1.0], [x + 3.0, 3.0, 4.0]]];
            let cells = regions.map(|region| cut(vec![region], 12, &mut rng));
            // A target is a point. A cell sees those of its tile that a lot says, but for one that
            // a line reaches it always does.
            let points: [Vec<[f64; 3]>; 2] = regions.map(|[low, high]| {
                (0..20)
                    .map(|k| {
                        // Some reach out.
                        let out = if k < 3 { [0.0, 4.0, 0.0] } else { [0.0; 3] };
                        core::array::from_fn(|a| rng.range(low[a], high[a]) + out[a])
                    })
                    .collect()
            });
            let mut rows = [0, 1].map(|tile: usize| vec![vec![false; 20]; cells[tile].len()]);
            // Lines, and what each must leave in the rows of its target's own tile.
            let mut lines = Vec::new();
            for _ in 0..60 {
                let (tile, target) = (rng.index(2), rng.index(20));
                let region = regions[rng.index(2)];
                let eye: [f64; 3] = core::array::from_fn(|a| rng.range(region[0][a], region[1][a]));
                let to = points[tile][target];
                for k in 0..=2000 {
                    let share = f64::from(k) / 2000.0;
                    let at: [f64; 3] = core::array::from_fn(|a| eye[a] + (to[a] - eye[a]) * share);
                    for (cell, [low, high]) in cells[tile].iter().enumerate() {
                        // A little more, for points where it enters lie between these.
                        let inside =
                            (0..3).all(|a| low[a] - 4e-3 <= at[a] && at[a] <= high[a] + 4e-3);
                        rows[tile][cell][target] |= inside;
                    }
                }
                lines.push((eye, tile, target));
            }
            let sets = [0, 1].map(|tile| sets_of(&rows[tile], Targets::Instances, 20));
            let numbers =
                [0, 1].map(|tile: u32| (0..20).map(|k| k * 2 + tile).collect::<Vec<u32>>());
            let bounds = points.map(|points| points.iter().map(|&p| [p, p]).collect::<Vec<_>>());
            let tiles = [0, 1].map(|k| Tile {
                sets: &sets[k],
                cells: &cells[k],
                targets: &numbers[k],
                bounds: &bounds[k],
            });
            let joined = join_tiles(&tiles, 41).expect("tiles");
            assert_eq!(joined.first_cells, [0, 12]);
            assert!(joined.unknown > 0, "some reach out, and one is of no tile");
            for (eye, tile, target) in lines {
                for part in 0..2 {
                    for (cell, [low, high]) in cells[part].iter().enumerate() {
                        if (0..3).all(|a| low[a] <= eye[a] && eye[a] <= high[a]) {
                            let cell = (part * 12 + cell) as u32;
                            let number = numbers[tile][target];
                            assert!(joined.sets.sees(cell, number), "{eye:?} {tile} {target}");
                            assert!(joined.sets.sees(cell, 40), "of no tile");
                            crossed += u32::from(part != tile);
                        }
                    }
                }
            }
            hidden += (0..24).map(|cell| 41 - joined.sets.count(cell)).sum::<u32>();
        }
        assert!(crossed > 100 && hidden > 1000, "{crossed} {hidden}");
    }
}
