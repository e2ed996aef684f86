//! Both eyes of a headset in one call: each eye's picture is the same with what the call left as with everything.

use cullet::{Culler, Depth, Instance, Output, Projection, Scene, Stage, Transform, View};
use cullet_draw::{RenderOptions, Selection, render};
use cullet_testkit::answers::cull;
use cullet_testkit::{Rng, cases, meshes};

/// Blocks and balls, in rows and heaps, of which many hide others.
fn crowd(rng: &mut Rng) -> Scene {
    let mut scene = Scene::new();
    let all = [meshes::block([-1.0; 3], [1.0; 3]), meshes::ball(8), meshes::ball(24)];
    let all = all.map(|mesh| scene.add_mesh(mesh));
    for _ in 0..150 {
        let at = [rng.range(-8.0, 8.0), rng.range(-3.0, 3.0), rng.range(-30.0, -1.5)];
        let size = [0; 3].map(|_| rng.range(0.1, 1.5) as f32);
        let mesh = all[rng.index(all.len())];
        let place = Transform::from_scale_translation(size, at);
        scene.add(Instance::new(mesh, place)).unwrap();
    }
    scene.prepare(&Culler::exact());
    scene.sort();
    scene
}

fn eyes(rng: &mut Rng) -> [View; 2] {
    let depth = if rng.chance(0.5) { Depth::Standard } else { Depth::Reversed };
    let half = [0.005, 0.032, 0.2][rng.index(3)];
    let turn = if rng.chance(0.5) { 0.0 } else { rng.range(-0.05, 0.2) };
    [-1.0, 1.0].map(|side: f64| {
        let (near, far) = (0.1, 100.0);
        let (left, right) = if side < 0.0 { (-0.12, 0.09) } else { (-0.09, 0.12) };
        let projection = Projection::OffCentre { left, right, bottom: -0.1, top: 0.1, near, far };
        let camera = cullet::Camera {
            eye: [side * half, 0.2, 0.0],
            direction: [side * turn, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            projection,
        };
        View::new(&camera, depth, [210, 200]).unwrap()
    })
}

#[test]
fn each_eye_sees_the_same_picture() {
    let mut rng = Rng(71);
    let (mut hidden, mut of_one) = (0, 0);
    for round in 0..cases(60) {
        let scene = crowd(&mut rng);
        let eyes = eyes(&mut rng);
        let both = View::stereo(&eyes[0], &eyes[1]).unwrap();
        let culler = Culler::exact().with_output(Output::Triangles).with_reasons(true);
        let result = cull(&culler, &scene, &both);
        for (eye, view) in eyes.iter().enumerate() {
            let options = RenderOptions::default();
            let full = render(&scene, view, Selection::All, &options);
            let culled = render(&scene, view, Selection::Visible(&result), &options);
            assert!(full.ids == culled.ids, "round {round}, eye {eye}");
        }
        let count = |result: &cullet::Visible| {
            let by = |r: &&Option<cullet::Reason>| r.is_some_and(|r| r.stage == Stage::Occlusion);
            result.reasons.iter().filter(by).count()
        };
        hidden += count(&result);
        of_one += count(&cull(&culler, &scene, &eyes[0]));
    }
    assert!(hidden * 3 > of_one, "{hidden} hidden from both, {of_one} from the left eye");
}
