//! `cullet bench lod --scenes`: what levels of detail and small-object culling leave of scenes,
//! beside what is to be reached.

use std::path::{Path, PathBuf};
use std::time::Instant;

use cullet::cull::detail::Detail;
use cullet::lod::Lod;
use cullet::{
    Camera, Culler, Depth, Output, Projection, Scene, Stage, View, ViewState, Visible, funnel::Unit,
};
use cullet_command::args::SceneArgs;
use cullet_command::clock::clock;
use cullet_command::console::{Console, digits, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_draw::{RenderOptions, Selection, render};
use cullet_io::Model;
use cullet_scenes::paths::{self, PathSpec};
use glam::DVec3;
use serde::Serialize;

use super::measured::{Measured, Yardstick};
use super::options::BenchOptions;
use cullet_cli::levels::{Wanted, load_with};
use cullet_command::machine::Machine;
use cullet_draw::Meter;

/// Pixels of every view.
const SIZE: [u32; 2] = [1280, 720];
/// Views of each row.
const VIEWS: usize = 4;
/// Random points of a view from which deviations are measured, each way.
const POINTS: usize = 200_000;
/// The threshold of small-object culling, in pixels.
const SMALL_PX: f64 = 2.0;

/// One figure.
#[derive(Clone, Debug, Serialize)]
struct Row {
    scene: String,
    what: &'static str,
    value: f64,
    goal: f64,
    /// How far 99.9 % of the points are off, and all, in pixels; where levels were drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    off_px: Option<[f64; 2]>,
    /// Whether the threshold of a pixel was kept, where it was measured, and the answer was right,
    /// where that was.
    kept: bool,
}

#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    machine: Machine,
    rows: Vec<Row>,
    complete: bool,
}

/// Runs the command. Ends with exit code 1 where a bound is not kept; goals that are missed are
/// figures, not errors.
pub(super) fn run(json: Option<&Path>, console: &Console) -> Outcome {
    console.line("scene        what                                             value     goal    off, 99.9 %      all");
    let mut rows = Vec::new();
    let mut add = |row: Row| {
        let off = row.off_px.map_or_else(String::new, |[most, all]| {
            let kept = if row.kept { "kept" } else { "NOT KEPT" };
            format!("{most:>12.3} px {all:>8.3} px  {kept}")
        });
        let wrong = if row.off_px.is_none() && !row.kept { "  WRONG ANSWER" } else { "" };
        console.line(format!(
            "{:<12} {:<44} {:>9} {:>8} {off}{wrong}",
            row.scene,
            row.what,
            digits(row.value),
            digits(row.goal)
        ));
        rows.push(row);
    };
    castle(console, &mut add)?;
    for (scene, path, what) in [
        (
            "city",
            PathSpec::Orbit,
            [
                "from above: triangles left over visible, 1 px",
                "the same, and nothing below a pixel",
            ],
        ),
        (
            "plant",
            PathSpec::Walk,
            ["on a walk: triangles left over visible, 1 px", "the same, and nothing below a pixel"],
        ),
    ] {
        if !interrupted() {
            over_visible(scene, &path, what, &load_with, console, &mut add)?;
        }
    }
    if !interrupted() {
        small("forest:n=1000000", console, &mut add)?;
        sweep(&mut add);
    }
    let complete = !interrupted();
    let all_kept = rows.iter().all(|row| row.kept);
    if let Some(path) = json {
        write_json(path, &Record { schema: 1, machine: Machine::here(), rows, complete })?;
    }
    Ok(match (all_kept, complete) {
        (false, _) => Exit::FalseCull,
        (true, false) => Exit::Interrupted,
        (true, true) => Exit::Fine,
    })
}

/// The levels of a pixel.
fn one_pixel() -> Lod {
    Lod::default()
}

