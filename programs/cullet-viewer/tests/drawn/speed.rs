//! Savings by culling for a renderer: the city at 1280×720. It measures, so it is run by hand,
//! alone: `cargo test -p cullet-viewer --profile checked --test drawn speed -- --ignored
//! --nocapture`

use std::time::Instant;

use cullet::{Culler, Output, Scene, View, ViewState, Visible, view::CullFace};
use cullet_viewer::draw::{Pane, Renderer, Style};

use crate::gpu::*;

const SIZE: [u32; 2] = [1280, 720];

#[test]
#[ignore = "measures; see above"]
fn city() {
    let Some(gpu) = gpu(Tier::Draw) else { return };
    println!("{}", gpu.adapter.get_info().name);
    let model = cullet_scenes::build("city").unwrap();
    let mut renderer = Renderer::new(&gpu.adapter, &gpu.device);
    let start = Instant::now();
    renderer.set_scene(&gpu.device, &gpu.queue, &model).unwrap();
    finish(gpu);
    println!("upload {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
    for away in [0.05, 0.3, 1.2] {
        // From a roof, from above the roofs, and from where all is seen.
        let ways = [
            ("nothing", None, CullFace::None),
            ("hardware back faces", None, CullFace::Back),
            ("instances", Some(Output::Instances), CullFace::Back),
            ("clusters", Some(Output::Clusters), CullFace::Back),
            ("triangles", Some(Output::Triangles), CullFace::Back),
        ];
        let mut first = None;
        for (name, output, cull_face) in ways {
            let mut view = view(&model.scene, [0.5, 0.35, 1.0], away, SIZE);
            view.cull_face = cull_face;
            let (took, cpu) = frames(gpu, &mut renderer, &model.scene, &view, output);
            let base = *first.get_or_insert(took);
            let stats = renderer.stats();
            println!(
                "away {away}: {name:20} {took:8.2} ms, {cpu:7.1} ms of CPU, device {:?} ms, {} triangles, {} draws, {:.1} times as fast",
                stats.device_ms,
                stats.triangles,
                stats.draws,
                base / took
            );
            if output.is_some() && away < 0.1 {
                assert!(took < base, "culling does not pay: {took} ms, {base} ms without");
            }
        }
    }
}

/// The median of a frame, culling included, and its CPU time on all cores, which other programs do
/// not change much; in milliseconds.
fn frames(
    gpu: &Gpu,
    renderer: &mut Renderer,
    scene: &Scene,
    view: &View,
    output: Option<Output>,
) -> (f64, f64) {
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let mut times = Vec::new();
    let mut cpu = 0.0;
    for frame in 0..8 {
        // The first two make pipelines and lists.
        if frame == 2 {
            cpu = cpu_ms();
        }
        let start = Instant::now();
        if let Some(output) = output {
            let culler = Culler::default().with_output(output);
            culler.cull_one(scene, view, &mut state, &mut visible);
        }
        let pane = Pane { visible: output.map(|_| &visible), ..pane(view, Style::default()) };
        renderer.draw(&gpu.device, &gpu.queue, SIZE, BACKGROUND, &[pane]);
        finish(gpu);
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let cpu = (cpu_ms() - cpu) / (times.len() - 2) as f64;
    times.sort_by(f64::total_cmp);
    (times[times.len() / 2], cpu)
}

/// CPU time of this process on all cores, where the system tells (Linux), else NaN.
fn cpu_ms() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // User and system time follow the name in brackets, in hundredths of a second.
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after.split_whitespace().skip(11).take(2).filter_map(|v| v.parse::<f64>().ok());
    let ticks: Vec<f64> = ticks.collect();
    if ticks.len() == 2 { (ticks[0] + ticks[1]) * 10.0 } else { f64::NAN }
}
