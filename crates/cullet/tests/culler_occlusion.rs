//! The culler's occlusion stage: what it drops and says, and that nothing but the scene and the view matters.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Occluder, Occlusion, Shape};
use cullet::mesh::Part;
use cullet::{
    Camera, Culler, Depth, Handle, Instance, InstanceFlags, Mesh, MeshData, Output, Projection,
    Reason, Scene, Stage, Transform, View, ViewState, Visible, funnel::Unit, prepared::Preparation,
    scene::BoundsOverride, view::CullFace,
};
use cullet_testkit::Rng;
use cullet_testkit::answers::{cull, listed, slots};

const HIDDEN: Option<Reason> = Some(Reason { stage: Stage::Occlusion, detail: 0 });

fn cube() -> MeshData {
    const FACES: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    MeshData {
        positions: Aabb::new([-1.0; 3], [1.0; 3]).corners().to_vec(),
        indices: FACES.iter().flat_map(|f| [0, 1, 2, 0, 2, 3].map(|k| f[k])).collect(),
        parts: vec![Part { triangle_count: 12, ..Part::default() }],
        ..MeshData::default()
    }
}

/// A sheet of n × n squares over −1..1 in x and y, seen from both sides.
fn sheet(n: u32) -> MeshData {
    let place = |i: u32| i as f32 * 2.0 / n as f32 - 1.0;
    let corner = |i: u32| [place(i % (n + 1)), place(i / (n + 1)), 0.0];
    let square = |i: u32| {
        let v = i / n * (n + 1) + i % n;
        [v, v + 1, v + n + 2, v, v + n + 2, v + n + 1]
    };
    MeshData {
        positions: (0..(n + 1) * (n + 1)).map(corner).collect(),
        indices: (0..n * n).flat_map(square).collect(),
        parts: vec![Part { triangle_count: n * n * 2, two_sided: true, ..Part::default() }],
        ..MeshData::default()
    }
}

fn view() -> View {
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.1, far: f64::INFINITY };
    let camera = Camera::look_at([0.3, 0.1, 10.0], [0.0, 0.0, 0.0], projection);
    View::new(&camera, Depth::Reversed, [960, 600]).unwrap()
}

fn culler() -> Culler {
    Culler::default().with_occlusion(Occlusion::default()).with_reasons(true)
}

/// A wall before three cubes, and a cube beside it.
struct Street {
    scene: Scene,
    wall: Handle,
    behind: [Handle; 3],
    beside: Handle,
}

fn at(scale: [f32; 3], place: [f64; 3]) -> Transform {
    Transform::from_scale_translation(scale, place)
}

fn street() -> Street {
    let mut scene = Scene::new();
    let cube = scene.add_mesh(Mesh::new(cube()).unwrap());
    let mut add = |scale, place| scene.add(Instance::new(cube, at(scale, place))).unwrap();
    let wall = add([3.0, 3.0, 0.2], [0.0, 0.0, 0.0]);
    let behind = [-1.0, 0.0, 1.0].map(|x| add([0.3; 3], [x, 0.5 * x, -4.0]));
    let beside = add([0.3; 3], [6.0, 0.0, -2.0]);
    scene.prepare(Preparation::ALL);
    Street { scene, wall, behind, beside }
}

impl Street {
    fn reason(&self, culler: &Culler, view: &View, handle: Handle) -> Option<Reason> {
        cull(culler, &self.scene, view).reasons[self.scene.slot(handle).unwrap() as usize]
    }

    /// How many of the three are hidden.
    fn hidden(&self) -> usize {
        let seen = |&&h: &&Handle| self.reason(&culler(), &view(), h) == HIDDEN;
        self.behind.iter().filter(seen).count()
    }
}

#[test]
fn what_is_behind_a_wall_goes_and_the_funnel_counts_it() {
    let s = street();
    for output in [Output::Instances, Output::Clusters, Output::Triangles] {
        let result = cull(&culler().with_output(output), &s.scene, &view());
        assert_eq!(slots(&result).len(), 2);
        let row = result.funnel.rows.iter().find(|r| r.stage == Stage::Occlusion).unwrap();
        assert_eq!((row.unit, row.entered.instances, row.left.instances), (Unit::Instances, 5, 2));
        let work = result.funnel.occlusion;
        assert!(work.drawn >= 1 && work.drawn <= work.chosen && work.chosen <= work.considered);
        assert!(work.considered <= 5 && work.tests >= 5, "{work:?}");
    }
    assert_eq!(s.hidden(), 3);
    assert_eq!(s.reason(&culler(), &view(), s.beside), None);
    assert_eq!(s.reason(&culler(), &view(), s.wall), None);
}

