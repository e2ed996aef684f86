//! Cuts triangles into clusters, and clusters into groups, of neighbours.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use cullet::bounds::Aabb;

use crate::sample::{find, nearby};

/// The limits of a cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClusterSize {
    pub(super) vertices: usize,
    pub(super) triangles: usize,
}

/// Triangles in the order of their clusters, and how many each cluster has.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Cut {
    pub(super) order: Vec<u32>,
    pub(super) counts: Vec<u32>,
}

/// A triangle that waits for its cluster.
#[derive(Clone, Copy, Debug)]
struct Item {
    middle: [f32; 3],
    number: u32,
}

/// Cuts triangles into clusters of equal size: halved across the longest side of the box around
/// their middles, until each part is within the limits. Within a cluster they keep their order.
pub(super) fn cut_into_clusters(positions: &[[f32; 3]], indices: &[u32], size: ClusterSize) -> Cut {
    let middle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        // A third first: a sum of three could overflow.
        [0, 1, 2].map(|k| a[k] / 3.0 + b[k] / 3.0 + c[k] / 3.0)
    };
    let triangles = indices.as_chunks::<3>().0;
    let mut items: Vec<Item> =
        (0..).zip(triangles).map(|(number, t)| Item { middle: middle(t), number }).collect();
    let mut cut = Cut { order: Vec::with_capacity(items.len()), counts: Vec::new() };
    halve(&mut items, triangles, size, &mut cut, &mut Vec::new());
    cut
}

fn halve(
    items: &mut [Item],
    triangles: &[[u32; 3]],
    size: ClusterSize,
    cut: &mut Cut,
    vertices: &mut Vec<u32>,
) {
    let mut parts = items.len().div_ceil(size.triangles);
    if parts <= 1 {
        vertices.clear();
        vertices.extend(items.iter().flat_map(|i| triangles[i.number as usize]));
        vertices.sort_unstable();
        vertices.dedup();
        if vertices.len() <= size.vertices {
            if !items.is_empty() {
                items.sort_unstable_by_key(|i| i.number);
                cut.order.extend(items.iter().map(|i| i.number));
                cut.counts.push(items.len() as u32);
            }
            return;
        }
        parts = 2;
    }
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for item in items.iter() {
        for a in 0..3 {
            low[a] = low[a].min(item.middle[a]);
            high[a] = high[a].max(item.middle[a]);
        }
    }
    let side = |a: usize| high[a] - low[a];
    let axis = (1..3).fold(0, |best, a| if side(a) > side(best) { a } else { best });
    let mid = (items.len() * (parts / 2) / parts).max(1);
    // By number where places are equal, so that the halves are the same everywhere.
    let order = |x: &Item, y: &Item| -> Ordering {
        x.middle[axis].total_cmp(&y.middle[axis]).then(x.number.cmp(&y.number))
    };
    items.select_nth_unstable_by(mid, order);
    let (left, right) = items.split_at_mut(mid);
    halve(left, triangles, size, cut, vertices);
    halve(right, triangles, size, cut, vertices);
}

/// Most clusters at one place that are all neighbours of each other.
const CROWD: usize = 12;

