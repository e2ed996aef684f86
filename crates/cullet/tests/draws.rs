//! Draws hold what the answer holds, each triangle once, in the order of their states.

use std::collections::BTreeMap;

use cullet::cull::shadow::Light;
use cullet::mesh::{Alpha, Part};
use cullet::{
    Culler, DrawList, Instance, InstanceFlags, Mesh, MeshData, Output, Scene, SceneError,
    ShadowView, Transform, ViewState, Visible,
    draw::{DrawCommand, DrawKey, DrawState, InstanceNumbers, MeshPlace},
    prepared::Preparation,
};
use cullet_testkit::scenes::random_scene;
use cullet_testkit::views::{looking_down_z, random_culler, random_view};
use cullet_testkit::{Rng, meshes};

/// Triangles by slot and original number, and how often each is drawn.
type Drawn = BTreeMap<(u32, [u32; 3]), u32>;

/// A ball in four parts of all classes, among others.
fn scene(rng: &mut Rng) -> Scene {
    let mut scene = random_scene(rng, 40);
    let ball = meshes::ball(24).to_data();
    let quarter = ball.indices.len() as u32 / 12;
    let part = |n: u32, alpha, two_sided, material| Part {
        first_triangle: n * quarter,
        triangle_count: quarter,
        material,
        two_sided,
        alpha,
    };
    let parts = vec![
        part(0, Alpha::Blended, true, 7),
        part(1, Alpha::Opaque, false, 9),
        part(2, Alpha::Masked, true, 1),
        part(3, Alpha::Opaque, true, 3),
    ];
    let indices = ball.indices[..quarter as usize * 12].to_vec();
    let mesh = Mesh::new(MeshData { parts, indices, ..ball }).expect("a good mesh");
    let ball = scene.add_mesh(mesh);
    for i in 0..12 {
        let mut place =
            Transform::from_scale_translation([rng.range(0.5, 6.0) as f32; 3], rng.vector(9.0));
        if i % 3 == 0 {
            place.linear[1] = place.linear[1].map(|v| -v);
        }
        let flags = InstanceFlags { transparent: i % 4 == 0, ..InstanceFlags::default() };
        scene.add(Instance { flags, ..Instance::new(ball, place) }).expect("the mesh exists");
    }
    scene.prepare(Preparation::ALL);
    scene
}

/// Triangles of clusters: those of no cluster are degenerate, and never drawn.
fn of_clusters(scene: &Scene, visible: &Visible) -> Drawn {
    let mut drawn = Drawn::new();
    let mut add = |slot: u32, clusters: std::ops::Range<usize>| {
        let mesh = scene.mesh(slot);
        for t in mesh.clusters()[clusters].iter().flat_map(cullet::mesh::Cluster::triangles) {
            *drawn.entry((slot, mesh.triangle(t))).or_default() += 1;
        }
    };
    for slot in visible.whole.iter().flat_map(|r| r.first..r.first + r.count) {
        add(slot, 0..scene.mesh(slot).clusters().len());
    }
    for d in &visible.partial {
        add(d.slot, d.first_cluster as usize..(d.first_cluster + d.cluster_count) as usize);
    }
    drawn
}

fn of_triangles(scene: &Scene, visible: &Visible) -> Drawn {
    let mut drawn = Drawn::new();
    for r in &visible.triangle_ranges {
        let mesh = scene.mesh(r.slot);
        let clustered = mesh.triangle_count() - mesh.degenerate_count();
        for &t in &visible.triangles[r.first as usize..(r.first + r.count) as usize] {
            if t < clustered {
                *drawn.entry((r.slot, mesh.triangle(t))).or_default() += 1;
            }
        }
    }
    drawn
}

/// Triangles that a renderer would draw, with one buffer of all indices.
fn rendered(scene: &Scene, list: &DrawList, all: &[u32], places: &[MeshPlace]) -> Drawn {
    assert_eq!(list.commands.len(), list.keys.len());
    let mut drawn = Drawn::new();
    for (command, key) in list.commands.iter().zip(&list.keys) {
        let DrawCommand { index_count, instance_count, first_index, first_instance, .. } = *command;
        assert!(index_count > 0 && instance_count > 0);
        assert_eq!(command.base_vertex, places[key.mesh as usize].base_vertex);
        let indices = &all[first_index as usize..(first_index + index_count) as usize];
        let instances = first_instance as usize..(first_instance + instance_count) as usize;
        for &slot in &list.instances[instances] {
            check_key(scene, slot, key);
            for t in indices.as_chunks::<3>().0 {
                *drawn.entry((slot, *t)).or_default() += 1;
            }
        }
    }
    drawn
}

