//! Greedy merging of neighbouring clusters under the cost model T = t + (1 − P) n r.
//!
//! Two clusters are merged where that lowers the expected cost: what is saved is one test, what is
//! lost are those triangles that each alone would have culled more often. Johannsen & Carter,
//! *Clustered Backface Culling* (1998). The best pair goes first; a queue holds every pair of
//! neighbours, and pairs whose clusters have since been merged with others are dropped when they
//! come up.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use cullet::bounds::Aabb;

use super::surface::PartSurface;
use crate::sample::find;

/// How often a cluster is culled.
pub(super) trait Estimate {
    /// Data of a cluster that the estimate needs.
    type State: Clone;
    /// The count of a cluster that is always culled.
    fn unit(&self) -> i64;
    /// Returns the state of one triangle.
    fn leaf(&self, triangle: u32) -> Self::State;
    /// Returns the state of two clusters together.
    fn join(&self, a: &Self::State, b: &Self::State) -> Self::State;
    /// How often it is culled, of [`unit`](Self::unit).
    fn hits(&self, state: &Self::State) -> i64;
}

/// Limits of a cluster.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) vertices: usize,
    pub(super) triangles: usize,
}

/// From what merging starts.
pub(super) struct Start {
    /// The cluster of each triangle.
    pub(super) of: Vec<u32>,
    /// How many clusters there are.
    pub(super) clusters: usize,
    /// Pairs of clusters that may be merged; twice or in either order does no harm.
    pub(super) links: Vec<(u32, u32)>,
}

impl Start {
    /// Single triangles, joined at their edges.
    pub(super) fn triangles(surface: &PartSurface) -> Self {
        let of: Vec<u32> = (0..surface.len() as u32).collect();
        Self { links: links(surface, &of), clusters: of.len(), of }
    }
}

