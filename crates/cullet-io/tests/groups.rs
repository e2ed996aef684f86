//! Node trees of files as groups to cull by, against the engine's own nodes over the same boxes.
//!
//! `cargo test --release -p cullet-io --test groups -- --nocapture` prints the table: blocks of sixteen
//! boxes that were tested and time, each a mean over views; and the share of all things that went with a
//! group.

use std::time::Instant;

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::Planes;
use cullet::cull::frustum::groups::{Fate, cull_groups, explain_groups};
use cullet::cull::frustum::tree::Cut;
use cullet::hierarchy::{Groups, Nodes, spatial_order};
use cullet::{Camera, Level, Projection};
use cullet_io::{LoadOptions, Model, load, load_bytes};
use cullet_testkit::data;

/// A model of the test data; `None` where it is not there.
fn model(path: &str) -> Option<Model> {
    Some(load(&data(path)?, &LoadOptions::default()).expect("a good model"))
}

/// Views from where things are, all around, that reach a tenth of the scene or all of it.
fn views(bounds: &[Aabb]) -> Vec<Planes> {
    let real: Vec<_> = bounds.iter().filter(|b| b.half_extent()[0] < 1e17).collect();
    let half = real.iter().fold(Aabb::EMPTY, |a, b| a.union(b)).half_extent();
    let size = half.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut all = Vec::new();
    for i in 0..64 {
        let turn = i as f64 * 2.399_963;
        let eye = real[(i * 2 + 1) * real.len() / 128].center();
        let direction = [(turn * 1.7).cos(), -0.05, (turn * 1.7).sin()];
        let far = if i % 2 == 0 { size * 0.2 } else { size * 4.0 };
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: size * 1e-4, far };
        let camera = Camera { eye, direction, up: [0.0, 1.0, 0.0], projection };
        all.push(Planes::new(&camera.frustum().expect("a plain perspective")));
    }
    all
}

/// Nanoseconds a view, the fastest of some rounds over all.
fn time(views: &[Planes], mut cull: impl FnMut(&Planes)) -> f64 {
    let rounds = (0..7).map(|_| {
        let start = Instant::now();
        views.iter().for_each(&mut cull);
        start.elapsed().as_nanos() as f64 / views.len() as f64
    });
    rounds.fold(f64::INFINITY, f64::min)
}

/// Blocks a view by groups and by nodes, and the share of things that went with a group.
struct Found {
    groups: f64,
    nodes: f64,
    whole: f64,
}

/// Prints a row, and checks that both ways see the same.
fn compare(name: &str, groups: &Groups) -> Found {
    let statistics = groups.validate().expect("just built");
    let bounds = by_item(groups);
    let mut boxes = Boxes::new();
    boxes.gather(Level::new(), &bounds, &spatial_order(&bounds));
    // Stored once more, boxes are a little wider: those of both ways must be the same.
    let mut groups = groups.clone();
    groups.set_all(&bounds);
    let nodes = Nodes::over(Level::new(), &boxes);
    let views = views(&bounds);
    let (mut by_groups, mut by_nodes) = (Cut::new(), Cut::new());
    let mut fates = Vec::new();
    let mut found = Found { groups: 0.0, nodes: 0.0, whole: 0.0 };
    let (mut seen, mut swept) = (0, 0);
    for planes in &views {
        explain_groups(Level::new(), planes, &groups, &mut by_groups, &mut fates);
        let whole = fates.iter().filter(|f| matches!(f, Fate::WithGroup { .. })).count();
        found.whole += whole as f64 / (bounds.len() * views.len()) as f64;
        cull_groups(Level::new(), planes, &groups, &mut by_groups);
        by_nodes.cull(Level::new(), planes, &nodes, &boxes);
        assert_eq!(by_groups.count(), by_nodes.count(), "{name}");
        let blocks = |cut: &Cut| {
            (cut.nodes_asked() + cut.leaves_asked() + cut.swept() / 16) as f64 / views.len() as f64
        };
        found.groups += blocks(&by_groups);
        found.nodes += blocks(&by_nodes);
        seen += by_nodes.count();
        swept += usize::from(by_groups.swept() > 0);
    }
    let flat = time(&views, |p| by_nodes.sweep_all(Level::new(), p, &boxes));
    let t_groups = time(&views, |p| cull_groups(Level::new(), p, &groups, &mut by_groups));
    let t_nodes = time(&views, |p| by_nodes.cull(Level::new(), p, &nodes, &boxes));
    println!(
        "{name:<24} {:>8} {:>8} {:>3} {:>6} {:>6.1} {:>6.1} {:>8.1} {:>8.1} {:>9.0} {:>9.0} {:>9.0} {:>5}",
        bounds.len(),
        statistics.groups,
        statistics.depth,
        statistics.widest,
        100.0 * seen as f64 / (bounds.len() * views.len()) as f64,
        100.0 * found.whole,
        found.groups,
        found.nodes,
        t_groups,
        t_nodes,
        flat,
        swept,
    );
    found
}

