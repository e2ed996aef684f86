//! The paper's algorithms as it tells them: one box, one plane, one number at a time.

use cullet::view::{Frustum, FrustumPlane};
use glam::DVec3;

/// A binary tree over boxes; its leaves are the boxes.
#[derive(Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Number of the box at each place, so that a node is a range of them.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    min: DVec3,
    max: DVec3,
    /// The boxes below, in the order of the tree.
    first: u32,
    count: u32,
    /// The second child; the first comes next after its parent.
    second: u32,
    /// The longest way from the origin to a corner, and half of the diagonal.
    reach: f64,
    radius: f64,
}

/// Tricks of the paper that are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Tricks {
    /// Octant test: of two opposite planes, the one on the other side of the middle is not tested
    /// where the box is too small to reach it.
    pub(super) octant: bool,
    /// A plane that a node is inside of is not tested below.
    pub(super) masking: bool,
    /// The plane that rejected a node last is tested first.
    pub(super) plane: bool,
    /// A node that a plane rejected by more than the plane has moved and turned since is rejected
    /// again.
    pub(super) motion: bool,
}

/// Counts of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub(super) nodes: u64,
    /// Boxes against planes, p-vertex and n-vertex being one test.
    pub(super) planes: u64,
}

/// A plane of the frustum, n·x = d with n of length 1 that points out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Side {
    n: DVec3,
    d: f64,
}

/// Six sides, of which 2 i and 2 i + 1 are opposite.
pub(super) type Sides = [Side; 6];

/// The sides of a frustum; `None` if one is missing.
pub(super) fn sides(frustum: &Frustum) -> Option<Sides> {
    use FrustumPlane::{Bottom, Far, Left, Near, Right, Top};
    let side = |which| {
        let p = frustum.plane(which)?.normalized()?;
        Some(Side { n: p.normal.into(), d: p.d })
    };
    Some([side(Near)?, side(Far)?, side(Left)?, side(Right)?, side(Bottom)?, side(Top)?])
}

/// State kept from frame to frame.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// Plane that rejected each node last.
    last: Vec<u8>,
    /// Total distance that this plane may move until the node must be tested again, for each node.
    due: Vec<f64>,
    /// Total movement of each plane: a constant, and an addition for each unit from the origin.
    gone: [(f64, f64); 6],
    before: Option<Sides>,
    stack: Vec<(u32, u8)>,
}

impl Tree {
    /// Splits the boxes at the median of their middles along the longest side, down to single ones.
    pub(super) fn new(boxes: &[[DVec3; 2]]) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(boxes.len() * 2),
            order: (0..boxes.len() as u32).collect(),
        };
        if !boxes.is_empty() {
            let mut order = std::mem::take(&mut tree.order);
            tree.split(boxes, &mut order, 0);
            tree.order = order;
        }
        tree
    }

    fn split(&mut self, boxes: &[[DVec3; 2]], order: &mut [u32], first: u32) {
        let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [min, max] = order.iter().fold(start, |[low, high], &i| {
            let [a, b] = boxes[i as usize];
            [low.min(a), high.max(b)]
        });
        let at = self.nodes.len();
        let count = order.len() as u32;
        let reach = min.abs().max(max.abs()).length();
        let radius = (max - min).length() * 0.5;
        self.nodes.push(Node { min, max, first, count, second: 0, reach, radius });
        if count == 1 {
            return;
        }
        let axis = (max - min).max_position();
        let middle = |i: u32| boxes[i as usize].iter().map(|v| v[axis]).sum::<f64>();
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)));
        let (low, high) = order.split_at_mut(half);
        self.split(boxes, low, first);
        self.nodes[at].second = self.nodes.len() as u32;
        self.split(boxes, high, first + half as u32);
    }

    /// Nothing known of any node.
    pub(super) fn state(&self) -> State {
        State {
            last: vec![0; self.nodes.len()],
            due: vec![f64::NEG_INFINITY; self.nodes.len()],
            gone: [(0.0, 0.0); 6],
            before: None,
            stack: Vec::new(),
        }
    }

    /// Lists runs of visible boxes, in the order of the tree.
    pub(super) fn cull(
        &self,
        sides: &Sides,
        tricks: Tricks,
        state: &mut State,
        visible: &mut Vec<(u32, u32)>,
    ) -> Counts {
        visible.clear();
        let mut counts = Counts::default();
        if tricks.motion {
            state.moves(sides);
        }
        state.stack.clear();
        if !self.nodes.is_empty() {
            state.stack.push((0, 0x3f));
        }
        while let Some((at, mask)) = state.stack.pop() {
            let node = &self.nodes[at as usize];
            counts.nodes += 1;
            let last = usize::from(state.last[at as usize]);
            if tricks.motion {
                let (a, b) = state.gone[last];
                if state.due[at as usize] > a + b * node.reach {
                    continue;
                }
            }
            let open = if tricks.masking { mask } else { 0x3f };
            let to_test = if tricks.octant { open & !hidden(node, sides, open) } else { open };
            let mut across = 0;
            let mut rejected = None;
            let first = if tricks.plane { 1 << last & to_test } else { 0 };
            for part in [first, to_test & !first] {
                let mut left = part;
                while left != 0 && rejected.is_none() {
                    let number = left.trailing_zeros() as usize;
                    left &= left - 1;
                    counts.planes += 1;
                    let (near, far) = distances(node, &sides[number]);
                    if near > 0.0 {
                        rejected = Some((number, near));
                    } else if far > 0.0 {
                        across |= 1 << number;
                    }
                }
            }
            if let Some((number, distance)) = rejected {
                state.last[at as usize] = number as u8;
                if tricks.motion {
                    let (a, b) = state.gone[number];
                    // A billionth for the rounding of all these sums.
                    let slack = 1e-9 * (node.reach + sides[number].d.abs() + a + b * node.reach);
                    state.due[at as usize] = distance + a + b * node.reach - slack;
                }
            } else if across == 0 || node.count == 1 {
                visible.push((node.first, node.count));
            } else {
                state.stack.push((node.second, across));
                state.stack.push((at + 1, across));
            }
        }
        counts
    }

    /// A bit for each box of the runs.
    pub(super) fn mark(&self, runs: &[(u32, u32)], words: &mut [u64]) {
        words.fill(0);
        for &(first, count) in runs {
            for &i in &self.order[first as usize..(first + count) as usize] {
                words[i as usize / 64] |= 1 << (i % 64);
            }
        }
    }
}

