//! The program `cullet-profile`; `cullet profile` starts it.
#![forbid(unsafe_code)]

mod profile_args;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use cullet::{Culler, Output, Stage};
use cullet_cells::InCells;
use cullet_command::args::CullArgs;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{replace, write_json};
use cullet_command::{inputs, program};
use cullet_gpu::{Gpu, GpuError, Tier};
use cullet_profile::{
    Amounts, Drawn, Effort, Link, Profile, Proof, Relief, Times, Waits, Way, Workload, picture,
};
use profile_args::{Already, PROFILE_HELP, ProfileArgs};

/// Names the slowest link of a frame, and the culling that relieves it
#[derive(Debug, Parser)]
#[command(name = "cullet-profile", version, arg_required_else_help = true)]
struct Cli {
    /// Print nothing but results and errors
    #[arg(long, short, global = true)]
    quiet: bool,
    /// The command to run.
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Name the slowest link of a frame, and the culling that relieves it
    #[command(after_help = PROFILE_HELP)]
    Profile(Box<ProfileArgs>),
}

fn main() -> ExitCode {
    let Cli { quiet, command: Command::Profile(mut args) } = Cli::parse();
    args.input.settle();
    program::run("cullet-profile", || run(&args, &Console::new(quiet, args.json.as_deref()))).into()
}

fn run(args: &ProfileArgs, console: &Console) -> Outcome {
    let gpu = Gpu::open(Tier::Compute).map_err(failure)?;
    let proof = Link::ALL.into_iter().find(|link| is_proof(args, *link));
    let profile = match proof {
        Some(link) => of_proof(&gpu, link, args, console)?,
        None => of_scene(&gpu, args, console)?,
    };
    console.line(profile.to_text().trim_end());
    if let Some(path) = &args.out {
        replace(path, picture(&profile).as_bytes())?;
        console.line(format!("{} written", path.display()));
    }
    if let Some(path) = &args.json {
        write_json(path, &profile)?;
    }
    Ok(if interrupted() { Exit::Interrupted } else { Exit::Fine })
}

/// Whether the scene is a frame that waits for one link. A file of that name wins.
fn is_proof(args: &ProfileArgs, link: Link) -> bool {
    let name = &args.input.scene.scene;
    name == link.name() && !std::path::Path::new(name).exists()
}

fn of_proof(
    gpu: &Gpu,
    link: Link,
    args: &ProfileArgs,
    console: &Console,
) -> Result<Profile, Failure> {
    let mut frames = Proof::new(gpu, Amounts::of(link));
    let times = measure(gpu, &mut frames, 0, args, console)?;
    Ok(Profile::new(link.name(), &gpu.adapter.get_info(), &times))
}

fn of_scene(gpu: &Gpu, args: &ProfileArgs, console: &Console) -> Result<Profile, Failure> {
    let input = &args.input;
    let mut model = inputs::load(&input.scene, console)?;
    inputs::demand_levels(&model, &input.scene.scene, &input.cull)?;
    inputs::begin(&mut model, &input.view, console)?;
    let views = inputs::culled_views(&model, &input.view, &input.cull, console)?;
    let all = inputs::culler(&input.cull).with_output(Output::Clusters);
    model.scene.prepare(&all);
    let tried = cullers(&all, args.already, model.in_cells(), &input.cull);
    let (_, others) = tried.split_first().expect("plain frames are among them");
    let own = tried.iter().map(|(_, culler)| culler.clone()).collect();
    let mut frames = Drawn::new(gpu, &model.scene, &views, own).map_err(failure)?;
    let mut works = Vec::new();
    let mut bar = console.progress("views", tried.len() as u64);
    for at in 0..tried.len() {
        works.push(frames.work(gpu, at).map_err(failure)?);
        bar.step();
    }
    drop(bar);
    let times = measure(gpu, &mut frames, others.len(), args, console)?;
    let waits = Waits::of(&times);
    let mut profile = Profile::new(&model.name, &gpu.adapter.get_info(), &times);
    for (at, (name, _)) in others.iter().enumerate() {
        let change = times.change(Way::Plain, Way::Culled(at));
        let work = (&works[0], &works[at + 1]);
        profile.relief.push(Relief::new(name, &waits, work, &change));
    }
    Ok(profile)
}

/// Returns the cullers of the frames: first plain ones, then each stage besides, then all of them.
fn cullers(
    all: &Culler,
    already: Already,
    world: InCells<'_>,
    args: &CullArgs,
) -> Vec<(&'static str, Culler)> {
    let plain = match already {
        Already::Nothing => all.only(Stage::Layer),
        Already::Frustum => all.only(Stage::Frustum),
    };
    let stages: Vec<Stage> = inputs::stages(args, world)
        .filter(|stage| *stage != Stage::Layer && !plain.runs(*stage))
        .collect();
    let frustum = plain.frustum;
    let with = |stage: Stage| {
        let own = all.only(stage);
        let frustum = frustum || own.frustum;
        own.with_frustum(frustum)
    };
    let each = stages.iter().map(|stage| (stage.name(), with(*stage)));
    let together = (stages.len() > 1).then(|| ("all", all.clone()));
    std::iter::once(("plain", plain)).chain(each).chain(together).collect()
}

fn measure(
    gpu: &Gpu,
    frames: &mut impl Workload,
    cullers: usize,
    args: &ProfileArgs,
    console: &Console,
) -> Result<Times, Failure> {
    let rounds = u64::from(args.rounds);
    let mut bar = console.progress("rounds", rounds);
    let effort = Effort { rounds: rounds as usize, ..Effort::default() };
    let go_on = || {
        bar.step();
        !interrupted()
    };
    Times::measure(gpu, frames, cullers, effort, go_on).map_err(failure)
}

fn failure(error: GpuError) -> Failure {
    let exit = match error {
        GpuError::Size { .. } | GpuError::TooLarge { .. } => Exit::Limit,
        _ => Exit::Input,
    };
    Failure { exit, message: error.to_string() }
}
