//! Views that stand: their answers are copied, and are those of a view that was never asked.

use cullet::bounds::Aabb;
use cullet::cull::detail::Detail;
use cullet::prepared::Preparation;
use cullet::scene::BoundsOverride;
use cullet::{
    Culler, Handle, Instance, InstanceFlags, Output, Scene, Transform, View, ViewState, Visible,
};
use cullet_testkit::Rng;
use cullet_testkit::meshes::block;

/// A name, and a change of a scene.
type Change = (&'static str, fn(&mut Scene, &[Handle]));

const CHANGES: &[Change] = &[
    ("nothing", |_, _| {}),
    ("moved", |scene, all| {
        scene.set_transform(all[3], Transform::from_translation([0.5, 0.0, -4.0])).unwrap();
    }),
    ("layers", |scene, all| scene.set_layers(all[2], 2).unwrap()),
    ("flags", |scene, all| {
        let flags = InstanceFlags { always_visible: true, ..InstanceFlags::default() };
        scene.set_flags(all[5], flags).unwrap();
    }),
    ("weight", |scene, all| scene.set_size_weight(all[1], 0.001).unwrap()),
    ("bounds", |scene, all| {
        let far = Aabb::new([900.0; 3], [901.0; 3]);
        scene.set_bounds(all[4], BoundsOverride::World(far)).unwrap();
    }),
    ("removed", |scene, all| scene.remove(all[0]).unwrap()),
    ("added", |scene, _| {
        scene.add(Instance::new(0, Transform::from_translation([0.0, 0.0, -6.0]))).unwrap();
    }),
    ("prepared", |scene, _| scene.prepare(Preparation::ALL)),
    ("edited", |scene, _| {
        scene.edit_mesh(0, |mesh| *mesh = block([-2.0; 3], [2.0; 3]));
    }),
    ("sorted", |scene, _| {
        scene.sort();
    }),
    ("another origin", |scene, _| scene.rebase([3.0, 1.0, -2.0])),
];

fn scene() -> (Scene, Vec<Handle>) {
    let (mut scene, mut rng) = (Scene::new(), Rng(4));
    scene.add_mesh(block([-1.0; 3], [1.0; 3]));
    let add = |_| {
        let at = [rng.range(-6.0, 6.0), rng.range(-4.0, 4.0), rng.range(-40.0, -5.0)];
        scene.add(Instance::new(0, Transform::from_translation(at))).unwrap()
    };
    let all = (0..300).map(add).collect();
    scene.sort();
    (scene, all)
}

fn view(x: f64) -> View {
    View::perspective([x, 0.0, 4.0], [x, 0.0, -20.0], 0.7, 0.1, 100.0, [320, 200]).unwrap()
}

#[test]
fn each_change_of_a_scene_is_seen_by_a_view_that_stood() {
    let detail = Some(Detail::default().with_threshold_px(3.0));
    let culler = Culler::exact().with_output(Output::Triangles).with_reasons(true);
    for culler in [culler.clone(), culler.with_detail(detail)] {
        for (what, change) in CHANGES {
            let (mut scene, all) = scene();
            let (mut state, mut visible) = (ViewState::default(), Visible::default());
            for frame in 0..8 {
                if frame == 4 {
                    change(&mut scene, &all);
                }
                culler.cull_one(&scene, &view(0.0), &mut state, &mut visible);
                let mut fresh = Visible::default();
                culler.cull_one(&scene, &view(0.0), &mut ViewState::default(), &mut fresh);
                assert_eq!(visible, fresh, "{what}, frame {frame}");
                assert_eq!(visible.version, scene.version(), "{what}, frame {frame}");
            }
        }
    }
}

#[test]
fn another_view_or_setting_is_no_frame_of_before() {
    let (scene, _) = scene();
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let presets = [Culler::exact(), Culler::balanced(), Culler::exact().with_reasons(true)];
    for (x, preset) in [(0.0, 0), (0.0, 0), (0.0, 0), (1.0, 0), (1.0, 1), (1.0, 1), (1.0, 2)] {
        let culler = &presets[preset];
        culler.cull_one(&scene, &view(x), &mut state, &mut visible);
        let mut fresh = Visible::default();
        culler.cull_one(&scene, &view(x), &mut ViewState::default(), &mut fresh);
        assert_eq!(visible, fresh, "{x}, {preset}");
    }
    // Among candidates, and back.
    let none = vec![0_u64; scene.slot_count().div_ceil(64) as usize];
    let culler = Culler::exact();
    for _ in 0..3 {
        culler.cull_among(&scene, &view(1.0), &none, &mut state, &mut visible).unwrap();
        assert_eq!(visible.instance_count, 0);
        for _ in 0..3 {
            culler.cull_one(&scene, &view(1.0), &mut state, &mut visible);
            assert!(visible.instance_count > 0);
        }
    }
}

/// A result belongs to the caller, who may change it: the next is whole again.
#[test]
fn a_result_that_was_changed_is_filled_anew() {
    let (scene, _) = scene();
    let culler = Culler::exact();
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let mut expected = None;
    for _ in 0..5 {
        culler.cull_one(&scene, &view(0.0), &mut state, &mut visible);
        assert_eq!(*expected.get_or_insert_with(|| visible.clone()), visible);
        visible.whole.clear();
        visible.instance_count = 7;
    }
}
