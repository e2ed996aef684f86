//! `cullet verify`: the proof alone, in lines.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use clap::Args;
use cullet::{Stage, View};
use cullet_command::args::{InputArgs, UnitArgs};
use cullet_command::console::{Console, agree, count, digits, grouped, percent};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::items::{Items, ItemsEnd};
use cullet_command::{inputs, sets};
use cullet_draw::{FalseCull, Verification};
use cullet_maps::recording::Recording;
use serde::{Deserialize, Serialize};

use crate::levels::{self, LevelsSummary};
use crate::record::{Loss, SCHEMA, Summary, ViewRecord};
use crate::recording;
use crate::survey::Survey;

/// End of `cullet verify --help`.
pub(crate) const HELP: &str = "\
Draws every view with and without culling, and demands that each pixel be owned by the same triangle
of the same instance. With --samples 4 it also looks for instances that own one of 4x4 jittered
samples a pixel and were dropped. Every loss is printed with its view, instance, stage and reason,
and the exit code is 1.

Sets of --pvs that were found by sampled lines may lack something, and say how much. What they lose is held against
that: the share of wrong pixels may be as large as the estimate of their worst cell. Whatever another stage
loses is a false cull as ever.

--lod 1 draws levels of detail, which may be off by a pixel. All stages without them are verified as ever. Then it is
measured how far the triangles that are drawn are from the original, by hundreds of thousands of points a view, both ways,
without a look at the errors that the levels state: 99.9 % of them must be within the threshold, and all within
1.2 of it, or the exit code is 1. How many pixels that changes is told.

--time 0..4 lets what moves do so along the views, under bounds from its joints and morph targets.

--unit I/N verifies one of N shares of the views, says what it found, and keeps that in --units; any number of processes
may share a folder. --resume then says what was found in all of them, after it has done what is missing. It also goes on after Ctrl-C.

Examples
  cullet verify city --path walk
  cullet verify figure.glb --time 0..4 --views 32
  cullet verify moving --time 1.5 --path walk
  cullet verify castle.glb --lod 1                   the error of levels of detail, stated and found
  cullet verify city --pvs city.cpvs --only pvs      sampled sets, against their own stated error
  cullet verify city --views 1000 --unit 3/8 --units /shared/city      the third of eight machines
  cullet verify city --views 1 --record city.occ     for cullet replay";

/// `cullet verify`
#[derive(Debug, Args)]
pub struct VerifyArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// N x N jittered samples a pixel; 1 is off
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) samples: u32,
    /// Record the occluders and boxes of every view, and what is hidden, for cullet replay
    #[arg(long, value_name = "PATH", conflicts_with_all = ["no_occlusion", "unit", "resume", "units"])]
    pub(crate) record: Option<PathBuf>,
    /// Write the result as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) units: UnitArgs,
}

/// Losses printed of one view; all of them are in the JSON.
const LOSSES_SHOWN: usize = 20;

#[derive(Serialize)]
struct VerifyRecord<'a> {
    schema: u32,
    scene: &'a str,
    samples: u32,
    views: &'a [ViewRecord],
    summary: &'a Summary,
    #[serde(skip_serializing_if = "Option::is_none")]
    stated: Option<Stated>,
    complete: bool,
}

/// Error that sampled sets state, and the error that was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
struct Stated {
    /// Share of looks that are estimated to go to what is missing: mean of the cells, and the
    /// worst.
    mean: f64,
    worst: f64,
    /// Pixels of all views, and those that show what only the sets dropped.
    pixels: u64,
    wrong_pixels: u64,
    /// Visible triangles that the sets dropped, and instances that only the samples see.
    losses: u64,
}

impl Stated {
    /// Returns what is stated by the sets that a scene is to be given; `None` for those that lack
    /// nothing.
    fn of(args: &VerifyArgs) -> Result<Option<Self>, Failure> {
        let Some(path) = &args.input.scene.pvs else { return Ok(None) };
        let stated = sets::stated_error(path)?;
        Ok(stated.map(|[mean, worst]| Self { mean, worst, ..Self::default() }))
    }

