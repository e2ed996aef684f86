//! Occlusion culling: what drawing occluders takes, what testing boxes takes, and whether it is
//! right.

mod engine;
mod measure;
mod rasteriser;
pub(super) mod report;
mod scene;
#[cfg(test)]
mod stand_in;
mod truth;

use std::path::{Path, PathBuf};

use clap::Args;
use cullet::Simd;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::machine::levels;
use cullet_command::parse;
use cullet_maps::occscn::{MAGIC, Occscn};

use super::measured::Measured;
use super::options::BenchOptions;
use super::results::Results;
use crate::occscn;
use cullet_command::machine::Machine;
use engine::{Engine, Kinds};
use measure::{Found, Passes, measure};
pub use rasteriser::{HIDDEN, OUTSIDE, VISIBLE};
pub use report::Occlusion;
use scene::Prepared;
pub use scene::view;
pub use truth::{Agreement, Reference, TOLERANCE};

/// `cullet bench occlusion --scene`
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "One scene: cullet bench occlusion --scene FILE")]
pub struct OcclusionArgs {
    /// Measure occlusion culling on this OCCSCN01 file; cullet occscn writes such files. References
    /// that lie beside it (FILE.ref1, FILE.ref4 ..., FILE.ref4j with jittered samples) are held
    /// against the answers
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    /// Pixels of the occlusion buffer
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse::size, requires = "scene")]
    resolution: [u32; 2],
    /// Write a byte for each view and object: 0 outside, 1 visible, 2 hidden
    #[arg(long, value_name = "PATH", requires = "scene")]
    answers: Option<PathBuf>,
    /// Draw the reference at N x 1280 by N x 720 samples too, and hold the answers against it
    #[arg(long, value_name = "N", requires = "scene", value_parser = clap::value_parser!(u32).range(1..=16))]
    reference: Option<u32>,
    /// Draw convex meshes by their triangles too, not by their outline
    #[arg(long, requires = "scene")]
    triangles: bool,
    /// Let triangles hide from their fronts alone; in the reference they hide from both sides
    #[arg(long, requires = "scene")]
    one_sided: bool,
    /// Pass over patches of fewer than 16 pixels a facet too, where hidden ones are passed over, and
    /// hold the answers against what is drawn then
    #[arg(long, requires = "scene")]
    thrifty: bool,
    /// The SIMD level, such as avx2 [default: the best of this machine]
    #[arg(long, value_name = "NAME", requires = "scene", value_parser = level)]
    level: Option<(&'static str, Simd)>,
    /// Measure every view N times, in each way [default: for 20 ms, and at least 3 times]
    #[arg(long, value_name = "N", requires = "scene", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    passes: Option<u32>,
}

fn level(text: &str) -> Result<(&'static str, Simd), String> {
    let levels = levels();
    levels.iter().find(|l| l.0 == text).copied().ok_or_else(|| {
        let known: Vec<&str> = levels.iter().map(|l| l.0).collect();
        format!("'{text}' is not a SIMD level of this machine; it has {}", known.join(", "))
    })
}

/// Seconds for each of five measurements of a view of a file's.
const SECONDS: f64 = 0.02;
/// The most objects of the workload's city, and objects to a building's place.
const OBJECTS: usize = 100_000;
const OBJECTS_A_CELL: f64 = 10.0;
/// Views of the workload that are held against the reference: one costs as much as measuring
/// several.
const CHECKED: usize = 2;

