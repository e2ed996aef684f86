//! Both eyes of a headset in one call: nothing that either sees is lost.

use cullet::view::ViewError;
use cullet::{
    Camera, Culler, Depth, Instance, Output, Projection, Scene, Stage, Transform, View, ViewState,
    Visible,
};
use cullet_testkit::answers::{cull, listed};
use cullet_testkit::oracles::visible::visible_ref;
use cullet_testkit::scenes::random_scene;
use cullet_testkit::{Rng, cases, meshes};
use glam::{DMat3, DVec3};

/// Eyes of a headset that looks anywhere: off the centre, sometimes turned outward, near and far planes of every kind.
fn random_eyes(rng: &mut Rng) -> [View; 2] {
    let depth = if rng.chance(0.5) { Depth::Standard } else { Depth::Reversed };
    let (near, far) = (rng.range(0.05, 0.5), if rng.chance(0.3) { f64::INFINITY } else { 200.0 });
    let eye = DVec3::from(rng.vector(12.0));
    let ahead = DVec3::from(rng.vector(1.0)).normalize();
    let right = ahead.any_orthonormal_vector();
    let (half, turn) =
        (rng.range(0.01, 0.3), if rng.chance(0.5) { 0.0 } else { rng.range(0.0, 0.4) });
    let (inner, outer) = (near * rng.range(0.5, 1.0), near * rng.range(0.6, 1.3));
    [-1.0, 1.0].map(|side: f64| {
        let up = right.cross(ahead);
        let direction = DMat3::from_axis_angle(up, -side * turn) * ahead;
        let (left, right_edge) = if side < 0.0 { (-outer, inner) } else { (-inner, outer) };
        let (bottom, top) = (-near * 0.9, near * 0.8);
        let projection = Projection::OffCentre { left, right: right_edge, bottom, top, near, far };
        let eye = (eye + right * (half * side)).into();
        let camera = Camera { eye, direction: direction.into(), up: up.into(), projection };
        View::new(&camera, depth, [400, 440]).expect("a good eye")
    })
}

#[test]
fn the_frustum_of_both_holds_that_of_each() {
    let mut rng = Rng(61);
    for _ in 0..500 {
        let eyes = random_eyes(&mut rng);
        let both = View::stereo(&eyes[0], &eyes[1]).unwrap().frustum();
        for eye in &eyes {
            let corners = eye.frustum().corners().unwrap();
            for [x, y, z, w] in corners {
                let far = if w == 0.0 { 1e6 } else { 1.0 };
                let at =
                    DVec3::from([x, y, z]) * far + DVec3::from_slice(&eye.eye()[..3]) * (1.0 - w);
                // A little inward, for what rounding does to the corners themselves.
                let quarter = |half: &[[f64; 4]]| {
                    half.iter().map(|c| DVec3::from_slice(&c[..3]) * 0.25).sum::<DVec3>()
                };
                let (near, beyond) = (quarter(&corners[..4]), quarter(&corners[4..]));
                let middle =
                    near + if corners[7][3] == 0.0 { beyond } else { (beyond - near) * 0.5 };
                let inward = at.lerp(middle, 1e-7);
                assert!(both.contains(inward), "{inward} of {corners:?}");
            }
        }
    }
}

/// Everything that the oracle sees from either eye is in the one answer, and each eye's bit says so.
#[test]
fn nothing_that_an_eye_sees_is_dropped() {
    let mut rng = Rng(62);
    let (mut all, mut kept, mut needed) = (0, 0, 0);
    for round in 0..cases(300) {
        let scene = random_scene(&mut rng, 14);
        let eyes = random_eyes(&mut rng);
        let both = View::stereo(&eyes[0], &eyes[1]).unwrap();
        // The oracle does not know what is hidden; `cullet-draw` holds that against pictures.
        let culler = Culler::exact().with_output(Output::Triangles).with_occlusion(None);
        let result = cull(&culler, &scene, &both);
        let listed = listed(&result);
        let bits: std::collections::BTreeMap<u32, u8> =
            result.by_eye(&scene, &eyes[0], &eyes[1]).collect();
        for (eye, view) in eyes.iter().enumerate() {
            for (slot, triangle) in visible_ref(&scene, view) {
                needed += 1;
                assert!(listed.contains(&(slot, triangle)), "round {round}: {slot}, {triangle}");
                assert!(bits[&slot] >> eye & 1 == 1, "round {round}: slot {slot} of eye {eye}");
            }
        }
        (all, kept) = (all + scene.triangle_count(), kept + result.triangle_count);
    }
    assert!(needed > 1000 && kept * 2 < all, "{needed} seen, {kept} kept of {all}");
}

