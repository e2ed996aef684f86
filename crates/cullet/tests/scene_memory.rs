//! Sorting a scene holds little beside the scene: of ten million instances each list of numbers takes 40 MB.

use cullet::{Instance, Scene, Transform};
use cullet_testkit::memory::{Counting, peak_of};
use cullet_testkit::{Rng, meshes};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Most bytes that sorting takes at its peak for an instance that has nothing of its own but a mesh
/// and a transform: lists of numbers, a part of its transform, and its share of the nodes, which
/// stay.
const MOST_BYTES: usize = 40;

// One test: what another thread holds would be counted too.
#[test]
fn sorting_takes_less_than_a_second_copy_of_the_transforms() {
    const COUNT: usize = 300_000;
    let mut rng = Rng(3);
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(meshes::tetrahedron());
    let handles: Vec<_> = (0..COUNT)
        .map(|_| {
            let place = [0; 3].map(|_| rng.range(-500.0, 500.0));
            scene.add(Instance::new(mesh, Transform::from_translation(place))).unwrap()
        })
        .collect();
    let place = |scene: &Scene, i: usize| *scene.transform(scene.slot(handles[i]).unwrap());
    let before: Vec<_> = (0..COUNT).map(|i| place(&scene, i)).collect();
    let (commit, peak) = peak_of(|| scene.sort());
    assert!(peak < COUNT * MOST_BYTES, "{} bytes each", peak as f64 / COUNT as f64);
    assert_eq!(commit.slot_of_old.len(), COUNT);
    assert!((0..COUNT).all(|i| place(&scene, i) == before[i]));
    // Again, without a third of them.
    let gone = |i: usize| i % 3 == 1;
    (0..COUNT).filter(|&i| gone(i)).for_each(|i| scene.remove(handles[i]).unwrap());
    let (_, peak) = peak_of(|| scene.sort());
    assert!(peak < COUNT * MOST_BYTES, "{} bytes each", peak as f64 / COUNT as f64);
    assert_eq!(scene.slot_count() as usize, COUNT - COUNT / 3);
    assert!((0..COUNT).filter(|&i| !gone(i)).all(|i| place(&scene, i) == before[i]));
}
