//! `cullet bench culler`: what each stage of the culler takes on a scene, view by view.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use cullet::{
    Output, Scene, Stage, ViewState, Visible,
    funnel::{Funnel, Unit},
    jobs::Rayon,
};
use cullet_cells::CellView;
use cullet_command::args::InputArgs;
use cullet_command::clock::clock;
use cullet_command::console::{Console, count, grouped, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::machine::levels;
use cullet_command::{inputs, parse};
use serde::Serialize;

use cullet_command::machine::Machine;

pub(crate) const HELP: &str = "\
Each view is culled again and again, in turns with the others so that none finds what it left behind; of every
view the fastest pass counts. The answer is held against a cull with fresh memory and without SIMD. With
--threads N of more than one, each pass is also made on so many threads, which must leave the same answer; of a
scene without cells.

Examples
  cullet bench culler city --path walk
  cullet bench culler forest:n=1000000 --path walk --views 8 --occlusion-budget 2000
  cullet bench culler model.glb --output triangles --json -";

/// `cullet bench culler`
#[derive(Debug, Args)]
pub(crate) struct CullerArgs {
    #[command(flatten)]
    input: InputArgs,
    /// How deep the answer goes
    #[arg(long, value_parser = parse::choice(OUTPUTS), default_value = "clusters")]
    output: Output,
    /// Seconds for each view
    #[arg(long, value_name = "S", default_value_t = 0.5, value_parser = parse::distance)]
    seconds: f64,
    /// Write the results as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,
}

impl CullerArgs {
    /// Puts the path that suits the scene where none was given.
    pub(crate) fn settle(&mut self) {
        self.input.settle();
    }

    /// The path that JSON is to be written to.
    pub(super) fn json(&self) -> Option<&Path> {
        self.json.as_deref()
    }
}

/// How deep the answer goes.
const OUTPUTS: &[(&str, Output, &str)] = &[
    ("instances", Output::Instances, "Whole instances"),
    ("clusters", Output::Clusters, "Instances and clusters"),
    ("triangles", Output::Triangles, "Triangles too"),
];

/// A stage in all views.
#[derive(Debug, Serialize)]
struct StageMeans {
    stage: &'static str,
    unit: &'static str,
    /// Means over the views.
    entered: f64,
    left: f64,
    ms: f64,
    /// In the view where it took longest.
    worst_ms: f64,
}

/// The work of the occlusion stage, means over the views.
#[derive(Debug, Default, Serialize)]
struct Work {
    considered: f64,
    chosen: f64,
    drawn: f64,
    tests: f64,
    choosing_ms: f64,
    drawing_ms: f64,
    testing_ms: f64,
}

#[derive(Debug, Serialize)]
struct CullerRecord<'a> {
    schema: u32,
    machine: Machine,
    scene: &'a str,
    instances: u32,
    views: usize,
    level: &'static str,
    stages: Vec<StageMeans>,
    /// All of a cull, what is between and after the stages included.
    ms: f64,
    worst_ms: f64,
    occlusion: Work,
    /// All of a cull on several threads, where that was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    on_threads: Option<OnThreads>,
    /// Whether all answers were those of a cull with fresh memory and without SIMD.
    checked: bool,
}

/// A cull of one view on several threads.
#[derive(Debug, Serialize)]
struct OnThreads {
    threads: usize,
    ms: f64,
    worst_ms: f64,
}

impl OnThreads {
    fn new(threads: usize, bests: &[Fastest]) -> Self {
        let ms = bests.iter().map(|best| best.on_threads.as_secs_f64() * 1e3);
        let worst_ms = ms.clone().fold(0.0, f64::max);
        Self { threads, ms: ms.sum::<f64>() / bests.len() as f64, worst_ms }
    }
}

/// At least so many passes over the views, whatever they take.
const LEAST_PASSES: usize = 2;

/// The fastest pass of a view.
#[derive(Debug)]
struct Fastest {
    took: Duration,
    funnel: Funnel,
    /// The same on several threads.
    on_threads: Duration,
}

