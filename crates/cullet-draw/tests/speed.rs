//! How long a frame takes. Prints figures and proves nothing, so it runs only when asked:
//! `cargo test --release -p cullet-draw --test speed -- --ignored --nocapture`

mod common;

use std::time::Instant;

use common::{ball, city, look};
use cullet::{Instance, Scene, Transform, View};
use cullet_draw::{RenderOptions, Selection, render};

fn time(name: &str, scene: &Scene, view: &View) {
    for (count_layers, what) in [(false, "nearest only"), (true, "all layers")] {
        let options = RenderOptions { count_layers, ..RenderOptions::default() };
        let mut best = f64::INFINITY;
        let mut frame = render(scene, view, Selection::All, &options);
        for _ in 0..5 {
            let start = Instant::now();
            frame = render(scene, view, Selection::All, &options);
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!(
            "{name:<28} {what:<13} {:>7.1} ms  {} triangles, {} visible, {:.2} layers",
            best * 1e3,
            scene.triangle_count(),
            frame.visible().len(),
            frame.stats.mean_layers,
        );
    }
}

#[test]
#[ignore = "prints times"]
fn times_of_frames() {
    let size = [1280, 720];
    println!("{} threads, 1280x720", rayon_threads());
    let scene = city(100, 1, 100_000);
    time("city, street", &scene, &look([12.0 - 12.0, 1.7, 600.0], [2.0, 1.7, 0.0], size));
    time("city, from 60 m", &scene, &look([0.0, 60.0, 800.0], [0.0, 20.0, 0.0], size));
    drop(scene);
    let mut big = Scene::new();
    let mesh = big.add_mesh(ball(708, 708));
    big.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
    time("one mesh of 1e6 triangles", &big, &look([0.0, 0.5, 2.5], [0.0; 3], size));
    time("the same from within", &big, &look([0.0, 0.0, 0.3], [0.0; 3], size));
}

fn rayon_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
