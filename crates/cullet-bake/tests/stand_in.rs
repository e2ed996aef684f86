//! Coarse stand-ins, measured without what made them.

use cullet::{Handle, Instance, MeshId, Scene, Transform};
use cullet_bake::stand_in::{StandIn, StandInOptions, StandIns};
use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::surface_points;
use cullet_testkit::steps::Balls;
use cullet_testkit::{Rng, cases};

/// Tries a property so many times, each with random numbers of its own.
fn tried(seed: u64, count: u32, mut property: impl FnMut(&mut Rng)) {
    (0..cases(count)).for_each(|case| property(&mut Rng(seed + u64::from(case))));
}

/// Positions and indices.
type Surface = (Vec<[f32; 3]>, Vec<u32>);

/// Balls whose levels state what they are off, blocks without levels, and pairs of balls in one place for which a third stands.
struct Yard {
    scene: Scene,
    /// Both of a pair, and who stands for them.
    pairs: Vec<([Handle; 2], Handle)>,
}

fn yard(rng: &mut Rng) -> Yard {
    let mut scene = Scene::new();
    let ball = |scene: &mut Scene| -> MeshId { Balls::new(&[16, 8, 4], 1.0).add_to(scene) };
    let (first, second, merged) = (ball(&mut scene), ball(&mut scene), ball(&mut scene));
    let block = scene.add_mesh(cullet_testkit::meshes::block([-1.0; 3], [1.0; 3]));
    let mut pairs = Vec::new();
    let add = |scene: &mut Scene, mesh, scale: f64, at| {
        let transform = Transform::from_scale_translation([scale as f32; 3], at);
        scene.add(Instance::new(mesh, transform)).unwrap()
    };
    for _ in 0..6 + rng.below(20) {
        let at: [f64; 3] = std::array::from_fn(|_| rng.range(-30.0, 30.0) + 1e4);
        let scale = rng.range(0.05, 3.0);
        match rng.below(3) {
            0 => _ = add(&mut scene, block, scale, at),
            1 => _ = add(&mut scene, first, scale, at),
            _ => {
                let two = [first, second].map(|mesh| add(&mut scene, mesh, scale, at));
                let own = add(&mut scene, merged, scale, at);
                scene.stand_for(own, &two).unwrap();
                pairs.push((two, own));
            }
        }
    }
    scene.rebase([1e4; 3]);
    scene.commit(&cullet::Culler::default());
    Yard { scene, pairs }
}

/// The surface of an instance in full, around a point of the world.
fn whole(scene: &Scene, slot: u32, origin: [f64; 3]) -> Surface {
    let (mesh, m) = (scene.mesh(slot), scene.transform(slot).to_matrix());
    let place = |p: &[f32; 3]| -> [f32; 3] {
        let [x, y, z] = p.map(f64::from);
        std::array::from_fn(|a| {
            (m[a] * x + m[4 + a] * y + m[8 + a] * z + m[12 + a] - origin[a]) as f32
        })
    };
    (mesh.positions().iter().map(place).collect(), mesh.indices().to_vec())
}

fn joined(surfaces: &[Surface]) -> Surface {
    let mut all = Surface::default();
    for (positions, indices) in surfaces {
        let first = all.0.len() as u32;
        all.0.extend(positions);
        all.1.extend(indices.iter().map(|v| v + first));
    }
    all
}

/// How far points of one surface are from another at the most.
fn farthest((positions, indices): &Surface, to: &Surface) -> f64 {
    let tree = SurfaceTree::new(&to.0, &to.1);
    let points = surface_points(positions, indices, 400, 3);
    let points = points.iter().map(|p| p.point).chain(positions.iter().copied());
    let far = |p| f64::from(tree.nearest(p, f32::INFINITY).map_or(f32::INFINITY, |n| n.0));
    points.map(far).fold(0.0, f64::max)
}

