//! Boxes hidden from boxes: never wrongly, often enough, and for the reasons that are said.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Convex, Occluder, Shape};
use cullet::{
    Handle, Instance, Mesh, Scene, Transform, prepared::Preparation, scene::BoundsOverride,
};
use cullet_cells::query::{
    BlockingSides, BoxSight, SightOptions, VolumeOptions, box_to_box, line_of_sight,
};
use cullet_testkit::meshes::{block, one_sided};
use cullet_testkit::oracles::sight::sight_ref;
use cullet_testkit::scenes::{city, random_transform};
use cullet_testkit::{Rng, cases, soups};

/// A point of a box, often one of its corners, edges or faces; in world space.
fn within(rng: &mut Rng, b: &Aabb, origin: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| {
        let share = [0.0, 1.0, rng.unit()][rng.index(3)];
        let (min, max) = (f64::from(b.min[a]), f64::from(b.max[a]));
        origin[a] + if share == 1.0 { max } else { min + (max - min) * share }
    })
}

fn hider(scene: &Scene, a: &Aabb, b: &Aabb) -> Option<Handle> {
    match box_to_box(scene, a, b, &VolumeOptions::default()) {
        BoxSight::Hidden(by) => Some(by.handle),
        BoxSight::Visible | BoxSight::Empty => None,
    }
}

fn cube(centre: [f64; 3], half: f64) -> Aabb {
    Aabb::new(centre.map(|v| (v - half) as f32), centre.map(|v| (v + half) as f32))
}

/// Every line between two boxes that are called hidden is blocked by a triangle of the very
/// instance that was named, and by the oracle that knows neither. Bodies of all kinds, turned,
/// sheared, mirrored, flattened, in the middle of all and at 1e7.
#[test]
fn between_boxes_that_are_hidden_every_line_is_blocked() {
    let mut rng = Rng(0xB0C5);
    let (mut hidden, mut visible_but_blocked) = (0, 0);
    for round in 0..cases(40) {
        let mut scene = Scene::new();
        let meshes = [
            block([-1.0, -0.5, -1.0], [1.0, 1.0, 0.3]),
            one_sided(soups::ball(5, 8)),
            one_sided(soups::divided_block(2)),
            one_sided(soups::ball_at([0.2, 0.1, -0.3], 1.2, 4)),
        ];
        let meshes = meshes.map(|m| scene.add_mesh(m));
        let far = [0.0, 0.0, 1e7][round as usize % 3];
        for _ in 0..1 + rng.below(12) {
            let mut t = random_transform(&mut rng);
            t.translation = std::array::from_fn(|a| t.translation[a] * 0.4 + far);
            t.linear = t.linear.map(|c| c.map(|v| v * 3.0));
            scene.add(Instance::new(meshes[rng.index(4)], t)).unwrap();
        }
        scene.commit(&cullet::Culler::default());
        scene.rebase([far; 3]);
        for _ in 0..200 {
            let (p, q) = (rng.vector(25.0), rng.vector(25.0));
            let (half, other) = (rng.range(0.0, 2.0), rng.range(0.0, 2.0));
            let (a, b) = (cube(p, half), cube(q, other));
            let lines = |rng: &mut Rng, count: usize| -> Vec<_> {
                let mut end = |b| within(rng, b, scene.origin());
                (0..count).map(|_| (end(&a), end(&b))).collect()
            };
            let sight = box_to_box(&scene, &a, &b, &VolumeOptions::default());
            let options = SightOptions { sides: BlockingSides::Both, ..Default::default() };
            if let BoxSight::Hidden(by) = sight {
                hidden += 1;
                assert_eq!(scene.handle(by.slot), Some(by.handle));
                for (from, to) in lines(&mut rng, 40) {
                    let hits = sight_ref(&scene, from, to, &options);
                    assert!(hits.iter().any(|h| h.slot == by.slot), "{by:?} {from:?} {to:?}");
                    // As drawn, too: from outside a body shows its front.
                    let drawn = line_of_sight(&scene, from, to, &SightOptions::default());
                    assert!(drawn.is_blocked(), "{by:?} {from:?} {to:?}");
                }
            } else {
                let is_blocked =
                    |&(from, to): &_| line_of_sight(&scene, from, to, &options).is_blocked();
                visible_but_blocked += u32::from(lines(&mut rng, 60).iter().all(is_blocked));
            }
        }
    }
    // A floor on what is found, as a share of the pairs that no line tried finds open.
    let blocked = hidden + visible_but_blocked;
    assert!(hidden * 100 > blocked * 40, "{hidden} of {blocked}");
    assert!(hidden > cases(40) * 8, "{hidden}");
}