/// A city of blocks of houses of floors of parts, and some trees that belong to no house; each level in
/// the order in which a program would make it. `blocks` by `blocks`.
fn city(blocks: u32, nested: bool) -> Groups {
    let (mut parents, mut members, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
    let mut seed = 1u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1 << 24) as f32
    };
    let group = |parents: &mut Vec<u32>, parent: u32| {
        parents.push(if nested { parent } else { Groups::NONE });
        parents.len() as u32 - 1
    };
    for block in 0..blocks * blocks {
        let corner = [(block % blocks) as f32 * 100.0, (block / blocks) as f32 * 100.0];
        let here = group(&mut parents, Groups::NONE);
        for house in 0..16 {
            let at = [corner[0] + (house % 4) as f32 * 22.0, corner[1] + (house / 4) as f32 * 22.0];
            let house = group(&mut parents, here);
            for floor in 0..2 + (random() * 6.0) as u32 {
                let y = floor as f32 * 3.0;
                let floor = group(&mut parents, house);
                for _ in 0..12 {
                    let min = [at[0] + random() * 15.0, y, at[1] + random() * 15.0];
                    members.push([floor, bounds.len() as u32]);
                    bounds.push(Aabb::new(min, min.map(|v| v + 0.3 + random() * 2.0)));
                }
            }
        }
    }
    Groups::build(&parents, &members, &bounds).expect("good groups")
}

/// Groups by kind, as many files have them: every twentieth thing of the city in one group.
fn by_kind(of: &Groups, kinds: u32) -> Groups {
    let members: Vec<_> = (0..of.items().len() as u32).map(|i| [i % kinds, i]).collect();
    let parents = vec![Groups::NONE; kinds as usize];
    Groups::build(&parents, &members, &by_item(of)).expect("good groups")
}

/// The boxes of all things, by their number.
fn by_item(groups: &Groups) -> Vec<Aabb> {
    let mut bounds = vec![Aabb::EMPTY; groups.items().len()];
    for (place, &item) in groups.items().iter().enumerate() {
        bounds[item as usize] = groups.boxes().get(place);
    }
    bounds
}

fn header() {
    println!(
        "{:<24} {:>8} {:>8} {:>3} {:>6} {:>6} {:>6} {:>8} {:>8} {:>9} {:>9} {:>9} {:>5}",
        "scene",
        "things",
        "groups",
        "dep",
        "widest",
        "seen%",
        "whole%",
        "blocks",
        "by nodes",
        "ns groups",
        "ns nodes",
        "ns flat",
        "swept"
    );
}

#[test]
fn good_groups_of_a_city_do_as_well_as_nodes_and_groups_by_kind_do_not() {
    header();
    for blocks in [8, 32] {
        let nested = city(blocks, true);
        let found = compare(&format!("city {blocks}², nested"), &nested);
        assert!(found.whole > 0.5, "{} went whole", found.whole);
        compare(&format!("city {blocks}², floors"), &city(blocks, false));
        let found = compare(&format!("city {blocks}², by kind"), &by_kind(&nested, 20));
        assert!(found.whole < 0.2 && found.groups > found.nodes, "kinds lie everywhere");
    }
}

#[test]
fn node_trees_of_files_are_groups() {
    header();
    for (path, nodes, least) in [
        ("intel-castle/intel-castle.glb", 2418, 0.3),
        ("duplex-bim/duplex.glb", 1, 0.0),
        ("cad-2cylinder/2CylinderEngine.glb", 82, 0.0),
        ("city-rotterdam/delfshaven.glb", 1, 0.0),
    ] {
        let Some(model) = model(path) else { continue };
        assert!(model.node_tree.len() >= nodes, "{path}: {} nodes", model.node_tree.len());
        let groups = model.groups().expect("a file's nodes are a tree");
        for slot in model.scene.slots() {
            let handle = model.scene.handle(slot).expect("there are no gaps");
            let node = groups.group_of(slot).expect("every instance has a node");
            let (name, instance) = (model.node_tree.name(node), model.instance_name(handle));
            assert!(instance.starts_with(&name), "{instance} is of node {name}");
            let place = groups.place(slot).expect("it is there") as usize;
            assert_eq!(groups.boxes().get(place), model.scene.boxes().get(slot as usize));
        }
        let found = compare(path.rsplit('/').next().unwrap_or(path), &groups);
        assert!(found.whole >= least, "{path}: {} went whole", found.whole);
    }
}

#[test]
fn a_file_without_nodes_has_no_groups() {
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let model = load_bytes("a.obj", obj, &LoadOptions::default()).expect("a triangle");
    assert!(model.node_tree.is_empty());
    let groups = model.groups().expect("none is right");
    assert_eq!((groups.len(), groups.items(), groups.group_of(0)), (0, &[0][..], None));
}
