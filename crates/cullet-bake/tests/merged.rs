//! Merged groups of instances, measured without what made them.
#![cfg(feature = "meshopt")]

use cullet::mesh::Part;
use cullet::{Culler, Instance, Mesh, MeshData, Output, Scene, Stage, Transform};
use cullet_bake::levels::{ChainOptions, LevelsError, NO_GROUP, build_chain, deviation};
use cullet_bake::merged::{Member, MergeOptions, MergedGroup, add_to_scene, merge};
use cullet_testkit::views::look;
use cullet_testkit::{Rng, answers::cull, cases, soups};

/// Balls and walls in rows, some mirrored, some of two parts, and a ground.
fn village(rng: &mut Rng) -> Scene {
    let mut scene = Scene::new();
    let (positions, indices) = soups::bumpy_ball(14, 0.1);
    let triangles = (indices.len() / 3) as u32;
    let part = |first_triangle, triangle_count, material| Part {
        first_triangle,
        triangle_count,
        material,
        ..Part::default()
    };
    let parts = vec![part(0, triangles / 2, 1), part(triangles / 2, triangles - triangles / 2, 2)];
    let ball = MeshData { positions, indices, parts, ..MeshData::default() };
    let mut meshes = Vec::new();
    for data in [ball, cullet_testkit::meshes::block([-0.5; 3], [0.5, 2.0, 0.2]).to_data()] {
        let mesh = scene.add_mesh(Mesh::new(data.clone()).unwrap());
        let chain = build_chain(&data, &ChainOptions::default()).unwrap();
        if !chain.groups.is_empty() {
            let (held, levels) = chain.into_levels().unwrap();
            let held = scene.add_mesh(held);
            scene.add_levels(mesh, held, levels).unwrap();
        }
        meshes.push(mesh);
    }
    for at in 0..30 + rng.below(30) {
        let place = [(at % 8) as f64 * 2.2 + 1e4, rng.range(0.0, 0.3), (at / 8) as f64 * 2.2];
        let scale = [rng.range(0.5, 1.2) as f32 * if at % 5 == 0 { -1.0 } else { 1.0 }, 1.0, 0.9];
        let transform = Transform::from_scale_translation(scale, place);
        scene.add(Instance::new(meshes[rng.index(2)], transform)).unwrap();
    }
    let ground =
        scene.add_mesh(cullet_testkit::meshes::block([-40.0, -1.0, -40.0], [40.0, 0.0, 40.0]));
    scene.add(Instance::new(ground, Transform::from_translation([1e4, 0.0, 0.0]))).unwrap();
    scene.rebase([1e4, 0.0, 0.0]);
    scene.commit();
    scene
}

/// The instances below a group.
fn below(groups: &[MergedGroup], number: usize) -> Vec<u32> {
    let members = groups[number].members.iter();
    members
        .flat_map(|m| match *m {
            Member::Instance(slot) => vec![slot],
            Member::Group(other) => {
                assert!((other as usize) < number);
                below(groups, other as usize)
            }
        })
        .collect()
}