fn diagonal(scene: &Scene, slot: u32) -> f64 {
    let b = scene.bounds(slot);
    (0..3).map(|a| f64::from(b.max[a] - b.min[a]).powi(2)).sum::<f64>().sqrt()
}

fn surface(made: &StandIn) -> Surface {
    (made.mesh.positions.clone(), made.mesh.indices.clone())
}

#[test]
fn a_stand_in_is_off_by_no_more_than_it_states_and_leaves_out_nothing_larger() {
    let mut left_out = 0;
    tried(0x57a0, 60, |rng| {
        let Yard { scene, .. } = yard(rng);
        let slots: Vec<u32> = scene.slots().filter(|_| rng.below(4) > 0).collect();
        let most = 40 << rng.below(8);
        let options = StandInOptions::default().with_triangles(most);
        let Some(made) = StandIns::new(&scene, &[], options).of(&slots, 0.0) else { return };
        assert!((made.mesh.indices.len() / 3) as u64 <= most);
        let all: Vec<Surface> = slots.iter().map(|&s| whole(&scene, s, made.origin)).collect();
        let room = made.error + 1e-4;
        assert!(farthest(&surface(&made), &joined(&all)) <= room, "it has what is not there");
        for (&slot, of) in slots.iter().zip(&all) {
            let far = farthest(of, &surface(&made));
            let is_small = diagonal(&scene, slot) <= room;
            assert!(far <= room || is_small, "{far} of {room}, {}", diagonal(&scene, slot));
            left_out += u32::from(far > room);
        }
    });
    assert!(left_out > 0, "some are too small to be kept");
}

#[test]
fn fewer_triangles_are_off_by_more_and_none_are_off_by_less_than_what_is_below() {
    tried(0x57a1, 40, |rng| {
        let Yard { scene, .. } = yard(rng);
        let slots: Vec<u32> = scene.slots().collect();
        let make = |most: u64, least: f64| {
            let options = StandInOptions::default().with_triangles(most);
            StandIns::new(&scene, &[], options).of(&slots, least)
        };
        let mut before = 0.0;
        for most in [100_000, 2000, 300, 50] {
            let Some(made) = make(most, 0.0) else { break };
            assert!(made.error >= before, "{most}");
            before = made.error;
        }
        assert!(make(100_000, 0.7).is_none_or(|made| made.error >= 0.7));
        assert_eq!(make(2000, 0.0), make(2000, 0.0));
    });
}

#[test]
fn a_group_is_used_where_all_that_it_stands_for_is_there_and_is_as_it_was() {
    let mut used = 0;
    tried(0x57a2, 60, |rng| {
        let Yard { mut scene, pairs } = yard(rng);
        let Some(&([a, b], _)) = pairs.first() else { return };
        // Enough for a ball of 224 triangles, and not for two.
        let options = StandInOptions::default().with_triangles(400);
        let count = |scene: &Scene, handles: &[Handle]| {
            let slots: Vec<u32> = handles.iter().map(|&h| scene.slot(h).unwrap()).collect();
            StandIns::new(scene, &[], options).of(&slots, 0.0).unwrap().mesh.indices.len() / 3
        };
        assert_eq!([count(&scene, &[a]), count(&scene, &[a, b])], [224; 2]);
        // From then on nobody stands for them, and each is there as itself.
        scene.set_layers(b, 2).unwrap();
        scene.commit(&cullet::Culler::default());
        assert_eq!(count(&scene, &[a, b]), 2 * 48);
        used += 1;
    });
    assert!(used > 5, "{used}");
}

#[test]
fn of_nothing_there_is_none() {
    let Yard { scene, .. } = yard(&mut Rng(5));
    let stand_ins = StandIns::new(&scene, &[], StandInOptions::default());
    assert_eq!(stand_ins.of(&[], 0.0), None);
    let all: Vec<u32> = scene.slots().collect();
    assert!(stand_ins.of(&all, 0.0).is_some());
    assert_eq!(stand_ins.of(&all, 1e9), None, "all is smaller than that");
}
