//! The pipeline of one view: the list of stages, in the order in which they run.
//!
//! Three working sets pass from stage to stage, each made of what is left of the one before:
//! instances are bits in words of 64 slots; those become runs of clusters, and those a list of
//! triangles. A stage goes over all of a set before the next begins, cheapest test first, so that
//! its time and its counts are its own.

use super::Culler;
use super::answer;
use super::frame::{Alone, Frame, Viewer};
use super::log::Log;
use super::sets::Sets;
use super::stage::{backface, candidates, degenerate, detail, frustum, layer, lod, occlusion};
use crate::funnel::{Stage, Unit};
use crate::jobs::Jobs;
use crate::scene::Scene;
use crate::visible::Visible;

/// A stage at work on one of the sets.
struct Step {
    stage: Stage,
    unit: Unit,
    /// Whether this step makes the set of its unit of what the one before left. Then it also runs
    /// where its stage is off, and takes everything.
    opens: bool,
    run: Run,
}

type Run = fn(&Frame<'_>, &mut Caches, &mut Sets, &mut Log<'_>);

const fn opens(stage: Stage, unit: Unit, run: Run) -> Step {
    Step { opens: true, ..then(stage, unit, run) }
}

const fn then(stage: Stage, unit: Unit, run: Run) -> Step {
    // What no answer goes as deep as is not linked.
    let is_on = cfg!(feature = "clusters") || matches!(unit, Unit::Instances);
    Step { stage, unit, opens: false, run: if is_on { run } else { |_, _, _, _| {} } }
}

/// The one list of what runs when. A step is left out where its stage is off, and where the answer
/// does not go as deep as its unit.
const PIPELINE: [Step; 16] = [
    then(Stage::Layer, Unit::Instances, |f, _, _, log| {
        layer::instances(f, log);
    }),
    opens(Stage::Frustum, Unit::Instances, |f, c, s, log| {
        frustum::instances(f, &mut c.frustum, &mut s.instances, log);
    }),
    then(Stage::Pvs, Unit::Instances, |f, _, s, log| {
        candidates::instances(f, Stage::Pvs, &mut s.instances, log);
    }),
    then(Stage::Portal, Unit::Instances, |f, _, s, log| {
        candidates::instances(f, Stage::Portal, &mut s.instances, log);
    }),
    then(Stage::Detail, Unit::Instances, |f, _, s, log| {
        detail::instances(f, &mut s.instances, log);
    }),
    then(Stage::Degenerate, Unit::Instances, |f, _, s, log| {
        degenerate::instances(f, &mut s.instances, log);
    }),
    then(Stage::Lod, Unit::Instances, |f, c, s, log| {
        lod::instances(f, &mut c.lod, &mut s.instances, &mut s.coarse, log);
    }),
    then(Stage::Occlusion, Unit::Instances, |f, c, s, log| {
        occlusion::instances(f, &mut c.occlusion, &mut s.instances, &mut s.coarse, log);
    }),
    opens(Stage::Frustum, Unit::Clusters, |f, c, s, log| {
        frustum::clusters(f, &mut c.frustum, &c.occlusion, s, log);
    }),
    then(Stage::Portal, Unit::Clusters, |f, c, s, log| {
        candidates::clusters(f, &mut c.candidates, &mut s.clusters, log);
    }),
    then(Stage::Detail, Unit::Clusters, |f, c, s, log| {
        detail::clusters(f, &c.occlusion, &mut s.clusters, log);
    }),
    then(Stage::Occlusion, Unit::Clusters, |f, c, s, log| {
        occlusion::clusters(f, &c.occlusion, &mut s.clusters, log);
    }),
    then(Stage::Backface, Unit::Clusters, |f, c, s, log| {
        backface::clusters(f, &mut c.backface, &mut s.clusters, log);
    }),
    opens(Stage::Frustum, Unit::Triangles, |f, _, s, log| {
        frustum::triangles(f, s, log);
    }),
    then(Stage::Backface, Unit::Triangles, |f, c, s, log| {
        backface::triangles(f, &mut c.backface, s, log);
    }),
    then(Stage::Degenerate, Unit::Triangles, |f, _, s, log| {
        degenerate::triangles(f, s, log);
    }),
];

/// State that stages keep between frames: memory, and results proved in the last one.
#[derive(Clone, Debug, Default)]
pub(super) struct Caches {
    frustum: frustum::Cache,
    candidates: candidates::Cache,
    pub(super) occlusion: occlusion::Cache,
    pub(super) lod: lod::Cache,
    backface: backface::Cache,
}

/// Memory that the culls of one view use again and again, and what was proved of its last frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    sets: Sets,
    pub(super) caches: Caches,
}

/// Culls for a camera or a light, on the threads of `jobs`; with `only`, one instance alone, by what the scratch has of the
/// whole scene.
pub(super) fn run(
    (culler, jobs): (&Culler, &dyn Jobs),
    scene: &Scene,
    viewer: Viewer<'_>,
    only: Option<Alone<'_>>,
    scratch: &mut Scratch,
    result: &mut Visible,
) {
    let culler = &*viewer.settings(culler);
    let mut frame = Frame::new(culler, scene, viewer, only);
    frame.jobs = jobs;
    let Scratch { sets, caches } = scratch;
    sets.triangles.swap_with(result);
    sets.clear();
    let mut log = Log::new(&frame, result);
    let depth = culler.output.unit();
    for step in &PIPELINE {
        if step.unit <= depth && (step.opens || culler.runs(step.stage)) {
            (step.run)(&frame, caches, sets, &mut log);
        }
    }
    if depth < Unit::Triangles && culler.runs(Stage::Degenerate) {
        degenerate::of_the_rest(&frame, sets, &mut log);
    }
    let work = log.finish();
    sets.triangles.swap_with(result);
    answer::write(&frame, sets, work, result);
    result.lod_pixels = caches.lod.pixels.filter(|_| culler.lod_settings().is_some());
}