impl State {
    /// Adds up how far each plane went since the frame before.
    fn moves(&mut self, sides: &Sides) {
        if let Some(before) = &self.before {
            for ((gone, now), then) in self.gone.iter_mut().zip(sides).zip(before) {
                gone.0 += (now.d - then.d).abs();
                gone.1 += (now.n - then.n).length();
            }
        }
        self.before = Some(*sides);
    }
}

/// How far outside a plane the corners nearest to its inside (the n-vertex) and farthest out (the
/// p-vertex) are. Sums of corners and not of a middle and half extents, for rounding keeps their
/// order: what holds of a node holds of each box in it, so all tricks give the same answer to the
/// last bit.
fn distances(node: &Node, side: &Side) -> (f64, f64) {
    let n = side.n;
    let inward = DVec3::select(n.cmpgt(DVec3::ZERO), node.min, node.max);
    let outward = DVec3::select(n.cmpgt(DVec3::ZERO), node.max, node.min);
    let sum = |x: DVec3| n.x * x.x + n.y * x.y + n.z * x.z - side.d;
    (sum(inward), sum(outward))
}

/// The octant test: of each two opposite open planes the one that the node cannot reach, for it is
/// on the other side of the middle between them, and its sphere is smaller than half their distance
/// there.
///
/// The paper requires a sphere smaller than the frustum at its middle. Towards the eye a frustum is
/// narrower, so here the distance is that at the node, and the answer is never another.
fn hidden(node: &Node, sides: &Sides, open: u8) -> u8 {
    let middle = (node.min + node.max) * 0.5;
    let mut hidden = 0;
    for pair in 0..3 {
        // Of one alone there is no middle.
        if open >> (pair * 2) & 3 != 3 {
            continue;
        }
        let [a, b] = [sides[pair * 2], sides[pair * 2 + 1]].map(|s| s.d - s.n.dot(middle));
        if (a + b) * 0.5 > node.radius * (1.0 + 1e-9) + 1e-9 * node.reach {
            hidden |= 1 << (pair * 2 + usize::from(a < b));
        }
    }
    hidden
}

#[cfg(test)]
mod tests {
    use cullet::{Camera, Projection};

    use super::*;

    #[test]
    fn every_trick_gives_the_answer_of_testing_each_box() {
        let mut rng = cullet_testkit::Rng(1);
        let mut number = || rng.range(-0.5, 0.5);
        let boxes: Vec<[DVec3; 2]> = (0..2000)
            .map(|_| {
                let corner = DVec3::new(number(), number(), number()) * 200.0;
                [corner, corner + DVec3::new(number() + 0.5, number() + 0.5, 1.0) * 9.0]
            })
            .collect();
        let tree = Tree::new(&boxes);
        let all = [false, true];
        let tricks: Vec<Tricks> = (0..16)
            .map(|i| [0, 1, 2, 3].map(|bit: usize| all[i >> bit & 1]))
            .map(|[octant, masking, plane, motion]| Tricks { octant, masking, plane, motion })
            .collect();
        let mut states: Vec<State> = tricks.iter().map(|_| tree.state()).collect();
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.5, near: 0.1, far: 150.0 };
        let mut runs = Vec::new();
        let mut seen = 0;
        for frame in 0..120 {
            let angle = f64::from(frame) * 0.003 + f64::from(frame / 40);
            let (x, z) = angle.sin_cos();
            let camera =
                Camera::look_at([0.3 * angle, 1.0, 2.0], [9.0 * x, 2.0, 9.0 * z], projection);
            let sides = sides(&camera.frustum().unwrap()).unwrap();
            let mut truth = vec![0_u64; boxes.len().div_ceil(64)];
            for (i, &[min, max]) in boxes.iter().enumerate() {
                let node =
                    Node { min, max, first: 0, count: 1, second: 0, reach: 0.0, radius: 0.0 };
                let visible = sides.iter().all(|s| distances(&node, s).0 <= 0.0);
                truth[i / 64] |= u64::from(visible) << (i % 64);
                seen += u64::from(visible);
            }
            for (&tricks, state) in tricks.iter().zip(&mut states) {
                tree.cull(&sides, tricks, state, &mut runs);
                let mut words = truth.clone();
                tree.mark(&runs, &mut words);
                assert!(words == truth, "{tricks:?} in frame {frame}");
            }
        }
        assert!(seen > 1000, "{seen}");
    }

    #[test]
    fn nothing_and_one_box_are_trees() {
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: 10.0 };
        let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
        let sides = sides(&camera.frustum().unwrap()).unwrap();
        let mut runs = Vec::new();
        for boxes in [vec![], vec![[DVec3::new(-1.0, -1.0, -6.0), DVec3::new(1.0, 1.0, -5.0)]]] {
            let tree = Tree::new(&boxes);
            let counts = tree.cull(&sides, Tricks::default(), &mut tree.state(), &mut runs);
            assert_eq!((counts.nodes as usize, runs.len()), (boxes.len(), boxes.len()));
        }
    }
}
