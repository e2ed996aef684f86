//! The two judges of what is hidden: cases with known answers, and each against the other.

use cullet::bounds::Aabb;
use cullet::{Camera, Depth, Projection, Transform, View};
use cullet_draw::{
    OccluderTriangles, Proof, ProofOptions, Prover, SampleOptions, Sampled, VerifyOptions,
    occluder_scene, prove_hidden, sampled_boxes, sampled_instances,
};
use cullet_testkit::Rng;
use cullet_testkit::scenes::{city, mixed_scene};
use cullet_testkit::views::{look, mixed_view};
use proptest::prelude::*;

/// Triangles as they are written down in a test.
#[derive(Clone, Default)]
struct Soup {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl Soup {
    /// Four corners in order, cut along the diagonal from the first.
    fn quad(mut self, corners: [[f32; 3]; 4]) -> Self {
        let n = self.positions.len() as u32;
        self.positions.extend(corners);
        self.indices.extend([n, n + 1, n + 2, n, n + 2, n + 3]);
        self
    }

    /// A wall across the line of sight.
    fn wall(self, x: [f32; 2], y: [f32; 2], z: f32) -> Self {
        self.quad([[x[0], y[0], z], [x[1], y[0], z], [x[1], y[1], z], [x[0], y[1], z]])
    }

    fn occluder(&self) -> OccluderTriangles<'_> {
        OccluderTriangles {
            positions: &self.positions,
            indices: &self.indices,
            transform: Transform::IDENTITY,
            two_sided: true,
        }
    }
}

fn front(viewport: [u32; 2]) -> View {
    look([0.0; 3], [0.0, 0.0, -1.0], viewport)
}

fn cube(centre: [f32; 3], half: f32) -> Aabb {
    Aabb::new(centre.map(|v| v - half), centre.map(|v| v + half))
}

fn prove(view: &View, soups: &[&Soup], bounds: Aabb) -> Proof {
    let occluders: Vec<_> = soups.iter().map(|s| s.occluder()).collect();
    prove_hidden(view, &occluders, &bounds, &Transform::IDENTITY, &ProofOptions::default())
}

fn sample(view: &View, soups: &[&Soup], bounds: Aabb, samples: u32) -> Sampled {
    let occluders: Vec<_> = soups.iter().map(|s| s.occluder()).collect();
    let scene = occluder_scene(&occluders).unwrap();
    let options = SampleOptions { samples, ..SampleOptions::default() };
    sampled_boxes(&scene, view, &[bounds], &options)[0]
}

fn is_refuted(proof: Proof) -> bool {
    matches!(proof, Proof::Refuted { .. })
}

#[test]
fn a_box_behind_a_wall_is_hidden_and_one_before_it_is_not() {
    // One wall of two triangles: the diagonal runs through the image of the box.
    let wall = Soup::default().wall([-5.0, 5.0], [-5.0, 5.0], -10.0);
    for size in [[1, 1], [37, 91], [320, 180], [1280, 720]] {
        let view = front(size);
        let behind = cube([0.0, 0.0, -20.0], 2.0);
        assert_eq!(prove(&view, &[&wall], behind), Proof::Proved, "{size:?}");
        assert_eq!(sample(&view, &[&wall], behind, 16), Sampled::Hidden, "{size:?}");
        let before = cube([0.0, 0.0, -8.0], 0.5);
        assert!(is_refuted(prove(&view, &[&wall], before)), "{size:?}");
        assert_eq!(sample(&view, &[&wall], before, 16), Sampled::Visible, "{size:?}");
        // Half of it looks over the edge.
        let beside = cube([0.0, 10.0, -20.0], 1.0);
        assert!(is_refuted(prove(&view, &[&wall], beside)), "{size:?}");
    }
}

