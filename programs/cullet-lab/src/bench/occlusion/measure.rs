//! The times of one rasteriser on one scene, as comparisons of occlusion cullers take them: of the
//! thread that draws, not of the clock on the wall.

use std::time::{Duration, Instant};

use cullet::Simd;
use cullet::bounds::Boxes;
use serde::Serialize;

use super::rasteriser::{HIDDEN, OUTSIDE, Rasteriser, VISIBLE};
use super::scene::{Prepared, Scratch};
use crate::stopwatch::of_thread;

/// The three ways to fill the buffer.
pub(super) const MODES: [&str; 3] = ["raw", "sorted", "interleaved"];

/// The times of one way, in milliseconds: of each view the fastest pass, and of these the mean.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Mode {
    /// `raw`: all pieces in their order. `sorted`: those in the frustum, nearest first.
    /// `interleaved`: so too, but each is first tested against what is drawn.
    pub(super) name: &'static str,
    /// Emptying the buffer and setting up the view.
    pub(super) clear_ms: f64,
    /// Drawing.
    pub(super) render_ms: f64,
    /// The same, of each view the median of its passes.
    pub(super) median_ms: f64,
    /// Culling pieces by the frustum and sorting them; 0 for raw.
    pub(super) prepare_ms: f64,
    /// Triangles of the file's meshes in the frustum; all of them for raw.
    pub(super) triangles: f64,
    /// Pieces that are drawn.
    pub(super) pieces: f64,
}

/// Times and results of testing the objects, with the buffer filled as `sorted` does: means over
/// views.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct ObjectTests {
    /// Time for those in the frustum alone, projection included, by their number.
    pub(super) ns_per_object: f64,
    /// Time for all objects, those outside of the frustum too.
    pub(super) all_ms: f64,
    /// Objects in the frustum.
    pub(super) in_frustum: f64,
    /// Objects among them that are proved hidden.
    pub(super) culled: f64,
    /// Objects among them that are not proved hidden.
    pub(super) visible: f64,
}

/// Results of a measurement.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// One entry for each of [`MODES`].
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

/// How often a view is measured.
#[derive(Clone, Copy, Debug)]
pub(super) enum Passes {
    /// For so many seconds, and at least three times.
    For(f64),
    /// So many times.
    Count(u32),
}

impl Passes {
    const LEAST: usize = 3;

    /// Whether that is not done yet, after some passes since `begin`.
    pub(super) fn go_on(self, passes: usize, begin: Instant) -> bool {
        match self {
            Self::For(seconds) => passes < Self::LEAST || begin.elapsed().as_secs_f64() < seconds,
            Self::Count(count) => passes < count.max(1) as usize,
        }
    }
}

/// Times of passes, in nanoseconds.
#[derive(Clone, Copy, Debug, Default)]
struct Times {
    least: f64,
    median: f64,
}

/// Times of what each pass measures.
fn times<const N: usize>(passes: Passes, mut pass: impl FnMut() -> [Duration; N]) -> [Times; N] {
    let mut all: Vec<[Duration; N]> = Vec::new();
    let begin = Instant::now();
    while passes.go_on(all.len(), begin) {
        all.push(pass().map(|time| time.max(SHORTEST)));
    }
    std::array::from_fn(|i| {
        let mut each: Vec<f64> = all.iter().map(|times| times[i].as_nanos() as f64).collect();
        each.sort_unstable_by(f64::total_cmp);
        Times { least: each[0], median: each[each.len() / 2] }
    })
}

/// Measures all views in turn, five times of each with so many passes for every one; `go_on` is
/// called after each view.
pub(super) fn measure(
    prepared: &Prepared,
    simd: Simd,
    rasteriser: &mut dyn Rasteriser,
    passes: Passes,
    go_on: &mut dyn FnMut() -> bool,
) -> Found {
    let all: Vec<u32> = (0..prepared.pieces.boxes.len() as u32).collect();
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
        let in_view = prepared.triangles_in(simd, view);
        let mut fill = |mode: usize, rasteriser: &mut dyn Rasteriser, scratch: &mut Scratch| {
            let mut pieces = all.len();
            let [prepare, clear, render] = times(passes, || {
                let prepare = match mode {
                    0 => Duration::ZERO,
                    _ => of_thread(|| prepared.sorted(simd, view, scratch)),
                };
                let order = if mode == 0 { &all } else { &scratch.pieces };
                let clear = of_thread(|| rasteriser.clear(culling_view));
                let render = of_thread(|| match mode {
                    2 => pieces = rasteriser.draw_unless_hidden(order),
                    _ => rasteriser.draw(order),
                });
                if mode == 1 {
                    pieces = order.len();
                }
                [prepare, clear, render]
            });
            let m = &mut found.modes[mode];
            m.prepare_ms += if mode == 0 { 0.0 } else { prepare.least * 1e-6 };
            m.clear_ms += clear.least * 1e-6;
            m.render_ms += render.least * 1e-6;
            m.median_ms += render.median * 1e-6;
            let triangles = if mode == 0 { prepared.scene.triangles.len() as u64 } else { in_view };
            m.triangles += triangles as f64;
            m.pieces += pieces as f64;
        };
        // The tests are held against the last.
        let modes = if rasteriser.is_thrifty() { [0, 1, 2] } else { [0, 2, 1] };
        modes.into_iter().for_each(|mode| fill(mode, rasteriser, &mut scratch));

        let first = found.answers.len();
        found.answers.resize(first + prepared.objects.len(), VISIBLE);
        let answers = &mut found.answers[first..];
        let [time] =
            times(passes, || [of_thread(|| rasteriser.test(&prepared.object_boxes, answers))]);
        found.test.all_ms += time.least * 1e-6;
        let inside: Vec<u32> =
            (0..answers.len() as u32).filter(|&i| answers[i as usize] != OUTSIDE).collect();
        let hidden = answers.iter().filter(|&&a| a == HIDDEN).count();
        found.test.in_frustum += inside.len() as f64;
        found.test.culled += hidden as f64;
        found.test.visible += (inside.len() - hidden) as f64;
        if !inside.is_empty() {
            let mut boxes = Boxes::new();
            boxes.gather(simd, &prepared.objects, &inside);
            let mut again = vec![VISIBLE; inside.len()];
            let [time] = times(passes, || [of_thread(|| rasteriser.test(&boxes, &mut again))]);
            test_ns += time.least;
            tested += inside.len();
        }
        found.views += 1;
        if !go_on() {
            break;
        }
    }
    let mean = 1.0 / found.views.max(1) as f64;
    for m in &mut found.modes {
        let times = [&mut m.prepare_ms, &mut m.clear_ms, &mut m.render_ms, &mut m.median_ms];
        for value in times.into_iter().chain([&mut m.triangles, &mut m.pieces]) {
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
