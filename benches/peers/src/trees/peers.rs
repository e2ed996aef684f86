//! The peers, each behind the same few calls.

use std::cell::Cell;
use std::time::{Duration, Instant};

use bvh::aabb::{Aabb as BvhAabb, Bounded, IntersectsAabb};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use cullet::bounds::Aabb;
use cullet::view::Frustum;
use glam::Vec3A;
use nalgebra::Point3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb as ObvhsAabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use parry3d::bounding_volume::Aabb as ParryAabb;
use parry3d::partitioning::{Bvh as ParryBvh, BvhBuildStrategy, TraversalAction};

/// Six planes, n·x ≤ d inside.
pub struct Test {
    planes: Vec<([f32; 3], f32)>,
    counting: Cell<bool>,
    tested: Cell<u64>,
}

impl Test {
    pub fn new(frustum: &Frustum) -> Self {
        let plane =
            |(_, p): (usize, &cullet::bounds::Plane)| (p.normal.map(|v| v as f32), p.d as f32);
        let planes = frustum.planes().map(plane).collect();
        Self { planes, counting: Cell::new(false), tested: Cell::new(0) }
    }

    /// How many boxes `run` tests.
    pub fn count(&self, run: impl FnOnce()) -> f64 {
        self.counting.set(true);
        self.tested.set(0);
        run();
        self.counting.set(false);
        self.tested.get() as f64
    }

    #[inline(always)]
    fn note(&self) {
        if self.counting.get() {
            self.tested.set(self.tested.get() + 1);
        }
    }

    /// Whether no plane rejects a box: the corner that lies deepest inside.
    #[inline(always)]
    fn sees(&self, min: [f32; 3], max: [f32; 3]) -> bool {
        self.note();
        self.planes.iter().all(|(n, d)| {
            let near = |a: usize| n[a] * if n[a] > 0.0 { min[a] } else { max[a] };
            near(0) + near(1) + near(2) <= *d
        })
    }

    /// Against the open planes only: `None` outside, else those that it straddles.
    #[inline(always)]
    fn narrow(&self, open: u32, min: [f32; 3], max: [f32; 3]) -> Option<u32> {
        self.note();
        let (mut left, mut straddled) = (open, 0);
        while left != 0 {
            let bit = left & left.wrapping_neg();
            let (n, d) = self.planes[left.trailing_zeros() as usize];
            left ^= bit;
            let low = |a: usize| n[a] * if n[a] > 0.0 { min[a] } else { max[a] };
            if low(0) + low(1) + low(2) > d {
                return None;
            }
            let high = |a: usize| n[a] * if n[a] > 0.0 { max[a] } else { min[a] };
            if high(0) + high(1) + high(2) > d {
                straddled |= bit;
            }
        }
        Some(straddled)
    }
}

/// A tree of another crate.
pub trait Peer {
    fn name(&self) -> &'static str;
    fn walk(&self, test: &Test, found: &mut Vec<u32>);
    /// The boxes in the order of its leaves, where that is of interest.
    fn order(&self) -> Option<Vec<u32>> {
        None
    }
}

