//! Scenes with as many meshes as instances, as of building models, cost little more than one mesh.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

use cullet::{
    Culler, DrawList, Instance, Mesh, MeshData, Scene, Transform, View, ViewState, Visible,
    prepared::Preparation,
};
use cullet_testkit::views::look;

/// A grid of tetrahedra, each a mesh of its own or all of one mesh.
fn grid(side: u32, of_own: bool) -> Scene {
    let mut scene = Scene::new();
    let add = |scene: &mut Scene| {
        let positions = vec![[1., 1., 1.], [-1., -1., 1.], [-1., 1., -1.], [1., -1., -1.]];
        let indices = vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
        let data = MeshData { positions, indices, ..MeshData::default() };
        scene.add_mesh(Mesh::new(data).expect("a mesh"))
    };
    let mut mesh = add(&mut scene);
    for k in 0..side * side {
        if k > 0 && of_own {
            mesh = add(&mut scene);
        }
        let at = [f64::from(k % side) * 8.0, 0.0, f64::from(k / side) * -8.0];
        scene.add(Instance::new(mesh, Transform::from_translation(at))).expect("few");
    }
    scene.prepare(Preparation::ALL);
    scene.sort();
    scene
}

/// Eyes at the border that look across the grid, and one above it that sees some of it.
fn views(side: u32) -> Vec<View> {
    let far = f64::from(side) * 8.0;
    let to = |from: [f64; 3], at: [f64; 3]| look(from, at, [1280, 720]);
    vec![
        to([-9.0, 3.0, 9.0], [far, 0.0, -far]),
        to([far, 3.0, 9.0], [0.0, 0.0, -far]),
        to([far / 2.0, 3.0, -far / 2.0], [far, 0.0, -far / 2.0]),
        to([far / 2.0, 9.0, 9.0], [far / 2.0, 0.0, -far]),
        to([far / 2.0, 50.0, -far / 2.0], [far / 2.0, 0.0, -far / 2.0 - 1.0]),
    ]
}

fn nanoseconds() -> u64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_nanos() as u64
}

/// Shortest time of a frame of all views, with and without the draws.
fn frame(scene: &Scene, views: &[View], rounds: usize) -> ([Duration; 2], Visible) {
    let culler = Culler::default().with_clock(Some(nanoseconds));
    let mut states = vec![ViewState::default(); views.len()];
    let mut results = vec![Visible::default(); views.len()];
    let mut lists = vec![DrawList::default(); views.len()];
    let mut best = [Duration::MAX; 2];
    for _ in 0..rounds {
        let start = Instant::now();
        for (view, (state, result)) in views.iter().zip(states.iter_mut().zip(&mut results)) {
            culler.cull_one(scene, view, state, result);
        }
        best[0] = best[0].min(start.elapsed());
        for (list, result) in lists.iter_mut().zip(&results) {
            list.fill(scene, result, &[]).expect("just culled");
        }
        best[1] = best[1].min(start.elapsed());
    }
    let of_all = results.into_iter().reduce(|mut all, one| {
        all.instance_count += one.instance_count;
        for (row, more) in all.funnel.rows.iter_mut().zip(&one.funnel.rows) {
            row.nanoseconds += more.nanoseconds;
        }
        all
    });
    (best, of_all.unwrap_or_default())
}

#[test]
fn answers_are_those_of_one_mesh() {
    let views = views(30);
    let [own, shared] =
        [true, false].map(|of_own| frame(&grid(30, of_own), &views, 2).1.instance_count);
    assert!(own == shared && own > 100);
}

/// Prints the ratio: `cargo test --release -p cullet-testkit --test cullet many_meshes -- --ignored --nocapture`.
#[test]
#[ignore = "takes gigabytes, and measures time"]
fn a_frame_of_many_meshes_beside_one_of_many_instances() {
    const SIDE: u32 = 707;
    let views = views(SIDE);
    let [own, shared] = [true, false].map(|of_own| frame(&grid(SIDE, of_own), &views, 12));
    assert_eq!(own.1.instance_count, shared.1.instance_count);
    println!("{} instances visible in five views", own.1.instance_count);
    for (own, shared) in own.1.funnel.rows.iter().zip(&shared.1.funnel.rows) {
        let [own_us, shared_us] = [own, shared].map(|row| row.nanoseconds / 1000);
        println!("{:?} {:?}: {own_us} us, {shared_us} us", own.stage, own.unit);
    }
    for (what, at) in [("cull", 0), ("cull and fill", 1)] {
        let [own, shared] = [own.0, shared.0].map(|times| times[at].as_secs_f64() * 1e3);
        println!("{what}: {own:.3} ms of many meshes, {shared:.3} ms of one: {:.2}", own / shared);
    }
}
