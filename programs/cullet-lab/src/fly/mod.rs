//! `cullet fly`: a world larger than memory, flown through while its tiles come and go.

mod page;
mod record;
mod world;

use std::io::Write as _;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use cullet::lod::Lod;
use cullet::{Camera, Culler, Depth, Projection, Stage, View, ViewState, Visible};
use cullet_command::console::{Console, count, digits, grouped, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{replace, write_json};
use cullet_command::parse;
use cullet_draw::{VerifyOptions, verify};
use cullet_tiles::{Settings, World};

use record::{Frame, Record, mebibytes};
use world::Route;

/// End of `cullet fly --help`.
pub(crate) const HELP: &str = "\
Flies through a world whose tiles are loaded and dropped on the way, within a budget of memory: half of the way low, half of it high.
Writes into --out: index.html with curves of time and memory, and frames.csv. Frames are 60 a second, as in a game; culling takes one
thread and loading another. Some frames are held against a picture that culls nothing; with --lod, without levels of detail.

A world is the built-in city of up to a thousand million instances, or 3D Tiles. Where `cullet tiles --pvs` wrote those, what can be seen from
the view cell of the eye is loaded before all else.

Examples
  cullet fly city:n=1e8                          a hundred million instances in a gibibyte
  cullet fly city:n=1e8 --budget 200 --pixels 16 coarser, in less
  cullet tiles city.glb -o city && cullet fly city/tileset.json
  cullet tiles castle.glb --stand-ins -o castle && cullet fly castle --budget 64";

/// `cullet fly`
#[derive(Debug, Args)]
pub struct FlyArgs {
    /// city:n=NUMBER,seed=NUMBER, or a tileset.json
    #[arg(default_value = "city:n=1e8")]
    world: String,
    /// Folder to write into
    #[arg(long, value_name = "DIR", default_value = "fly")]
    out: PathBuf,
    /// MiB that tiles and their scenes may take
    #[arg(long, value_name = "MIB", default_value_t = BUDGET, value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    budget: u64,
    /// Tiles are wanted finer while they are off by more than so many pixels
    #[arg(long, value_name = "PX", default_value_t = PIXELS, value_parser = parse::pixels)]
    pixels: f64,
    /// Seconds of flight
    #[arg(long, value_name = "S", default_value_t = SECONDS, value_parser = parse::seconds)]
    seconds: f64,
    /// Units of the world a second [default: 100 in the city, through all of a tileset in that
    /// time]
    #[arg(long, value_name = "SPEED", value_parser = parse::distance)]
    speed: Option<f64>,
    /// Draw levels of detail that are off by up to PX pixels, where tiles have some
    #[arg(long, value_name = "PX", value_parser = parse::pixels)]
    lod: Option<f64>,
    /// Do not let visible sets say what is loaded first, where the tileset has some
    #[arg(long)]
    no_sets: bool,
    /// Frames that are held against a picture that culls nothing
    #[arg(long, value_name = "N", default_value_t = CHECKS)]
    check: u32,
    /// Write the figures as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = parse::output)]
    pub(crate) json: Option<PathBuf>,
}

const BUDGET: u64 = 1024;
const PIXELS: f64 = 8.0;
const SECONDS: f64 = 30.0;
const CHECKS: u32 = 9;

/// Frames a second.
const RATE: f64 = 60.0;
const SIZE: [u32; 2] = [1920, 1080];
/// Size of the pictures that check.
const SMALL: [u32; 2] = [320, 180];

/// Runs the command.
pub(crate) fn run(args: &FlyArgs, console: &Console) -> Outcome {
    let mut settings = Settings::default().with_budget(args.budget << 20).with_pixels(args.pixels);
    settings.scale = f64::from(SIZE[1]) * 0.5 / (FOV * 0.5).tan();
    let (mut world, route) = world::open(&args.world, &settings, !args.no_sets)?;
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    let (frames, mut record) = fly(args, &mut world, &route, console);
    record.world = args.world.clone();
    (record.instances, record.cells) = (route.instances, route.cells);
    let csv = args.out.join("frames.csv");
    write_csv(&frames).map_or(Ok(()), |bytes| replace(&csv, &bytes))?;
    let path = args.out.join("index.html");
    replace(&path, page::page(&record, &frames).as_bytes())?;
    print(&record, console);
    console.line(format!("{} written", path.display()));
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    Ok(match (record.complete, record.false_culls) {
        (false, _) => Exit::Interrupted,
        (true, 0) => Exit::Fine,
        (true, _) => Exit::FalseCull,
    })
}

const FOV: f64 = std::f64::consts::FRAC_PI_3;

/// The view from a place along the way.
fn view(eye: [f64; 3], target: [f64; 3], size: [u32; 2], near: f64) -> Option<View> {
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let projection =
        Projection::Perspective { fov_y_radians: FOV, aspect, near, far: f64::INFINITY };
    View::new(&Camera::look_at(eye, target, projection), Depth::Reversed, size).ok()
}

fn fly(
    args: &FlyArgs,
    world: &mut World,
    route: &Route,
    console: &Console,
) -> (Vec<Frame>, Record) {
    let count = (args.seconds * RATE).clamp(1.0, 1e6) as u32;
    let every = count.div_ceil(args.check.max(1)).max(1);
    let speed = args.speed.unwrap_or_else(|| route.speed(args.seconds));
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let lod = args.lod.map(|pixels| Lod::default().with_pixels(pixels));
    let culler = Culler::balanced().with_lod(lod);
    let proven = culler.without(Stage::Lod);
    let mut frames = Vec::with_capacity(count as usize);
    let mut record = Record::new(args.budget << 20);
    let mut progress = console.progress("frames", count.into());
    for number in 0..count {
        let begin = Instant::now();
        let seconds = f64::from(number) / RATE;
        let high = number >= count / 2;
        let [eye, target] = route.at(seconds, args.seconds, speed, high);
        world.look(eye, route.direction.map(|v| v * speed));
        let looked = begin.elapsed();
        let Some(of) = view(eye, target, SIZE, route.near) else { break };
        let start = Instant::now();
        culler.cull_one(world.scene(), &of, &mut state, &mut visible);
        let culled = start.elapsed();
        let status = world.status();
        record.longest_build_seconds = record.longest_build_seconds.max(status.build_seconds);
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        frames.push(Frame {
            seconds,
            eye,
            high,
            cull_ms: ms(culled),
            look_ms: ms(looked),
            instances: world.scene().instance_count(),
            visible: visible.instance_count,
            triangles: visible.triangle_count,
            tiles: status.tiles,
            wanted: status.wanted.len(),
            bytes: status.bytes,
        });
        if args.check > 0 && number.is_multiple_of(every) {
            record.checked += 1;
            record.false_culls += false_culls(world, &proven, [eye, target], route.near);
        }
        progress.step();
        if interrupted() {
            break;
        }
        std::thread::sleep(Duration::from_secs_f64(1.0 / RATE).saturating_sub(begin.elapsed()));
    }
    progress.finish();
    record.complete = frames.len() == count as usize;
    record.sum(&frames);
    let status = world.status();
    (record.loaded, record.built) = (status.loaded, status.built);
    record.failed = status.failed.iter().map(ToString::to_string).collect();
    (frames, record)
}

/// Counts what culling loses of what is loaded, by a picture of a place.
fn false_culls(world: &World, culler: &Culler, [eye, target]: [[f64; 3]; 2], near: f64) -> u64 {
    let Some(small) = view(eye, target, SMALL, near) else { return 0 };
    let options = VerifyOptions::default();
    let proof = verify(world.scene(), &small, culler, &mut ViewState::default(), &options);
    proof.false_culls.len() as u64
}

/// The frames as a table; `None` where that cannot be made, for which there is no reason.
fn write_csv(frames: &[Frame]) -> Option<Vec<u8>> {
    let mut out =
        b"seconds,eye_x,eye_y,eye_z,cull_ms,look_ms,instances,visible,triangles,tiles,wanted,bytes\n"
            .to_vec();
    for f in frames {
        let [x, y, z] = f.eye;
        let Frame {
            seconds,
            cull_ms,
            look_ms,
            instances,
            visible,
            triangles,
            tiles,
            wanted,
            bytes,
            ..
        } = f;
        writeln!(out, "{seconds:.4},{x},{y},{z},{cull_ms:.4},{look_ms:.4},{instances},{visible},{triangles},{tiles},{wanted},{bytes}").ok()?;
    }
    Some(out)
}

fn print(r: &Record, console: &Console) {
    console.line(format!(
        "{}: {}; at the most {} of them in {} and {} of {} MiB",
        r.world,
        count(r.instances, "instance", "instances"),
        grouped(r.most_instances.into()),
        count(r.most_tiles as u64, "tile", "tiles"),
        mebibytes(r.most_bytes),
        mebibytes(r.budget),
    ));
    console.line(format!(
        "  {} loaded, {} built, the longest in {} s beside the frames, of which none took more than {} ms to look",
        count(r.loaded, "tile", "tiles"),
        count(r.built, "scene", "scenes"),
        digits(r.longest_build_seconds),
        digits(r.longest_look_ms),
    ));
    if r.cells > 0 {
        let cells = count(r.cells.into(), "view cell says", "view cells say");
        console.line(format!("  {cells} what is loaded first"));
    }
    for (name, half) in [("low", r.low), ("high", r.high)] {
        console.line(format!(
            "  {name:<5} cull {} ms in the median, {} ms in 99 of 100; {} visible in the mean",
            digits(half.median_ms),
            digits(half.p99_ms),
            grouped(half.visible as u64),
        ));
    }
    if r.checked > 0 {
        console.line(format!(
            "  {} in {}",
            count(r.false_culls, "FALSE CULL", "false culls"),
            count(r.checked.into(), "picture", "pictures")
        ));
    }
    r.failed.iter().for_each(|failed| console.note(format!("warning: {failed}")));
}