/// A street of blocks: what hides from both eyes is found by one buffer, nearly as much as from each eye alone.
#[test]
fn one_buffer_hides_for_both() {
    let mut scene = Scene::new();
    let block = scene.add_mesh(meshes::block([-1.0; 3], [1.0; 3]));
    let mut rng = Rng(63);
    for i in 0..900 {
        let at = [f64::from(i % 30) * 8.0 - 120.0, 0.0, f64::from(i / 30) * -8.0 - 12.0];
        let size = [3.0, 4.0 + rng.range(0.0, 6.0) as f32, 3.0];
        scene.add(Instance::new(block, Transform::from_scale_translation(size, at))).unwrap();
    }
    scene.commit(&Culler::default());
    let eyes = [-0.032, 0.032].map(|x| {
        let eye = [x + 0.3, 1.7, 0.0];
        let ahead = [x + 0.3, 1.7, -1.0];
        View::perspective(eye, ahead, 1.6, 0.1, 1000.0, [1000, 1000]).unwrap()
    });
    let both = View::stereo(&eyes[0], &eyes[1]).unwrap();
    let culler = Culler::exact();
    let count = |view: &View| cull(&culler, &scene, view).instance_count;
    let ([left, right], of_both) = ([count(&eyes[0]), count(&eyes[1])], count(&both));
    let without = cull(&culler.without(Stage::Occlusion), &scene, &both).instance_count;
    assert!(of_both >= left.max(right));
    assert!(of_both * 3 < without, "{of_both} of {without}");
    assert!(of_both <= left.max(right) + 2, "{left} and {right}, {of_both} of both");
    // The answer is the same cold and warm.
    let (mut state, mut result) = (ViewState::default(), Visible::default());
    for _ in 0..2 {
        culler.cull_one(&scene, &both, &mut state, &mut result);
        assert_eq!(result.instance_count, of_both);
    }
}

#[test]
fn views_that_make_no_pair_are_refused() {
    let view = |x: f64, z: f64| {
        View::perspective([x, 0.0, 0.0], [x, 0.0, z], 1.0, 0.1, 100.0, [64, 64]).unwrap()
    };
    let refused = |a: &View, b: &View| match View::stereo(a, b) {
        Err(ViewError::Stereo { what }) => what,
        other => panic!("{other:?}"),
    };
    let left = view(-0.03, -1.0);
    assert_eq!(refused(&left, &view(0.03, -1.0).with_layers(2)), "have different layers");
    assert_eq!(refused(&left, &view(0.03, 1.0)), "look apart");
    let plan = View::orthographic([0.0; 3], [0.0, 0.0, -1.0], 2.0, 0.1, 9.0, [64, 64]).unwrap();
    assert_eq!(refused(&left, &plan), "is orthographic");
    let wide = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 9.0, [65, 64]).unwrap();
    assert_eq!(refused(&left, &wide), "have different viewports or depths");
    assert!(View::stereo(&left, &left).is_ok());
    assert_eq!(View::stereo(&left, &left).unwrap().eyes_apart(), [0.0; 3]);
}

/// Prints the time of both eyes in one call beside that of two calls, at the corner of a street of a city.
#[test]
#[ignore = "measures"]
fn both_eyes_beside_two_calls() {
    let mut scene = cullet_testkit::scenes::city(40, 6, 20_000);
    scene.commit(&Culler::default());
    let eyes = |turn: f64| {
        [-0.032, 0.032].map(|x: f64| {
            let side = [-turn.sin() * x, turn.cos() * x];
            let eye = [6.0 + side[0], 1.7, 6.0 + side[1]];
            let ahead = [eye[0] + turn.cos(), 1.7, eye[2] + turn.sin()];
            View::perspective(eye, ahead, 1.6, 0.1, 1000.0, [1600, 1600]).expect("an eye")
        })
    };
    let culler = Culler::exact();
    let mut states: [ViewState; 3] = Default::default();
    let mut results: [Visible; 3] = Default::default();
    let (mut two, mut one, mut left) = (0.0, 0.0, [0; 2]);
    for frame in 0..60 {
        let pair = eyes(f64::from(frame) * 0.02);
        let start = std::time::Instant::now();
        for eye in 0..2 {
            culler.cull_one(&scene, &pair[eye], &mut states[eye], &mut results[eye]);
        }
        let middle = std::time::Instant::now();
        let both = View::stereo(&pair[0], &pair[1]).expect("a pair");
        culler.cull_one(&scene, &both, &mut states[2], &mut results[2]);
        if frame > 20 {
            two += (middle - start).as_secs_f64();
            one += middle.elapsed().as_secs_f64();
            left[0] += results[0].instance_count.max(results[1].instance_count);
            left[1] += results[2].instance_count;
        }
    }
    println!("one call {:.2} of two, {} instances left of {}", one / two, left[1], left[0]);
}
