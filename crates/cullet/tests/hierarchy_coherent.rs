//! A view that moves: the coherent walk gives the results of a cold one in every frame, and tests less.

use std::time::Instant;

use cullet::bounds::{Aabb, Plane};
use cullet::cull::frustum::batch::Planes;
use cullet::cull::frustum::tree::{Coherent, Cut};
use cullet::hierarchy::{Handle, Hierarchy};
use cullet::{Camera, Frustum, Projection, Simd};
use cullet_testkit::{Rng, at_every_level};
use glam::{DQuat, DVec3};

fn random_box(rng: &mut Rng) -> Aabb {
    let centre = rng.vector(100.0).map(|v| v as f32);
    let half = rng.range(0.0, 4.0) as f32;
    // So few that most nodes are none of these.
    match rng.below(4000) {
        0 => Aabb::EMPTY,
        1 => Aabb::EVERYTHING,
        2 => Aabb::new([f32::NAN; 3], [1.0; 3]),
        3 => Aabb::new([1e17; 3], [2e17; 3]),
        _ => Aabb::new(centre.map(|c| c - half), centre.map(|c| c + half)),
    }
}

fn world(rng: &mut Rng, count: u64) -> (Hierarchy, Vec<Handle>) {
    let boxes: Vec<_> = (0..count).map(|_| random_box(rng)).collect();
    Hierarchy::build(&boxes).expect("few")
}

fn perspective(fov_y_radians: f64, aspect: f64, far: f64) -> Projection {
    Projection::Perspective { fov_y_radians, aspect, near: 0.1, far }
}

/// A view on its way.
struct Walker {
    eye: DVec3,
    turn: DQuat,
    projection: Projection,
}

impl Walker {
    fn new() -> Self {
        let projection = perspective(1.0, 1.3, 150.0);
        Self { eye: DVec3::ZERO, turn: DQuat::IDENTITY, projection }
    }

    fn step(&mut self, way: f64, radians: f64, rng: &mut Rng) {
        self.eye += DVec3::from(rng.vector(way));
        let axis = DVec3::from(rng.vector(1.0)).normalize_or(DVec3::Y);
        self.turn = (DQuat::from_axis_angle(axis, radians) * self.turn).normalize();
    }

    fn frustum(&self) -> Frustum {
        let camera = Camera {
            eye: self.eye.into(),
            direction: (self.turn * DVec3::NEG_Z).into(),
            up: (self.turn * DVec3::Y).into(),
            projection: self.projection,
        };
        camera.frustum().expect("a camera")
    }

    /// Any kind of step, most of them small.
    fn wander(&mut self, rng: &mut Rng) {
        match rng.below(16) {
            0 | 1 => {}
            2..=5 => self.step(0.0, rng.range(0.0, 0.002), rng),
            6..=8 => self.step(rng.range(0.0, 0.1), 0.0, rng),
            9 => self.step(1e-7, 1e-9, rng),
            10 | 11 => self.step(0.5, 0.02, rng),
            12 => self.step(20.0, 1.0, rng),
            13 => {
                let far = if rng.below(2) == 0 { 150.0 } else { f64::INFINITY };
                self.projection = perspective(rng.range(0.3, 2.0), 1.3, far);
            }
            14 => {
                let w = rng.range(5.0, 60.0);
                self.projection = Projection::Orthographic {
                    left: -w,
                    right: w,
                    bottom: -w,
                    top: w,
                    near: 0.0,
                    far: 150.0,
                };
            }
            // Along an axis, where planes have coefficients of nought.
            _ => {
                let quarters = rng.below(4) as f64;
                self.turn = DQuat::from_rotation_y(quarters * std::f64::consts::FRAC_PI_2);
            }
        }
    }
}

/// One frame, both ways; returns how many blocks were answered from memory.
fn same(level: Simd, planes: &Planes, h: &Hierarchy, version: u64, state: &mut Coherent) -> u64 {
    let mut cold = Cut::new();
    cold.cull(level, planes, h.nodes(), h.boxes());
    state.cull(level, planes, h.nodes(), h.boxes(), version);
    assert!(state.cut().visible() == cold.visible(), "visible, {level:?}");
    assert!(state.cut().inside() == cold.inside(), "inside, {level:?}");
    assert!(state.cut().touched().eq(cold.touched()));
    state.answered()
}

#[test]
fn a_wandering_view_sees_what_a_cold_one_sees() {
    let mut rng = Rng(31);
    for count in [0, 5, 16, 17, 300, 5000, 30_000] {
        let (h, _) = world(&mut rng, count);
        at_every_level!(|level| {
            let (mut walker, mut state, mut answered) = (Walker::new(), Coherent::new(), 0);
            for _ in 0..150 {
                walker.wander(&mut rng);
                let planes = Planes::new(&walker.frustum());
                answered += same(level, &planes, &h, 0, &mut state);
            }
            assert!(count < 300 || answered > count / 64, "{answered} of {count}");
        });
    }
}

