//! Region queries: an oracle of single rays, degenerate boxes of eyes, and what is said of the rest.

use cullet::bounds::Aabb;
use cullet::{
    Instance, InstanceFlags, Mesh, MeshData, Reason, Scene, Stage, Transform, View,
    scene::BoundsOverride, view::CullFace,
};
use cullet_cells::query::{EyeBox, RegionCuller, RegionError, RegionState, RegionVisible};
use cullet_testkit::meshes::{block, of_parts};
use cullet_testkit::scenes::random_transform;
use cullet_testkit::views::look;
use cullet_testkit::{Rng, at_every_level, cases};
use glam::{DMat3, DVec3};

fn culler() -> RegionCuller {
    RegionCuller { reasons: true, near_world: 0.01, ..RegionCuller::default() }
}

fn query(culler: &RegionCuller, scene: &Scene, eyes: &EyeBox) -> RegionVisible {
    let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
    culler.cull(scene, eyes, &mut state, &mut visible).expect("settings in range");
    visible
}

/// Boxes and walls of any size around the origin, some turned, sheared and mirrored.
fn random_boxes(rng: &mut Rng, count: usize) -> Scene {
    let mut scene = Scene::new();
    let cube = scene.add_mesh(block([-1.0; 3], [1.0; 3]));
    for _ in 0..count {
        let mut at = random_transform(rng);
        let size = rng.range(0.1, 1.5).exp2() as f32;
        at.linear.iter_mut().flatten().for_each(|v| *v *= size);
        at.translation = rng.vector(14.0);
        if rng.chance(0.6) {
            let walls = [rng.range(0.2, 6.0), rng.range(0.2, 6.0), rng.range(0.2, 6.0)];
            at = Transform::from_scale_translation(walls.map(|v| v as f32), at.translation);
        }
        scene.add(Instance::new(cube, at)).expect("few");
    }
    scene.commit(&cullet::Culler::default());
    scene
}

/// The part of the segment between two points that is in the cube −1..1 of an instance; by f64, a plane at a time.
fn part_within(at: &Transform, from: DVec3, to: DVec3) -> Option<[f64; 2]> {
    let columns = at.linear.map(|c| DVec3::from(c.map(f64::from)));
    let linear = DMat3::from_cols(columns[0], columns[1], columns[2]);
    // Flat ones are skipped: the sight through them is not asked.
    if linear.determinant() == 0.0 {
        return None;
    }
    let inverse = linear.inverse();
    let local = |p: DVec3| inverse * (p - DVec3::from(at.translation));
    let (from, to) = (local(from), local(to));
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for a in 0..3 {
        for sign in [1.0, -1.0] {
            // Where sign · x ≤ 1 along the segment.
            let (start, end) = (sign * from[a] - 1.0, sign * to[a] - 1.0);
            match (start > 0.0, end > 0.0) {
                (true, true) => return None,
                (true, false) => first = first.max(start / (start - end)),
                (false, true) => last = last.min(start / (start - end)),
                (false, false) => {}
            }
        }
    }
    (first < last).then_some([first, last])
}

/// Whether a point of an instance is seen from an eye: no other instance lies between, by more than rounding. One that
/// the eye is in hides nothing.
fn is_seen(scene: &Scene, eye: DVec3, point: DVec3, of: u32) -> bool {
    scene.slots().filter(|&s| s != of).all(|slot| {
        part_within(scene.transform(slot), eye, point)
            .is_none_or(|[first, last]| first <= 1e-9 || last - first < 1e-9)
    })
}