#[test]
fn every_gap_between_abutting_walls_is_found() {
    let view = front([320, 180]);
    // A pixel at the distance of the walls, in world units.
    let pixel = 2.0 * 10.0 * 30f64.to_radians().tan() / 180.0;
    let behind = cube([0.0, 0.0, -20.0], 1.0);
    for gap in [1.0, 0.1, 0.02] {
        let x = (pixel * gap) as f32;
        let walls = Soup::default().wall([-5.0, 0.0], [-5.0, 5.0], -10.0).wall(
            [x, 5.0],
            [-5.0, 5.0],
            -10.0,
        );
        let proof = prove(&view, &[&walls], behind);
        let Proof::Refuted { pixel: [at, _] } = proof else {
            panic!("a gap of {gap} pixels: {proof:?}")
        };
        assert!(at > 160.0 && at < 160.0 + gap, "{at}");
        // Samples at the pixels' centres miss what is narrower than half a pixel.
        let sampled = sample(&view, &[&walls], behind, 1);
        assert_eq!(sampled, if gap < 0.5 { Sampled::Hidden } else { Sampled::Visible });
    }
    // Narrower than a cell may be: never proved; found where cells may be small enough.
    for gap in [1e-2, 1e-3] {
        let x = (pixel * gap) as f32;
        let walls = Soup::default().wall([-5.0, 0.0], [-5.0, 5.0], -10.0).wall(
            [x, 5.0],
            [-5.0, 5.0],
            -10.0,
        );
        assert_ne!(prove(&view, &[&walls], behind), Proof::Proved, "{gap}");
        let fine = ProofOptions { smallest_px: gap * 0.25, max_cells: 10_000_000 };
        let occluders = [walls.occluder()];
        let proof = prove_hidden(&view, &occluders, &behind, &Transform::IDENTITY, &fine);
        assert!(is_refuted(proof), "{gap}: {proof:?}");
    }
}

#[test]
fn shared_edges_prove_and_edges_that_only_touch_do_not() {
    let view = front([320, 180]);
    let behind = cube([0.0, 0.0, -20.0], 1.0);
    // In one mesh, the vertices between the walls are the same places.
    let joined =
        Soup::default().wall([-5.0, 0.1], [-5.0, 5.0], -10.0).wall([0.1, 5.0], [-5.0, 5.0], -10.0);
    assert_eq!(prove(&view, &[&joined], behind), Proof::Proved);
    // A T: the edge on the left has no vertex in the middle, those on the right have.
    let tee = Soup::default()
        .wall([-5.0, 0.1], [-5.0, 5.0], -10.0)
        .wall([0.1, 5.0], [-5.0, 0.05], -10.0)
        .wall([0.1, 5.0], [0.05, 5.0], -10.0);
    let Proof::Undecided { area } = prove(&view, &[&tee], behind) else { panic!("a T-junction") };
    assert!(area > 0.0 && area < 2.0, "{area}");
    // Walls that overlap need no vertices in common, nor a mesh.
    let left = Soup::default().wall([-5.0, 0.2], [-5.0, 5.0], -10.0);
    let right = Soup::default().wall([0.1, 5.0], [-5.0, 5.0], -11.0);
    assert_eq!(prove(&view, &[&left, &right], behind), Proof::Proved);
    // A fan around a vertex before the middle of the box.
    let mut fan = Soup { positions: vec![[0.03, -0.02, -9.0]], indices: Vec::new() };
    for k in 0..7u32 {
        let (s, c) = (f64::from(k) / 7.0 * std::f64::consts::TAU).sin_cos();
        fan.positions.push([(5.0 * c) as f32, (5.0 * s) as f32, -10.0]);
        fan.indices.extend([0, 1 + k, 1 + (k + 1) % 7]);
    }
    assert_eq!(prove(&view, &[&fan], behind), Proof::Proved);
    // Without one of its blades it is a gap.
    fan.indices.truncate(18);
    assert!(is_refuted(prove(&view, &[&fan], behind)));
}