#[test]
fn many_planes_and_odd_ones_are_no_trap() {
    let mut rng = Rng(32);
    let (h, _) = world(&mut rng, 8000);
    let mut state = Coherent::new();
    for _ in 0..15 {
        let count = rng.below(33);
        let mut planes: Vec<_> =
            (0..count).map(|_| (rng.vector(1.0), rng.range(0.0, 120.0))).collect();
        for _ in 0..12 {
            let mut frustum = Frustum::everything();
            for (normal, d) in &mut planes {
                let step = 10f64.powf(rng.range(-8.0, -1.0));
                *d += rng.range(-step, step);
                let turn = rng.vector(step * 0.01);
                *normal = std::array::from_fn(|a| normal[a] + turn[a]);
                let offset = match rng.below(400) {
                    0 => f64::INFINITY,
                    1 => f64::NEG_INFINITY,
                    2 => f64::NAN,
                    3 => 1e30,
                    4 => -1e18,
                    _ => *d,
                };
                let _ = frustum.push(Plane::new(*normal, offset));
            }
            same(Simd::best(), &Planes::new(&frustum), &h, 0, &mut state);
        }
    }
}

#[test]
fn what_moves_is_asked_again() {
    let mut rng = Rng(33);
    let (mut h, mut handles) = world(&mut rng, 6000);
    let (mut walker, mut state) = (Walker::new(), Coherent::new());
    let mut by_slot = Coherent::new();
    let mut version = 0;
    for _ in 0..200 {
        if rng.below(3) > 0 {
            walker.step(0.01, 0.0003, &mut rng);
        }
        let mut all = true;
        match rng.below(8) {
            0 => {
                let handle = handles[rng.below(handles.len() as u64) as usize];
                h.set_bounds(handle, &random_box(&mut rng)).expect("there");
                by_slot.moved(h.slot(handle).expect("there"));
                all = false;
            }
            1 => handles.push(h.insert(&random_box(&mut rng)).expect("few")),
            2 => {
                let at = rng.below(handles.len() as u64) as usize;
                h.remove(handles.swap_remove(at)).expect("there");
            }
            3 => drop(h.commit_slice()),
            4 => drop(h.commit()),
            5 => {
                let slot = rng.below(u64::from(h.slot_count())) as u32;
                if h.handle(slot).is_some() {
                    h.bounds_mut().set(slot, &random_box(&mut rng));
                }
            }
            6 => {
                h.refit();
                all = false;
            }
            _ => all = false,
        }
        version += u64::from(all);
        let planes = Planes::new(&walker.frustum());
        same(Simd::best(), &planes, &h, h.change_version(), &mut state);
        same(Simd::best(), &planes, &h, version, &mut by_slot);
    }
}

#[test]
fn a_view_that_hardly_moves_asks_little() {
    let mut rng = Rng(35);
    let boxes: Vec<_> = (0..200_000)
        .map(|_| rng.vector(100.0).map(|v| v as f32))
        .map(|c| Aabb::new(c, c.map(|v| v + 0.3)))
        .collect();
    let (h, _) = Hierarchy::build(&boxes).expect("few");
    let (mut walker, mut state) = (Walker::new(), Coherent::new());
    let mut frame = |walker: &Walker| {
        state.cull(Simd::best(), &Planes::new(&walker.frustum()), h.nodes(), h.boxes(), 0);
        (state.share_answered(), state.cut().nodes_tested())
    };
    assert_eq!(frame(&walker).0, 0.0);
    assert_eq!(frame(&walker), (1.0, 0), "still");
    walker.step(1e-4, 1e-6, &mut rng);
    let (share, _) = frame(&walker);
    assert!(share > 0.6, "{share}");
    // Away and back again, as a hand that trembles: what was proved is not forgotten.
    let (eye, turn) = (walker.eye, walker.turn);
    for _ in 0..20 {
        (walker.eye, walker.turn) = (eye, turn);
        walker.step(1e-3, 1e-5, &mut rng);
        assert!(frame(&walker).0 > 0.6);
    }
    walker.step(100.0, 2.0, &mut rng);
    let (share, _) = frame(&walker);
    assert!(share < 0.5, "{share}");
}

