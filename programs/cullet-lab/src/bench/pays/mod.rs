//! `cullet bench pays`: whether occlusion culling gives back what it takes, scene by scene and view
//! by view.

mod record;
mod rounds;
mod scenes;

use std::path::{Path, PathBuf};

use clap::Args;
use cullet::{Culler, Stage, View, costs::Costs};
use cullet_command::args::{CullArgs, PRESETS, ViewArgs};
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::{inputs, parse};
use cullet_io::Model;

use cullet_command::machine::{Machine, levels};
use cullet_command::stored_costs::Stored;
use record::{Record, Row};
use rounds::Arm;

pub(crate) const HELP: &str = "\
Culls each view of a walk with occlusion and without, and adds what drawing the rest costs: its triangles and
draws at the costs of cullet calibrate, or at --triangle-ns and --draw-ns. The ratio of the sums says whether
occlusion pays. Settings take turns in rounds; times are those of the thread, not of the clock on the wall, and
of each view the fastest counts. Rounds fall into two halves, which go on until they agree to half a per cent of
cull and draw or --seconds are over: *noise* is by how much they differ, and *sure* is the ratio in the half where it
is lower, so that a view counts as slower only if each half found it slower. *even* is the cost of a triangle from
which occlusion pays over all views. Every answer is held against a cull with fresh memory and without SIMD.

Examples
  cullet bench pays                                  every built-in scene and every model of CULLET_DATA
  cullet bench pays --most-slower 3                  for CI: exit code 5 if any view is slower by over 3 %
  cullet bench pays city model.glb --triangle-ns 5   these two, for a renderer of 5 ns a triangle
  cullet bench pays --presets                        exact, balanced and fast, each against no occlusion";

/// `cullet bench pays`
#[derive(Debug, Args)]
pub(crate) struct PaysArgs {
    /// Scenes: files or built-in ones [default: every built-in one, and every model below --data]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Folder of the models [default: `CULLET_DATA`, else ../shared/data]
    #[arg(long, value_name = "FOLDER", conflicts_with = "scenes")]
    data: Option<PathBuf>,
    /// Pixels of a view
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse::size)]
    size: [u32; 2],
    /// How many views along the path
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    views: u32,
    /// Where from: as of cullet report
    #[arg(long, value_name = "PATH", default_value = "walk")]
    path: String,
    /// Costs that `cullet calibrate --out` wrote [default: those that `cullet calibrate` kept]
    #[arg(long, value_name = "FILE")]
    costs: Option<PathBuf>,
    /// Cost of a triangle in your renderer, in nanoseconds [default: the calibrated one]
    #[arg(long, value_name = "NS", value_parser = parse::nanoseconds)]
    triangle_ns: Option<f64>,
    /// Cost of a draw in your renderer, in nanoseconds [default: the calibrated one, else that of a
    /// triangle]
    #[arg(long, value_name = "NS", value_parser = parse::nanoseconds)]
    draw_ns: Option<f64>,
    /// The most seconds for the rounds of a scene
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = parse::distance)]
    seconds: f64,
    /// Measure every preset
    #[arg(long, conflicts_with_all = ["preset", "only", "no_occlusion", "occlusion_width", "occlusion_budget", "detail"])]
    presets: bool,
    /// End with exit code 5 if a view is slower by more per cent
    #[arg(long, value_name = "PERCENT", value_parser = parse::pixels)]
    most_slower: Option<f64>,
    /// Write the results as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,
    #[command(flatten)]
    cull: CullArgs,
}

impl PaysArgs {
    /// The path that JSON is to be written to.
    pub(super) fn json(&self) -> Option<&Path> {
        self.json.as_deref()
    }

    /// Returns the cullers to measure: first without occlusion, then with.
    fn cullers(&self) -> Result<Vec<(&'static str, Culler)>, Failure> {
        let on: Vec<(&str, Culler)> = if self.presets {
            PRESETS.iter().map(|(name, preset, _)| (*name, preset.culler())).collect()
        } else {
            let mut on = inputs::culler(&self.cull);
            if let Some(occlusion) = &mut on.occlusion {
                let preset = self.cull.preset.culler().occlusion.and_then(|o| o.risk);
                occlusion.risk = self.cull.occlusion_risk.or(preset);
            }
            vec![("on", on)]
        };
        if on.iter().any(|c| c.1.occlusion.is_none()) {
            return Err(Failure::usage(
                "without occlusion there is nothing to compare; leave out --no-occlusion and --only",
            ));
        }
        let base = if self.presets { Culler::balanced() } else { on[0].1.clone() };
        Ok([("off", base.without(Stage::Occlusion))].into_iter().chain(on).collect())
    }