#[test]
fn what_touches_is_not_hidden() {
    let view = front([320, 180]);
    let wall = Soup::default().wall([-9.0, 9.0], [-9.0, 9.0], -10.0);
    let touching = Aabb::new([-1.0, -1.0, -12.0], [1.0, 1.0, -10.0]);
    assert_ne!(prove(&view, &[&wall], touching), Proof::Proved);
    assert_eq!(sample(&view, &[&wall], touching, 4), Sampled::Visible);
    let clear = Aabb::new([-1.0, -1.0, -12.0], [1.0, 1.0, -10.001]);
    assert_eq!(prove(&view, &[&wall], clear), Proof::Proved);
    // Reference files of the exchange format let it go.
    let scene = occluder_scene(&[wall.occluder()]).unwrap();
    let options = SampleOptions { tolerance: 1e-6, ..SampleOptions::default() };
    assert_eq!(sampled_boxes(&scene, &view, &[touching], &options), [Sampled::Hidden]);
    let before = Aabb::new([-1.0, -1.0, -12.0], [1.0, 1.0, -9.999]);
    assert_eq!(sampled_boxes(&scene, &view, &[before], &options), [Sampled::Visible]);
}

#[test]
fn eye_inside_near_and_outside() {
    let view = front([64, 64]);
    let wall = Soup::default().wall([-9.0, 9.0], [-9.0, 9.0], -1.0);
    let all = Proof::Undecided { area: 4096.0 };
    // Around the eye; across the near plane at 0.5; wholly nearer than it; beside the eye.
    let around = cube([0.0; 3], 3.0);
    let across = Aabb::new([-0.1, -0.1, -2.0], [0.1, 0.1, -0.4]);
    for b in [around, across] {
        assert_eq!(prove(&view, &[&wall], b), all);
        assert_eq!(sample(&view, &[&wall], b, 1), Sampled::CrossesNear);
    }
    for b in [cube([0.0, 0.0, -0.2], 0.1), cube([0.0, 0.0, 5.0], 1.0), cube([40.0, 0.0, -9.0], 1.0)]
    {
        assert_eq!(prove(&view, &[&wall], b), Proof::Proved);
        assert_eq!(sample(&view, &[&wall], b, 1), Sampled::Outside);
    }
    // A wall nearer than the near plane is not drawn, and hides nothing.
    let too_near = Soup::default().wall([-9.0, 9.0], [-9.0, 9.0], -0.3);
    let b = cube([0.0, 0.0, -20.0], 2.0);
    assert!(is_refuted(prove(&view, &[&too_near], b)));
    assert_eq!(sample(&view, &[&too_near], b, 1), Sampled::Visible);
    // A floor that runs under the eye hides what is below it, though corners are behind the eye.
    let floor = Soup::default().quad([
        [-50.0, -1.0, 50.0],
        [50.0, -1.0, 50.0],
        [50.0, -1.0, -90.0],
        [-50.0, -1.0, -90.0],
    ]);
    let cellar = cube([0.0, -6.0, -20.0], 2.0);
    assert_eq!(prove(&view, &[&floor], cellar), Proof::Proved);
    assert_eq!(sample(&view, &[&floor], cellar, 4), Sampled::Hidden);
    // The eye in a closed room.
    let mut room = Soup::default();
    let c = Aabb::new([-2.0; 3], [2.0; 3]).corners();
    room.positions = c.to_vec();
    room.positions.sort_by(|a, b| a.partial_cmp(b).unwrap());
    for [a, b, c, d] in
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    {
        room.indices.extend([a, b, c, a, c, d]);
    }
    assert_eq!(prove(&view, &[&room], cube([0.0, 0.0, -20.0], 9.0)), Proof::Proved);
}