/// Prints what the docs of `Coherent` quote: run with `--release -- --ignored --nocapture measure`.
#[test]
#[ignore = "measures, and asserts only that answers agree"]
fn measure_the_gain() {
    let level = Simd::best();
    println!(
        "scene      seen %       step                   same % answered % cold µs coherent µs ratio"
    );
    for clustered in [false, true] {
        let mut rng = Rng(36);
        let middles: Vec<_> = (0..500).map(|_| rng.vector(900.0)).collect();
        let boxes: Vec<_> = (0..1_000_000)
            .map(|i| {
                let p = rng.vector(1000.0);
                let near = rng.vector(60.0);
                let m = middles[i % middles.len()];
                let c = if clustered { [0, 1, 2].map(|a| m[a] + near[a]) } else { p };
                let half = rng.range(0.5, 3.0) as f32;
                let c = c.map(|v| v as f32);
                Aabb::new(c.map(|v| v - half), c.map(|v| v + half))
            })
            .collect();
        let (h, _) = Hierarchy::build(&boxes).expect("few");
        for (seen, fov) in [(1, 0.44), (10, 1.2), (50, 2.5)] {
            for (name, way, degrees) in [
                ("1.2 degrees", 0.0, 1.2),
                ("0.3 degrees", 0.0, 0.3),
                ("0.1 degrees", 0.0, 0.1),
                ("0.03 degrees", 0.0, 0.03),
                ("1 unit ahead", 1.0, 0.0),
                ("0.1 unit ahead", 0.1, 0.0),
                ("0.1 unit, 0.1 degrees", 0.1, 0.1),
                ("still", 0.0, 0.0),
            ] {
                let frames = 150;
                let mut best = vec![[f64::INFINITY; 2]; frames as usize];
                let (mut share, mut visible, mut unchanged) = (0.0, 0, 0.0);
                for turn in 0..8 {
                    let (mut cold, mut warm) = (Cut::new(), Coherent::new());
                    (share, visible, unchanged) = (0.0, 0, 0.0);
                    let mut last = (Vec::new(), Vec::new());
                    for frame in 0..frames {
                        let angle = f64::to_radians(degrees) * f64::from(frame);
                        let direction = [angle.sin(), 0.1, -angle.cos()];
                        let ahead = way * f64::from(frame);
                        let eye = [0.0, 0.0, 200.0 - ahead];
                        let projection = perspective(fov, 1.0, 3000.0);
                        let camera = Camera { eye, direction, up: [0.0, 1.0, 0.0], projection };
                        let planes = Planes::new(&camera.frustum().expect("a camera"));
                        // In turns: who comes second finds the boxes in the cache.
                        let mut took = [0.0; 2];
                        for which in [turn % 2, 1 - turn % 2] {
                            let start = Instant::now();
                            match which {
                                0 => cold.cull(level, &planes, h.nodes(), h.boxes()),
                                _ => warm.cull(level, &planes, h.nodes(), h.boxes(), 0),
                            }
                            took[which] = start.elapsed().as_secs_f64();
                        }
                        for (best, took) in best[frame as usize].iter_mut().zip(took) {
                            *best = best.min(took * 1e6);
                        }
                        assert!(cold.visible() == warm.cut().visible());
                        share += warm.share_answered() * 100.0 / f64::from(frames);
                        visible = cold.count();
                        // Groups whose answer is another than in the frame before: no memory of
                        // groups can answer these.
                        let now = (cold.visible().to_vec(), cold.inside().to_vec());
                        if frame > 0 {
                            let mixed = |at: usize| {
                                let all =
                                    |v: u64| (at..at + 4).all(|i| now.0[i] == v && now.1[i] == v);
                                !all(0) && !all(u64::MAX)
                            };
                            let differs = |at: usize| {
                                let at = at..at + 4;
                                now.0[at.clone()] != last.0[at.clone()]
                                    || now.1[at.clone()] != last.1[at]
                            };
                            let groups = || (0..now.0.len() / 4 * 4).step_by(4);
                            let differing = groups().filter(|&at| mixed(at) && differs(at)).count();
                            let tested = groups().filter(|&at| mixed(at)).count().max(1);
                            unchanged += 1.0 - differing as f64 / tested as f64;
                        }
                        last = now;
                    }
                }
                let best =
                    [0, 1].map(|i| best.iter().map(|b| b[i]).sum::<f64>() / f64::from(frames));
                let scene = if clustered { "clustered" } else { "random" };
                println!(
                    "{scene:<10} {seen:>3} {:>5.1} {name:<22} {:>6.1} {share:>8.1} {:>9.1} {:>9.1} {:>7.2}",
                    visible as f64 / 1e4,
                    unchanged * 100.0 / f64::from(frames - 1),
                    best[0],
                    best[1],
                    best[0] / best[1]
                );
            }
        }
    }
}
