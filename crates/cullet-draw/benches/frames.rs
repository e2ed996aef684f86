//! How long a frame of the reference renderer takes: `cargo bench -p cullet-draw`.

use std::time::Instant;

use cullet::{Instance, Scene, Transform, View};
use cullet_draw::{RenderOptions, Selection, render};
use cullet_testkit::scenes::city;
use cullet_testkit::views::look;
use cullet_testkit::{meshes, soups};

fn time(name: &str, scene: &Scene, view: &View) {
    for (count_layers, what) in [(false, "nearest only"), (true, "all layers")] {
        let options = RenderOptions { count_layers, ..RenderOptions::default() };
        let mut best = f64::INFINITY;
        let frame = render(scene, view, Selection::All, &options);
        for _ in 0..5 {
            let start = Instant::now();
            let again = render(scene, view, Selection::All, &options);
            best = best.min(start.elapsed().as_secs_f64());
            assert!(again == frame, "{name}: two frames of one view differ");
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

fn main() {
    let size = [1280, 720];
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!("{threads} threads, 1280x720");
    let scene = city(100, 1, 100_000);
    time("city, street", &scene, &look([0.0, 1.7, 600.0], [2.0, 1.7, 0.0], size));
    time("city, from 60 m", &scene, &look([0.0, 60.0, 800.0], [0.0, 20.0, 0.0], size));
    drop(scene);
    let mut big = Scene::new();
    let mesh = big.add_mesh(meshes::one_sided(soups::ball(708, 708)));
    big.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
    time("one mesh of 1e6 triangles", &big, &look([0.0, 0.5, 2.5], [0.0; 3], size));
    time("the same from within", &big, &look([0.0, 0.0, 0.3], [0.0; 3], size));
}