/// A slab, and boxes of a grid around it: what is hidden is known by whole numbers, up to the last of them.
#[test]
fn a_box_is_hidden_up_to_where_one_line_passes_the_edge() {
    let mut scene = Scene::new();
    let slab = scene.add_mesh(block([-4.0, -4.0, -1.0], [4.0, 4.0, 1.0]));
    scene.add(Instance::new(slab, Transform::IDENTITY)).unwrap();
    scene.commit(&cullet::Culler::default());
    let eye = Aabb::new([-1.0, -1.0, 8.0], [1.0, 1.0, 9.0]);
    let target = |x: f32| Aabb::new([0.0, 0.0, -3.0], [x, 1.0, -2.0]);
    let hides = |x: f32| hider(&scene, &eye, &target(x)).is_some();
    // From (1, ., 9) past the edge at (4, ., 1), in 8 of the 11 units down to z = −2: to x = 1 + 3 · 11 / 8.
    assert!(hides(4.2) && hides(5.12499) && !hides(5.125) && !hides(5.2));
    assert!(hider(&scene, &target(4.2), &eye).is_some(), "a body hides both ways");
}

/// Two boxes with one body between them, changed a little.
struct Pair {
    scene: Scene,
    a: Aabb,
    b: Aabb,
}

impl Pair {
    fn new(mesh: Mesh, change: impl FnOnce(&mut Instance)) -> Self {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(mesh);
        let mut instance = Instance::new(mesh, Transform::IDENTITY);
        change(&mut instance);
        scene.add(instance).unwrap();
        scene.commit(&cullet::Culler::default());
        Self { scene, a: cube([0.0, 0.0, 20.0], 0.5), b: cube([0.0, 0.0, -20.0], 0.5) }
    }

    fn is_hidden(&self) -> bool {
        hider(&self.scene, &self.a, &self.b).is_some()
    }
}

/// Change that makes an instance another.
type Change = fn(&mut Instance);

fn body() -> Mesh {
    block([-5.0; 3], [5.0; 3])
}

#[test]
fn what_may_not_occlude_hides_nothing() {
    assert!(Pair::new(body(), |_| {}).is_hidden());
    let changes: [(&str, Change); 7] = [
        ("no occlusion", |i| i.flags.no_occlusion = true),
        ("transparent", |i| i.flags.transparent = true),
        ("in no layer", |i| i.layers = 0),
        ("margin", |i| i.bounds = BoundsOverride::Margin(0.1)),
        ("no bounds", |i| i.bounds = BoundsOverride::None),
        ("flat", |i| i.transform.linear[2] = [0.0; 3]),
        ("not finite", |i| i.transform.translation[0] = f64::NAN),
    ];
    for (name, change) in changes {
        assert!(!Pair::new(body(), change).is_hidden(), "{name}");
    }
    let pair = Pair::new(body(), |i| i.layers = 2);
    let options = VolumeOptions { layers: 1, ..VolumeOptions::default() };
    assert_eq!(box_to_box(&pair.scene, &pair.a, &pair.b, &options), BoxSight::Visible);
    // Not prepared: nothing is known of it.
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(body());
    scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
    assert!(!Pair { scene, ..pair }.is_hidden());
}

#[test]
fn boxes_that_touch_the_body_or_are_no_boxes_are_not_hidden_by_it() {
    let mut pair = Pair::new(body(), |_| {});
    let good = pair.b;
    for b in [
        Aabb::new([-1.0, -1.0, -9.0], [1.0, 1.0, -5.0]),
        Aabb::new([-1.0, -1.0, -9.0], [1.0, 1.0, 9.0]),
        Aabb::new([0.0; 3], [0.0; 3]),
        Aabb::EVERYTHING,
        Aabb::new([f32::NAN; 3], [1.0; 3]),
        Aabb::new([-1.0, -1.0, f32::NEG_INFINITY], [1.0, 1.0, -9.0]),
    ] {
        pair.b = b;
        assert!(!pair.is_hidden(), "{b:?}");
        (pair.a, pair.b) = (b, good);
        assert!(!pair.is_hidden(), "{b:?}");
        pair.a = cube([0.0, 0.0, 20.0], 0.5);
    }
    pair.b = Aabb::new([-1.0, -1.0, -9.0], [1.0, 1.0, -5.001]);
    assert!(pair.is_hidden(), "next to it, but apart");
    let empty = box_to_box(&pair.scene, &Aabb::EMPTY, &pair.b, &VolumeOptions::default());
    assert_eq!(empty, BoxSight::Empty);
    // Points are boxes.
    (pair.a, pair.b) = (cube([0.0, 0.0, 6.0], 0.0), cube([0.0, 0.0, -6.0], 0.0));
    assert!(pair.is_hidden());
}

fn with_occluder(occluder: Occluder) -> Pair {
    let mut pair = Pair::new(body(), |_| {});
    pair.scene.set_occluder(0, occluder);
    pair.scene.prepare(Preparation::ALL);
    pair
}