    /// The costs of a triangle and a draw, and whose they are.
    fn costs(&self, console: &Console) -> Result<(Costs, String), Failure> {
        let stored = Stored::find(self.costs.as_deref(), console, "costs must be given")?;
        let Some(triangle_ns) =
            self.triangle_ns.or(stored.as_ref().map(|s| s.1.costs().opaque_triangle_ns))
        else {
            return Err(Failure::input(
                "what a triangle costs is not known; `cullet calibrate` measures it for the reference renderer, and \
                 --triangle-ns 5 says it of another",
            ));
        };
        let draw_ns = self.draw_ns.or(stored.as_ref().map(|s| s.1.costs().draw_ns));
        let draw_ns = draw_ns.unwrap_or(triangle_ns);
        let costs = Costs { opaque_triangle_ns: triangle_ns, draw_ns, ..Costs::default() };
        let source = match (self.triangle_ns, &stored) {
            (None, Some((path, stored))) => {
                format!("{}, {}, {}", path.display(), stored.renderer, stored.date)
            }
            _ => "as given".to_owned(),
        };
        Ok((costs, source))
    }

    fn view_args(&self) -> ViewArgs {
        ViewArgs {
            size: self.size,
            views: self.views,
            path: self.path.clone(),
            eye: None,
            target: None,
            fov: None,
            near: None,
            far: None,
            time: None,
            seed: 1,
            threads: 1,
        }
    }

    /// Loads a scene and makes its views.
    fn load(&self, scene: &str) -> Result<(Model, Vec<View>), Failure> {
        let quiet = Console::new(true, None);
        let mut model = inputs::load(&scenes::args(scene), &quiet)?;
        inputs::demand_levels(&model, scene, &self.cull)?;
        inputs::give_occluders(&mut model, &self.cull, &quiet)?;
        let views = inputs::culled_views(&model, &self.view_args(), &self.cull, &quiet)?;
        Ok((model, views))
    }
}

/// Runs the command.
pub(crate) fn run(args: &PaysArgs, console: &Console) -> Outcome {
    let mut cullers = args.cullers()?;
    let (costs, source) = args.costs(console)?;
    cullers.iter_mut().for_each(|(_, culler)| culler.costs = costs);
    let is_named = !args.scenes.is_empty();
    let names = match is_named {
        true => args.scenes.clone(),
        false => scenes::all(&scenes::folder(args.data.as_deref())),
    };
    if cfg!(debug_assertions) {
        console.note("warning: this build has debug assertions, which make its times its own");
    }
    let mut record = Record {
        schema: 1,
        machine: Machine::here(),
        triangle_ns: costs.opaque_triangle_ns,
        draw_ns: costs.draw_ns,
        size: args.size,
        path: args.path.clone(),
        rows: Vec::new(),
        skipped: Vec::new(),
    };
    record.begin(console, &source);
    let all_levels = levels();
    let oracle = all_levels[all_levels.len() - 1].1;
    for name in &names {
        if interrupted() {
            break;
        }
        let (mut model, views) = match args.load(name) {
            Ok(loaded) => loaded,
            Err(failure) if is_named => return Err(failure),
            Err(failure) => {
                record.skipped.push(failure.message);
                continue;
            }
        };
        let mut arms: Vec<Arm> =
            cullers.iter().map(|(name, culler)| Arm::new(name, culler.clone())).collect();
        for (_, culler) in &cullers {
            model.scene.prepare(culler);
        }
        let (world, seconds) = (model.in_cells(), args.seconds);
        let measured =
            rounds::measure(world, &views, &mut arms, &costs, oracle, seconds, || !interrupted());
        let triangles_a_draw = costs.draw_ns / costs.opaque_triangle_ns;
        if let ([off], with) = arms.split_at(1) {
            for on in with {
                record.add(Row::new(name, off, on, measured, triangles_a_draw), console);
            }
        }
    }
    record.end(console);
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    let is_slow =
        |row: &Row| args.most_slower.is_some_and(|percent| (row.sure - 1.0) * 100.0 > percent);
    Ok(match () {
        () if !record.rows.iter().all(|row| row.checked) => Exit::FalseCull,
        () if interrupted() => Exit::Interrupted,
        () if record.rows.iter().any(is_slow) => Exit::FailIf,
        () => Exit::Fine,
    })
}