fn check_key(scene: &Scene, slot: u32, key: &DrawKey) {
    let part = scene.mesh(slot).parts()[key.part as usize];
    let flags = scene.flags(slot);
    assert_eq!((key.mesh, key.material), (scene.mesh_id(slot), part.material));
    assert_eq!(key.state.has(DrawState::TWO_SIDED), part.two_sided || flags.double_sided);
    assert_eq!(key.state.has(DrawState::MIRRORED), scene.transform(slot).is_mirrored());
    assert_eq!(key.state.has(DrawState::MASKED), part.alpha == Alpha::Masked);
    let blended = part.alpha == Alpha::Blended || flags.transparent;
    assert_eq!(key.state.has(DrawState::BLENDED), blended);
}

fn is_sorted(keys: impl Iterator<Item = (DrawState, u32, u32)>) -> bool {
    keys.is_sorted()
}

#[test]
fn draws_hold_each_visible_triangle_once_in_the_order_of_states() {
    let mut rng = Rng(77);
    let mut list = DrawList::default();
    let (mut partial, mut instanced) = (0, 0);
    for round in 0..60 {
        let mut scene = scene(&mut rng);
        if round % 2 == 0 {
            scene.commit(&Culler::default());
        }
        // One buffer with all meshes, the last first.
        let mut all = Vec::new();
        let mut places = vec![MeshPlace::default(); scene.meshes().len()];
        for (id, mesh) in scene.meshes().iter().enumerate().rev() {
            places[id] =
                MeshPlace { first_index: all.len() as u32, base_vertex: id as i32 * 1000 - 500 };
            all.extend_from_slice(mesh.indices());
        }
        let (view, culler) = (random_view(&mut rng), random_culler(&mut rng));
        for output in [Output::Instances, Output::Clusters, Output::Triangles] {
            let culler = culler.clone().with_output(output);
            let (mut state, mut visible) = (ViewState::default(), Visible::default());
            culler.cull_one(&scene, &view, &mut state, &mut visible);
            let expected = of_clusters(&scene, &visible);
            assert!(expected.values().all(|&n| n == 1));

            let draws = visible.draws(&scene).unwrap();
            assert!(is_sorted(draws.iter().map(|d| (d.state, d.material, d.mesh))));
            let mut drawn = Drawn::new();
            for d in &draws {
                assert_eq!(scene.slot(d.handle), Ok(d.slot));
                let (mesh, part, level) = (d.mesh, d.part, d.level);
                let key = DrawKey { state: d.state, material: d.material, mesh, part, level };
                check_key(&scene, d.slot, &key);
                let indices = &scene.mesh(d.slot).indices()[d.indices.start as usize..];
                for t in indices[..d.indices.len()].as_chunks::<3>().0 {
                    *drawn.entry((d.slot, *t)).or_default() += 1;
                }
            }
            assert_eq!(drawn, expected);

            list.fill(&scene, &visible, &places).unwrap();
            assert!(is_sorted(list.keys.iter().map(|k| (k.state, k.material, k.mesh))));
            assert_eq!(rendered(&scene, &list, &all, &places), expected);
            instanced += list.commands.iter().filter(|c| c.instance_count > 1).count();
            partial += visible.partial.len();
            if output == Output::Triangles {
                list.fill_triangles(&scene, &visible, &places).unwrap();
                let found = rendered(&scene, &list, &list.indices, &places);
                assert_eq!(found, of_triangles(&scene, &visible));
            }
        }
    }
    assert!(partial > 100 && instanced > 100, "{partial} {instanced}");
}

#[test]
fn an_empty_answer_has_no_draws_and_meshes_without_a_place_begin_at_zero() {
    let scene = scene(&mut Rng(5));
    let mut list = DrawList::default();
    let nothing = Visible { version: scene.version(), ..Visible::default() };
    list.fill(&scene, &nothing, &[]).unwrap();
    assert!(list.commands.is_empty() && list.instances.is_empty());
    let everything = Culler::default().with_frustum(false).with_output(Output::Instances);
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    everything.cull_one(&scene, &looking_down_z(), &mut state, &mut visible);
    list.fill(&scene, &visible, &[]).unwrap();
    let mut firsts = list.keys.iter().zip(&list.commands).filter(|(key, _)| key.part == 0);
    assert!(firsts.all(|(_, command)| (command.first_index, command.base_vertex) == (0, 0)));
}