#[test]
fn what_a_ray_from_an_eye_in_the_box_reaches_is_kept() {
    let mut rng = Rng(77);
    let mut dropped = 0;
    for case in 0..cases(60) {
        let scene = random_boxes(&mut rng, 60);
        let middle = rng.vector(10.0);
        let size = match case % 3 {
            0 => [0.0; 3],
            1 => [rng.range(0.0, 3.0), 0.0, rng.range(0.0, 3.0)],
            _ => [rng.range(0.0, 2.0), rng.range(0.0, 2.0), rng.range(0.0, 2.0)],
        };
        let eyes = EyeBox::new(
            std::array::from_fn(|a| middle[a] - size[a]),
            std::array::from_fn(|a| middle[a] + size[a]),
        );
        let culler = RegionCuller {
            cell_world: rng.range(0.2, 2.0),
            most_cells: 1 + rng.below(12) as u32,
            width: 64,
            ..culler()
        };
        let visible = query(&culler, &scene, &eyes);
        dropped += scene.instance_count() as usize - visible.slots().count();
        for slot in scene.slots().filter(|&s| !visible.has(s)) {
            for _ in 0..200 {
                let eye = DVec3::from(std::array::from_fn::<_, 3, _>(|a| {
                    eyes.min[a] + (eyes.max[a] - eyes.min[a]) * rng.unit()
                }));
                let on = [rng.signed(), rng.signed(), rng.signed()];
                let at = scene.transform(slot);
                let point = (0..3).fold(DVec3::from(at.translation), |p, a| {
                    p + DVec3::from(at.linear[a].map(f64::from)) * on[a]
                });
                assert!(
                    !is_seen(&scene, eye, point, slot),
                    "{slot} from {eye} of {eyes:?} {culler:?}"
                );
            }
        }
    }
    assert!(dropped > cases(60) as usize * 10, "{dropped}");
}

/// A wall of 20 by 10, two thick, with a crate behind it and one beside it.
fn wall() -> (Scene, [u32; 3]) {
    let mut scene = Scene::new();
    let cube = scene.add_mesh(block([-1.0; 3], [1.0; 3]));
    let mut add = |size: [f32; 3], at: [f64; 3]| {
        scene.add(Instance::new(cube, Transform::from_scale_translation(size, at))).expect("few")
    };
    let handles = [
        add([10.0, 5.0, 1.0], [0.0, 0.0, -10.0]),
        add([1.0; 3], [0.0, 0.0, -16.0]),
        add([1.0; 3], [30.0, 0.0, -16.0]),
    ];
    scene.commit(&cullet::Culler::default());
    let slots = handles.map(|h| scene.slot(h).expect("added"));
    (scene, slots)
}

const HIDDEN: Option<Reason> = Some(Reason { stage: Stage::Occlusion, detail: 0 });

#[test]
fn a_wall_hides_a_crate_from_all_of_a_box_and_not_from_a_larger_one() {
    let (scene, [wall, behind, beside]) = wall();
    let around = |x: f64| EyeBox::new([-x, -0.5, -0.5], [x, 0.5, 0.5]);
    let near = query(&culler(), &scene, &around(5.0));
    assert!(near.has(wall) && !near.has(behind) && near.has(beside));
    assert_eq!(near.reasons[behind as usize], HIDDEN);
    assert_eq!(near.reasons[wall as usize], None);
    assert_eq!(near.handles(&scene).count(), 2);
    // From its ends one sees round it.
    assert!(query(&culler(), &scene, &around(25.0)).has(behind));
    // One cell for all: the wall is no thicker than it.
    let cells = |most_cells| RegionCuller { most_cells, cell_world: 1.0, ..culler() };
    let (coarse, fine) = (cells(1), cells(64));
    let deep = EyeBox::new([-1.0, -0.5, -2.0], [1.0, 0.5, 2.0]);
    assert!(query(&coarse, &scene, &deep).has(behind) && !query(&fine, &scene, &deep).has(behind));
}

#[test]
fn answers_are_the_same_at_every_level_and_with_used_memory() {
    let mut rng = Rng(4);
    let scenes: Vec<Scene> = (0..3).map(|i| random_boxes(&mut rng, 40 + i * 300)).collect();
    let eyes = EyeBox::new([-1.0, -1.0, -1.0], [1.0, 1.0, 1.5]);
    let fresh: Vec<RegionVisible> = scenes.iter().map(|s| query(&culler(), s, &eyes)).collect();
    at_every_level!(|level| {
        let culler = RegionCuller { simd: level, ..culler() };
        let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
        for (scene, fresh) in scenes.iter().zip(&fresh).chain(scenes.iter().zip(&fresh).rev()) {
            culler.cull(scene, &eyes, &mut state, &mut visible).unwrap();
            assert_eq!(&visible, fresh);
        }
    });
}

