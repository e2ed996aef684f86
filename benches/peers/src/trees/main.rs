//! cullet's hierarchy beside the trees of other crates, over the same boxes, index list out:
//! `cargo run --release --no-default-features --features trees --bin trees [-- COUNT]` in this folder.
//!
//! None of them comes with a walk for frusta: each is given a scalar plane test, through the hook that it has,
//! and an own stack over its public nodes where it has none. Those walks also carry the mask of planes still
//! open, which theirs cannot. Bevy-like f32 tests know no error bound, so a few boxes on a border may differ.
//!
//! The last lines say how good the shapes of the trees are: how many boxes are tested for each that is visible,
//! and how many blocks our walk tests where our order of the boxes is replaced by that of a tree built by
//! surface area.
#![forbid(unsafe_code)]

mod peers;

use std::hint::black_box;
use std::time::{Duration, Instant};

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::{Indices, Planes, count_boxes, cull_boxes};
use cullet::cull::frustum::tree::Cut;
use cullet::hierarchy::{Hierarchy, Nodes};
use cullet::{Camera, Level, Projection, view::Frustum};
use peers::{Peer, Test};

const SECONDS: f64 = 1.0;

fn main() {
    let count =
        std::env::args().nth(1).map_or(1_000_000, |n| n.parse().expect("a number of boxes"));
    for clustered in [false, true] {
        let items = boxes(count, clustered);
        println!("{count} boxes, {}", if clustered { "clustered" } else { "random" });
        let start = Instant::now();
        let (hierarchy, _) = Hierarchy::build(&items).expect("fewer than there are slots");
        println!("build: cullet {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
        let peers = peers::all(&items);
        let flat = Boxes::from_slice(&items);
        println!(
            "visible  walk                               us   x cullet  boxes tested a visible one"
        );
        for percent in [1, 10, 50] {
            compare(&frustum(percent, &flat), (&items, &flat), &hierarchy, &peers);
        }
        shapes(&items, &flat, &hierarchy, &peers);
    }
}

fn compare(
    frustum: &Frustum,
    (items, flat): (&[Aabb], &Boxes),
    h: &Hierarchy,
    peers: &[Box<dyn Peer>],
) {
    let level = Level::new();
    let planes = Planes::new(frustum);
    let test = Test::new(frustum);
    let (mut cut, mut list) = (Cut::new(), Indices::new());
    let ours = fastest(|| {
        cut.cull(level, &planes, h.nodes(), h.boxes());
        cut.list(level, &mut list);
    });
    let mut swept = Indices::new();
    let sweep = fastest(|| cull_boxes(level, &planes, flat, &mut swept));
    assert_eq!(swept.len(), list.len(), "the same boxes");
    let visible = list.len();
    let share = visible as f64 * 100.0 / items.len() as f64;
    let row = |name: &str, time: Duration, tested: f64| {
        let ratio = time.as_secs_f64() / ours.as_secs_f64();
        let us = time.as_secs_f64() * 1e6;
        println!(
            "{share:5.1} %  {name:30} {us:9.1} {ratio:9.1}  {:8.2}",
            tested / visible.max(1) as f64
        );
    };
    row("cullet, hierarchy", ours, 16.0 * (cut.nodes_tested() + cut.leaves_tested()) as f64);
    row("cullet, flat sweep", sweep, items.len() as f64);
    for peer in peers {
        let mut found = Vec::new();
        let time = fastest(|| {
            found.clear();
            peer.walk(&test, &mut found);
        });
        let differ = found.len().abs_diff(visible);
        assert!(differ <= 2 + items.len() / 1000, "{}: {} for {visible}", peer.name(), found.len());
        row(peer.name(), time, test.count(|| peer.walk(&test, &mut Vec::new())));
    }
}

/// Blocks that our walk tests, in our order and in that of the peer's leaves.
fn shapes(items: &[Aabb], flat: &Boxes, h: &Hierarchy, peers: &[Box<dyn Peer>]) {
    for peer in peers {
        let Some(order) = peer.order() else { continue };
        let sorted: Vec<_> = order.iter().map(|&i| items[i as usize]).collect();
        let theirs = Boxes::from_slice(&sorted);
        let nodes = Nodes::over(Level::new(), &theirs);
        for percent in [1, 10, 50] {
            let planes = Planes::new(&frustum(percent, flat));
            let asked = |nodes: &Nodes, boxes: &Boxes| {
                let mut cut = Cut::new();
                cut.cull(Level::new(), &planes, nodes, boxes);
                (cut.nodes_tested() + cut.leaves_tested()) as f64
            };
            let (a, b) = (asked(h.nodes(), h.boxes()), asked(&nodes, &theirs));
            println!(
                "{percent:3} %: our walk tests {a:.0} blocks in our order, {b:.0} in that of {}: {:.3} times",
                peer.name(),
                a / b
            );
        }
    }
}

/// The fastest pass within a second, of at least three.
fn fastest(mut run: impl FnMut()) -> Duration {
    let begin = Instant::now();
    let mut best = Duration::MAX;
    let mut passes = 0;
    while passes < 3 || begin.elapsed().as_secs_f64() < SECONDS {
        let start = Instant::now();
        run();
        best = best.min(start.elapsed());
        passes += 1;
    }
    black_box(best)
}

/// A camera that moves back from the far corner of the world until it sees so much of it.
fn frustum(percent: usize, boxes: &Boxes) -> Frustum {
    let at = |back: f64| {
        let direction = [0.6, -0.3, -0.742];
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.1, far: 1e4 };
        let eye = direction.map(|v| -v * back);
        let camera = Camera { eye, direction, up: [0.0, 1.0, 0.0], projection };
        camera.frustum().expect("a plain perspective")
    };
    let (mut low, mut high) = (-2000.0, 6000.0);
    for _ in 0..24 {
        let middle = (low + high) / 2.0;
        let seen = count_boxes(Level::new(), &Planes::new(&at(middle)), boxes);
        if seen * 100 < percent * boxes.len() { low = middle } else { high = middle }
    }
    at(high)
}

fn boxes(count: usize, clustered: bool) -> Vec<Aabb> {
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let heaps: Vec<[f32; 3]> =
        (0..200).map(|_| std::array::from_fn(|_| next() * 2000.0 - 1000.0)).collect();
    let mut one = || {
        let min: [f32; 3] = if clustered {
            let heap = heaps[(next() * 200.0) as usize];
            heap.map(|v| v + 40.0 * ((0..4).map(|_| next()).sum::<f32>() - 2.0))
        } else {
            std::array::from_fn(|_| next() * 2000.0 - 1000.0)
        };
        Aabb::new(min, min.map(|v| v + next() * 10.0))
    };
    (0..count).map(|_| one()).collect()
}
