//! `cullet check-occlusion`: every pixel that the occlusion buffer claims, against samples.

use std::path::PathBuf;
use std::time::Instant;

use crate::claims::{ClaimOptions, Claims, SceneOccluders, WrongClaim, check_claims};
use clap::Args;
use cullet::cull::occlusion::OcclusionBuffer;
use cullet::{Scene, Simd, View};
use cullet_command::args::{SceneArgs, ViewArgs};
use cullet_command::console::{Console, agree, count, grouped, interrupted, percent};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::inputs;
use cullet_scenes::adversaries::{ADVERSARIES, adversary};
use serde::Serialize;

/// End of `cullet check-occlusion --help`.
pub(crate) const HELP: &str = "\
Draws every occluder of the scene into an occlusion buffer of --size, whatever it costs, and holds each pixel that
the buffer says is covered against 8x8 jittered samples in f64: each sample must be covered by a triangle that
shows a side it is drawn from, and that is at least as near as the pixel says. A wrong pixel is printed with what
the sample met, and the exit code is 1. cullet verify looks at whole scenes with the culling that is used; this
looks at the drawing itself, and also where nothing stands behind it.

--adversaries N checks generated scenes in place of SCENE: folds, T-junctions, hairline gaps, slivers, triangles
through the near plane and more. Each has --views views, and --seed makes others.

Examples
  cullet check-occlusion castle.glb --path walk --views 16
  cullet check-occlusion sponza.ply --up z --one-sided --eye 0,2,0 --target 9,2,0
  cullet check-occlusion --adversaries 80 --views 8 --size 480x270
  cullet check-occlusion --adversaries 80 --seed 7 --samples 16    four times as many samples
  cullet check-occlusion city --json - | jq .wrong";

/// `cullet check-occlusion`
#[derive(Debug, Args)]
pub struct CheckArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    /// N x N jittered samples a pixel
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=i64::from(ClaimOptions::MOST_SAMPLES)))]
    samples: u32,
    /// Check N generated scenes instead of SCENE
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), conflicts_with_all = ["eye", "target", "time", "path"])]
    adversaries: Option<u32>,
    /// Write the result as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

impl CheckArgs {
    /// Puts what depends on the scene where nothing was given.
    pub(crate) fn settle(&mut self) {
        self.view.settle(&self.scene);
    }
}

/// Wrong pixels printed of one view, and kept in the JSON.
const SHOWN: usize = 5;

/// A pixel whose claim a sample refutes.
#[derive(Debug, Serialize)]
struct WrongRecord {
    pixel: [u32; 2],
    claimed: f32,
    sample: [f64; 2],
    /// The greatest nearness there; null where no occluder covers it.
    found: Option<f64>,
    samples: u32,
}

/// One view.
#[derive(Debug, Serialize)]
struct ViewRecord {
    view: usize,
    shapes: u64,
    pixels: u64,
    claimed: u64,
    wrong: u64,
    first: Vec<WrongRecord>,
    seconds: f64,
}

/// One scene.
#[derive(Debug, Serialize)]
struct SceneRecord {
    scene: String,
    views: Vec<ViewRecord>,
}

/// All of it.
#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    size: [u32; 2],
    samples: u32,
    seed: u64,
    scenes: Vec<SceneRecord>,
    pixels: u64,
    claimed: u64,
    wrong: u64,
    seconds: f64,
    complete: bool,
}

impl Record {
    fn new(args: &CheckArgs) -> Self {
        let (size, samples, seed) = (args.view.size, args.samples, args.view.seed);
        let (pixels, claimed, wrong) = (0, 0, 0);
        let (scenes, seconds, complete) = (Vec::new(), 0.0, true);
        Self { schema: 1, size, samples, seed, scenes, pixels, claimed, wrong, seconds, complete }
    }

    fn add(&mut self, scene: SceneRecord) {
        for v in &scene.views {
            self.pixels += v.pixels;
            self.claimed += v.claimed;
            self.wrong += v.wrong;
            self.seconds += v.seconds;
        }
        self.scenes.push(scene);
    }

    fn views(&self) -> u64 {
        self.scenes.iter().map(|s| s.views.len() as u64).sum()
    }
}

/// Runs the command.
pub(crate) fn run(args: &CheckArgs, console: &Console) -> Outcome {
    let mut record = Record::new(args);
    let options = ClaimOptions {
        samples: args.samples,
        seed: args.view.seed,
        threads: args.view.threads,
        listed: SHOWN,
    };
    if let Some(n) = args.adversaries {
        let mut progress = console.progress("scenes", u64::from(n));
        for number in 0..n {
            let a = adversary(number, args.view.seed, args.view.views, args.view.size);
            let name = format!("{number} {}", a.name);
            let views = check(&a.scene, &a.views, args.view.size, &options, || {})?;
            record.complete &= views.len() == a.views.len();
            record.add(SceneRecord { scene: name, views });
            progress.step();
            if interrupted() {
                record.complete &= number + 1 == n;
                break;
            }
        }
    } else {
        let mut model = inputs::load(&args.scene, console)?;
        inputs::begin(&mut model, &args.view, console)?;
        let views = inputs::views(&model, &args.view, console)?;
        let mut progress = console.progress("views", views.len() as u64);
        let done = check(&model.scene, &views, args.view.size, &options, || progress.step())?;
        record.complete = done.len() == views.len();
        record.add(SceneRecord { scene: model.name, views: done });
    }
    print(console, &record, args.adversaries.is_some());
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    Ok(match (record.complete, record.wrong) {
        (_, 1..) => Exit::FalseCull,
        (true, 0) => Exit::Fine,
        (false, 0) => Exit::Interrupted,
    })
}