#[test]
fn degenerate_boxes_of_eyes_have_stated_answers() {
    let (scene, [_, behind, _]) = wall();
    let count = |eyes: EyeBox| query(&culler(), &scene, &eyes).slots().count();
    let point = EyeBox::new([0.0; 3], [0.0; 3]);
    assert!(!query(&culler(), &scene, &point).has(behind));
    let plane = EyeBox::new([-2.0, -1.0, 0.0], [2.0, 1.0, 0.0]);
    assert!(!query(&culler(), &scene, &plane).has(behind));
    let empty = query(&culler(), &scene, &EyeBox::new([1.0; 3], [0.0; 3]));
    assert_eq!((empty.slots().count(), empty.work.cells), (0, 0));
    let unseen = Some(Reason { stage: Stage::Frustum, detail: Reason::MIXED });
    assert!(empty.reasons.iter().all(|r| *r == unseen), "{:?}", empty.reasons);
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        assert_eq!(count(EyeBox::new([0.0, -bad, 0.0], [1.0, bad, 1.0])), 3, "{bad}");
        assert_eq!(count(EyeBox::around(&[[0.0, bad, 0.0]], 1.0)), 3, "{bad}");
    }
    assert_eq!(count(EyeBox::around(&[], 1.0)), 0);
    // So large that the wall is nothing to its cells.
    assert_eq!(count(EyeBox::new([-1e6; 3], [1e6; 3])), 3);
    assert_eq!(count(EyeBox::new([1e17; 3], [1e17; 3])), 3);
    assert!(query(&culler(), &Scene::new(), &point).words.is_empty());
}

#[test]
fn a_box_of_eyes_contains_its_surface() {
    let eyes = EyeBox::new([-1.0, 0.0, 2.0], [1.0, 0.0, 3.0]);
    assert!(eyes.contains([-1.0, 0.0, 2.0]) && eyes.contains([1.0, 0.0, 3.0]));
    assert!(eyes.contains([0.0, 0.0, 2.5]) && !eyes.contains([0.0, 0.1, 2.5]));
    assert!(!eyes.contains([-1.1, 0.0, 2.5]) && !eyes.contains([0.0, 0.0, f64::NAN]));
}

#[test]
fn settings_out_of_range_are_named() {
    let (scene, _) = wall();
    let eyes = EyeBox::new([0.0; 3], [1.0; 3]);
    let error = |culler: RegionCuller| {
        let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
        let error = culler.cull(&scene, &eyes, &mut state, &mut visible).unwrap_err();
        error.to_string()
    };
    let told = |text: String, what: &str| assert!(text.starts_with(what), "{text}");
    told(
        error(RegionCuller { cell_world: 0.0, ..culler() }),
        "cell_world is 0; it must be above 0",
    );
    told(error(RegionCuller { cell_world: f64::NAN, ..culler() }), "cell_world is NaN");
    told(error(RegionCuller { most_cells: 0, ..culler() }), "most_cells is 0");
    told(
        error(RegionCuller { width: 5000, ..culler() }),
        "width is 5000; it must be from 8 to 4096",
    );
    told(error(RegionCuller { near_world: -1.0, ..culler() }), "near_world is -1");
    let flat = View::orthographic([0.0; 3], [0.0, 0.0, -1.0], 10.0, 0.0, 50.0, [64, 64]).unwrap();
    let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
    let error = culler().cull_view(&scene, &eyes, &flat, &mut state, &mut visible);
    assert_eq!(error, Err(RegionError::Orthographic));
}