#[test]
fn an_explanation_names_the_wall() {
    let s = street();
    for handle in s.behind {
        let why = culler().explain(&s.scene, &view(), handle).unwrap();
        assert_eq!(why.reason, HIDDEN);
        assert_eq!(why.hidden_by, [s.scene.slot(s.wall).unwrap()]);
        let step = why.steps.iter().find(|step| step.stage == Stage::Occlusion).unwrap();
        assert!(step.to_string().ends_with("all covered by what is nearer"), "{step}");
    }
    let why = culler().explain(&s.scene, &view(), s.beside).unwrap();
    assert!(why.reason.is_none() && why.hidden_by.is_empty());
    let step = why.steps.iter().find(|step| step.stage == Stage::Occlusion).unwrap();
    assert!(step.to_string().contains("lets it through"), "{step}");
}

#[test]
fn only_what_is_solid_hides() {
    let mut s = street();
    let flags = |f: fn(&mut InstanceFlags)| {
        let mut flags = InstanceFlags::default();
        f(&mut flags);
        flags
    };
    for (flags, hidden) in [
        (flags(|f| f.no_occlusion = true), 0),
        (flags(|f| f.transparent = true), 0),
        (flags(|f| f.always_visible = true), 3),
        (flags(|f| f.dynamic = true), 3),
        (flags(|f| f.double_sided = true), 3),
        (InstanceFlags::default(), 3),
    ] {
        s.scene.set_flags(s.wall, flags).unwrap();
        assert_eq!(s.hidden(), hidden, "{flags:?}");
    }
    // Bounds of the caller's: a shader may move its vertices.
    for bounds in [
        BoundsOverride::None,
        BoundsOverride::Margin(0.0),
        BoundsOverride::World(Aabb::new([-3.0; 3], [3.0; 3])),
    ] {
        s.scene.set_bounds(s.wall, bounds).unwrap();
        assert_eq!(s.hidden(), 0, "{bounds:?}");
    }
    s.scene.set_bounds(s.wall, BoundsOverride::Mesh).unwrap();
    s.scene.set_layers(s.wall, 0).unwrap();
    assert_eq!(s.hidden(), 0, "in no layer of the view");
    s.scene.set_layers(s.wall, 1).unwrap();
    // A view that draws the backs of one-sided meshes alone sees in at their fronts.
    let mut backs = view();
    backs.cull_face = CullFace::Front;
    assert_eq!(s.reason(&culler(), &backs, s.behind[0]), None);
    assert_eq!(s.hidden(), 3);
}

#[test]
fn what_can_deform_hides_nothing() {
    let mut s = street();
    let data = MeshData { deformable: true, ..cube() };
    let mesh = s.scene.add_mesh(Mesh::new(data).unwrap());
    let wall = Instance::new(mesh, at([3.0, 3.0, 0.2], [0.0; 3]));
    s.scene.add(wall).unwrap();
    s.scene.remove(s.wall).unwrap();
    assert_eq!(s.hidden(), 0);
}

#[test]
fn what_is_always_visible_stays() {
    let mut s = street();
    let flags = InstanceFlags { always_visible: true, ..InstanceFlags::default() };
    s.scene.set_flags(s.behind[1], flags).unwrap();
    assert_eq!(s.reason(&culler(), &view(), s.behind[1]), None);
    assert_eq!(s.hidden(), 2);
}

#[test]
fn a_door_opens_and_shuts_in_the_same_frame() {
    let mut s = street();
    let (culler, view) = (culler(), view());
    let (mut state, mut result) = (ViewState::default(), Visible::default());
    let slot = s.scene.slot(s.behind[1]).unwrap() as usize;
    for step in 0..20 {
        let open = step % 3 == 1;
        let x = if open { 20.0 } else { 0.0 };
        s.scene.set_transform(s.wall, at([3.0, 3.0, 0.2], [x, 0.0, 0.0])).unwrap();
        let vanished = step % 4 == 2;
        let flags = InstanceFlags { no_occlusion: vanished, ..InstanceFlags::default() };
        s.scene.set_flags(s.wall, flags).unwrap();
        culler.cull_one(&s.scene, &view, &mut state, &mut result);
        let hidden = result.reasons[slot] == HIDDEN;
        assert_eq!(hidden, !open && !vanished, "step {step}");
    }
}