/// Pairs of clusters that share an edge, each once.
pub(super) fn links(surface: &PartSurface, of: &[u32]) -> Vec<(u32, u32)> {
    let mut pairs = Vec::with_capacity(of.len() * 2);
    for t in 0..of.len() as u32 {
        let a = of[t as usize];
        let near = surface.neighbours(t).iter().map(|&u| of[u as usize]);
        pairs.extend(near.filter(|&b| a < b).map(|b| (a, b)));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Costs by which merging chooses.
#[derive(Clone, Copy, Debug)]
pub(super) struct MergeCosts {
    /// t/r.
    pub(super) test: f64,
    /// The widest box that a merged cluster may have, as its diagonal; narrower ones go first.
    /// Infinite where only the cost counts.
    pub(super) widest: f32,
}

struct Node<S> {
    state: S,
    /// Triangles × hits.
    value: i64,
    count: u32,
    /// How often it was merged: entries of the queue from before are void.
    stamp: u32,
    /// First and last triangle of the chain.
    ends: (u32, u32),
    bounds: Aabb,
    /// Sorted.
    vertices: Vec<u32>,
    neighbours: Vec<u32>,
}

/// Merges clusters; returns the cluster of each triangle, and the number of clusters.
///
/// O(n log n), some 4 µs a triangle from single ones. `step` is told now and then how many merges
/// were made, and stops them by returning false: what was merged stays.
pub(super) fn merge<E: Estimate>(
    surface: &PartSurface,
    estimate: &E,
    start: &Start,
    limits: Limits,
    costs: MergeCosts,
    mut step: impl FnMut(usize) -> bool,
) -> (Vec<u32>, usize) {
    let test = (costs.test * estimate.unit() as f64) as i64;
    let mut next = vec![u32::MAX; surface.len()];
    let mut nodes = nodes(surface, estimate, start, &mut next);
    // The gain, less up to one test for a wide box.
    let gain = |a: &Node<E::State>, b: &Node<E::State>| -> Option<i64> {
        let count = a.count + b.count;
        if count as usize > limits.triangles {
            return None;
        }
        let hits = estimate.hits(&estimate.join(&a.state, &b.state));
        let gain = test + hits * i64::from(count) - a.value - b.value;
        if gain <= 0 {
            return None;
        }
        if costs.widest == f32::INFINITY {
            return Some(gain);
        }
        let wide = diagonal(&a.bounds.union(&b.bounds));
        (wide <= costs.widest).then(|| gain - (wide / costs.widest * test as f32) as i64)
    };
    // Of equal gains the lower numbers go first.
    let entry = |nodes: &[Node<E::State>], a: u32, b: u32| {
        let (a, b) = (a.min(b), a.max(b));
        let (x, y) = (&nodes[a as usize], &nodes[b as usize]);
        gain(x, y).map(|g| (g, Reverse((a, b)), x.stamp, y.stamp))
    };
    let mut heap: BinaryHeap<_> =
        start.links.iter().filter_map(|&(a, b)| entry(&nodes, a, b)).collect();
    let mut into: Vec<u32> = (0..nodes.len() as u32).collect();
    let mut union = Vec::new();
    let mut merges = 0;
    while let Some((_, Reverse((a, b)), stamp_a, stamp_b)) = heap.pop() {
        let (x, y) = (&nodes[a as usize], &nodes[b as usize]);
        if (x.stamp, y.stamp) != (stamp_a, stamp_b) {
            continue;
        }
        unite(&x.vertices, &y.vertices, &mut union);
        if union.len() > limits.vertices {
            continue;
        }
        let nothing = gone(&x.state);
        let mut y = std::mem::replace(&mut nodes[b as usize], nothing);
        let x = &mut nodes[a as usize];
        into[b as usize] = a;
        next[x.ends.1 as usize] = y.ends.0;
        x.ends.1 = y.ends.1;
        x.state = estimate.join(&x.state, &y.state);
        x.count += y.count;
        x.value = estimate.hits(&x.state) * i64::from(x.count);
        x.stamp += 1;
        x.bounds = x.bounds.union(&y.bounds);
        x.vertices.clone_from(&union);
        x.neighbours.append(&mut y.neighbours);
        let mut near = std::mem::take(&mut x.neighbours);
        near.iter_mut().for_each(|c| *c = find(&mut into, *c));
        near.sort_unstable();
        near.dedup();
        near.retain(|&c| c != a);
        heap.extend(near.iter().filter_map(|&c| entry(&nodes, a, c)));
        nodes[a as usize].neighbours = near;
        merges += 1;
        if merges % 4096 == 0 && !step(merges) {
            break;
        }
    }
    let mut of = vec![0; surface.len()];
    let mut clusters = 0;
    for node in nodes.iter().filter(|n| n.count > 0) {
        let mut t = node.ends.0;
        while t != u32::MAX {
            of[t as usize] = clusters;
            t = next[t as usize];
        }
        clusters += 1;
    }
    (of, clusters as usize)
}

/// The clusters to start with; `next` becomes the chains of their triangles.
fn nodes<E: Estimate>(
    surface: &PartSurface,
    estimate: &E,
    start: &Start,
    next: &mut [u32],
) -> Vec<Node<E::State>> {
    let mut nodes: Vec<Option<Node<E::State>>> = Vec::new();
    nodes.resize_with(start.clusters, || None);
    for (t, &c) in start.of.iter().enumerate() {
        let (leaf, corners) = (estimate.leaf(t as u32), surface.corners[t]);
        match &mut nodes[c as usize] {
            None => {
                nodes[c as usize] = Some(Node {
                    state: leaf,
                    value: 0,
                    count: 1,
                    stamp: 0,
                    ends: (t as u32, t as u32),
                    bounds: surface.boxes[t],
                    vertices: corners.to_vec(),
                    neighbours: Vec::new(),
                });
            }
            Some(node) => {
                node.state = estimate.join(&node.state, &leaf);
                node.count += 1;
                next[node.ends.1 as usize] = t as u32;
                node.ends.1 = t as u32;
                node.bounds = node.bounds.union(&surface.boxes[t]);
                node.vertices.extend(corners);
            }
        }
    }
    let mut nodes: Vec<Node<E::State>> = nodes.into_iter().flatten().collect();
    debug_assert_eq!(nodes.len(), start.clusters, "no cluster is empty");
    for node in &mut nodes {
        node.value = estimate.hits(&node.state) * i64::from(node.count);
        node.vertices.sort_unstable();
        node.vertices.dedup();
    }
    for &(a, b) in &start.links {
        nodes[a as usize].neighbours.push(b);
        nodes[b as usize].neighbours.push(a);
    }
    nodes
}

/// Placeholder of a cluster that was merged into another.
fn gone<S: Clone>(state: &S) -> Node<S> {
    Node {
        state: state.clone(),
        value: 0,
        count: 0,
        stamp: u32::MAX,
        ends: (u32::MAX, u32::MAX),
        bounds: Aabb::EMPTY,
        vertices: Vec::new(),
        neighbours: Vec::new(),
    }
}

/// Returns the diagonal of a box that is not empty.
pub(super) fn diagonal(b: &Aabb) -> f32 {
    let side = |k: usize| f64::from(b.max[k]) - f64::from(b.min[k]);
    (side(0).powi(2) + side(1).powi(2) + side(2).powi(2)).sqrt() as f32
}

/// The union of two sorted lists.
fn unite(a: &[u32], b: &[u32], out: &mut Vec<u32>) {
    out.clear();
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        let (x, y) = (a[i], b[j]);
        out.push(x.min(y));
        i += usize::from(x <= y);
        j += usize::from(y <= x);
    }
    out.extend_from_slice(&a[i..]);
    out.extend_from_slice(&b[j..]);
}

#[cfg(test)]
pub(super) mod tests {
    use cullet::mesh::weld;

    use super::super::surface::Frame;
    use super::super::views::Views;
    use super::*;
    use crate::sample::view_points;

    /// A bumpy sheet of `side`² quads.
    pub(in super::super) fn sheet(side: u32) -> (Vec<[f32; 3]>, PartSurface, Views<4>) {
        let at = |i: u32, j: u32| i * (side + 1) + j;
        let positions: Vec<[f32; 3]> = (0..(side + 1).pow(2))
            .map(|v| {
                let (x, y) = ((v % (side + 1)) as f32, (v / (side + 1)) as f32);
                [x, y, (x * 0.9).sin() * 1.5 + (y * 1.3).cos()]
            })
            .collect();
        let quads = (0..side * side).map(|q| (q / side, q % side));
        let indices: Vec<u32> = quads
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                [a, b, c, a, c, d]
            })
            .collect();
        let triangles = indices.len() as u32 / 3;
        let surface =
            PartSurface::new(&positions, &indices, &weld(&positions), (0..triangles).collect());
        let frame = Frame::around(&positions, std::slice::from_ref(&surface));
        let points = view_points(256, &[1.5, 3.0]);
        let views = Views::new(&positions, &surface, &frame, &points);
        (positions, surface, views)
    }

    /// The oracle: looks at all pairs of clusters in each step, and knows a cluster by its
    /// triangles.
    fn merge_ref(
        surface: &PartSurface,
        views: &Views<4>,
        limits: Limits,
        test: f64,
    ) -> Vec<Vec<u32>> {
        let value = |c: &[u32]| {
            let hits =
                c.iter().fold([u64::MAX; 4], |b, &t| views.join(&b, &views.behind[t as usize]));
            views.hits(&hits) * c.len() as i64
        };
        let mut clusters: Vec<Vec<u32>> = (0..surface.len() as u32).map(|t| vec![t]).collect();
        loop {
            let mut best = (0, 0, 0);
            for b in 0..clusters.len() {
                for a in 0..b {
                    let (x, y) = (&clusters[a], &clusters[b]);
                    let touch =
                        x.iter().any(|&t| surface.neighbours(t).iter().any(|u| y.contains(u)));
                    let joint = [x.as_slice(), y].concat();
                    let mut vertices: Vec<u32> =
                        joint.iter().flat_map(|&t| surface.corners[t as usize]).collect();
                    vertices.sort_unstable();
                    vertices.dedup();
                    if !touch || joint.len() > limits.triangles || vertices.len() > limits.vertices
                    {
                        continue;
                    }
                    let gain = (test * 256.0) as i64 + value(&joint) - value(x) - value(y);
                    // Of equal gains the pair with the lowest first cluster, then second.
                    if gain > best.0 || gain == best.0 && gain > 0 && (a, b) < (best.1, best.2) {
                        best = (gain, a, b);
                    }
                }
            }
            let (gain, a, b) = best;
            if gain <= 0 {
                return clusters.into_iter().filter(|c| !c.is_empty()).collect();
            }
            let mut joined = std::mem::take(&mut clusters[b]);
            clusters[a].append(&mut joined);
        }
    }

    #[test]
    fn merging_takes_the_best_pair_every_time() {
        let (_, surface, views) = sheet(6);
        for (vertices, triangles, test) in
            [(64, 124, 4.0), (12, 124, 4.0), (64, 7, 1.0), (10, 9, 30.0)]
        {
            let limits = Limits { vertices, triangles };
            let costs = MergeCosts { test, widest: f32::INFINITY };
            let start = Start::triangles(&surface);
            let (of, clusters) = merge(&surface, &views, &start, limits, costs, |_| true);
            let mut fast = vec![Vec::new(); clusters];
            of.iter().zip(0u32..).for_each(|(&c, t)| fast[c as usize].push(t));
            let mut slow = merge_ref(&surface, &views, limits, test);
            slow.iter_mut().for_each(|c| c.sort_unstable());
            fast.sort();
            slow.sort();
            assert!(clusters < surface.len() / 3, "{clusters} clusters are hardly merged");
            assert_eq!(fast, slow, "{vertices} vertices, {triangles} triangles, t/r {test}");
        }
    }
}
