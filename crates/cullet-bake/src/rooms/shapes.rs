//! From voxels to boxes and rectangles.

use cullet_cells::cell::Portal;

use super::basins::NONE;
use super::found::FoundCell;
use super::regions::is_open;
use super::voxels::{FREE, Grid, SOLID};

/// The boxes of all cells: free voxels in pieces, others in skins. None overlap.
pub(super) fn boxes(grid: &Grid, states: &[u8], labels: &[u32], cells: &mut [FoundCell]) {
    let strides = grid.strides();
    let is_free = |voxel: usize| states[voxel] & 15 == FREE;
    let mut done: Vec<bool> =
        (0..grid.len()).map(|v| labels[v] == NONE || states[v] & 15 == SOLID).collect();
    for first in 0..grid.len() {
        if done[first] {
            continue;
        }
        let at = grid.place(first);
        let fits = |voxel: usize, done: &[bool]| {
            !done[voxel] && labels[voxel] == labels[first] && is_free(voxel) == is_free(first)
        };
        let mut counts = [1; 3];
        for axis in 0..3 {
            // Another layer, of all that there is along the axes before.
            while at[axis] + counts[axis] < grid.counts[axis] {
                let base = first + counts[axis] * strides[axis];
                let mut layer = counts;
                layer[axis] = 1;
                if !all_of(base, layer, strides, |voxel| fits(voxel, &done)) {
                    break;
                }
                counts[axis] += 1;
            }
        }
        all_of(first, counts, strides, |voxel| {
            done[voxel] = true;
            true
        });
        let low = std::array::from_fn(|a| grid.coordinate(a, at[a]));
        let high = std::array::from_fn(|a| grid.coordinate(a, at[a] + counts[a]));
        let cell = &mut cells[labels[first] as usize];
        if is_free(first) { &mut cell.pieces } else { &mut cell.skins }.push([low, high]);
    }
}

fn all_of(
    first: usize,
    counts: [usize; 3],
    strides: [usize; 3],
    mut test: impl FnMut(usize) -> bool,
) -> bool {
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            let row = first + y * strides[1] + z * strides[2];
            if !(row..row + counts[0]).all(&mut test) {
                return false;
            }
        }
    }
    true
}

/// A portal for every rectangle of open sides between voxels of two cells.
pub(super) fn portals(grid: &Grid, states: &[u8], labels: &[u32]) -> Vec<Portal> {
    let strides = grid.strides();
    let mut out = Vec::new();
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for layer in 1..grid.counts[axis] {
            // The sides of this plane, by the cells below and above, and by rows.
            let mut sides: Vec<([u32; 2], [usize; 2])> = Vec::new();
            for j in 0..grid.counts[c] {
                for i in 0..grid.counts[b] {
                    let above = layer * strides[axis] + i * strides[b] + j * strides[c];
                    let below = above - strides[axis];
                    let pair = [labels[below], labels[above]];
                    if pair[0] != pair[1]
                        && !pair.contains(&NONE)
                        && is_open(states[below], states[above], axis)
                    {
                        sides.push((pair, [i, j]));
                    }
                }
            }
            sides.sort_unstable_by_key(|&(pair, [i, j])| (pair, j, i));
            let mut from = 0;
            while from < sides.len() {
                let pair = sides[from].0;
                let count = sides[from..].iter().take_while(|(p, _)| *p == pair).count();
                let places: Vec<[usize; 2]> =
                    sides[from..from + count].iter().map(|&(_, at)| at).collect();
                for [low, high] in rectangles(&places) {
                    let corner = |i: usize, j: usize| {
                        let mut p = [0.0; 3];
                        p[axis] = grid.coordinate(axis, layer);
                        p[b] = grid.coordinate(b, i);
                        p[c] = grid.coordinate(c, j);
                        p
                    };
                    // Along b and then c they turn about the axis, and face whoever looks from
                    // above.
                    let polygon = vec![
                        corner(low[0], low[1]),
                        corner(high[0], low[1]),
                        corner(high[0], high[1]),
                        corner(low[0], high[1]),
                    ];
                    out.push(Portal { cells: [pair[1], pair[0]], polygon });
                }
                from += count;
            }
        }
    }
    out
}

/// Rectangles that places make up, each by its first and behind its last; places are sorted by row.
/// The fewer of those that grow along rows first, and along columns.
fn rectangles(places: &[[usize; 2]]) -> Vec<[[usize; 2]; 2]> {
    let turned = |places: &[[usize; 2]]| -> Vec<[usize; 2]> {
        let mut turned: Vec<_> = places.iter().map(|&[i, j]| [j, i]).collect();
        turned.sort_unstable_by_key(|&[i, j]| (j, i));
        turned
    };
    let rows = stacked(places);
    let columns = stacked(&turned(places));
    if rows.len() <= columns.len() {
        return rows;
    }
    columns.into_iter().map(|[[a, b], [c, d]]| [[b, a], [d, c]]).collect()
}

/// Runs of rows, stacked where the next row has the same run.
fn stacked(places: &[[usize; 2]]) -> Vec<[[usize; 2]; 2]> {
    let mut out: Vec<[[usize; 2]; 2]> = Vec::new();
    let mut grows: Vec<usize> = Vec::new();
    let mut from = 0;
    while from < places.len() {
        let row = places[from][1];
        let end = from + places[from..].iter().take_while(|p| p[1] == row).count();
        let mut now = Vec::new();
        while from < end {
            let first = places[from][0];
            let count = (from..end).take_while(|&k| places[k][0] == first + (k - from)).count();
            let run = [first, first + count];
            from += count;
            let same = grows.iter().copied().find(|&at| {
                let [low, high] = out[at];
                [low[0], high[0]] == run && high[1] == row
            });
            let at = same.unwrap_or_else(|| {
                out.push([[run[0], row], [run[1], row]]);
                out.len() - 1
            });
            out[at][1][1] = row + 1;
            now.push(at);
        }
        grows = now;
    }
    out
}