/// A city of random boxes, sorted or as it came.
fn city(rng: &mut Rng, count: usize) -> Scene {
    let mut scene = Scene::new();
    let cube = scene.add_mesh(Mesh::new(cube()).unwrap());
    let sheet = scene.add_mesh(Mesh::new(sheet(24)).unwrap());
    scene.prepare(Preparation::ALL);
    for i in 0..count {
        let place = [rng.range(-40.0, 40.0), rng.range(-1.0, 1.0), rng.range(-90.0, 12.0)];
        let scale = [rng.range(0.2, 2.0), rng.range(0.5, 5.0), rng.range(0.2, 2.0)];
        let mesh = if i % 9 == 0 { sheet } else { cube };
        scene.add(Instance::new(mesh, at(scale.map(|v| v as f32), place))).unwrap();
    }
    scene
}

#[test]
fn warm_and_cold_moved_and_sorted_agree() {
    let mut rng = Rng(31);
    let mut scene = city(&mut rng, 3000);
    let culler = culler().with_output(Output::Triangles);
    let (mut state, mut warm) = (ViewState::default(), Visible::default());
    let mut dropped = 0;
    for frame in 0..24 {
        let handles: Vec<Handle> = scene.slots().filter_map(|s| scene.handle(s)).collect();
        for _ in 0..frame * 3 {
            let handle = handles[rng.below(handles.len() as u64) as usize];
            let place = [rng.range(-40.0, 40.0), 0.0, rng.range(-90.0, 12.0)];
            scene.set_transform(handle, at([1.0, 2.0, 1.0], place)).unwrap();
        }
        if frame == 8 {
            scene.commit(&Culler::default());
        }
        let projection =
            Projection::Perspective { fov_y_radians: 1.1, aspect: 1.6, near: 0.1, far: 200.0 };
        let eye = [f64::from(frame) * 0.4 - 4.0, 0.5, 14.0 - f64::from(frame)];
        let camera = Camera::look_at(eye, [eye[0] * 0.5, 0.0, -40.0], projection);
        let view = View::new(&camera, Depth::Reversed, [640, 400]).unwrap();
        culler.cull_one(&scene, &view, &mut state, &mut warm);
        let cold = cull(&culler, &scene, &view);
        assert_eq!(warm, cold, "frame {frame}");
        // Nodes that fit anew: another way to the same answer.
        scene.refit();
        let fitted = cull(&culler, &scene, &view);
        assert_eq!(fitted, cold, "frame {frame}, refitted");
        dropped += cold.reasons.iter().filter(|&&r| r == HIDDEN).count();
        for slot in (0..scene.slot_count()).step_by(if frame == 3 { 97 } else { 1500 }) {
            let why = culler.explain(&scene, &view, scene.handle(slot).unwrap()).unwrap();
            assert_eq!(why.reason, cold.reasons[slot as usize], "slot {slot} of frame {frame}");
        }
    }
    // The floor: at this seed some 19 000 go.
    assert!(dropped > 10_000, "{dropped} hidden");
}

/// A view down the city of [`city`], from where nothing of it crosses the near plane: of such instances ties go by
/// slot, which sorting changes.
fn street_view() -> View {
    let projection =
        Projection::Perspective { fov_y_radians: 1.1, aspect: 1.6, near: 0.1, far: 200.0 };
    let camera = Camera::look_at([-2.0, 0.5, 20.0], [0.0, 0.0, -40.0], projection);
    View::new(&camera, Depth::Reversed, [640, 400]).unwrap()
}

#[test]
fn by_nodes_or_one_by_one_the_same_occluders_are_chosen() {
    for count in [6000, 60_000] {
        are_chosen_by_nodes_as_one_by_one(city(&mut Rng(5), count));
    }
}