#[test]
fn nothing_that_is_not_finite_is_proved() {
    let view = front([64, 64]);
    let wall = Soup::default().wall([-9.0, 9.0], [-9.0, 9.0], -1.0);
    for b in [
        Aabb::new([f32::NAN, 0.0, -9.0], [1.0, 1.0, -8.0]),
        Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]),
        Aabb::EMPTY,
    ] {
        assert!(matches!(prove(&view, &[&wall], b), Proof::Undecided { .. }), "{b:?}");
        assert_eq!(sample(&view, &[&wall], b, 1), Sampled::CrossesNear);
    }
    // A wall with a corner that is no place, or that is not there, hides nothing.
    let mut broken = Soup::default().wall([-9.0, 9.0], [-9.0, 9.0], -1.0);
    broken.indices[4] = 99;
    broken.positions[1][0] = f32::NAN;
    let b = cube([0.0, 0.0, -20.0], 2.0);
    assert_ne!(prove(&view, &[&broken], b), Proof::Proved);
    let error = occluder_scene(&[broken.occluder()]).unwrap_err().to_string();
    assert_eq!(error, "occluder 0 refers to vertex 99, but there are only 4 (from 0)");
    broken.indices[4] = 2;
    let error = occluder_scene(&[broken.occluder()]).unwrap_err().to_string();
    assert!(error.starts_with("occluder 0: vertex 1 is not finite"), "{error}");
}

/// Views of one place by projections of every kind.
fn projections() -> Vec<(&'static str, View)> {
    let at = |projection, depth| {
        let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
        View::new(&camera, depth, [113, 67]).unwrap()
    };
    let window = |left: f64, right: f64, far: f64| Projection::OffCentre {
        left,
        right,
        bottom: -0.1,
        top: 0.3,
        near: 0.2,
        far,
    };
    let parallel = |left: f64, right: f64| Projection::Orthographic {
        left,
        right,
        bottom: -4.0,
        top: 4.0,
        near: -5.0,
        far: 100.0,
    };
    vec![
        ("off-centre", at(window(-0.1, 0.5, 100.0), Depth::Standard)),
        ("reversed, infinite", at(window(-0.4, 0.4, f64::INFINITY), Depth::Reversed)),
        ("mirrored", at(window(0.4, -0.4, 100.0), Depth::Standard)),
        ("orthographic", at(parallel(-6.0, 6.0), Depth::Standard)),
        ("orthographic, reversed", at(parallel(-6.0, 6.0), Depth::Reversed)),
        ("orthographic, mirrored", at(parallel(6.0, -6.0), Depth::Standard)),
    ]
}

#[test]
fn every_projection_gives_the_known_answers() {
    let wall = Soup::default().wall([-2.0, 2.0], [-2.0, 2.0], -10.0);
    for (name, view) in projections() {
        for (b, hidden) in [
            (cube([0.1, 0.2, -12.0], 1.0), true),
            (cube([0.1, 0.2, -8.0], 1.0), false),
            (cube([2.0, 0.2, -12.0], 1.0), false),
        ] {
            let proof = prove(&view, &[&wall], b);
            assert_eq!(proof == Proof::Proved, hidden, "{name}: {proof:?}");
            assert_eq!(is_refuted(proof), !hidden, "{name}: {proof:?}");
            let expected = if hidden { Sampled::Hidden } else { Sampled::Visible };
            assert_eq!(sample(&view, &[&wall], b, 4), expected, "{name}");
        }
    }
}

#[test]
fn the_edge_of_the_screen_cuts_what_has_to_be_proved() {
    let view = front([200, 100]);
    // At distance 10 the picture reaches to ±11.5; the wall covers only what of the box is in it.
    let wall = Soup::default().wall([5.0, 12.0], [-3.0, 3.0], -10.0);
    let over_the_edge = Aabb::new([14.0, -1.0, -20.0], [60.0, 1.0, -19.0]);
    assert_eq!(prove(&view, &[&wall], over_the_edge), Proof::Proved);
    assert_eq!(sample(&view, &[&wall], over_the_edge, 4), Sampled::Hidden);
    let short = Soup::default().wall([5.0, 11.0], [-3.0, 3.0], -10.0);
    assert!(is_refuted(prove(&view, &[&short], over_the_edge)));
    assert_eq!(sample(&view, &[&short], over_the_edge, 4), Sampled::Visible);
}