    /// Adds a view.
    fn add(&mut self, view: &Verification) {
        let lost: HashSet<u32> = (view.false_culls.iter())
            .filter(|f| f.reason.is_some_and(|r| r.stage == Stage::Pvs))
            .map(|f| f.slot)
            .collect();
        let is_lost = |f: &&FalseCull| lost.contains(&f.slot);
        self.losses += view.false_culls.iter().filter(is_lost).count() as u64;
        self.pixels += view.frame.ids.len() as u64;
        let pixels = view.frame.ids.iter().zip(&view.culled_frame.ids);
        let wrong = pixels.filter(|(all, left)| all != left && lost.contains(&all.slot));
        self.wrong_pixels += wrong.count() as u64;
    }

    /// Adds what was counted of another view.
    fn join(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.wrong_pixels += other.wrong_pixels;
        self.losses += other.losses;
    }

    fn share(&self) -> f64 {
        self.wrong_pixels as f64 / self.pixels.max(1) as f64
    }

    /// Whether no more was lost than the sets say. A view may well be from the worst cell.
    fn is_kept(&self) -> bool {
        self.share() <= self.worst
    }

    fn text(&self) -> String {
        let percent = |share: f64| format!("{} %", digits(share * 100.0));
        format!(
            "the sets were sampled: they state {} of looks to go to what they lack, {} in the worst cell; {} of {} were wrong, {}, {}",
            percent(self.mean),
            percent(self.worst),
            grouped(self.wrong_pixels),
            count(self.pixels, "pixel", "pixels"),
            percent(self.share()),
            if self.is_kept() { "within the stated error" } else { "ABOVE THE STATED ERROR" },
        )
    }
}

/// Findings of a view.
#[derive(Debug, Deserialize, Serialize)]
struct Found {
    view: ViewRecord,
    /// Where sets of --pvs were sampled.
    stated: Option<Stated>,
}

/// Work of a verification; views are taken one at a time, as each uses all threads.
#[derive(Debug)]
struct Work {
    survey: Survey,
    recording: Recording,
    found: BTreeMap<u32, Found>,
    failure: Option<Failure>,
}

/// All that a view's result is a function of besides the files, in words: unit files of other
/// options and versions are of another work.
fn options(args: &VerifyArgs, views: usize) -> String {
    let mut input = args.input.clone();
    input.view.threads = 0;
    // What files contain counts, and not where they lie.
    if Path::new(&input.scene.scene).exists() {
        input.scene.scene = String::new();
    }
    input.scene.pvs = None;
    format!("{:?}", (env!("CARGO_PKG_VERSION"), input, args.samples, views))
}

/// Runs the command.
pub(crate) fn run(args: &VerifyArgs, console: &Console) -> Outcome {
    let stated = Stated::of(args)?;
    let mut model = levels::load(&args.input.scene, &args.input.cull, console)?;
    inputs::give_occluders(&mut model, &args.input.cull, console)?;
    inputs::begin(&mut model, &args.input.view, console)?;
    let views = inputs::culled_views(&model, &args.input.view, &args.input.cull, console)?;
    let options = cullet_draw::VerifyOptions {
        samples: args.samples,
        seed: args.input.view.seed,
        threads: args.input.view.threads,
        count_layers: false,
    };
    let mut survey = Survey::new(model, inputs::culler(&args.input.cull), options);
    survey.move_over(inputs::times(&args.input.view, views.len()));
    let work =
        Work { survey, recording: Recording::default(), found: BTreeMap::new(), failure: None };
    let ended = verify(args, &views, work, stated, console)?;
    if let Some(path) = &args.record {
        recording::write(&ended.recording, path, console)?;
    }
    let mut stated = stated;
    if let Some(stated) = &mut stated {
        ended.stated.iter().for_each(|one| stated.join(one));
    }
    tell(args, &ended, stated, console)
}

