//! `cullet report`: the page, its figures and its pictures.

mod advice;
mod args;
mod baseline;
mod charts;
mod drawing;
mod export;
mod fail_if;
mod folder;
mod levels_page;
mod opened;
mod page;
mod record;
mod saved;
mod scene;
mod tables;

use std::path::Path;
use std::time::{Duration, Instant};

use cullet_command::console::{Console, count, grouped, percent};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_io::shell_word;
use cullet_scenes::CityName;

use crate::levels::LevelsSummary;
use crate::neighbours::LAB;
use fail_if::FailIf;
use record::Record;
use scene::of_scene;

pub(crate) use args::{HELP, ReportArgs};

/// Runs the command.
pub(crate) fn run(args: &ReportArgs, console: &Console) -> Outcome {
    let fail_ifs = args
        .fail_if
        .iter()
        .map(|text| FailIf::parse(text).map_err(Failure::usage))
        .collect::<Result<Vec<_>, _>>()?;
    if args.baseline.is_none() && fail_ifs.iter().any(FailIf::needs_baseline) {
        return Err(Failure::usage("--fail-if compares with the baseline, so give --baseline too"));
    }
    let scene = args.input.scene.scene.as_str();
    if Path::new(scene).is_dir() {
        return folder::run(args, &fail_ifs, console);
    }
    if scene.parse::<CityName>().is_ok_and(|city| city.needs_tiles()) {
        return in_tiles(args, console);
    }
    if args.units.are_kept() {
        return Err(Failure::usage(
            "--unit, --units and --resume are for a folder of files; the views of one scene are shared by cullet verify",
        ));
    }
    let baseline = args.baseline.as_deref().map(baseline::read).transpose()?;
    let start = Instant::now();
    let record = of_scene(args, baseline.as_ref(), console)?;
    let complete = record.complete;
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    let summary = &record.summary;
    print_summary(console, &record, &args.out, start.elapsed());
    if let Some(old) = &baseline {
        baseline::changes(&record, old).iter().for_each(|line| console.line(format!("  {line}")));
    }
    if !complete {
        return Ok(Exit::Interrupted);
    }
    let broken = summary.levels.as_ref().is_some_and(LevelsSummary::is_broken);
    if summary.false_culls > 0 || broken {
        return Ok(Exit::FalseCull);
    }
    let crossed: Vec<String> =
        fail_ifs.iter().filter_map(|f| f.holds(summary, baseline.as_ref())).collect();
    crossed.iter().for_each(|line| console.line(line));
    Ok(if crossed.is_empty() { Exit::Fine } else { Exit::FailIf })
}

/// Reports on a flight through a city that is larger than memory.
fn in_tiles(args: &ReportArgs, console: &Console) -> Outcome {
    let scene = args.input.scene.scene.as_str();
    if args.json.is_some()
        || args.baseline.is_some()
        || !args.fail_if.is_empty()
        || args.units.are_kept()
    {
        return Err(Failure::usage(format!(
            "{scene} is never whole, so that --json, --baseline, --fail-if, --unit, --units and --resume have nothing to compare; \
             `cullet fly {} --json flight.json` writes the figures of a flight",
            shell_word(scene)
        )));
    }
    console.note(format!(
        "{scene} is larger than memory: flown through, as by `cullet fly {}`",
        shell_word(scene)
    ));
    let rest = [scene.into(), "--out".into(), args.out.clone().into_os_string()];
    LAB.run_command("fly", &rest, console.quiet)
}

fn print_summary(console: &Console, record: &Record, out: &Path, time: Duration) {
    let s = &record.summary;
    console.line(page::full_headline(record));
    console.line(page::lead(s));
    let t = s.triangles;
    for (stage, n) in &s.removed {
        let name = stage.name();
        console.line(format!("  {name:<11} takes {:>9} of all triangles", percent(*n, t.all)));
    }
    console.line(match (s.false_culls, s.verified_views.len()) {
        (0, 0) => "  not verified".into(),
        (0, n) if n == s.views => {
            format!("  verified in {}: nothing visible was lost", count(n as u64, "view", "views"))
        }
        (0, n) => format!("  verified in {n} of {} views: nothing visible was lost", s.views),
        (n, _) => {
            let lost = count(n, "FALSE CULL", "FALSE CULLS");
            format!("  {lost}, visible and yet culled: see the page")
        }
    });
    let levels = s.levels.iter().flat_map(|levels| levels.lines(s.views as u64));
    levels.for_each(|line| console.line(format!("  {line}")));
    if let Some(b) = s.backfaces.filter(|b| b.facing_away > 0) {
        console.line(format!(
            "  back faces  {} of one-sided triangles; {} of them are culled by whole clusters (ideal {}), {} by their planes",
            percent(b.facing_away, b.one_sided),
            percent(b.by_cluster, b.facing_away),
            percent(b.ideal_by_cluster, b.facing_away),
            percent(b.by_plane.saturating_sub(b.by_cluster), b.facing_away),
        ));
    }
    let views = s.views.max(1) as u64;
    if s.whole.occluders[0] > 0 {
        console.line(format!(
            "  whole instances: {} per view, {} in the frustum, {} not occluded",
            count(t.all / views, "triangle", "triangles"),
            grouped(s.whole.in_frustum[1] / views),
            grouped(s.whole.not_hidden[1] / views)
        ));
    }
    for a in s.advice.iter().take(5) {
        console.line(format!("  advice: {}", a.title));
    }
    if let Some(words) = page::assumption(record) {
        console.line(format!("  {words}"));
    }
    if !record.complete {
        console.line("  stopped early: the report holds the views done so far");
    }
    let page = out.join("index.html");
    console.line(format!("{} written in {:.1} s", page.display(), time.as_secs_f64()));
}