#[test]
fn each_level_is_as_near_to_its_instances_as_it_states() {
    let mut rng = Rng(5);
    for case in 0..cases(4).max(1) {
        let scene = village(&mut rng);
        let groups = merge(&scene, &MergeOptions::default(), |_| true).unwrap().unwrap();
        assert!(groups.len() > 1, "case {case}");
        let mut times = vec![0; scene.slot_count() as usize];
        for (number, group) in groups.iter().enumerate() {
            let slots = below(&groups, number);
            group.members.iter().for_each(|m| {
                if let Member::Instance(slot) = m {
                    times[*slot as usize] += 1;
                }
            });
            let (mut positions, mut indices) = (Vec::new(), Vec::new());
            for slot in slots {
                let (mesh, m) = (scene.mesh(slot), scene.transform(slot).to_matrix());
                indices.extend(mesh.indices().iter().map(|i| i + positions.len() as u32));
                positions.extend(mesh.positions().iter().map(|p| {
                    let p = p.map(f64::from);
                    let place = |a: usize| {
                        m[a] * p[0] + m[4 + a] * p[1] + m[8 + a] * p[2] + m[12 + a]
                            - group.origin[a]
                    };
                    [0, 1, 2].map(|a| place(a) as f32)
                }));
            }
            let levels = &group.levels;
            assert!(
                !levels.groups.is_empty() && levels.groups.is_sorted_by(|a, b| a.error <= b.error)
            );
            for (level, stated) in levels.groups.iter().enumerate() {
                let made =
                    (0..levels.made_from.len()).filter(|&c| levels.made_from[c] == level as u32);
                let list: Vec<u32> = made
                    .flat_map(|c| levels.cluster_indices(c as u32).collect::<Vec<_>>())
                    .collect();
                assert!(!list.is_empty() && list.len() < indices.len());
                let far =
                    deviation((&positions, &indices), (&levels.mesh.positions, &list), 40_000, 77);
                assert!(
                    far.p999 <= stated.error && far.max <= stated.error * 1.2,
                    "case {case}: {far:?}, {stated:?}"
                );
                // The sphere is around all of it.
                let length = |p: &[f32; 3]| p.iter().map(|v| v * v).sum::<f32>().sqrt();
                assert!(positions.iter().all(|p| length(p) <= stated.radius * 1.0001));
            }
            assert!(levels.made_from.iter().all(|&g| g != NO_GROUP));
        }
        assert!(times.iter().all(|&n| n <= 1));
    }
}

#[test]
fn merged_groups_draw_less_from_afar_and_nothing_changes_near_by() {
    let mut rng = Rng(8);
    let mut scene = village(&mut rng);
    let groups = merge(&scene, &MergeOptions::default(), |_| true).unwrap().unwrap();
    let count = |scene: &Scene, far: f64| {
        let view = look([1e4 + 8.0, 0.4 * far, far], [1e4 + 8.0, 0.0, 8.0], [1280, 720]);
        let lod = Some(cullet::lod::Lod::default());
        let culler = Culler { lod, output: Output::Triangles, ..Culler::default() };
        cull(&culler.only(Stage::Lod), scene, &view).triangle_count
    };
    let fars = [4.0, 40.0, 120.0, 1000.0];
    let before = fars.map(|far| count(&scene, far));
    assert_eq!(add_to_scene(&mut scene, &groups).unwrap().len(), groups.len());
    scene.commit();
    let after = fars.map(|far| count(&scene, far));
    assert!(after.iter().zip(&before).all(|(a, b)| a <= b), "{after:?} of {before:?}");
    // Farther away all that is left of each is a sheet or two.
    assert!(after[1] * 10 < before[1] * 9, "{after:?} of {before:?}");
    // Added twice, an instance would be stood for twice.
    assert!(add_to_scene(&mut scene, &groups).is_err());
}

#[test]
fn groups_are_the_same_on_any_number_of_threads_and_can_be_stopped() {
    let scene = village(&mut Rng(3));
    let mut options = MergeOptions::default();
    let one = merge(&scene, &options, |_| true).unwrap();
    options.threads = 3;
    assert_eq!(merge(&scene, &options, |_| true).unwrap(), one);
    assert_eq!(merge(&scene, &options, |share| share < 0.3).unwrap(), None);
    assert_eq!(merge(&Scene::new(), &options, |_| true).unwrap(), Some(Vec::new()));
}

#[test]
fn wrong_options_are_refused() {
    let scene = Scene::new();
    let refused = |change: &dyn Fn(&mut MergeOptions)| {
        let mut options = MergeOptions::default();
        change(&mut options);
        matches!(merge(&scene, &options, |_| true), Err(LevelsError::Value { .. }))
    };
    assert!(!refused(&|_| ()));
    assert!(refused(&|o| o.smallest = 1));
    assert!(refused(&|o| o.fan = 6));
    assert!(refused(&|o| o.first = f64::NAN));
    assert!(refused(&|o| o.levels = 0));
    assert!(refused(&|o| o.keep = 1.5));
    assert!(refused(&|o| o.threads = 0));
}
