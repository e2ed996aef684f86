//! From basins to the cells of voxels: straight cuts, and touched voxels given to those from which
//! they are reached.

use super::basins::NONE;
use super::voxels::{Grid, SOLID};

/// A cut that is farther from straight than so many voxels stays as it is.
const DEEPEST: usize = 40;
/// So many voxels beyond a cut a narrower place is looked for.
const GROWN: usize = 5;

/// Whether one gets from a voxel to the next along an axis, by the states of both.
pub(super) fn is_open(state: u8, beyond: u8, axis: usize) -> bool {
    state & 15 != SOLID && beyond & 15 != SOLID && state >> (4 + axis) & 1 == 0
}

/// Makes cuts straight, by the open sides between voxels, where that makes them hardly larger:
/// between two basins, along one plane of the grid. Any cut is sound; straight ones are few
/// rectangles.
pub(super) fn straighten(grid: &Grid, states: &[u8], labels: &mut [u32]) {
    let strides = grid.strides();
    // Voxels on the border of two basins, by the two.
    let mut borders: Vec<([u32; 2], u32)> = Vec::new();
    for voxel in 0..grid.len() - strides[2] {
        for (axis, stride) in strides.into_iter().enumerate() {
            let (a, b) = (labels[voxel], labels[voxel + stride]);
            if a != b
                && a != NONE
                && b != NONE
                && is_open(states[voxel], states[voxel + stride], axis)
            {
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
            straighten_one(grid, states, labels, pair, &group);
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

fn straighten_one(grid: &Grid, states: &[u8], labels: &mut [u32], pair: [u32; 2], group: &[u32]) {
    let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
    for &voxel in group {
        let at = grid.place(voxel as usize);
        for a in 0..3 {
            low[a] = low[a].min(at[a]);
            high[a] = high[a].max(at[a]);
        }
    }
    let strides = grid.strides();
    let of_pair = |label: u32| pair.contains(&label);
    // How many sides the cut has along each axis.
    let mut sides = [0_usize; 3];
    each_in(grid, low, high, |voxel, at| {
        for a in 0..3 {
            if at[a] < high[a] && of_pair(labels[voxel]) {
                let beyond = labels[voxel + strides[a]];
                let is_open = is_open(states[voxel], states[voxel + strides[a]], a);
                sides[a] += usize::from(is_open && of_pair(beyond) && beyond != labels[voxel]);
            }
        }
    });
    let axis = (1..3).fold(0, |most, a| if sides[a] > sides[most] { a } else { most });
    // The door may be a little farther on.
    low[axis] = low[axis].saturating_sub(GROWN);
    high[axis] = (high[axis] + GROWN).min(grid.counts[axis] - 1);
    // What is around the grid stays one cell.
    let is_inner = (0..3).all(|a| low[a] > 0 && high[a] + 1 < grid.counts[a]);
    if !is_inner || high[axis] - low[axis] >= DEEPEST {
        return;
    }
    let middle = (low[axis] + high[axis]).div_ceil(2);
    let mut of_low = [0_i64; 2];
    each_in(grid, low, high, |voxel, at| {
        let one = i64::from(labels[voxel] == pair[0]) - i64::from(labels[voxel] == pair[1]);
        of_low[usize::from(at[axis] >= middle)] += one;
    });
    let [first, second] = if of_low[0] >= of_low[1] { pair } else { [pair[1], pair[0]] };
    // By layer: sides to the layer before, and to voxels of each of the two around the box; sides
    // that the cut has now.
    let deep = high[axis] - low[axis] + 1;
    let mut layers = vec![[0_usize; 3]; deep];
    let (mut ends, mut now) = ([[0_usize; 2]; 2], 0);
    each_in(grid, low, high, |voxel, at| {
        let own = labels[voxel];
        if !of_pair(own) {
            return;
        }
        let layer = &mut layers[at[axis] - low[axis]];
        for a in 0..3 {
            for (beside, is_out) in
                [(voxel - strides[a], at[a] == low[a]), (voxel + strides[a], at[a] == high[a])]
            {
                let other = labels[beside];
                let is_before = beside < voxel;
                let lower = voxel.min(beside);
                if !of_pair(other) || !is_open(states[lower], states[lower + strides[a]], a) {
                    continue;
                }
                now += usize::from(other != own && (is_out || is_before));
                let which = usize::from(other == second);
                if is_out && a == axis {
                    ends[usize::from(!is_before)][which] += 1;
                } else if is_out {
                    layer[1 + which] += 1;
                } else if a == axis && is_before {
                    layer[0] += 1;
                }
            }
        }
    });
    let cost = |cut: usize| {
        let below: usize = layers[..cut].iter().map(|layer| layer[2]).sum();
        let above: usize = layers[cut..].iter().map(|layer| layer[1]).sum();
        let within = if cut > 0 && cut < deep { layers[cut][0] } else { 0 };
        // The lowest layer is of the first, unless the cut is below it.
        let low = ends[0][usize::from(cut > 0)];
        let high = ends[1][usize::from(cut == deep)];
        below + above + within + low + high
    };
    let best = (0..=deep).min_by_key(|&cut| (cost(cut), (low[axis] + cut).abs_diff(middle)));
    let Some(cut) = best.filter(|&cut| cost(cut) * 4 <= now * 5) else { return };
    each_in(grid, low, high, |voxel, at| {
        if of_pair(labels[voxel]) {
            labels[voxel] = if at[axis] < low[axis] + cut { first } else { second };
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

/// Gives all that is reached through open sides, and of no cell, to the cell that is nearest in
/// steps. What is not reached is seen from no cell.
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