/// The worse of what was found before and in one more view.
fn worse([p999, all]: [f64; 2], model: &Scene, view: &View, shown: [&Visible; 2]) -> [f64; 2] {
    let found =
        Meter { points: POINTS, seed: 1 }.measure(model, view, &one_pixel(), shown[0], shown[1]);
    [p999.max(found.p999_px), all.max(found.max_px)]
}

fn is_kept([p999_px, max_px]: [f64; 2]) -> bool {
    cullet_draw::Measured { p999_px, max_px, ..Default::default() }.keeps(one_pixel().pixels)
}

/// The castle, if it is there: triangles that levels choose of all its instances, over all their
/// triangles; by themselves, and with its instances merged in groups.
fn castle(console: &Console, add: &mut impl FnMut(Row)) -> Result<(), Failure> {
    let set = std::env::var_os("CULLET_DATA").filter(|v| !v.is_empty()).map(PathBuf::from);
    let folder = set.unwrap_or_else(|| "../shared/data".into());
    let path = folder.join("intel-castle/intel-castle.glb");
    if !path.is_file() {
        console.note(format!("{} is not there: no rows of the castle", path.display()));
        return Ok(());
    }
    let path = SceneArgs::of(path.to_string_lossy());
    for (wanted, what) in [
        (
            Wanted::Levels,
            [
                "from its middle: triangles over all, 1 px",
                "from two radii: triangles over all, 1 px",
            ],
        ),
        (
            Wanted::Groups,
            ["the same, instances merged in groups", "from two radii, merged in groups"],
        ),
    ] {
        castle_with(&load_with(&path, wanted, console)?.scene, what, add)?;
    }
    Ok(())
}

fn castle_with(
    scene: &Scene,
    what: [&'static str; 2],
    add: &mut impl FnMut(Row),
) -> Result<(), Failure> {
    let culler = Culler::balanced().with_lod(one_pixel()).with_output(Output::Triangles);
    let culler = culler.only(Stage::Lod);
    let extent = scene.extent();
    let middle = DVec3::from(extent.center()) + DVec3::from(scene.origin());
    let radius = DVec3::from(extent.half_extent()).length();
    for (radii, what, goal) in [(0.0, what[0], 0.5), (2.0, what[1], 1.0 / 3.0)] {
        let (mut drawn, mut all, mut off) = (0, 0, [0.0; 2]);
        for direction in around(VIEWS) {
            if interrupted() {
                return Ok(());
            }
            let eye = middle + direction * (radius * radii);
            let target = if radii > 0.0 { middle } else { middle + direction };
            let view = view(eye, target, radius * 1e-4).map_err(Failure::input)?;
            let mut cut = Visible::default();
            culler.cull_one(scene, &view, &mut ViewState::default(), &mut cut);
            drawn += cut.triangle_count;
            all += scene.triangle_count();
            off = worse(off, scene, &view, [&cut, &cut]);
        }
        let value = drawn as f64 / all as f64;
        let kept = is_kept(off);
        add(Row { scene: "castle".into(), what, value, goal, off_px: Some(off), kept });
    }
    Ok(())
}

/// Directions around the upright, all a little from above.
fn around(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let (sin, cos) = ((i as f64 + 0.3) / count as f64 * std::f64::consts::TAU).sin_cos();
        DVec3::new(cos, 0.2, sin).normalize()
    })
}

fn view(eye: DVec3, target: DVec3, near: f64) -> Result<View, cullet::view::ViewError> {
    let projection = Projection::Perspective {
        fov_y_radians: std::f64::consts::FRAC_PI_3,
        aspect: f64::from(SIZE[0]) / f64::from(SIZE[1]),
        near,
        far: f64::INFINITY,
    };
    View::new(&Camera::look_at(eye, target, projection), Depth::Reversed, SIZE)
}

/// Loads a scene with levels of detail.
type Load<'a> = &'a dyn Fn(&SceneArgs, Wanted, &Console) -> Result<Model, Failure>;