/// Draws and checks the views of a scene, up to the one in which it is interrupted.
fn check(
    scene: &Scene,
    views: &[View],
    size: [u32; 2],
    options: &ClaimOptions,
    mut step: impl FnMut(),
) -> Result<Vec<ViewRecord>, Failure> {
    let occluders = SceneOccluders::new(scene);
    let mut buffer = OcclusionBuffer::new(size).map_err(Failure::usage)?;
    let mut done = Vec::with_capacity(views.len());
    for (number, view) in views.iter().enumerate() {
        let start = Instant::now();
        let shapes = occluders.draw(view, Simd::best(), &mut buffer);
        let claims = Claims::of(&buffer);
        let found = check_claims(view, &claims, &occluders.triangles(view), options);
        done.push(ViewRecord {
            view: number,
            shapes,
            pixels: found.pixels,
            claimed: found.claimed,
            wrong: found.wrong,
            first: found.first.iter().map(wrong_record).collect(),
            seconds: start.elapsed().as_secs_f64(),
        });
        step();
        if interrupted() {
            break;
        }
    }
    Ok(done)
}

fn wrong_record(w: &WrongClaim) -> WrongRecord {
    let WrongClaim { pixel, claimed, samples, sample, found } = *w;
    WrongRecord { pixel, claimed, sample, found, samples }
}

fn print(console: &Console, record: &Record, generated: bool) {
    for scene in &record.scenes {
        if generated {
            // Of each a row; a view of its own only where it is wrong.
            let sum = |of: fn(&ViewRecord) -> u64| scene.views.iter().map(of).sum();
            let seconds = scene.views.iter().map(|v| v.seconds).sum();
            let wrong = sum(|v| v.wrong);
            let [pixels, claimed] = [sum(|v| v.pixels), sum(|v| v.claimed)];
            if wrong > 0 || !console.quiet {
                console.line(row(&format!("{:<72}", scene.scene), pixels, claimed, wrong, seconds));
            }
        }
        for v in &scene.views {
            if v.wrong > 0 || !(generated || console.quiet) {
                let name = format!("view {:>3}", v.view);
                console.line(row(&name, v.pixels, v.claimed, v.wrong, v.seconds));
            }
            v.first.iter().for_each(|w| console.line(format!("  WRONG {}", wrong_text(w))));
            let more = v.wrong.saturating_sub(v.first.len() as u64);
            if more > 0 {
                console.line(format!("  and {more} more"));
            }
        }
    }
    let scenes = match generated {
        true => format!(" of {}", count(record.scenes.len() as u64, "adversary", "adversaries")),
        false => String::new(),
    };
    console.line(format!(
        "{} over {}{scenes}, {} claimed, {} each, {:.1} s",
        count(record.pixels, "pixel", "pixels"),
        count(record.views(), "view", "views"),
        grouped(record.claimed),
        count(u64::from(record.samples * record.samples), "sample", "samples"),
        record.seconds
    ));
    if generated && record.scenes.len() < ADVERSARIES as usize {
        console.note(format!("there are {ADVERSARIES} kinds of adversaries"));
    }
    console.line(match record.wrong {
        0 => "0 wrong: all that the buffer claims is covered, and as near as it says".to_owned(),
        n => format!(
            "{} of what the buffer claims {} wrong: a fault of cullet, please report it",
            count(n, "pixel", "pixels"),
            agree(n, "is", "are")
        ),
    });
}

fn row(name: &str, pixels: u64, claimed: u64, wrong: u64, seconds: f64) -> String {
    format!(
        "{name}: {:>11} {} {:>13} claimed, {:>6} wrong, {seconds:>6.2} s",
        grouped(pixels),
        agree(pixels, "pixel, ", "pixels,"),
        percent(claimed, pixels),
        grouped(wrong)
    )
}

/// A wrong pixel in a line.
fn wrong_text(w: &WrongRecord) -> String {
    let found = w.found.map_or_else(
        || "covered by no occluder".to_owned(),
        |n| format!("where the nearest occluder has {n:e}"),
    );
    format!(
        "pixel {},{} claims nearness {:e}; {} of its samples {} not, such as {:.4},{:.4}, {found}",
        w.pixel[0],
        w.pixel[1],
        w.claimed,
        w.samples,
        agree(u64::from(w.samples), "does", "do"),
        w.sample[0],
        w.sample[1],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_pixel_names_what_its_sample_met() {
        let w = WrongRecord {
            pixel: [3, 4],
            claimed: 0.25,
            sample: [3.5, 4.125],
            found: None,
            samples: 1,
        };
        let text = wrong_text(&w);
        assert!(text.contains("pixel 3,4 claims nearness 2.5e-1; 1 of its samples does not"));
        assert!(text.ends_with("covered by no occluder"), "{text}");
        let far = WrongRecord { found: Some(0.125), ..w };
        assert!(wrong_text(&far).ends_with("where the nearest occluder has 1.25e-1"));
    }
}