/// All of them; says how long each took to build.
pub fn all(items: &[Aabb]) -> Vec<Box<dyn Peer>> {
    let say =
        |name: &str, time: Duration| println!("build: {name} {:.0} ms", time.as_secs_f64() * 1e3);
    let mut peers: Vec<Box<dyn Peer>> = Vec::new();

    let theirs: Vec<_> =
        items.iter().map(|b| ParryAabb { mins: b.min.into(), maxs: b.max.into() }).collect();
    let start = Instant::now();
    let parry = ParryBvh::from_leaves(BvhBuildStrategy::Binned, &theirs);
    say("parry3d, binned", start.elapsed());
    peers.push(Box::new(Parry(parry)));

    let mut shapes: Vec<_> = (0..)
        .zip(items)
        .map(|(id, b)| Shape {
            bounds: BvhAabb::with_bounds(Point3::from(b.min), Point3::from(b.max)),
            id,
            node: 0,
        })
        .collect();
    let start = Instant::now();
    let tree = Bvh::build(&mut shapes);
    say("bvh", start.elapsed());
    peers.push(Box::new(BvhPeer { tree, shapes }));

    let theirs: Vec<_> =
        items.iter().map(|b| ObvhsAabb::new(Vec3A::from(b.min), Vec3A::from(b.max))).collect();
    for (name, masked, params) in [
        ("obvhs, fastest, masked", true, BvhBuildParams::fastest_build()),
        ("obvhs, medium", false, BvhBuildParams::medium_build()),
        ("obvhs, medium, masked", true, BvhBuildParams::medium_build()),
    ] {
        let mut core = Duration::ZERO;
        let mut tree = build_bvh2(&theirs, params, &mut core);
        // Nodes in the order in which a stack meets them: kinder to the caches.
        tree.reorder_in_stack_traversal_order();
        say(name, core);
        peers.push(Box::new(Obvhs { name, masked, tree, boxes: theirs.clone() }));
    }
    peers
}

struct Parry(ParryBvh);

impl Peer for Parry {
    fn name(&self) -> &'static str {
        "parry3d, traverse"
    }

    fn walk(&self, test: &Test, found: &mut Vec<u32>) {
        self.0.traverse(|node| {
            if !test.sees(node.mins().into(), node.maxs().into()) {
                return TraversalAction::Prune;
            }
            found.extend(node.leaf_data());
            TraversalAction::Continue
        });
    }
}

struct Shape {
    bounds: BvhAabb<f32, 3>,
    id: u32,
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> BvhAabb<f32, 3> {
        self.bounds
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl IntersectsAabb<f32, 3> for &Test {
    fn intersects_aabb(&self, b: &BvhAabb<f32, 3>) -> bool {
        self.sees(b.min.into(), b.max.into())
    }
}

struct BvhPeer {
    tree: Bvh<f32, 3>,
    shapes: Vec<Shape>,
}

impl Peer for BvhPeer {
    fn name(&self) -> &'static str {
        "bvh, traverse_iterator"
    }

    fn walk(&self, test: &Test, found: &mut Vec<u32>) {
        found.extend(self.tree.traverse_iterator(&test, &self.shapes).map(|s| s.id));
    }
}

struct Obvhs {
    name: &'static str,
    masked: bool,
    tree: Bvh2,
    boxes: Vec<ObvhsAabb>,
}

impl Peer for Obvhs {
    fn name(&self) -> &'static str {
        self.name
    }

    fn walk(&self, test: &Test, found: &mut Vec<u32>) {
        let all = (1 << test.planes.len()) - 1;
        let narrow = |open: u32, b: &ObvhsAabb| {
            let (min, max) = (b.min.to_array(), b.max.to_array());
            match open {
                0 => Some(0),
                _ if self.masked => test.narrow(open, min, max),
                _ => test.sees(min, max).then_some(open),
            }
        };
        let mut stack = vec![(0_u32, all)];
        while let Some((index, open)) = stack.pop() {
            let node = &self.tree.nodes[index as usize];
            let Some(open) = narrow(open, &node.aabb) else { continue };
            if node.is_leaf() {
                let members = node.first_index..node.first_index + node.prim_count;
                for &id in
                    &self.tree.primitive_indices[members.start as usize..members.end as usize]
                {
                    // A leaf of one has its box.
                    if node.prim_count == 1 || narrow(open, &self.boxes[id as usize]).is_some() {
                        found.push(id);
                    }
                }
            } else {
                stack.extend([(node.first_index + 1, open), (node.first_index, open)]);
            }
        }
    }

    fn order(&self) -> Option<Vec<u32>> {
        let mut order = Vec::with_capacity(self.boxes.len());
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            let node = &self.tree.nodes[index as usize];
            if node.is_leaf() {
                let first = node.first_index as usize;
                order.extend(&self.tree.primitive_indices[first..first + node.prim_count as usize]);
            } else {
                stack.extend([node.first_index + 1, node.first_index]);
            }
        }
        (self.name == "obvhs, medium").then_some(order)
    }
}