/// Measures what the engine's own preset leaves with levels, relative to the triangles that own a
/// pixel where all is drawn in full; and what is left of it where small objects go as well.
fn over_visible(
    scene: &str,
    path: &PathSpec,
    what: [&'static str; 2],
    load: Load<'_>,
    console: &Console,
    add: &mut impl FnMut(Row),
) -> Result<(), Failure> {
    let mut model = load(&SceneArgs::of(scene), Wanted::Levels, console)?;
    let culler = Culler::balanced().with_lod(one_pixel()).with_output(Output::Triangles);
    let detail = Some(Detail::default().with_threshold_px(one_pixel().pixels));
    let without_small = culler.clone().with_detail(detail);
    model.scene.prepare(&culler);
    let scene_name = scene.to_owned();
    let scene = &model.scene;
    let (mut left, mut visible, mut off) = ([0; 2], 0, [0.0; 2]);
    let mut progress = console.progress("views", VIEWS as u64);
    for view in along(&model, path)? {
        if interrupted() {
            break;
        }
        let mut state = ViewState::default();
        let (mut drawn, mut cut) = (Visible::default(), Visible::default());
        culler.cull_one(scene, &view, &mut state, &mut drawn);
        culler.only(Stage::Lod).cull_one(scene, &view, &mut ViewState::default(), &mut cut);
        left[0] += drawn.triangle_count;
        let frame = render(scene, &view, Selection::All, &RenderOptions::default());
        visible += frame.visible().len() as u64;
        off = worse(off, scene, &view, [&cut, &drawn]);
        without_small.cull_one(scene, &view, &mut state, &mut drawn);
        left[1] += drawn.triangle_count;
        progress.step();
    }
    progress.finish();
    let row = |what, left: u64, off_px: Option<[f64; 2]>| Row {
        scene: scene_name.clone(),
        what,
        value: left as f64 / visible.max(1) as f64,
        goal: 3.0,
        off_px,
        kept: off_px.is_none_or(is_kept),
    };
    add(row(what[0], left[0], Some(off)));
    // What is below a pixel is left out, which is no deviation of levels: nothing to be kept.
    add(row(what[1], left[1], None));
    Ok(())
}

/// Views along a path.
fn along(model: &Model, path: &PathSpec) -> Result<Vec<View>, Failure> {
    let overrides = paths::Overrides::default();
    let cameras = paths::cameras(model, path, VIEWS, SIZE, &overrides).map_err(Failure::input)?;
    let view = |camera| View::new(camera, overrides.depth, SIZE).map_err(Failure::input);
    cameras.iter().map(view).collect()
}

/// Times of the small-object stage and of the whole cull of many instances seen from above: the
/// means of the fastest passes of all views.
fn small(name: &str, console: &Console, add: &mut impl FnMut(Row)) -> Result<(), Failure> {
    const PASSES: usize = 24;
    let mut model = cullet_command::inputs::load(&SceneArgs::of(name), &Console::new(true, None))?;
    let detail = Some(Detail::default().with_threshold_px(SMALL_PX));
    let culler = Culler::balanced().with_detail(detail).with_clock(Some(clock));
    model.scene.prepare(&culler);
    let scene = &model.scene;
    let views = along(&model, &PathSpec::Orbit)?;
    let mut progress = console.progress("views", views.len() as u64);
    let (mut stage_ms, mut all_ms, mut right) = (0.0, 0.0, true);
    for view in &views {
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        let mut best = [f64::INFINITY; 2];
        for _ in 0..PASSES {
            let begin = Instant::now();
            culler.cull_one(scene, view, &mut state, &mut result);
            best[1] = best[1].min(begin.elapsed().as_secs_f64() * 1e3);
            let own = result
                .funnel
                .rows
                .iter()
                .find(|row| (row.stage, row.unit) == (Stage::Detail, Unit::Instances));
            let took = own.and_then(cullet::funnel::FunnelRow::time).unwrap_or(0);
            best[0] = best[0].min(took as f64 * 1e-6);
        }
        let level = cullet_command::machine::levels().last().map_or(culler.simd, |l| l.1);
        let mut expected = Visible::default();
        let plain = culler.clone().with_simd(level).with_clock(None);
        plain.cull_one(scene, view, &mut ViewState::default(), &mut expected);
        right &= super::culler::is_same(&result, &expected);
        stage_ms += best[0] / views.len() as f64;
        all_ms += best[1] / views.len() as f64;
        progress.step();
        if interrupted() {
            break;
        }
    }
    progress.finish();
    let row = |what, value, goal| Row {
        scene: "forest, 1e6".into(),
        what,
        value,
        goal,
        off_px: None,
        kept: right,
    };
    add(row("from above: small-object stage at 2 px, ms", stage_ms, 0.3));
    add(row("from above: the whole cull, ms", all_ms, 2.0));
    Ok(())
}

/// Times of choosing by a sweep over groups, in the cache and from memory.
fn sweep(add: &mut impl FnMut(Row)) {
    let options = BenchOptions {
        filter: Some("lod/far".to_owned()),
        tree_sizes: vec![16_384, 4_194_304],
        ..BenchOptions::default()
    };
    let mut found: Vec<Measured> = Vec::new();
    let best = cullet::Simd::best().name();
    super::lod::run(&options, &mut |measured| found.push(measured));
    let of_best: Vec<&Measured> = found.iter().filter(|m| m.level == best).collect();
    let [small, large] = of_best[..] else { return };
    let row = |what, value, goal, m: &Measured| Row {
        scene: "groups".into(),
        what,
        value,
        goal,
        off_px: None,
        kept: m.checked,
    };
    add(row("choosing, in the cache: ns a group", small.ns_per_item, 0.5, small));
    if let Yardstick::Streaming { limit_ratio, .. } = large.yardstick {
        add(row("choosing, from memory: times reading", limit_ratio, 1.3, large));
    }
}

#[cfg(test)]
mod tests {
    use cullet::{Instance, Transform};
    use cullet_testkit::steps::Balls;

    use super::*;

    /// Levels that state so many times their true error, in place of the baker's.
    fn balls(honesty: f64) -> Model {
        let mut scene = Scene::new();
        let mesh = Balls::new(&[64, 32, 16, 8], honesty).add_to(&mut scene);
        for x in 0..6 {
            let place = Transform::from_translation([3.0 * f64::from(x), 0.0, -20.0]);
            scene.add(Instance::new(mesh, place)).unwrap();
        }
        scene.commit(&Culler::default());
        Model { scene, ..Model::default() }
    }

    #[test]
    fn a_bound_that_is_not_kept_is_found() {
        let console = Console::new(true, None);
        for (honesty, kept) in [(1.0, true), (0.2, false)] {
            let load = |_: &SceneArgs, _, _: &Console| Ok(balls(honesty));
            let mut rows = Vec::new();
            let mut add = |row| rows.push(row);
            over_visible("balls", &PathSpec::Orbit, ["", ""], &load, &console, &mut add).unwrap();
            let [row, without_small] = &rows[..] else { panic!("{rows:?}") };
            assert!(without_small.kept && without_small.value <= row.value, "{rows:?}");
            let off = row.off_px.unwrap();
            assert_eq!(row.kept, kept, "{honesty}: {off:?}");
            assert!(off[1] > 0.05 && row.value > 0.0, "{row:?}");
        }
    }

    #[test]
    fn rows_of_the_sweep_and_of_small_instances_are_checked() {
        let mut rows = Vec::new();
        let console = Console::new(true, None);
        small("forest:n=3000", &console, &mut |row| rows.push(row)).unwrap();
        assert_eq!(rows.len(), 2);
        assert!(rows.iter().all(|row| row.kept && row.value > 0.0), "{rows:?}");
        assert!(rows[0].value < rows[1].value, "{rows:?}");
    }
}