#[test]
fn a_result_that_is_older_than_its_scene_is_refused() {
    let (mut rng, mut list) = (Rng(6), DrawList::default());
    let everything = Culler::default().with_frustum(false).with_output(Output::Triangles);
    let (view, sun) = (looking_down_z(), Light::Directional { direction: [0.0, -1.0, 0.0] });
    // What makes the numbers of slots or clusters others, and what does not.
    let removes_half = |scene: &mut Scene| {
        let handles: Vec<_> = scene.slots().filter_map(|slot| scene.handle(slot)).collect();
        handles.iter().step_by(2).for_each(|&handle| scene.remove(handle).unwrap());
        scene.commit(&Culler::default());
    };
    let edits = |scene: &mut Scene| {
        scene.edit_mesh(0, |mesh| *mesh = meshes::tetrahedron());
    };
    let moves = |scene: &mut Scene| {
        let handle = scene.handle(0).expect("the slot is taken");
        scene.set_transform(handle, Transform::from_translation([1.0, 2.0, 3.0])).unwrap();
        scene.add(Instance::new(0, Transform::IDENTITY)).unwrap();
    };
    type Change<'a> = (&'a dyn Fn(&mut Scene), bool);
    let changes: [Change<'_>; 4] = [
        (&removes_half, true),
        (&edits, true),
        (&|scene| *scene = random_scene(&mut Rng(6), 3), true),
        (&moves, false),
    ];
    for (change, is_stale) in changes {
        let mut scene = scene(&mut rng);
        scene.commit(&Culler::default());
        let (mut state, mut visible) = (ViewState::default(), Visible::default());
        let is_refused = |scene: &Scene, visible: &Visible, list: &mut DrawList| {
            let refused = [
                visible.draws(scene).err(),
                list.fill(scene, visible, &[]).err(),
                list.fill_triangles(scene, visible, &[]).err(),
                ShadowView::new(view.clone(), sun).receiving(scene, visible).err(),
            ];
            let [result, scene] = [visible.version, scene.version()];
            let expected = (result != scene).then_some(SceneError::Stale { result, scene });
            assert_eq!(refused, [expected; 4]);
            assert!(expected.is_none() || list.commands.is_empty() && list.indices.is_empty());
            expected.is_some()
        };
        assert!(is_refused(&scene, &visible, &mut list), "never culled");
        everything.cull_one(&scene, &view, &mut state, &mut visible);
        assert!(!is_refused(&scene, &visible, &mut list));
        change(&mut scene);
        assert_eq!(is_refused(&scene, &visible, &mut list), is_stale);
        everything.cull_one(&scene, &view, &mut state, &mut visible);
        assert!(!is_refused(&scene, &visible, &mut list));
    }
}

/// Lists by handles and by the caller's numbers name the instances of the list by slots, and keep their names through a
/// commit.
#[test]
fn instances_are_listed_by_the_numbers_that_are_wanted() {
    let mut rng = Rng(8);
    let mut scene = scene(&mut rng);
    for i in 0..60_u32 {
        let at = Transform::from_translation([f64::from(i) * 0.1, 0.0, -20.0]);
        let user_data = (7 << 32) + 1000 + u64::from(i);
        scene.add(Instance { user_data, ..Instance::new(0, at) }).unwrap();
    }
    let handles: Vec<_> = scene.slots().filter_map(|slot| scene.handle(slot)).collect();
    handles.iter().step_by(3).for_each(|&handle| scene.remove(handle).unwrap());
    scene.commit(&Culler::default());
    let culler = Culler::default().with_output(Output::Triangles);
    let mut visible = Visible::default();
    culler.cull_one(&scene, &looking_down_z(), &mut ViewState::default(), &mut visible);
    let list = |numbers, triangles| {
        let mut list = DrawList::by(numbers);
        match triangles {
            true => list.fill_triangles(&scene, &visible, &[]).unwrap(),
            false => list.fill(&scene, &visible, &[]).unwrap(),
        }
        (list.instances, list.commands)
    };
    for triangles in [false, true] {
        let (slots, commands) = list(InstanceNumbers::Slots, triangles);
        assert!(slots.len() > 10);
        let (by_handles, same) = list(InstanceNumbers::Handles, triangles);
        assert_eq!(same, commands);
        let index = |slot: &u32| scene.handle(*slot).unwrap().index;
        assert!(by_handles.iter().copied().eq(slots.iter().map(index)));
        let (by_users, same) = list(InstanceNumbers::Users, triangles);
        assert_eq!(same, commands);
        let user = |slot: &u32| scene.user_data(*slot) as u32;
        assert!(slots.iter().filter(|slot| user(slot) >= 1000).count() > 10);
        assert!(by_users.iter().copied().eq(slots.iter().map(user)));
    }
}
