//! Rounds of culls, with and without: of each view the fastest, in two halves that are held against
//! each other.

use std::time::Instant;

use cullet::{Culler, Scene, Simd, View, ViewState, Visible, costs::Costs};
use cullet_cells::{CellView, InCells};
use serde::Serialize;

use super::super::culler::is_same;
use crate::stopwatch::of_thread;

/// At least so many rounds.
const LEAST_ROUNDS: usize = 8;
/// Rounds end where no view's halves differ by more, as a part of all it takes.
const SETTLED: f64 = 0.005;

/// Settings that are measured, with what they did in every view.
#[derive(Debug)]
pub(super) struct Arm {
    pub(super) name: &'static str,
    culler: Culler,
    pub(super) views: Vec<OneView>,
}

/// A view, culled by one of the settings.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct OneView {
    /// Nanoseconds of the fastest cull in each half of the rounds. Other work on the machine only
    /// ever adds, so halves that agree have both found what the cull takes.
    pub(super) cull_ns: [f64; 2],
    /// Triangles that are left.
    pub(super) triangles: u64,
    /// Draws that they take.
    pub(super) draws: u64,
    /// Estimated time of drawing them, in nanoseconds.
    pub(super) draw_ns: f64,
}

impl OneView {
    /// The fastest cull.
    pub(super) fn cull(&self) -> f64 {
        self.cull_ns[0].min(self.cull_ns[1])
    }

    /// Cull and draw.
    pub(super) fn all(&self) -> f64 {
        self.cull() + self.draw_ns
    }

    /// Returns the difference of the halves, as a share of the whole.
    pub(super) fn noise(&self) -> f64 {
        (self.cull_ns[0] - self.cull_ns[1]).abs() / self.all()
    }

    fn half(&self, half: usize) -> f64 {
        self.cull_ns[half] + self.draw_ns
    }
}

/// A view with the stage over the same view without.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ratio {
    /// Ratio of the fastest culls.
    pub(super) ratio: f64,
    /// The lower one of the two halves': above 1 only where each of them found it slower.
    pub(super) sure: f64,
}

impl Ratio {
    pub(super) fn of(on: &OneView, off: &OneView) -> Self {
        let half = |h| on.half(h) / off.half(h);
        Self { ratio: on.all() / off.all(), sure: half(0).min(half(1)) }
    }
}

impl Arm {
    /// Settings that are not measured yet.
    pub(super) const fn new(name: &'static str, culler: Culler) -> Self {
        Self { name, culler, views: Vec::new() }
    }
}

/// Timing of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Timing {
    pub(super) rounds: usize,
    /// Whether each answer was that of a cull with fresh memory at the level of the oracle, and had
    /// nothing in it that was culled without the stage.
    pub(super) checked: bool,
}

/// Culls all views of a walk by all settings in turn, the first of which are without the stage,
/// until each view's halves agree or `seconds` are over. Settings take turns in being first. A
/// round goes through all views with one of them before the next, so that each finds in its state
/// what it left there one view ago, as in a renderer.
pub(super) fn measure(
    world: InCells<'_>,
    views: &[View],
    arms: &mut [Arm],
    costs: &Costs,
    oracle: Simd,
    seconds: f64,
    go_on: impl Fn() -> bool,
) -> Timing {
    let mut states: Vec<(CellView, ViewState)> = arms.iter().map(|_| Default::default()).collect();
    let mut results: Vec<Visible> = arms.iter().map(|_| Visible::default()).collect();
    let mut checked = true;
    for view in views {
        for (i, arm) in arms.iter_mut().enumerate() {
            let (among, state) = &mut states[i];
            among.cull(world, &arm.culler, view, state, &mut results[i]);
            checked &= is_right(world, view, &arm.culler, oracle, &results[i]);
            checked &= i == 0 || is_within(&results[i], &results[0]);
            arm.views.push(OneView::drawn(world.scene, &results[i], costs));
        }
    }
    let begin = Instant::now();
    let mut rounds = 0;
    let settled = |arms: &[Arm]| arms.iter().all(|a| a.views.iter().all(|v| v.noise() < SETTLED));
    while rounds < LEAST_ROUNDS || (begin.elapsed().as_secs_f64() < seconds && !settled(arms)) {
        if !go_on() {
            break;
        }
        // Each half has every order of the settings as often.
        let half = rounds / arms.len() % 2;
        for turn in 0..arms.len() {
            let i = (turn + rounds) % arms.len();
            let Arm { culler, views: taken, .. } = &mut arms[i];
            for (view, taken) in views.iter().zip(taken) {
                let ((among, state), result) = (&mut states[i], &mut results[i]);
                let time = of_thread(|| among.cull(world, culler, view, state, result));
                let best = &mut taken.cull_ns[half];
                *best = best.min(time.as_nanos() as f64);
            }
        }
        rounds += 1;
    }
    Timing { rounds, checked }
}

