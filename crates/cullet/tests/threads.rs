//! One view on several threads: the answer of one thread, bit for bit, whatever the pool.

use std::sync::atomic::{AtomicU32, Ordering};

use cullet::cull::occlusion::{Occlusion, OcclusionBuffer};
use cullet::jobs::{Job, Jobs, Rayon};
use cullet::prepared::Preparation;
use cullet::{Culler, Instance, Output, Scene, Simd, Transform, View, ViewState, Visible};
use cullet_testkit::scenes::random_transform;
use cullet_testkit::views::{look, random_view};
use cullet_testkit::{Rng, cases, meshes};

/// So many threads, as far as a culler can tell: all is done by the last, in turn.
struct InTurn {
    threads: usize,
    runs: AtomicU32,
}

impl InTurn {
    fn new(threads: usize) -> Self {
        Self { threads, runs: AtomicU32::new(0) }
    }
}

impl Jobs for InTurn {
    fn threads(&self) -> usize {
        self.threads
    }

    fn run(&self, jobs: &mut [Job<'_>]) {
        self.runs.fetch_add(1, Ordering::Relaxed);
        jobs.iter_mut().rev().for_each(|job| job());
    }
}

/// Threads that are started for each run.
struct Started(usize);

impl Jobs for Started {
    fn threads(&self) -> usize {
        self.0
    }

    fn run(&self, jobs: &mut [Job<'_>]) {
        std::thread::scope(|scope| {
            for job in jobs {
                scope.spawn(job);
            }
        });
    }
}

/// Bodies, surfaces, and small things by the thousand behind them; some cross the near plane.
fn scene(rng: &mut Rng, small: usize) -> Scene {
    let mut scene = Scene::new();
    let meshes = [
        meshes::block([-1.0; 3], [1.0; 3]),
        meshes::ball(24),
        meshes::blob(rng),
        meshes::tetrahedron(),
    ];
    let meshes = meshes.map(|mesh| scene.add_mesh(mesh));
    for _ in 0..150 {
        let (mesh, mut transform) = (meshes[rng.below(4) as usize], random_transform(rng));
        transform.translation = rng.vector(20.0);
        scene.add(Instance::new(mesh, transform)).expect("the mesh exists");
    }
    for _ in 0..small {
        let place = rng.vector(60.0);
        let transform = Transform::from_scale_translation([0.05; 3], place);
        scene.add(Instance::new(meshes[0], transform)).expect("the mesh exists");
    }
    scene.prepare(Preparation::ALL);
    scene.sort();
    scene
}

fn pixels(buffer: Option<&OcclusionBuffer>) -> Vec<u32> {
    let Some(buffer) = buffer else { return Vec::new() };
    let [width, height] = buffer.size();
    let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    all.map(|(x, y)| buffer.nearness(x, y).to_bits()).collect()
}

/// Everything that a cull says.
fn told(visible: &Visible, state: &ViewState) -> (String, Vec<(u32, u32)>, Vec<u32>) {
    let drawn = state.occluders_drawn().to_vec();
    (format!("{visible:?}"), drawn, pixels(state.occlusion_buffer()))
}

fn views(rng: &mut Rng) -> Vec<View> {
    let mut views: Vec<View> = (0..2).map(|_| random_view(rng)).collect();
    views.push(look([3.0, 20.0, 150.0], [0.0; 3], [640, 400]));
    for viewport in [[640, 360], [203, 125], [1280, 1000]] {
        views.push(look(rng.vector(25.0), rng.vector(3.0), viewport));
    }
    views
}

fn cullers() -> [Culler; 3] {
    let always = Occlusion::default();
    [
        Culler::exact().with_output(Output::Triangles),
        Culler::default().with_occlusion(always),
        Culler::default().with_occlusion(always.with_width(320)).with_reasons(true),
    ]
}

#[test]
fn the_answer_is_that_of_one_thread_on_any_number_at_every_level() {
    let mut rng = Rng(44);
    let (mut runs, mut hidden) = (0, 0);
    for round in 0..cases(3) {
        let scene = scene(&mut rng, if round == 0 { 30_000 } else { 3_000 });
        let views = views(&mut rng);
        for culler in cullers() {
            for level in Simd::all() {
                let culler = culler.clone().with_simd(level);
                let pools = [1, 2, 3, 7, 40].map(InTurn::new);
                let mut states = pools.each_ref().map(|_| ViewState::default());
                let (mut one, mut state) = (Visible::default(), ViewState::default());
                for (number, view) in views.iter().enumerate() {
                    culler.cull_one(&scene, view, &mut state, &mut one);
                    let expected = told(&one, &state);
                    hidden += one.funnel.occlusion.drawn;
                    for (pool, state) in pools.iter().zip(&mut states) {
                        let mut on = Visible::default();
                        culler.cull_one_on(pool, &scene, view, state, &mut on);
                        let is_same = told(&on, state) == expected;
                        assert!(is_same, "{level:?}, view {number}, {} threads", pool.threads);
                    }
                }
                assert_eq!(pools[0].runs.load(Ordering::Relaxed), 0);
                runs += pools.iter().map(|pool| pool.runs.load(Ordering::Relaxed)).sum::<u32>();
            }
        }
    }
    // The floors: it was split, and there was something to draw.
    assert!(runs > 300 && hidden > 500, "{runs} {hidden}");
}

#[test]
fn threads_that_run_side_by_side_leave_the_same_answer() {
    let mut rng = Rng(45);
    let (scene, views) = (scene(&mut rng, 30_000), views(&mut rng));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("three threads");
    for culler in cullers() {
        let (mut one, mut state) = (Visible::default(), ViewState::default());
        let mut states = [(); 3].map(|()| ViewState::default());
        for view in &views {
            culler.cull_one(&scene, view, &mut state, &mut one);
            let expected = told(&one, &state);
            for (number, state) in states.iter_mut().enumerate() {
                let mut on = Visible::default();
                match number {
                    0 => culler.cull_one_on(&Rayon, &scene, view, state, &mut on),
                    1 => pool.install(|| culler.cull_one_on(&Rayon, &scene, view, state, &mut on)),
                    _ => culler.cull_one_on(&Started(4), &scene, view, state, &mut on),
                }
                assert!(told(&on, state) == expected, "pool {number}");
            }
        }
    }
}
