//! The times of one rasteriser on one scene, as comparisons of occlusion cullers take them.

use std::time::{Duration, Instant};

use cullet::Simd;
use cullet::bounds::Boxes;
use serde::Serialize;

use super::rasteriser::{HIDDEN, OUTSIDE, Rasteriser, VISIBLE};
use super::scene::{Prepared, Scratch};

/// The three ways to fill the buffer.
pub(super) const MODES: [&str; 3] = ["raw", "sorted", "interleaved"];

/// The times of one way, in milliseconds: of each view the fastest pass, and of these the mean.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Mode {
    /// `raw`: all triangles in the file's order. `sorted`: the meshes in the frustum, nearest first.
    /// `interleaved`: so too, but each mesh is first tested against what is drawn.
    pub(super) name: &'static str,
    /// Emptying the buffer and setting up the view.
    pub(super) clear_ms: f64,
    /// Drawing.
    pub(super) render_ms: f64,
    /// Culling meshes by the frustum and sorting them; 0 for raw.
    pub(super) prepare_ms: f64,
    /// Triangles that are handed over.
    pub(super) triangles: f64,
    /// Meshes that are drawn.
    pub(super) meshes: f64,
}

/// Times and results of testing the objects, with the buffer filled as `sorted` does: means over views.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct ObjectTests {
    /// Time for those in the frustum alone, projection included, by their number.
    pub(super) ns_per_object: f64,
    /// Time for all objects, those outside of the frustum too.
    pub(super) all_ms: f64,
    /// Objects in the frustum.
    pub(super) in_frustum: f64,
    /// Those of them that are proved hidden.
    pub(super) culled: f64,
    /// Those of them that are not.
    pub(super) visible: f64,
}

/// Results of a measurement.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// By [`MODES`].
    pub(super) modes: [Mode; 3],
    /// The tests.
    pub(super) test: ObjectTests,
    /// View by view, an answer for each object.
    pub(super) answers: Vec<u8>,
    /// Views that were measured: all, unless it was stopped.
    pub(super) views: usize,
}

/// A pass that takes less than the clock's own cost would measure the clock.
const SHORTEST: Duration = Duration::from_nanos(1);

/// Times: the least of at least three passes, and of as many as `seconds` allow.
fn fastest<const N: usize>(seconds: f64, mut pass: impl FnMut() -> [Duration; N]) -> [f64; N] {
    let mut best = [Duration::MAX; N];
    let begin = Instant::now();
    let mut passes = 0;
    while passes < 3 || begin.elapsed().as_secs_f64() < seconds {
        for (best, time) in best.iter_mut().zip(pass()) {
            *best = (*best).min(time.max(SHORTEST));
        }
        passes += 1;
    }
    best.map(|d| d.as_nanos() as f64)
}

/// Time that some work takes.
pub(super) fn timed(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

/// Measures all views in turn, about `seconds` for each of five times in each; `go_on` is called after
/// each view.
pub(super) fn measure(
    prepared: &Prepared,
    level: Simd,
    rasteriser: &mut dyn Rasteriser,
    seconds: f64,
    go_on: &mut dyn FnMut() -> bool,
) -> Found {
    let all: Vec<u32> = (0..prepared.scene.meshes.len() as u32).collect();
    let mut scratch = Scratch::default();
    let mut found = Found {
        modes: MODES.map(|name| Mode { name, ..Mode::default() }),
        test: ObjectTests::default(),
        answers: Vec::new(),
        views: 0,
    };
    let (mut test_ns, mut tested) = (0.0, 0usize);
    for view in 0..prepared.views.len() {
        let culling_view = &prepared.views[view];
        let mut fill = |mode: usize, rasteriser: &mut dyn Rasteriser, scratch: &mut Scratch| {
            let mut meshes = all.len();
            let [prepare, clear, render] = fastest(seconds, || {
                let prepare = match mode {
                    0 => Duration::ZERO,
                    _ => timed(|| prepared.sorted(level, view, scratch)),
                };
                let order = if mode == 0 { &all } else { &scratch.meshes };
                let clear = timed(|| rasteriser.clear(culling_view));
                let render = timed(|| match mode {
                    2 => meshes = rasteriser.draw_unless_hidden(order),
                    _ => rasteriser.draw(order),
                });
                if mode == 1 {
                    meshes = order.len();
                }
                [prepare, clear, render]
            });
            let order = if mode == 0 { &all } else { &scratch.meshes };
            let m = &mut found.modes[mode];
            m.prepare_ms += if mode == 0 { 0.0 } else { prepare * 1e-6 };
            m.clear_ms += clear * 1e-6;
            m.render_ms += render * 1e-6;
            m.triangles += prepared.triangles(order) as f64;
            m.meshes += meshes as f64;
        };
        fill(0, rasteriser, &mut scratch);
        fill(2, rasteriser, &mut scratch);
        // Last, for the tests are held against it.
        fill(1, rasteriser, &mut scratch);

        let first = found.answers.len();
        found.answers.resize(first + prepared.objects.len(), VISIBLE);
        let answers = &mut found.answers[first..];
        let [time] =
            fastest(seconds, || [timed(|| rasteriser.test(&prepared.object_boxes, answers))]);
        found.test.all_ms += time * 1e-6;
        let inside: Vec<u32> =
            (0..answers.len() as u32).filter(|&i| answers[i as usize] != OUTSIDE).collect();
        let hidden = answers.iter().filter(|&&a| a == HIDDEN).count();
        found.test.in_frustum += inside.len() as f64;
        found.test.culled += hidden as f64;
        found.test.visible += (inside.len() - hidden) as f64;
        if !inside.is_empty() {
            let mut boxes = Boxes::new();
            boxes.gather(level, &prepared.objects, &inside);
            let mut again = vec![VISIBLE; inside.len()];
            let [time] = fastest(seconds, || [timed(|| rasteriser.test(&boxes, &mut again))]);
            test_ns += time;
            tested += inside.len();
        }
        found.views += 1;
        if !go_on() {
            break;
        }
    }
    let mean = 1.0 / found.views.max(1) as f64;
    for m in &mut found.modes {
        for value in
            [&mut m.prepare_ms, &mut m.clear_ms, &mut m.render_ms, &mut m.triangles, &mut m.meshes]
        {
            *value *= mean;
        }
    }
    let t = &mut found.test;
    for value in [&mut t.all_ms, &mut t.in_frustum, &mut t.culled, &mut t.visible] {
        *value *= mean;
    }
    t.ns_per_object = test_ns / tested.max(1) as f64;
    found
}