#[test]
fn sides_hide_as_they_are_drawn() {
    let view = front([64, 64]);
    let b = cube([0.0, 0.0, -20.0], 2.0);
    // Counter-clockwise as seen from the eye: its front.
    let wall = Soup::default().wall([-9.0, 9.0], [-9.0, 9.0], -10.0);
    for (mirror, two_sided, hidden) in
        [(false, false, true), (true, false, false), (true, true, true)]
    {
        let mut occluder = OccluderTriangles { two_sided, ..wall.occluder() };
        let mut indices = wall.indices.clone();
        if mirror {
            indices.as_chunks_mut::<3>().0.iter_mut().for_each(|t| t.swap(0, 1));
        }
        occluder.indices = &indices;
        let proof =
            prove_hidden(&view, &[occluder], &b, &Transform::IDENTITY, &ProofOptions::default());
        assert_eq!(proof == Proof::Proved, hidden);
        let scene = occluder_scene(&[occluder]).unwrap();
        let seen = sampled_boxes(&scene, &view, &[b], &SampleOptions::default())[0];
        assert_eq!(seen == Sampled::Hidden, hidden);
    }
    // Slivers, a hundred thousand of them in one pixel or so, hide what they cover together.
    let mut slivers = Soup::default();
    let n = 20_000u32;
    for i in 0..=n {
        let x = -0.2 + 0.4 * i as f32 / n as f32;
        slivers.positions.extend([[x, -0.2, -10.0], [x, 0.2, -10.0]]);
    }
    for i in 0..n {
        let a = i * 2;
        slivers.indices.extend([a, a + 2, a + 1, a + 1, a + 2, a + 3]);
    }
    let small = cube([0.0, 0.0, -20.0], 0.1);
    assert_eq!(prove(&view, &[&slivers], small), Proof::Proved);
    slivers.indices.drain(60_000..60_003);
    assert_ne!(prove(&view, &[&slivers], small), Proof::Proved);
}

/// Boxes about a scene, some of them placed by a transform of any kind.
fn boxes(rng: &mut Rng, n: u32) -> Vec<Aabb> {
    (0..n)
        .map(|_| {
            let half = rng.range(0.01, 0.6) as f32;
            cube(std::array::from_fn(|_| rng.range(-5.0, 5.0) as f32), half)
        })
        .collect()
}

/// Holds the proof against samples: N × N jittered ones must not see what is proved hidden, and what is
/// refuted must be seen by a sample at the very place.
fn agree(scene: &cullet::Scene, view: &View, boxes: &[Aabb], seed: u64) -> [u32; 3] {
    let options = SampleOptions { samples: 8, seed: Some(seed), ..SampleOptions::default() };
    let sampled = sampled_boxes(scene, view, boxes, &options);
    let prover = Prover::of_scene(view, scene);
    let quick = ProofOptions { smallest_px: 0.25, max_cells: 20_000 };
    let mut counts = [0; 3];
    for (b, sampled) in boxes.iter().zip(sampled) {
        match prover.prove(b, &Transform::from_translation(scene.origin()), &quick) {
            Proof::Proved => {
                assert_ne!(sampled, Sampled::Visible, "{b:?} is proved hidden, but seen");
                counts[0] += 1;
            }
            Proof::Refuted { pixel } => {
                assert_ne!(sampled, Sampled::Outside, "{b:?} is refuted, but out of sight");
                // One sample to a pixel, at the place of the refutation in its own pixel.
                let at = pixel.map(|v| v - v.floor());
                let here = SampleOptions { jitter: at, ..SampleOptions::default() };
                let seen = sampled_boxes(scene, view, std::slice::from_ref(b), &here)[0];
                assert_eq!(seen, Sampled::Visible, "{b:?} is refuted at {pixel:?}, but not seen");
                counts[1] += 1;
            }
            Proof::Undecided { .. } => counts[2] += 1,
        }
    }
    counts
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cullet_testkit::cases(60), ..ProptestConfig::default() })]

    #[test]
    fn the_judges_agree(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let scene = mixed_scene(&mut rng);
        let size = [1 + rng.below(60) as u32, 1 + rng.below(40) as u32];
        let view = mixed_view(&mut rng, size);
        agree(&scene, &view, &boxes(&mut rng, 20), seed);
    }
}