/// Result of all views, or of those that were done.
struct Ended {
    name: String,
    views: Vec<ViewRecord>,
    stated: Vec<Stated>,
    recording: Recording,
    /// Whether all that was to be done is.
    complete: bool,
}

/// Verifies the views, or this process's share of them.
fn verify(
    args: &VerifyArgs,
    views: &[View],
    work: Work,
    stated: Option<Stated>,
    console: &Console,
) -> Result<Ended, Failure> {
    let work = Mutex::new(work);
    let lock = || work.lock().unwrap_or_else(PoisonError::into_inner);
    let make = |item: u32| {
        let mut work = lock();
        let view = views.get(item as usize)?;
        let Work { survey, recording, found, failure } = &mut *work;
        let seen = match survey.add_as(item as usize, view, true) {
            Ok(seen) => seen,
            Err(problem) => {
                *failure = Some(problem);
                return None;
            }
        };
        let mut of_sets = stated;
        if let (Some(stated), Some(view)) = (&mut of_sets, &seen.in_full().verification) {
            stated.add(view);
        }
        if args.record.is_some() {
            recording::record(survey.model.in_cells(), view, &survey.culler, recording);
        }
        let one = Found { view: survey.views.pop()?, stated: of_sets };
        let bytes = serde_json::to_vec(&one).ok()?;
        found.insert(item, one);
        Some(bytes)
    };
    let scene = &args.input.scene;
    let paths = [&scene.pvs, &scene.cells].into_iter().flatten();
    let files = paths.map(|path| path.to_string_lossy().into_owned());
    let items = Items {
        units: &args.units,
        of: Path::new(&scene.scene),
        options: options(args, views.len()),
        files: std::iter::once(scene.scene.clone()).chain(files).collect(),
        costs: vec![1.0; views.len()],
        make: &make,
    };
    let (end, made) = items.run(console)?;
    let made: Option<Vec<Found>> = made.map(|made| items.read(&made)).transpose()?;
    let work = work.into_inner().unwrap_or_else(PoisonError::into_inner);
    if let Some(failure) = work.failure {
        return Err(failure);
    }
    let found = made.unwrap_or_else(|| work.found.into_values().collect());
    let stated = found.iter().filter_map(|one| one.stated).collect();
    Ok(Ended {
        name: work.survey.model.name,
        views: found.into_iter().map(|one| one.view).collect(),
        stated,
        recording: work.recording,
        complete: end != ItemsEnd::Stopped,
    })
}

/// Says what was found.
fn tell(args: &VerifyArgs, ended: &Ended, stated: Option<Stated>, console: &Console) -> Outcome {
    let Ended { name, views, complete, .. } = ended;
    let summary = Summary::of(views);
    views.iter().for_each(|view| print_view(console, view));
    print_summary(console, &summary, args.samples);
    let allowed = stated.filter(Stated::is_kept).map_or(0, |stated| stated.losses);
    if let Some(stated) = &stated {
        console.line(stated.text());
    }
    if let Some(found) = &summary.levels {
        found.lines(summary.views as u64).iter().for_each(|line| console.line(line));
    }
    let broken = summary.levels.as_ref().is_some_and(LevelsSummary::is_broken);
    if let Some(path) = &args.json {
        let record = VerifyRecord {
            schema: SCHEMA,
            scene: name,
            samples: args.samples,
            views,
            summary: &summary,
            stated,
            complete: *complete,
        };
        write_json(path, &record)?;
    }
    Ok(match (complete, summary.false_culls - allowed) {
        (false, _) => Exit::Interrupted,
        (true, 0) if !broken => Exit::Fine,
        (true, _) => Exit::FalseCull,
    })
}

