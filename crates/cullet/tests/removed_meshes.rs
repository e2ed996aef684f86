//! Meshes that are removed, and others in their place: the scene answers as one that never had them.

use cullet::scene::SceneError;
use cullet::{Culler, Instance, Mesh, Scene, Transform, View, ViewState, Visible};
use cullet_testkit::{Rng, cases, meshes};

fn block(rng: &mut Rng) -> Mesh {
    let size = rng.range(0.5, 6.0) as f32;
    meshes::block([-size; 3], [size, rng.range(0.1, 6.0) as f32, size])
}

fn at(rng: &mut Rng) -> Transform {
    Transform::from_translation([
        rng.range(-30.0, 30.0),
        rng.range(-4.0, 4.0),
        rng.range(-60.0, -4.0),
    ])
}

/// Returns the numbers of the visible instances, ascending.
fn seen(scene: &Scene, culler: &Culler, state: &mut ViewState) -> Vec<u64> {
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 0.9, 0.1, 200.0, [320, 200]).unwrap();
    let mut visible = Visible::default();
    culler.cull_one(scene, &view, state, &mut visible);
    let mut numbers: Vec<u64> = visible.slots().map(|slot| scene.user_data(slot)).collect();
    numbers.sort_unstable();
    numbers
}

#[test]
fn a_scene_whose_meshes_come_and_go_answers_as_a_new_one() {
    for seed in 0..cases(60) {
        let mut rng = Rng(seed.into());
        let (mut scene, mut state) = (Scene::new(), ViewState::default());
        // Each instance with its mesh, place, number and handle.
        let mut own: Vec<(u32, Transform, u64, _)> = Vec::new();
        let mut ids: Vec<u32> = Vec::new();
        for number in 0..60u64 {
            match rng.below(4) {
                0 => ids.push(scene.add_mesh(block(&mut rng))),
                1 if !ids.is_empty() => {
                    let mesh = ids.swap_remove(rng.index(ids.len()));
                    for (_, _, _, handle) in own.iter().filter(|own| own.0 == mesh) {
                        let refused = scene.remove_mesh(mesh).unwrap_err();
                        assert!(
                            matches!(refused, SceneError::MeshInUse { mesh: m, .. } if m == mesh)
                        );
                        scene.remove(*handle).unwrap();
                    }
                    own.retain(|own| own.0 != mesh);
                    assert!(scene.remove_mesh(mesh).unwrap().triangle_count() > 0);
                    assert!(matches!(scene.remove_mesh(mesh), Err(SceneError::NoMesh { .. })));
                    let gone = scene.add(Instance::new(mesh, Transform::IDENTITY));
                    assert!(matches!(gone, Err(SceneError::NoMesh { .. })));
                }
                _ if !ids.is_empty() => {
                    let (mesh, at) = (ids[rng.index(ids.len())], at(&mut rng));
                    let instance = Instance { user_data: number, ..Instance::new(mesh, at) };
                    own.push((mesh, at, number, scene.add(instance).unwrap()));
                }
                _ => {}
            }
            if rng.below(3) == 0 {
                scene.commit(&Culler::exact());
            }
            let mut new = Scene::new();
            for (mesh, at, number, _) in &own {
                let mesh = new.add_mesh(scene.meshes()[*mesh as usize].clone());
                new.add(Instance { user_data: *number, ..Instance::new(mesh, *at) }).unwrap();
            }
            assert_eq!(new.triangle_count(), scene.triangle_count(), "seed {seed}");
            // Prepared alike, or one finds more.
            scene.prepare(&Culler::exact());
            new.prepare(&Culler::exact());
            let exact = Culler::exact();
            let cold = seen(&scene, &exact, &mut ViewState::default());
            assert_eq!(seen(&scene, &exact, &mut state), cold, "seed {seed}, {number}");
            // What is hidden follows from the order of slots too.
            let open = exact.with_occlusion(None);
            let [own, expected] =
                [&scene, &new].map(|scene| seen(scene, &open, &mut ViewState::default()));
            assert_eq!(own, expected, "seed {seed}, {number}");
        }
    }
}

#[test]
fn a_mesh_that_changes_a_thousand_times_takes_one_number() {
    let mut scene = Scene::new();
    let stays = scene.add_mesh(meshes::tetrahedron());
    scene.add(Instance::new(stays, Transform::IDENTITY)).unwrap();
    let mut last = scene.add_mesh(meshes::tetrahedron());
    for _ in 0..1000 {
        scene.remove_mesh(last).unwrap();
        last = scene.add_mesh(meshes::tetrahedron());
    }
    assert_eq!((last, scene.meshes().len()), (1, 2));
    assert!(scene.remove_mesh(7).is_err());
    scene.edit_meshes(|mesh, _| assert!(mesh < 2));
}

#[test]
fn levels_go_with_the_mesh_that_has_or_holds_them() {
    let mut scene = Scene::new();
    let [fine, coarse, other] = std::array::from_fn(|_| scene.add_mesh(meshes::tetrahedron()));
    scene.add_lod(fine, coarse, 0.1).unwrap();
    scene.add_lod(other, coarse, 0.1).unwrap();
    scene.add(Instance::new(other, Transform::IDENTITY)).unwrap();
    scene.remove_mesh(fine).unwrap();
    assert_eq!((scene.levels(fine).len(), scene.levels(other).len()), (0, 1));
    assert!(scene.add_lod(fine, coarse, 0.1).is_err() && scene.add_lod(other, fine, 0.1).is_err());
    scene.remove_mesh(coarse).unwrap();
    assert!(scene.levels(other).is_empty());
    assert_eq!(scene.add_mesh(meshes::tetrahedron()), fine, "the lowest number is given first");
    assert!(scene.levels(fine).is_empty());
}