#[test]
fn polygons_hide_from_the_sides_that_they_have() {
    let corners = [[-6.0, -6.0, 0.0], [6.0, -6.0, 0.0], [6.0, 6.0, 0.0], [-6.0, 6.0, 0.0]];
    let one = Shape::Convex(Convex::from_one_sided_polygon(&corners).unwrap());
    let both = Shape::Convex(Convex::from_polygon(&corners).unwrap());
    for (shape, from_behind) in [(one, false), (both, true)] {
        for (mirrored, shift) in [(false, 0.0), (true, 0.0), (false, 7.0)] {
            let mut pair = with_occluder(Occluder::new(vec![shape.clone()]));
            let scale = if mirrored { [-1.0, 1.0, 1.0] } else { [1.0; 3] };
            let t = Transform::from_scale_translation(scale, [shift, 0.0, 0.0]);
            let handle = pair.scene.handle(0).unwrap();
            pair.scene.set_transform(handle, t).unwrap();
            // Beside it nothing is hidden.
            assert_eq!(pair.is_hidden(), shift == 0.0);
            (pair.a, pair.b) = (pair.b, pair.a);
            assert_eq!(pair.is_hidden(), from_behind && shift == 0.0, "{mirrored} {shift}");
        }
    }
}

#[test]
fn nobody_within_what_is_sealed_has_the_body_between() {
    let bodies = || vec![Shape::Convex(Convex::from_box(&cube([0.0; 3], 5.0)).unwrap())];
    let sealed = |at: f64| Occluder::new(bodies()).with_sealed(vec![cube([0.0, 0.0, at], 6.0)]);
    assert!(with_occluder(Occluder::new(bodies())).is_hidden());
    assert!(!with_occluder(sealed(20.0)).is_hidden(), "the eye is within");
    assert!(with_occluder(sealed(-20.0)).is_hidden(), "who is looked at may be within");
    let near = Occluder::new(Vec::new()).with_near(bodies());
    assert!(!with_occluder(near).is_hidden(), "shapes for views from within are for no other");
}

/// Two towers side by side hide what neither hides alone.
#[test]
fn halves_may_be_hidden_by_different_bodies() {
    let mut scene = Scene::new();
    let tower = scene.add_mesh(block([-3.0, -20.0, -1.0], [3.0, 20.0, 1.0]));
    let towers = [-2.9, 2.9].map(|x| {
        scene.add(Instance::new(tower, Transform::from_translation([x, 0.0, 0.0]))).unwrap()
    });
    scene.commit(&cullet::Culler::default());
    let eye = Aabb::new([-0.05, -0.1, 20.0], [0.05, 0.1, 20.2]);
    let target = Aabb::new([-6.0, -1.0, -22.0], [6.0, 1.0, -20.0]);
    let ask = |splits| {
        box_to_box(&scene, &eye, &target, &VolumeOptions { splits, ..VolumeOptions::default() })
    };
    assert_eq!(ask(0), BoxSight::Visible);
    let BoxSight::Hidden(by) = ask(3) else { panic!("each half is hidden") };
    assert_eq!(by.handle, towers[0], "the first half is the one at the low end");
    let mut gap = scene;
    let far = Transform::from_translation([3.2, 0.0, 0.0]);
    gap.set_transform(towers[1], far).unwrap();
    let options = VolumeOptions { splits: 16, ..VolumeOptions::default() };
    assert_eq!(box_to_box(&gap, &eye, &target, &options), BoxSight::Visible, "there is a gap");
}

/// Cells of a city at the height of people: how much is found hidden, of what no line tried finds open.
#[test]
fn in_a_city_most_hidden_cells_are_found() {
    let mut scene = city(10, 1, 0);
    scene.commit(&cullet::Culler::default());
    let mut rng = Rng(12);
    let sides = SightOptions { sides: BlockingSides::Both, ..SightOptions::default() };
    let (mut found, mut split, mut blocked) = (0, 0, 0);
    for _ in 0..400 {
        let mut cell = |half: f64| {
            let [x, z] = [(); 2].map(|()| rng.range(-110.0, 110.0));
            cube([x, 1.0 + half, z], half)
        };
        let (a, b) = (cell(0.5), cell(1.0));
        let options = |splits| VolumeOptions { splits, ..VolumeOptions::default() };
        let is_hidden =
            |splits| matches!(box_to_box(&scene, &a, &b, &options(splits)), BoxSight::Hidden(_));
        let (whole, halves) = (is_hidden(0), is_hidden(6));
        assert!(!whole || halves, "halving loses nothing");
        let all_blocked = (0..60).all(|_| {
            let (from, to) = (within(&mut rng, &a, [0.0; 3]), within(&mut rng, &b, [0.0; 3]));
            line_of_sight(&scene, from, to, &sides).is_blocked()
        });
        assert!(all_blocked || !halves, "{a:?} {b:?}");
        found += u32::from(whole);
        split += u32::from(halves);
        blocked += u32::from(all_blocked);
    }
    assert!(found * 100 >= blocked * 80, "{found} of {blocked}");
    assert!(split * 100 >= blocked * 90 && blocked > 200, "{split} of {blocked}");
}
