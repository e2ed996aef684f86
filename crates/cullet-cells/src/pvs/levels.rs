//! Sets of levels that were baked apart, joined when they are loaded together.

use alloc::vec;
use alloc::vec::Vec;

use super::{JoinedSets, SetsError, Targets, VisibleSets};
use crate::bits;

/// A cell of one of several levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelCell {
    /// Number of the level.
    pub level: u32,
    /// Number of the cell in it.
    pub cell: u32,
}

/// Joins the sets of levels whose cells are joined by portals.
///
/// `borders` are the pairs of cells of two levels with an opening between them, and must be all
/// such pairs of these two. Whatever a cell sees of its own level up to a border cell, it may see of
/// what the cell beyond sees, and so on. Of two levels that no chain of borders joins nothing is
/// known, and all is kept.
///
/// O(cells · (words + borders) · border cells seen).
///
/// # Errors
/// If the sets of a level are not of its cells, or a border names a cell that is not there.
pub fn join_levels(
    levels: &[VisibleSets<'_>],
    borders: &[[LevelCell; 2]],
) -> Result<JoinedSets, SetsError> {
    let mut first_cells = Vec::with_capacity(levels.len());
    let (mut total, mut level_of) = (0_u32, Vec::new());
    for (part, sets) in (0..).zip(levels) {
        let is_of_cells =
            sets.targets() == Targets::Cells && sets.target_count() == sets.cell_count();
        if !is_of_cells {
            return Err(SetsError::Part {
                part,
                problem: "its sets are not those of its own cells",
            });
        }
        first_cells.push(total);
        level_of.resize(level_of.len() + sets.cell_count() as usize, part);
        total += sets.cell_count();
    }
    // Which levels a chain of borders joins: each has the lowest number of its chain.
    let mut chain: Vec<u32> = (0..levels.len() as u32).collect();
    let mut openings = Vec::with_capacity(borders.len() * 2);
    for &border in borders {
        let number = |at: LevelCell| {
            let sets = levels.get(at.level as usize).filter(|sets| at.cell < sets.cell_count());
            let no_cell =
                SetsError::Part { part: at.level, problem: "a border names no cell of it" };
            sets.map(|_| first_cells[at.level as usize] + at.cell).ok_or(no_cell)
        };
        let [a, b] = border;
        let (from, to) = (number(a)?, number(b)?);
        openings.extend([[from, to], [to, from]]);
        let [low, high] = [a, b].map(|at| chain[at.level as usize]);
        let (low, high) = (low.min(high), low.max(high));
        chain.iter_mut().filter(|c| **c == high).for_each(|c| *c = low);
    }
    let words = (total as usize).div_ceil(64);
    let (mut rows, mut unknown) = (Vec::with_capacity(total as usize), 0);
    let mut entered = vec![0_u64; words];
    for cell in 0..total {
        let mut row = vec![0_u64; words];
        entered.fill(0);
        let mut left = vec![cell];
        bits::set(&mut entered, cell as usize, true);
        while let Some(at) = left.pop() {
            let level = level_of[at as usize] as usize;
            let first = first_cells[level];
            levels[level].visit(at - first, |word, bits| {
                let at = first as usize + word * 64;
                let (place, shift) = (at / 64, at % 64);
                row[place] |= bits << shift;
                if shift > 0 && bits >> (64 - shift) != 0 {
                    row[place + 1] |= bits >> (64 - shift);
                }
            });
            for &[from, to] in &openings {
                let (from, to) = (from as usize, to as usize);
                if bits::get(&row, from) && !bits::get(&entered, to) {
                    bits::set(&mut entered, to, true);
                    left.push(to as u32);
                }
            }
        }
        let own = chain[level_of[cell as usize] as usize];
        for (other, &level) in level_of.iter().enumerate() {
            if chain[level as usize] != own {
                bits::set(&mut row, other, true);
                unknown += 1;
            }
        }
        rows.push(row);
    }
    let sets = VisibleSets::from_rows(Targets::Cells, total, rows.iter().map(Vec::as_slice));
    Ok(JoinedSets { sets, first_cells, unknown })
}

#[cfg(test)]
mod tests {
    use cullet_testkit::Rng;

    use super::*;
    use crate::pvs::testing::sets_of;

    /// Grows sets by the borders until nothing changes.
    fn levels_ref(levels: &[Vec<Vec<bool>>], borders: &[[[usize; 2]; 2]]) -> Vec<Vec<bool>> {
        let mut first = vec![0];
        levels.iter().for_each(|level| first.push(first.last().unwrap_or(&0) + level.len()));
        let total = first[levels.len()];
        let number = |[level, cell]: [usize; 2]| first[level] + cell;
        let level_of = |cell: usize| first.iter().rposition(|&f| f <= cell).unwrap_or(0);
        let sees = |a: usize, b: usize| {
            let level = level_of(a);
            level == level_of(b) && levels[level][a - first[level]][b - first[level]]
        };
        let mut rows: Vec<Vec<bool>> =
            (0..total).map(|a| (0..total).map(|b| sees(a, b)).collect()).collect();
        let mut grown = true;
        while grown {
            grown = false;
            for row in &mut rows {
                for border in borders {
                    for [from, to] in [[0, 1], [1, 0]] {
                        let (from, to) = (number(border[from]), number(border[to]));
                        if !row[from] {
                            continue;
                        }
                        for other in (0..total).filter(|&other| sees(to, other)) {
                            grown |= !core::mem::replace(&mut row[other], true);
                        }
                    }
                }
            }
        }
        // Levels that no chain joins.
        let mut chained = vec![vec![false; levels.len()]; levels.len()];
        (0..levels.len()).for_each(|k| chained[k][k] = true);
        borders.iter().for_each(|[a, b]| {
            chained[a[0]][b[0]] = true;
            chained[b[0]][a[0]] = true;
        });
        for via in 0..levels.len() {
            for a in 0..levels.len() {
                for b in 0..levels.len() {
                    chained[a][b] |= chained[a][via] && chained[via][b];
                }
            }
        }
        for a in 0..total {
            for b in (0..total).filter(|&b| !chained[level_of(a)][level_of(b)]) {
                rows[a][b] = true;
            }
        }
        rows
    }

    #[test]
    fn levels_join_through_their_borders_as_by_plain_growth() {
        let mut rng = Rng(51);
        let (mut joined_some, mut unsure) = (0, 0);
        for _ in 0..cullet_testkit::cases(200) {
            let levels: Vec<Vec<Vec<bool>>> = (0..1 + rng.index(4))
                .map(|_| {
                    let cells = 1 + rng.index(40);
                    let row = |a: usize, rng: &mut Rng| -> Vec<bool> {
                        (0..cells).map(|b| a == b || rng.index(6) == 0).collect()
                    };
                    (0..cells).map(|a| row(a, &mut rng)).collect()
                })
                .collect();
            let borders: Vec<[[usize; 2]; 2]> = (0..rng.index(4))
                .map(|_| {
                    [0, 1].map(|_| {
                        let level = rng.index(levels.len());
                        [level, rng.index(levels[level].len())]
                    })
                })
                .collect();
            let sets: Vec<VisibleSets<'_>> =
                levels.iter().map(|rows| sets_of(rows, Targets::Cells, rows.len())).collect();
            let cell =
                |[level, cell]: [usize; 2]| LevelCell { level: level as u32, cell: cell as u32 };
            let borders_of: Vec<_> = borders.iter().map(|b| b.map(cell)).collect();
            let joined = join_levels(&sets, &borders_of).expect("levels");
            let rows = levels_ref(&levels, &borders);
            assert_eq!(joined.sets, sets_of(&rows, Targets::Cells, rows.len()));
            joined_some += u32::from(joined.unknown == 0 && levels.len() > 1);
            unsure += u32::from(joined.unknown > 0);
        }
        assert!(joined_some > 5 && unsure > 20, "{joined_some} {unsure}");
    }

    #[test]
    fn levels_that_do_not_fit_are_refused() {
        let cells = sets_of(&[vec![true]], Targets::Cells, 1);
        let instances = sets_of(&[vec![true]], Targets::Instances, 1);
        let border = |cell| [LevelCell { level: 0, cell }, LevelCell { level: 1, cell: 0 }];
        let both = [cells.clone(), cells.clone()];
        assert!(join_levels(&both, &[border(0)]).is_ok_and(|joined| joined.unknown == 0));
        assert!(join_levels(&both, &[]).is_ok_and(|joined| joined.unknown == 2));
        assert!(matches!(join_levels(&both, &[border(1)]), Err(SetsError::Part { part: 0, .. })));
        let mixed = [cells, instances];
        assert!(matches!(join_levels(&mixed, &[]), Err(SetsError::Part { part: 1, .. })));
    }
}