/// Puts clusters into groups of some `size` neighbours, at most a third more; for each cluster its
/// group, numbered from 0 in the order of their first clusters. Neighbours are those that share
/// places, and where none do those that are near; `clusters` are the places of the corners of each.
///
/// The smallest group is joined with the neighbour with which it shares most, again and again.
pub(super) fn partition<'a>(
    positions: &[[f32; 3]],
    clusters: impl Iterator<Item = &'a [u32]>,
    place: &[u32],
    size: usize,
) -> Vec<u32> {
    // For each place the last use of it: a cluster, and the use before.
    let mut last = vec![u32::MAX; positions.len()];
    let mut uses: Vec<(u32, u32)> = Vec::new();
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    let mut boxes = Vec::new();
    for (number, corners) in (0..).zip(clusters) {
        let mut points = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for &v in corners {
            let at = place[v as usize] as usize;
            for a in 0..3 {
                points[0][a] = points[0][a].min(positions[at][a]);
                points[1][a] = points[1][a].max(positions[at][a]);
            }
            let mut before = last[at];
            if uses.get(before as usize).is_some_and(|u| u.0 == number) {
                continue;
            }
            last[at] = uses.len() as u32;
            uses.push((number, before));
            for _ in 0..CROWD {
                let Some(&(other, next)) = uses.get(before as usize) else { break };
                pairs.push((other, number));
                before = next;
            }
        }
        boxes.push(Aabb::new(points[0], points[1]));
    }
    let count = boxes.len();
    pairs.sort_unstable();
    // Neighbours of each group, with how many places are shared.
    let mut near: Vec<Vec<(u32, u32)>> = vec![Vec::new(); count];
    let mut add = |(a, b): (u32, u32), shared: u32| {
        near[a as usize].push((b, shared));
        near[b as usize].push((a, shared));
    };
    pairs.chunk_by(|a, b| a == b).for_each(|same| add(same[0], same.len() as u32));
    nearby(&boxes).into_iter().for_each(|pair| add(pair, 0));
    let most = size + size / 3;
    let mut into: Vec<u32> = (0..count as u32).collect();
    let mut sizes = vec![1usize; count];
    let mut waiting: BinaryHeap<Reverse<(usize, u32)>> =
        (0..count as u32).map(|c| Reverse((1, c))).collect();
    while let Some(Reverse((own, group))) = waiting.pop() {
        if own >= size {
            break;
        }
        if into[group as usize] != group || sizes[group as usize] != own {
            continue;
        }
        let mut around = std::mem::take(&mut near[group as usize]);
        around.iter_mut().for_each(|n| n.0 = find(&mut into, n.0));
        around.retain(|n| n.0 != group);
        around.sort_unstable();
        around.dedup_by(|b, a| {
            let same = a.0 == b.0;
            a.1 += if same { b.1 } else { 0 };
            same
        });
        // More shared beside the root of the size is better; of equals the first.
        let mut best: Option<(u64, u64, u32)> = None;
        for &(other, shared) in around.iter().filter(|n| own + sizes[n.0 as usize] <= most) {
            let (shared, of) = (u64::from(shared).pow(2), sizes[other as usize] as u64);
            let is_better = |b: &(u64, u64, u32)| match (shared * b.1).cmp(&(b.0 * of)) {
                Ordering::Equal => of < b.1,
                order => order == Ordering::Greater,
            };
            if best.as_ref().is_none_or(is_better) {
                best = Some((shared, of, other));
            }
        }
        let Some((.., other)) = best else { continue };
        into[other as usize] = group;
        sizes[group as usize] += sizes[other as usize];
        around.append(&mut near[other as usize]);
        near[group as usize] = around;
        waiting.push(Reverse((sizes[group as usize], group)));
    }
    let mut number = vec![u32::MAX; count];
    let mut next = 0;
    (0..count as u32)
        .map(|c| {
            let known = &mut number[find(&mut into, c) as usize];
            if *known == u32::MAX {
                *known = next;
                next += 1;
            }
            *known
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::soups;

    #[test]
    fn clusters_hold_each_triangle_once_and_groups_are_of_the_size() {
        for (positions, indices) in [soups::terrain(40), soups::bumpy_ball(40, 0.05)] {
            let size = ClusterSize { vertices: 64, triangles: 64 };
            let cut = cut_into_clusters(&positions, &indices, size);
            let mut sorted = cut.order.clone();
            sorted.sort_unstable();
            assert!(sorted.iter().copied().eq(0..(indices.len() / 3) as u32));
            assert!(cut.counts.iter().all(|c| (1..=64).contains(c)));
            // None is nearly empty.
            assert!(cut.counts.len() * 40 < indices.len() / 3, "{} clusters", cut.counts.len());
            let corners: Vec<u32> = cut
                .order
                .iter()
                .flat_map(|&t| indices[t as usize * 3..][..3].iter().copied())
                .collect();
            let mut rest = &corners[..];
            let clusters: Vec<&[u32]> = cut
                .counts
                .iter()
                .map(|&count| {
                    let (own, after) = rest.split_at(count as usize * 3);
                    rest = after;
                    own
                })
                .collect();
            let place: Vec<u32> = (0..positions.len() as u32).collect();
            let groups = partition(&positions, clusters.iter().copied(), &place, 8);
            assert_eq!(groups.len(), cut.counts.len());
            let number = groups.iter().max().map_or(0, |g| *g as usize + 1);
            let mut members = vec![0; number];
            groups.iter().for_each(|&g| members[g as usize] += 1);
            assert!(members.iter().all(|m| (1..=10).contains(m)), "{members:?}");
            assert!(number * 5 <= groups.len() + 12, "{number} of {}", groups.len());
        }
    }

    #[test]
    fn triangles_that_share_nothing_are_cut_by_their_vertices_and_grouped_by_place() {
        let (positions, indices) = soups::scattered(500);
        let size = ClusterSize { vertices: 64, triangles: 64 };
        let cut = cut_into_clusters(&positions, &indices, size);
        assert!(cut.counts.iter().all(|c| *c * 3 <= 64));
        let one = |t: u32| &indices[t as usize * 3..][..3];
        let place: Vec<u32> = (0..positions.len() as u32).collect();
        let groups = partition(&positions, (0..500).map(one), &place, 8);
        let number = groups.iter().max().map_or(0, |g| *g as usize + 1);
        assert!(number * 4 < 500, "{number}");
        assert_eq!(cut_into_clusters(&positions, &[], size), Cut::default());
        assert!(partition(&positions, std::iter::empty(), &place, 8).is_empty());
    }
}