impl OneView {
    /// Returns what is left to draw, not timed yet.
    fn drawn(scene: &Scene, result: &Visible, costs: &Costs) -> Self {
        let draws = result.draws(scene).expect("the scene stands as it was culled");
        let (triangles, draws) = (result.triangle_count, draws.len() as u64);
        let draw_ns = triangles as f64 * costs.opaque_triangle_ns + draws as f64 * costs.draw_ns;
        Self { cull_ns: [f64::INFINITY; 2], triangles, draws, draw_ns }
    }
}

/// Whether a result is that of a cull with fresh memory at another level.
fn is_right(
    world: InCells<'_>,
    view: &View,
    culler: &Culler,
    simd: Simd,
    result: &Visible,
) -> bool {
    let mut expected = Visible::default();
    let oracle = culler.clone().with_simd(simd);
    world.cull(&oracle, view, &mut ViewState::default(), &mut expected);
    is_same(result, &expected)
}

/// Whether all that is visible in one result is in the other too.
fn is_within(inner: &Visible, outer: &Visible) -> bool {
    let (mut added, mut removed) = (Vec::new(), Vec::new());
    inner.changes_since(outer, &mut added, &mut removed);
    added.is_empty() && inner.triangle_count <= outer.triangle_count
}

#[cfg(test)]
mod tests {
    use cullet::cull::occlusion::Occlusion;

    use super::*;

    fn view(cull_ns: [f64; 2], draw_ns: f64) -> OneView {
        OneView { cull_ns, triangles: 1, draws: 1, draw_ns }
    }

    #[test]
    fn one_half_that_was_disturbed_does_not_make_a_view_slower() {
        let off = view([100.0, 100.0], 900.0);
        let disturbed = Ratio::of(&view([500.0, 110.0], 890.0), &off);
        assert_eq!(disturbed, Ratio { ratio: 1.0, sure: 1.0 });
        let slower = Ratio::of(&view([150.0, 160.0], 900.0), &off);
        assert_eq!(slower, Ratio { ratio: 1.05, sure: 1.05 });
        assert!(view([100.0, 100.5], 900.0).noise() < SETTLED);
        assert!(view([100.0, 110.0], 900.0).noise() > SETTLED);
        assert!(view([100.0, f64::INFINITY], 1.0).noise().is_infinite(), "not measured yet");
    }

    #[test]
    fn every_view_is_timed_in_both_halves_and_checked() {
        let mut model = cullet_scenes::build("city:cells=6,objects=100").unwrap();
        // Whether it pays or not.
        let on = Culler::balanced().with_occlusion(Occlusion::default());
        model.scene.prepare(&on);
        let spec = cullet_scenes::paths::PathSpec::Walk;
        let cameras = cullet_scenes::paths::cameras(
            &model,
            &spec,
            2,
            [320, 180],
            &cullet_scenes::paths::Overrides::default(),
        );
        let view = |c: &cullet::Camera| View::new(c, cullet::Depth::Reversed, [320, 180]).unwrap();
        let views: Vec<View> = cameras.unwrap().iter().map(view).collect();
        let off = on.without(cullet::Stage::Occlusion);
        let mut arms = [Arm::new("off", off), Arm::new("on", on)];
        let costs = Costs { opaque_triangle_ns: 10.0, draw_ns: 10.0, ..Costs::default() };
        let level = *Simd::all().last().unwrap();
        let found = measure(model.in_cells(), &views, &mut arms, &costs, level, 0.0, || true);
        assert_eq!(found, Timing { rounds: LEAST_ROUNDS, checked: true });
        for (on, off) in arms[1].views.iter().zip(&arms[0].views) {
            assert!(on.cull_ns.iter().chain(&off.cull_ns).all(|t| *t > 0.0 && t.is_finite()));
            assert!(on.triangles < off.triangles && on.draws < off.draws);
            assert_eq!(off.draw_ns, (off.triangles + off.draws) as f64 * 10.0);
        }
    }
}