#[test]
fn what_may_not_be_dropped_is_kept_and_what_may_not_hide_does_not() {
    let behind = |edit: &dyn Fn(&mut Instance), of_wall: bool| {
        let mut scene = Scene::new();
        let cube = scene.add_mesh(block([-1.0; 3], [1.0; 3]));
        let wall = Transform::from_scale_translation([10.0, 5.0, 1.0], [0.0, 0.0, -10.0]);
        let mut wall = Instance::new(cube, wall);
        let mut target = Instance::new(cube, Transform::from_translation([0.0, 0.0, -16.0]));
        edit(if of_wall { &mut wall } else { &mut target });
        scene.add(wall).unwrap();
        let target = scene.add(target).unwrap();
        scene.commit(&cullet::Culler::default());
        let visible = query(&culler(), &scene, &EyeBox::new([-0.5; 3], [0.5; 3]));
        visible.has(scene.slot(target).unwrap())
    };
    assert!(!behind(&|_| {}, false));
    let flags = |flags: InstanceFlags| move |i: &mut Instance| i.flags = flags;
    let none = InstanceFlags::default();
    assert!(behind(&flags(InstanceFlags { always_visible: true, ..none }), false));
    assert!(behind(&|i| i.bounds = BoundsOverride::None, false));
    assert!(!behind(&|i| i.layers = 0, false), "in no layer");
    assert!(behind(&flags(InstanceFlags { no_occlusion: true, ..none }), true));
    assert!(behind(&flags(InstanceFlags { transparent: true, ..none }), true));
    assert!(behind(&|i| i.layers = 0, true), "a wall that is not drawn");
    assert!(behind(&|i| i.bounds = BoundsOverride::Margin(0.5), true), "a wall that sways");
    // A mesh that bends may be anywhere, among others that do not.
    let mut scene = wall().0;
    let data = MeshData { deformable: true, ..block([-1.0; 3], [1.0; 3]).to_data() };
    let bends = scene.add_mesh(Mesh::new(data).expect("a good mesh"));
    let at = Transform::from_translation([3.0, 0.0, -16.0]);
    let bends = scene.add(Instance::new(bends, at)).unwrap();
    scene.commit(&cullet::Culler::default());
    let visible = query(&culler(), &scene, &EyeBox::new([-0.5; 3], [0.5; 3]));
    assert!(visible.has(scene.slot(bends).unwrap()));
    // The eyes are in it, or a near plane could cut it open.
    assert!(behind(&|i| i.transform.translation = [0.0; 3], true));
    let near = |i: &mut Instance| i.transform.translation[2] = -1.505;
    assert!(behind(&near, true));
    assert!(!behind(&|i| i.transform.translation[2] = -1.52, true));
}

#[test]
fn sheets_hide_nothing() {
    let mut scene = Scene::new();
    let corners = vec![[-9.0, -9.0, -5.0], [9.0, -9.0, -5.0], [9.0, 9.0, -5.0], [-9.0, 9.0, -5.0]];
    let sheet = scene.add_mesh(of_parts((corners, vec![0, 1, 2, 0, 2, 3]), Vec::new()));
    let cube = scene.add_mesh(block([-1.0; 3], [1.0; 3]));
    scene.add(Instance::new(sheet, Transform::IDENTITY)).unwrap();
    scene.add(Instance::new(cube, Transform::from_translation([0.0, 0.0, -9.0]))).unwrap();
    scene.commit(&cullet::Culler::default());
    let visible = query(&culler(), &scene, &EyeBox::new([-0.1; 3], [0.1; 3]));
    assert_eq!(visible.slots().count(), 2);
}

#[test]
fn eyes_that_look_as_a_view_does_see_what_is_in_any_of_their_frusta() {
    let mut rng = Rng(21);
    let mut taken = [0_u64; 2];
    for _ in 0..cases(40) {
        let scene = random_boxes(&mut rng, 80);
        let eyes = EyeBox::around(&[rng.vector(8.0)], rng.range(0.0, 2.0));
        let eye = |rng: &mut Rng| -> [f64; 3] {
            std::array::from_fn(|a| rng.range(eyes.min[a], eyes.max[a]))
        };
        let direction = rng.direction();
        let at = |eye: [f64; 3]| {
            let target = std::array::from_fn(|a| eye[a] + direction[a]);
            look(eye, target, [64, 48])
        };
        let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
        // From anywhere: only how it looks matters.
        let view = at(rng.vector(50.0));
        let culler = RegionCuller { near_world: 1.0, most_cells: 1, ..culler() };
        culler.cull_view(&scene, &eyes, &view, &mut state, &mut visible).unwrap();
        let all = query(&culler, &scene, &eyes);
        assert_eq!(visible.funnel.rows.len(), 3);
        for row in 0..2 {
            taken[row] += visible.funnel.rows[row + 1].dropped().instances;
        }
        for _ in 0..20 {
            let frustum = at(eye(&mut rng)).frustum();
            for slot in scene.slots() {
                let b: Aabb = scene.bounds(slot);
                let outside = frustum.planes().any(|(_, p)| b.span(p)[0] > 0.0);
                // Nothing but its frusta takes what the box sees in other directions.
                if !outside && all.has(slot) {
                    assert!(visible.has(slot), "{slot}: {:?}", visible.reasons[slot as usize]);
                }
            }
        }
    }
    let few = u64::from(cases(40)) / 4;
    assert!(taken[0] > 48 * few && taken[1] > few, "{taken:?}");
}