#[test]
fn the_judges_agree_on_a_city_and_decide_nearly_all_of_it() {
    let scene = city(8, 2, 0);
    let view = look([3.0, 1.7, 97.0], [20.0, 4.0, 0.0], [320, 180]);
    let mut rng = Rng(3);
    let boxes: Vec<Aabb> = (0..300)
        .map(|_| {
            let p = [rng.range(-95.0, 95.0), 1.3, rng.range(-95.0, 80.0)];
            cube(p.map(|v| v as f32), rng.range(0.2, 1.0) as f32)
        })
        .collect();
    let [proved, refuted, undecided] = agree(&scene, &view, &boxes, 5);
    assert!(proved > 150 && refuted > 10, "{proved} proved, {refuted} refuted");
    assert!(undecided * 20 < proved + refuted, "{undecided} undecided");
}

#[test]
fn more_occluders_and_smaller_boxes_are_never_seen_more() {
    let mut rng = Rng(11);
    let all = city(6, 1, 0);
    let view = look([0.0, 3.0, 80.0], [0.0, 2.0, 0.0], [160, 90]);
    let mut fewer = city(6, 1, 0);
    for slot in (1..fewer.slot_count()).step_by(2) {
        let handle = fewer.handle(slot).unwrap();
        fewer.remove(handle).unwrap();
    }
    let boxes: Vec<Aabb> = (0..200)
        .map(|_| cube([rng.range(-70.0, 70.0), 1.0, rng.range(-70.0, 70.0)].map(|v| v as f32), 0.7))
        .collect();
    let smaller: Vec<Aabb> =
        boxes.iter().map(|b| cube(b.center().map(|v| v as f32), 0.3)).collect();
    let options = SampleOptions { samples: 4, ..SampleOptions::default() };
    let [few, many] = [&fewer, &all].map(|s| sampled_boxes(s, &view, &boxes, &options));
    let small = sampled_boxes(&all, &view, &smaller, &options);
    let hidden = |v: &[Sampled]| v.iter().filter(|s| **s == Sampled::Hidden).count();
    assert!(hidden(&few) < hidden(&many));
    for i in 0..boxes.len() {
        assert!(few[i] != Sampled::Hidden || many[i] == Sampled::Hidden);
        assert!(many[i] != Sampled::Hidden || small[i] != Sampled::Visible);
    }
    // However many threads.
    let one = SampleOptions { threads: 1, ..options };
    assert_eq!(sampled_boxes(&all, &view, &boxes, &one), many);
}

#[test]
fn instances_seen_by_samples_are_those_that_verify_would_miss() {
    let scene = city(6, 1, 60);
    let view = look([5.0, 3.0, 90.0], [0.0, 2.0, 0.0], [160, 90]);
    let options = VerifyOptions::default();
    let coarse = sampled_instances(&scene, &view, &VerifyOptions { samples: 1, ..options });
    let fine = sampled_instances(&scene, &view, &VerifyOptions { samples: 8, ..options });
    assert!(fine.len() >= coarse.len() && coarse.len() > 5, "{} {}", coarse.len(), fine.len());
    assert!(fine.is_sorted() && (fine.len() as u32) < scene.slot_count());
    let prover = Prover::of_scene(&view, &scene);
    for &(slot, _) in &fine {
        let proof =
            prover.prove(&scene.bounds(slot), &Transform::IDENTITY, &ProofOptions::default());
        assert_ne!(proof, Proof::Proved, "slot {slot} is seen");
    }
}