/// Runs the command.
pub(crate) fn run(args: &CullerArgs, console: &Console) -> Outcome {
    let mut model = inputs::load(&args.input.scene, console)?;
    inputs::demand_levels(&model, &args.input.scene.scene, &args.input.cull)?;
    inputs::give_occluders(&mut model, &args.input.cull, console)?;
    inputs::begin(&mut model, &args.input.view, console)?;
    let views = inputs::culled_views(&model, &args.input.view, &args.input.cull, console)?;
    let mut culler = inputs::culler(&args.input.cull);
    culler.output = args.output;
    model.scene.prepare(&culler);
    let (scene, world) = (&model.scene, model.in_cells());
    let level = levels()[0].0;
    let oracle = culler.clone().with_simd(levels().last().map_or(culler.simd, |l| l.1));
    culler.clock = Some(clock);

    let (mut among, mut state, mut result) = Default::default();
    let (mut bests, mut checked): (Vec<Fastest>, bool) = (Vec::new(), true);
    let mut bar = console.progress("checking", views.len() as u64);
    for view in &views {
        if interrupted() {
            break;
        }
        CellView::cull(&mut among, world, &culler, view, &mut state, &mut result);
        let mut expected = Visible::default();
        world.cull(&oracle, view, &mut ViewState::default(), &mut expected);
        checked &= is_same(&result, &expected);
        // Memory still grows here, so this pass is never the fastest.
        bests.push(Fastest {
            took: Duration::MAX,
            funnel: result.funnel.clone(),
            on_threads: Duration::MAX,
        });
        bar.step();
    }
    bar.finish();
    let threads = args.input.view.threads;
    let pool = (threads > 1 && model.placed.is_none())
        .then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build())
        .transpose()
        .map_err(Failure::usage)?;
    let (mut own_state, mut own) = (ViewState::default(), Visible::default());
    let begin = Instant::now();
    let mut passes = 0;
    while passes < LEAST_PASSES || begin.elapsed().as_secs_f64() < args.seconds * bests.len() as f64
    {
        if interrupted() {
            break;
        }
        passes += 1;
        for (view, best) in views.iter().zip(&mut bests) {
            let start = Instant::now();
            CellView::cull(&mut among, world, &culler, view, &mut state, &mut result);
            let took = start.elapsed();
            if took < best.took {
                (best.took, best.funnel) = (took, result.funnel.clone());
            }
            if let Some(pool) = &pool {
                pool.install(|| {
                    let start = Instant::now();
                    culler.cull_one_on(&Rayon, scene, view, &mut own_state, &mut own);
                    best.on_threads = best.on_threads.min(start.elapsed());
                });
                checked &= is_same(&result, &own);
            }
        }
    }
    if passes == 0 {
        return Ok(Exit::Interrupted);
    }
    let complete = bests.len() == views.len() && !interrupted();
    let mut record = CullerRecord::new(&model.name, scene, level, &bests, checked);
    record.on_threads = pool.map(|_| OnThreads::new(threads, &bests));
    record.print(console);
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    match (checked, complete) {
        (false, _) => Ok(Exit::FalseCull),
        (true, false) => Ok(Exit::Interrupted),
        (true, true) => Ok(Exit::Fine),
    }
}

/// Whether two culls of one view agree: what is drawn, and the counts of each stage.
pub(super) fn is_same(a: &Visible, b: &Visible) -> bool {
    let counts = |v: &Visible| {
        v.funnel.rows.iter().map(|r| (r.stage, r.unit, r.entered, r.left)).collect::<Vec<_>>()
    };
    (&a.whole, &a.partial, &a.triangle_ranges) == (&b.whole, &b.partial, &b.triangle_ranges)
        && a.triangles == b.triangles
        && counts(a) == counts(b)
}