#[test]
fn fronts_that_a_view_does_not_draw_hide_nothing() {
    let (scene, [_, behind, _]) = wall();
    let eyes = EyeBox::new([-0.5; 3], [0.5; 3]);
    let mut view = look([0.0; 3], [0.0, 0.0, -1.0], [64, 64]);
    let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
    let mut sees = |view: &View| {
        culler().cull_view(&scene, &eyes, view, &mut state, &mut visible).unwrap();
        visible.has(behind)
    };
    assert!(!sees(&view));
    view.cull_face = CullFace::Front;
    assert!(sees(&view));
}

#[test]
fn the_funnel_and_the_reasons_say_the_same() {
    let mut rng = Rng(8);
    let mut scene = random_boxes(&mut rng, 200);
    let handles: Vec<_> = scene.slots().filter_map(|s| scene.handle(s)).collect();
    for handle in handles.iter().step_by(7) {
        scene.set_layers(*handle, 2).unwrap();
    }
    scene.remove(handles[3]).unwrap();
    let culler = RegionCuller { layers: 1, ..culler() };
    let visible = query(&culler, &scene, &EyeBox::new([-1.0; 3], [1.0; 3]));
    for stage in [Stage::Layer, Stage::Occlusion] {
        let told = visible.reasons.iter().flatten().filter(|r| r.stage == stage).count() as u64;
        assert_eq!(visible.funnel.dropped(stage).instances, told);
        assert!(told > 0, "{stage:?}");
    }
    for slot in scene.slots() {
        let of_layer = visible.reasons[slot as usize].is_some_and(|r| r.stage == Stage::Layer);
        assert_eq!(of_layer, scene.layers(slot) & culler.layers == 0, "slot {slot}");
    }
    assert_eq!(visible.funnel.left().instances, visible.slots().count() as u64);
    assert_eq!(visible.funnel.entered().instances, u64::from(scene.instance_count()));
}

#[test]
fn of_thousands_each_is_kept_before_a_wall_and_none_behind_it() {
    let mut scene = Scene::new();
    let cube = scene.add_mesh(block([-1.0; 3], [1.0; 3]));
    let mut add = |size: [f32; 3], at: [f64; 3]| {
        scene.add(Instance::new(cube, Transform::from_scale_translation(size, at))).expect("few")
    };
    add([200.0, 200.0, 2.0], [0.0, 0.0, -60.0]);
    // No crate hides another: they lie in one plane, apart.
    let mut sheet = |z: f64| -> Vec<_> {
        let at = (0..1600).map(|i| [f64::from(i % 40 - 20) * 2.0, f64::from(i / 40 - 20) * 2.0, z]);
        at.map(|at| add([0.2; 3], at)).collect()
    };
    let (before, behind) = (sheet(-50.0), sheet(-70.0));
    scene.commit(&cullet::Culler::default());
    let visible = query(&culler(), &scene, &EyeBox::new([-0.5; 3], [0.5; 3]));
    let has = |&handle: &_| visible.has(scene.slot(handle).expect("added"));
    assert_eq!(before.iter().filter(|h| has(h)).count(), 1600);
    assert_eq!(behind.iter().filter(|h| has(h)).count(), 0);
}

#[test]
fn what_was_added_since_the_commit_is_found_too() {
    let (mut scene, [_, behind, _]) = wall();
    let cube = scene.mesh_id(behind);
    for x in 0..40 {
        let at = Transform::from_translation([f64::from(x) * 3.0, 20.0, 0.0]);
        scene.add(Instance::new(cube, at)).unwrap();
    }
    let visible = query(&culler(), &scene, &EyeBox::new([-0.5; 3], [0.5; 3]));
    assert_eq!(visible.slots().count(), 42);
}

#[test]
fn worlds_far_from_zero_answer_as_those_near_it() {
    let (near, [_, behind, _]) = wall();
    let far = [3e7, -1e7, 5e6];
    let mut scene = Scene::new();
    scene.rebase(far);
    let cube = scene.add_mesh(block([-1.0; 3], [1.0; 3]));
    for slot in 0..3 {
        let mut at = *near.transform(slot);
        (0..3).for_each(|a| at.translation[a] += far[a]);
        scene.add(Instance::new(cube, at)).unwrap();
    }
    scene.commit(&cullet::Culler::default());
    let eyes = EyeBox::new(far.map(|v| v - 0.5), far.map(|v| v + 0.5));
    assert_eq!(query(&culler(), &scene, &eyes).slots().count(), 2);
    assert!(near.bounds(behind).is_finite());
}