fn print_view(console: &Console, view: &ViewRecord) {
    let t = view.triangles;
    let seen = t.visible.unwrap_or(0);
    let line = format!(
        "view {:>3}: {:>11} {} {:>11} left, {:>10} visible, tightness {}",
        view.index,
        grouped(t.all),
        agree(t.all, "triangle, ", "triangles,"),
        grouped(t.potentially_visible),
        grouped(seen),
        view.tightness.map_or_else(|| "-".into(), |t| format!("{t:.2}")),
    );
    if view.losses.is_empty() {
        // Quiet: only what is wrong, and the sum.
        if !console.quiet {
            console.line(line);
        }
        return;
    }
    console.line(line);
    for loss in view.losses.iter().take(LOSSES_SHOWN) {
        console.line(format!("  LOST {}", loss_text(loss)));
    }
    let more = view.losses.len().saturating_sub(LOSSES_SHOWN);
    if more > 0 {
        console.line(format!("  and {more} more, all of them in the JSON of --json"));
    }
}

/// A loss in a line: where, what, which stage, why.
fn loss_text(loss: &Loss) -> String {
    let what = loss
        .triangle
        .map_or_else(|| "seen by the jittered samples".to_owned(), |t| format!("triangle {t}"));
    format!(
        "view {} pixel {},{}: “{}” {what}, dropped by {} ({})",
        loss.view,
        loss.pixel[0],
        loss.pixel[1],
        loss.instance,
        loss.stage.map_or("a stage for triangles", Stage::name),
        loss.reason
    )
}

fn print_summary(console: &Console, s: &Summary, samples: u32) {
    let t = s.triangles;
    let seen = t.visible.unwrap_or(0);
    console.line(format!(
        "|A| {} all, |S'| {} potentially visible, |S| {} visible, over {}",
        grouped(t.all),
        grouped(t.potentially_visible),
        grouped(seen),
        count(s.views as u64, "view", "views")
    ));
    // Triangles left if the stages up to this one were the only ones.
    let mut left = t.all;
    for (stage, &n) in &s.removed {
        left = left.saturating_sub(n);
        let tightness = crate::record::tightness(left, seen);
        console.line(format!(
            "  {:<11} takes {:>9} of all, {} left, tightness {}",
            stage.name(),
            percent(n, t.all),
            grouped(left),
            tightness.map_or_else(|| "-".into(), |t| format!("{t:.2}")),
        ));
    }
    let how = match samples {
        0 | 1 => "pixel for pixel".to_owned(),
        n => format!("pixel for pixel, and with {n}x{n} samples"),
    };
    let of_what =
        if s.levels.is_some() { "without levels of detail the images" } else { "the images" };
    console.line(match s.false_culls {
        0 => format!("0 false culls: {of_what} agree {how}"),
        n => count(n, "FALSE CULL", "FALSE CULLS"),
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_held_against_their_worst_cell() {
        let stated = Stated { mean: 0.001, worst: 0.01, pixels: 1000, wrong_pixels: 10, losses: 3 };
        assert!(stated.is_kept(), "{}", stated.text());
        assert!(stated.text().ends_with("within the stated error"), "{}", stated.text());
        let worse = Stated { wrong_pixels: 11, ..stated };
        assert!(!worse.is_kept() && worse.text().ends_with("ABOVE THE STATED ERROR"));
    }

    #[test]
    fn a_loss_names_all_that_is_known() {
        let loss = Loss {
            view: 3,
            instance: "door".into(),
            handle: [7, 0].into(),
            triangle: Some(12),
            pixel: [640, 360],
            stage: Some(Stage::Frustum),
            reason: "outside the left plane of the frustum".into(),
        };
        assert_eq!(
            loss_text(&loss),
            "view 3 pixel 640,360: “door” triangle 12, dropped by frustum (outside the left plane of the frustum)"
        );
        let whole = Loss { triangle: None, stage: None, ..loss };
        assert!(loss_text(&whole).contains("jittered samples"));
    }
}