impl<'a> CullerRecord<'a> {
    fn new(
        name: &'a str,
        scene: &Scene,
        level: &'static str,
        bests: &[Fastest],
        checked: bool,
    ) -> Self {
        let views = bests.len() as f64;
        let ms = |d: Duration| d.as_secs_f64() * 1e3;
        let mut stages: Vec<(Stage, Unit, StageMeans)> = Vec::new();
        let mut work = Work::default();
        for best in bests {
            for row in &best.funnel.rows {
                let at = stages.iter().position(|s| (s.0, s.1) == (row.stage, row.unit));
                let at = at.unwrap_or_else(|| {
                    let (stage, unit) = (row.stage.name(), row.unit.name());
                    let empty =
                        StageMeans { stage, unit, entered: 0.0, left: 0.0, ms: 0.0, worst_ms: 0.0 };
                    stages.push((row.stage, row.unit, empty));
                    stages.len() - 1
                });
                let sum = &mut stages[at].2;
                let took = row.time().unwrap_or(0) as f64 * 1e-6;
                sum.entered += row.entered.of(row.unit) as f64 / views;
                sum.left += row.left.of(row.unit) as f64 / views;
                sum.ms += took / views;
                sum.worst_ms = sum.worst_ms.max(took);
            }
            let of = best.funnel.occlusion;
            work.considered += of.considered as f64 / views;
            work.chosen += of.chosen as f64 / views;
            work.drawn += of.drawn as f64 / views;
            work.tests += of.tests as f64 / views;
            let times = of.times.unwrap_or_default();
            work.choosing_ms += times.choosing as f64 * 1e-6 / views;
            work.drawing_ms += times.drawing as f64 * 1e-6 / views;
            work.testing_ms += times.testing as f64 * 1e-6 / views;
        }
        Self {
            schema: 2,
            machine: Machine::here(),
            scene: name,
            instances: scene.instance_count(),
            views: bests.len(),
            level,
            stages: stages.into_iter().map(|s| s.2).collect(),
            ms: bests.iter().map(|b| ms(b.took) / views).sum(),
            worst_ms: bests.iter().map(|b| ms(b.took)).fold(0.0, f64::max),
            occlusion: work,
            on_threads: None,
            checked,
        }
    }

    fn print(&self, console: &Console) {
        let m = &self.machine;
        let cpu = m.cpu.as_deref().unwrap_or(m.arch);
        console.line(format!(
            "{cpu}, {} (one used), {}, {}",
            count(m.threads as u64, "thread", "threads"),
            m.os,
            self.level
        ));
        console.line(format!(
            "{}: {}, means over {}",
            self.scene,
            count(u64::from(self.instances), "instance", "instances"),
            count(self.views as u64, "view", "views")
        ));
        console.line("stage       unit            entered          left        ms  worst view");
        for r in &self.stages {
            console.line(format!(
                "{:<11} {:<10} {:>12} {:>13} {:>9.3} {:>11.3}",
                r.stage,
                r.unit,
                grouped(r.entered.round() as u64),
                grouped(r.left.round() as u64),
                r.ms,
                r.worst_ms
            ));
        }
        let checked = if self.checked { "yes" } else { "NO" };
        console.line(format!(
            "{:<48} {:>9.3} {:>11.3}  checked: {checked}",
            "all", self.ms, self.worst_ms
        ));
        if let Some(OnThreads { threads, ms, worst_ms }) = &self.on_threads {
            let name = format!("on {}", count(*threads as u64, "thread", "threads"));
            let times = self.ms / ms;
            console
                .line(format!("{name:<48} {ms:>9.3} {worst_ms:>11.3}  {times:.2} times as fast"));
        }
        let w = &self.occlusion;
        if w.tests > 0.0 {
            let [considered, chosen, drawn, tests] =
                [w.considered, w.chosen, w.drawn, w.tests].map(|v| grouped(v.round() as u64));
            console.line(format!(
                "occluders: {considered} considered, {chosen} chosen, {drawn} drawn; {tests} tests"
            ));
            console.line(format!(
                "of the time of occlusion of instances: choosing {:.3} ms, drawing {:.3}, testing {:.3}",
                w.choosing_ms, w.drawing_ms, w.testing_ms
            ));
        }
    }
}