fn are_chosen_by_nodes_as_one_by_one(mut scene: Scene) {
    let drawn = |scene: &Scene, budget| {
        let occlusion = Some(Occlusion::default().with_budget(budget));
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        let culler = culler().with_occlusion(occlusion);
        culler.cull_one(scene, &street_view(), &mut state, &mut result);
        let drawn = state.occluders_drawn().iter();
        let drawn: Vec<_> = drawn.map(|&(slot, shape)| (scene.handle(slot), shape)).collect();
        (drawn, result.funnel.occlusion.considered)
    };
    let budgets = [1.0, 30.0, 300.0, 3000.0, f32::INFINITY];
    // Not sorted yet, so that no node is over anything.
    let flat = budgets.map(|budget| drawn(&scene, budget));
    scene.commit(&Culler::default());
    let mut looked_at = Vec::new();
    for (budget, (flat, _)) in budgets.into_iter().zip(flat) {
        let (nodes, considered) = drawn(&scene, budget);
        assert_eq!(nodes, flat, "for {budget} microseconds");
        looked_at.push(considered);
    }
    // The floor: a small budget looks at a small part.
    assert!(looked_at[1] * 4 < looked_at[4], "{looked_at:?}");
}

#[test]
fn what_nodes_answer_for_is_what_each_box_would_be_told() {
    for count in [9000, 60_000] {
        are_told_the_same_by_nodes(city(&mut Rng(9), count));
    }
}

fn are_told_the_same_by_nodes(mut scene: Scene) {
    for sorted in [false, true] {
        if sorted {
            scene.commit(&Culler::default());
        }
        for budget in [0.0, 60.0, 2000.0] {
            let occlusion = Some(Occlusion::default().with_budget(budget));
            let culler = culler().with_occlusion(occlusion).with_output(Output::Instances);
            let (mut state, mut result) = (ViewState::default(), Visible::default());
            culler.cull_one(&scene, &street_view(), &mut state, &mut result);
            let buffer = state.occlusion_buffer().unwrap();
            // Each by itself: no nodes here.
            let words = (scene.slot_count() as usize).div_ceil(64);
            let mut tested = vec![0; words];
            let is_tested = |r: Option<Reason>| r.is_none_or(|r| r.stage == Stage::Occlusion);
            for (slot, &reason) in result.reasons.iter().enumerate() {
                tested[slot / 64] |= u64::from(is_tested(reason)) << (slot % 64);
            }
            let (mut visible, mut hidden) = (vec![0; words], vec![0; words]);
            let boxes = scene.boxes();
            buffer.test_boxes(culler.simd, boxes, 0, &tested, &mut visible, &mut hidden);
            let mut count = 0;
            for (slot, &reason) in result.reasons.iter().enumerate() {
                if is_tested(reason) {
                    let is_visible = visible[slot / 64] >> (slot % 64) & 1 == 1;
                    assert_eq!(reason.is_none(), is_visible, "slot {slot} at {budget}");
                    count += 1;
                }
            }
            assert!(count > 3000, "{count} in the view");
            let tests = result.funnel.occlusion.tests;
            assert!(!sorted || budget > 0.0 || tests * 3 < count, "{tests} tests of {count}");
        }
    }
}

#[test]
fn what_is_drawn_whole_is_counted_as_if_cluster_by_cluster() {
    let mut scene = city(&mut Rng(77), 3000);
    scene.commit(&Culler::default());
    for occlusion in [None, Some(Occlusion::default())] {
        for cull_face in [CullFace::None, CullFace::Back] {
            let mut view = street_view();
            view.cull_face = cull_face;
            let clusters = cull(&culler().with_occlusion(occlusion), &scene, &view);
            // Where triangles are wanted every instance goes on as its clusters.
            let by_triangle = culler().with_occlusion(occlusion).with_output(Output::Triangles);
            let triangles = cull(&by_triangle, &scene, &view);
            let rows = |v: &Visible| {
                let rows = v.funnel.rows.iter().filter(|r| r.unit == Unit::Clusters);
                rows.copied().collect::<Vec<_>>()
            };
            assert_eq!(rows(&clusters), rows(&triangles));
            let left = rows(&clusters).last().unwrap().left.clusters;
            let whole = clusters.whole.iter().flat_map(|r| r.first..r.first + r.count);
            let of_whole = whole.map(|s| u64::from(scene.mesh(s).cluster_count()));
            let of_partial = clusters.partial.iter().map(|d| u64::from(d.cluster_count));
            assert_eq!(of_whole.sum::<u64>() + of_partial.sum::<u64>(), left);
            let slots: Vec<u32> = clusters.slots().collect();
            assert!(slots.is_sorted() && slots.len() as u64 == clusters.instance_count);
            assert!(triangles.slots().all(|s| slots.binary_search(&s).is_ok()));
            assert!(clusters.triangle_count >= triangles.triangle_count);
        }
    }
}