/// Measures a file, prints and writes what it finds.
pub(super) fn run_scene(o: &OcclusionArgs, json: Option<&Path>, console: &Console) -> Outcome {
    let Some(path) = &o.scene else { return Ok(Exit::Fine) };
    let fail = |what: String| Failure::input(format!("{}: {what}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| fail(format!("cannot be read: {e}")))?;
    let scene = Occscn::parse(&bytes).map_err(|e| {
        let advice =
            if bytes.starts_with(MAGIC) { "" } else { "; cullet occscn makes such a file" };
        fail(format!("{e}{advice}"))
    })?;
    drop(bytes);
    if scene.cameras.is_empty() {
        return Err(fail("it has no camera to measure from".into()));
    }
    let (views, objects) = (scene.cameras.len(), scene.objects.len());
    let mut references = Reference::beside(path, views, objects)?;
    let level = o.level.unwrap_or_else(|| levels()[0]);
    let kinds = Kinds { triangles: o.triangles, two_sided: !o.one_sided };
    let passes = o.passes.map_or(Passes::For(SECONDS), Passes::Count);
    let shapes = engine::shapes(&scene, kinds).map_err(|e| fail(e.message))?;
    let prepared = Prepared::new(scene, o.resolution).map_err(|e| fail(e.message))?;
    let prepared = prepared.in_pieces(engine::bounds(&shapes));
    let mut engine =
        Engine::new(&prepared, &shapes, level.1, o.resolution).map_err(|e| fail(e.message))?;
    if o.thrifty {
        engine = engine.thrifty();
    }
    let mut bar = console.progress("measuring", views as u64);
    let found = measure(&prepared, level.1, &mut engine, passes, &mut || {
        bar.step();
        !interrupted()
    });
    bar.finish();
    if let Some(n) = o.reference {
        references.retain(|r| r.samples != n || r.jittered);
        let mut bar = console.progress("drawing the reference", found.views as u64);
        let drawn = truth::drawn(&prepared.scene, &prepared.objects, found.views, n, &mut || {
            bar.step();
            !interrupted()
        })?;
        bar.finish();
        references.push(drawn);
    }
    let agreements: Vec<_> = references.iter().map(|r| r.judge(&found.answers)).collect();
    let name = path.file_stem().map_or_else(Default::default, |n| n.to_string_lossy());
    let mut results = Vec::new();
    let streaming = report::streaming(&prepared, level.1);
    let right = agreements.iter().all(|v| v.false_culls == 0);
    // Without a reference nothing was held against anything.
    let checked = right && !agreements.is_empty();
    report::measured(&name, level.0, &prepared, &found, &streaming, checked, &mut |m| {
        results.push(m);
    });
    let occlusion = Occlusion::new(level.0, o.resolution, &found, agreements, &streaming);
    if let Some(out) = &o.answers {
        std::fs::write(out, &found.answers).map_err(|e| Failure::write(out, &e))?;
    }
    report::print(&path.display().to_string(), &prepared, &occlusion, console);
    if let Some(out) = json {
        let machine = Machine::here();
        write_json(out, &Results { schema: 1, machine, results, occlusion: Some(occlusion) })?;
    }
    match (right, found.views == views) {
        (false, _) => Ok(Exit::FalseCull),
        (true, true) => Ok(Exit::Fine),
        (true, false) => {
            console.note(format!("stopped after {} of {views} views", found.views));
            Ok(Exit::Interrupted)
        }
    }
}

/// The workload: a city made here, at each level. Answers of all levels must be equal, and hide
/// nothing that the reference sees. Returns what the best level found.
pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) -> Option<Occlusion> {
    let objects = options.sizes.iter().copied().max().unwrap_or(0).min(OBJECTS);
    let cells = (objects as f64 / OBJECTS_A_CELL).sqrt().ceil().max(1.0);
    let name = format!("occlusion/city/{}", report::power(objects));
    if !report::names(&name).iter().any(|n| options.wants(n)) {
        return None;
    }
    let text = format!("city:ground=0,cells={cells},objects={objects}");
    let model = cullet_scenes::build(&text).ok()?;
    let size = [1280, 720];
    let scene = occscn::of_model(&model).ok()?;
    let shapes = engine::shapes(&scene, Kinds::default()).ok()?;
    let prepared = Prepared::new(scene, size).ok()?.in_pieces(engine::bounds(&shapes));
    let passes = Passes::For(options.seconds / prepared.views.len() as f64);
    let truth = truth::drawn(&prepared.scene, &prepared.objects, CHECKED, 1, &mut || true).ok()?;
    let mut best: Option<(Found, Occlusion)> = None;
    for (level_name, level) in levels() {
        let mut engine = Engine::new(&prepared, &shapes, level, size).ok()?;
        let found = measure(&prepared, level, &mut engine, passes, &mut || true);
        let agreement = truth.judge(&found.answers);
        let alike = best.as_ref().is_none_or(|(b, _)| b.answers == found.answers);
        let streaming = report::streaming(&prepared, level);
        let right = alike && agreement.false_culls == 0 && agreement.found > 0;
        report::measured(&name, level_name, &prepared, &found, &streaming, right, &mut |m| {
            if options.wants(&m.name) {
                each(m);
            }
        });
        if best.is_none() {
            let occlusion = Occlusion::new(level_name, size, &found, vec![agreement], &streaming);
            best = Some((found, occlusion));
        }
    }
    best.map(|b| b.1)
}

#[cfg(test)]
mod tests {
    use super::measure::MODES;
    use super::rasteriser::{HIDDEN, OUTSIDE, Rasteriser, VISIBLE};
    use super::scene::Scratch;
    use super::stand_in::StandIn;
    use super::*;

    const SIZE: [u32; 2] = [160, 90];
    const VIEWS: usize = 3;

    fn prepared() -> Prepared {
        let model = cullet_scenes::build("city:ground=0,cells=6,objects=200").unwrap();
        let mut scene = occscn::of_model(&model).unwrap();
        scene.cameras.truncate(VIEWS);
        Prepared::new(scene, SIZE).unwrap()
    }

    fn found(prepared: &Prepared, rasteriser: &mut dyn Rasteriser) -> Found {
        measure(prepared, Simd::best(), rasteriser, Passes::Count(2), &mut || true)
    }

    fn truth(prepared: &Prepared) -> Reference {
        truth::drawn(&prepared.scene, &prepared.objects, VIEWS, 1, &mut || true).unwrap()
    }

    #[test]
    fn counts_are_those_of_the_answers() {
        let prepared = prepared();
        let found = found(&prepared, &mut StandIn::new(&prepared.scene));
        assert_eq!((found.views, found.answers.len()), (VIEWS, VIEWS * 200));
        let count = |a: u8| found.answers.iter().filter(|&&x| x == a).count() as f64;
        let sum = |mean: f64| (mean * VIEWS as f64).round();
        let t = &found.test;
        assert_eq!(count(HIDDEN) + count(VISIBLE) + count(OUTSIDE), 600.0);
        assert_eq!((sum(t.culled), sum(t.visible)), (count(HIDDEN), count(VISIBLE)));
        assert_eq!(sum(t.in_frustum), count(HIDDEN) + count(VISIBLE));
        assert!(t.ns_per_object > 0.0 && t.all_ms > 0.0);
        let [raw, sorted, interleaved] = found.modes;
        assert_eq!([raw.name, sorted.name, interleaved.name], MODES);
        assert_eq!((raw.triangles, raw.pieces, raw.prepare_ms), (432.0, 36.0, 0.0));
        assert!(sorted.triangles < raw.triangles && sorted.prepare_ms > 0.0);
        assert_eq!(interleaved.triangles, sorted.triangles);
        assert!(interleaved.pieces <= sorted.pieces && sorted.pieces < raw.pieces);
        assert_eq!(sorted.triangles, sorted.pieces * 12.0);
        assert!(sorted.median_ms >= sorted.render_ms && sorted.render_ms > 0.0);
    }

    #[test]
    fn the_reference_tells_wrong_from_right() {
        let prepared = prepared();
        let truth = truth(&prepared);
        let mut stand_in = StandIn::new(&prepared.scene);
        let right = truth.judge(&found(&prepared, &mut stand_in).answers);
        assert_eq!(right.false_culls, 0);
        assert!(right.found > 0 && right.visible > 0, "{right:?}");
        stand_in.reckless = true;
        let wrong = truth.judge(&found(&prepared, &mut stand_in).answers);
        assert!(wrong.false_culls > 0 && wrong.efficiency > right.efficiency, "{wrong:?}");
    }

    #[test]
    fn the_engine_is_right_at_each_level_and_finds_more_than_a_stand_in() {
        let prepared = prepared();
        let truth = truth(&prepared);
        let least = truth.judge(&found(&prepared, &mut StandIn::new(&prepared.scene)).answers);
        for kinds in [
            Kinds::default(),
            Kinds { triangles: true, two_sided: false },
            Kinds { triangles: true, two_sided: true },
        ] {
            let mut first = None;
            let shapes = engine::shapes(&prepared.scene, kinds).unwrap();
            let prepared = self::prepared().in_pieces(engine::bounds(&shapes));
            for (name, level) in levels() {
                let mut engine = Engine::new(&prepared, &shapes, level, SIZE).unwrap();
                let found = measure(&prepared, level, &mut engine, Passes::Count(1), &mut || true);
                let agreement = truth.judge(&found.answers);
                assert_eq!(agreement.false_culls, 0, "{kinds:?} at {name}");
                assert!(
                    agreement.found >= least.found,
                    "{kinds:?} at {name}: {agreement:?}, {least:?}"
                );
                let first = first.get_or_insert_with(|| found.answers.clone());
                assert_eq!(*first, found.answers, "{kinds:?} at {name}");
            }
        }
    }

    #[test]
    fn pieces_come_nearest_first() {
        let prepared = prepared();
        let mut scratch = Scratch::default();
        for view in 0..VIEWS {
            prepared.sorted(Simd::best(), view, &mut scratch);
            let eye = prepared.scene.cameras[view].eye;
            let distance = |&m: &u32| {
                let b = prepared.pieces.boxes.get(m as usize);
                (0..3).map(|k| (b.min[k] - eye[k]).max(eye[k] - b.max[k]).max(0.0).powi(2)).sum()
            };
            let distances: Vec<f32> = scratch.pieces.iter().map(distance).collect();
            assert!(distances.len() > 1 && distances.is_sorted(), "{distances:?}");
        }
    }

    #[test]
    fn a_stop_leaves_what_was_measured() {
        let prepared = prepared();
        let mut rasteriser = StandIn::new(&prepared.scene);
        let found =
            measure(&prepared, Simd::best(), &mut rasteriser, Passes::Count(1), &mut || false);
        assert_eq!((found.views, found.answers.len()), (1, 200));
    }
}
