//! From basins to the cells of voxels: straight cuts, and touched voxels given to those from which they are reached.

use super::basins::{Basins, NONE};
use super::voxels::{Grid, SOLID};

/// A cut that is farther from straight than so many voxels stays as it is.
const DEEPEST: usize = 24;

/// Whether one gets from a voxel to the next along an axis, by the states of both.
pub(super) fn is_open(state: u8, beyond: u8, axis: usize) -> bool {
    state & 15 != SOLID && beyond & 15 != SOLID && state >> (4 + axis) & 1 == 0
}

/// Makes cuts straight where that makes them no larger: between two basins, along one plane of the grid. Any cut is
/// sound; straight ones are few rectangles.
pub(super) fn straighten(grid: &Grid, basins: &mut Basins) {
    let strides = grid.strides();
    // Voxels on the border of two basins, by the two.
    let mut borders: Vec<([u32; 2], u32)> = Vec::new();
    let labels = &mut basins.labels;
    for voxel in 0..grid.len() - strides[2] {
        for stride in strides {
            let (a, b) = (labels[voxel], labels[voxel + stride]);
            if a != b && a != NONE && b != NONE {
                let pair = [a.min(b), a.max(b)];
                borders.extend([(pair, voxel as u32), (pair, (voxel + stride) as u32)]);
            }
        }
    }
    borders.sort_unstable();
    borders.dedup();
    let mut from = 0;
    while from < borders.len() {
        let pair = borders[from].0;
        let count = borders[from..].iter().take_while(|(p, _)| *p == pair).count();
        let voxels: Vec<u32> = borders[from..from + count].iter().map(|&(_, v)| v).collect();
        for group in groups(grid, &voxels) {
            straighten_one(grid, labels, pair, &group);
        }
        from += count;
    }
}

/// Voxels that hang together, also by their corners.
fn groups(grid: &Grid, voxels: &[u32]) -> Vec<Vec<u32>> {
    let mut seen = vec![false; voxels.len()];
    let mut out = Vec::new();
    for first in 0..voxels.len() {
        if seen[first] {
            continue;
        }
        seen[first] = true;
        let (mut group, mut at) = (vec![voxels[first]], 0);
        while at < group.len() {
            let [x, y, z] = grid.place(group[at] as usize);
            at += 1;
            // Rows that go on around the border of the grid join groups, and do no harm.
            for near_z in z.saturating_sub(1)..=z + 1 {
                for near_y in y.saturating_sub(1)..=y + 1 {
                    let start = grid.number([x.saturating_sub(1), near_y, near_z]) as u32;
                    let mut next = voxels.partition_point(|&v| v < start);
                    while next < voxels.len() && voxels[next] <= start + 2 {
                        if !seen[next] {
                            seen[next] = true;
                            group.push(voxels[next]);
                        }
                        next += 1;
                    }
                }
            }
        }
        out.push(group);
    }
    out
}

fn straighten_one(grid: &Grid, labels: &mut [u32], pair: [u32; 2], group: &[u32]) {
    let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
    for &voxel in group {
        let at = grid.place(voxel as usize);
        for a in 0..3 {
            low[a] = low[a].min(at[a]);
            high[a] = high[a].max(at[a]);
        }
    }
    // What is around the grid stays one cell.
    if (0..3).any(|a| low[a] == 0 || high[a] + 1 == grid.counts[a]) {
        return;
    }
    let strides = grid.strides();
    let of_pair = |label: u32| pair.contains(&label);
    // How many sides the cut has now, along each axis and in all.
    let mut sides = [0_usize; 3];
    each_in(grid, low, high, |voxel, at| {
        for a in 0..3 {
            if at[a] < high[a] && of_pair(labels[voxel]) {
                let beyond = labels[voxel + strides[a]];
                sides[a] += usize::from(of_pair(beyond) && beyond != labels[voxel]);
            }
        }
    });
    let most = (1..3).fold(0, |most, a| if sides[a] > sides[most] { a } else { most });
    if high[most] - low[most] + 1 > DEEPEST {
        return;
    }
    // The plane that the fewest sides are in, of several the one nearest to the middle.
    let mut widths = vec![0_usize; high[most] + 1];
    let mut of_low = [0_i64; 2];
    let middle = (low[most] + high[most]).div_ceil(2);
    each_in(grid, low, high, |voxel, at| {
        if of_pair(labels[voxel]) {
            let side = usize::from(at[most] >= middle);
            of_low[side] += if labels[voxel] == pair[0] { 1 } else { -1 };
            if at[most] > low[most] && of_pair(labels[voxel - strides[most]]) {
                widths[at[most]] += 1;
            }
        }
    });
    let planes = low[most] + 1..=high[most];
    let Some(cut) = planes.min_by_key(|&p| (widths[p], p.abs_diff(middle))) else { return };
    if widths[cut] > sides.iter().sum() {
        return;
    }
    let [first, second] = if of_low[0] >= of_low[1] { pair } else { [pair[1], pair[0]] };
    each_in(grid, low, high, |voxel, at| {
        if of_pair(labels[voxel]) {
            labels[voxel] = if at[most] < cut { first } else { second };
        }
    });
}

fn each_in(
    grid: &Grid,
    low: [usize; 3],
    high: [usize; 3],
    mut each: impl FnMut(usize, [usize; 3]),
) {
    for z in low[2]..=high[2] {
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                each(grid.number([x, y, z]), [x, y, z]);
            }
        }
    }
}

/// Gives all that is reached through open sides, and of no cell, to the cell that is nearest in steps. What is not reached
/// is seen from no cell.
pub(super) fn spread(grid: &Grid, states: &[u8], labels: &mut [u32]) {
    let strides = grid.strides();
    let inner = grid.counts.map(|n| n - 1);
    let mut front: Vec<u32> = Vec::new();
    // Neighbours of a voxel that are reached from it and have no cell.
    let reach = |voxel: usize, labels: &[u32], each: &mut dyn FnMut(usize)| {
        let at = grid.place(voxel);
        for a in 0..3 {
            if at[a] < inner[a] {
                let beyond = voxel + strides[a];
                if labels[beyond] == NONE && is_open(states[voxel], states[beyond], a) {
                    each(beyond);
                }
            }
            if at[a] > 0 {
                let before = voxel - strides[a];
                if labels[before] == NONE && is_open(states[before], states[voxel], a) {
                    each(before);
                }
            }
        }
    };
    for voxel in 0..grid.len() {
        if labels[voxel] != NONE {
            let mut has = false;
            reach(voxel, labels, &mut |_| has = true);
            if has {
                front.push(voxel as u32);
            }
        }
    }
    let mut found: Vec<(u32, u32)> = Vec::new();
    while !front.is_empty() {
        found.clear();
        for &voxel in &front {
            let own = labels[voxel as usize];
            reach(voxel as usize, labels, &mut |beside| found.push((beside as u32, own)));
        }
        // The lowest cell of those that come at once.
        found.sort_unstable();
        found.dedup_by_key(|(voxel, _)| *voxel);
        found.iter().for_each(|&(voxel, own)| labels[voxel as usize] = own);
        front.clear();
        front.extend(found.iter().map(|&(voxel, _)| voxel));
    }
}