/// Whether the view shows the place of a point.
fn is_in_view(p: [f64; 3]) -> bool {
    let m = view().clip_from_world();
    let [x, y, w] = [0, 1, 3].map(|r| m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);
    w > 0.0 && x.abs() <= w && y.abs() <= w
}

#[test]
fn hidden_clusters_go_and_others_stay() {
    let mut s = street();
    let sheet = s.scene.add_mesh(Mesh::new(sheet(64)).unwrap());
    // Far wider than the wall, and behind it.
    let wide = s.scene.add(Instance::new(sheet, at([8.0, 4.0, 1.0], [0.0, 0.0, -3.0]))).unwrap();
    let slot = s.scene.slot(wide).unwrap();
    let result = cull(&culler().with_output(Output::Triangles), &s.scene, &view());
    let row = |unit| {
        let is_row = |r: &&cullet::funnel::FunnelRow| (r.stage, r.unit) == (Stage::Occlusion, unit);
        *result.funnel.rows.iter().find(is_row).unwrap()
    };
    let clusters = row(Unit::Clusters);
    assert!(clusters.dropped().clusters > 10, "{clusters:?}");
    // The wall as a box; what is dropped must lie behind it, corner by corner.
    let listed = listed(&result);
    let mesh = s.scene.mesh(slot);
    let eye = [0.3, 0.1, 10.0];
    let (mut kept, mut dropped) = (0, 0);
    for t in 0..mesh.triangle_count() {
        if listed.contains(&(slot, t)) {
            kept += 1;
            continue;
        }
        let corners = mesh.corners(t).map(|c| [f64::from(c[0]) * 8.0, f64::from(c[1]) * 4.0, -3.0]);
        let is_behind = |p: [f64; 3]| {
            // Where the line of sight meets the front of the wall.
            let along = (eye[2] - 0.2) / (eye[2] - p[2]);
            (0..2).all(|a| (eye[a] + (p[a] - eye[a]) * along).abs() <= 3.0)
        };
        if corners.iter().any(|&c| is_in_view(c)) {
            dropped += 1;
            assert!(corners.iter().all(|&c| is_behind(c)), "triangle {t} is seen");
        }
    }
    assert!(kept > 500 && dropped > 1000, "{kept} kept, {dropped} dropped");
    let why = culler().explain(&s.scene, &view(), wide).unwrap();
    assert!(why.steps.iter().any(|s| s.stage == Stage::Occlusion && s.unit == Unit::Clusters));
}

#[test]
fn the_budget_buys_the_largest() {
    let s = street();
    let with = |budget| {
        let occlusion = Some(Occlusion::default().with_budget(budget));
        cull(&culler().with_occlusion(occlusion), &s.scene, &view())
    };
    assert_eq!(with(0.0).instance_count, 5);
    assert_eq!(with(f32::NAN).instance_count, 5);
    // One box, and the wall is the largest.
    let one = with(20.0);
    assert_eq!((one.instance_count, with(f32::INFINITY).instance_count), (2, 2));
}

#[test]
fn an_occluder_of_the_callers_is_used() {
    let mut s = street();
    let bare = s.scene.add_mesh(Mesh::new(cube()).unwrap());
    s.scene.set_occluder(bare, Occluder::new(Vec::new()));
    s.scene.add(Instance::new(bare, at([3.0, 3.0, 0.2], [0.0; 3]))).unwrap();
    s.scene.remove(s.wall).unwrap();
    assert_eq!(s.hidden(), 0);
    let half = Aabb::new([-1.0, -1.0, -1.0], [0.0, 1.0, 1.0]);
    let mesh = s.scene.add_mesh(Mesh::new(cube()).unwrap());
    let shape = cullet::cull::occlusion::Convex::from_box(&half).unwrap();
    s.scene.set_occluder(mesh, Occluder::new(vec![Shape::Convex(shape)]));
    s.scene.add(Instance::new(mesh, at([3.0, 3.0, 0.2], [0.0; 3]))).unwrap();
    assert_eq!(s.hidden(), 1);
}
