//! `cullet report FOLDER`: a report of each file in a folder, and a page over all of them.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use cullet_command::console::{Console, count, grouped, interrupted, percent};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{replace, write_json};
use cullet_command::html::{escape, link};
use cullet_command::items::{Items, ItemsEnd};
use cullet_maps::has_scene_ending;
use serde::{Deserialize, Serialize};

use super::args::ReportArgs;
use super::fail_if::FailIf;
use super::record::Record;
use super::scene::of_scene;
use crate::record::{Counts, SCHEMA};

/// Result of a file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
struct Row {
    /// Below the folder that was given, with `/` between its parts.
    file: String,
    /// Address of its report, below the folder of reports.
    page: Option<String>,
    /// Why there is none.
    error: Option<String>,
    views: usize,
    instances: u64,
    /// Sums over the views.
    triangles: Counts,
    tightness: Option<f64>,
    false_culls: u64,
    verified_views: usize,
    /// The advice that is worth the most.
    advice: Option<String>,
    /// The `--fail-if` that hold.
    failed: Vec<String>,
}

impl Row {
    fn of(file: &str, record: &Record, fail_ifs: &[FailIf]) -> Self {
        let s = &record.summary;
        Self {
            file: file.to_owned(),
            page: Some(format!("{file}/index.html")),
            error: None,
            views: s.views,
            instances: record.scene.instances,
            triangles: s.triangles,
            tightness: s.tightness,
            false_culls: s.false_culls,
            verified_views: s.verified_views.len(),
            advice: s.advice.first().map(|advice| advice.title.clone()),
            failed: fail_ifs.iter().filter_map(|f| f.holds(s, None)).collect(),
        }
    }

    fn failed(file: &str, failure: Failure) -> Self {
        Self {
            file: file.to_owned(),
            page: None,
            error: Some(failure.message),
            views: 0,
            instances: 0,
            triangles: Counts::default(),
            tightness: None,
            false_culls: 0,
            verified_views: 0,
            advice: None,
            failed: Vec::new(),
        }
    }

    /// Triangles a view that are drawn for nothing: without culling, of what nobody sees.
    fn waste(&self) -> u64 {
        let t = self.triangles;
        let needed = t.visible.unwrap_or(t.potentially_visible);
        t.all.saturating_sub(needed) / self.views.max(1) as u64
    }
}

/// Contents of `index.json`.
#[derive(Debug, Serialize)]
struct Index<'a> {
    schema: u32,
    /// Rows by waste, the most wasteful first; files that cannot be read last.
    files: &'a [Row],
    complete: bool,
}

/// Runs the command on a folder.
pub(super) fn run(args: &ReportArgs, fail_ifs: &[FailIf], console: &Console) -> Outcome {
    let root = Path::new(&args.input.scene.scene);
    if args.baseline.is_some() || args.export.is_some() {
        let message = "--baseline and --export are of one scene; give a file of the folder";
        return Err(Failure::usage(message));
    }
    let files = files_in(root)?;
    if files.is_empty() {
        let message = format!(
            "{}: no scene lies in this folder (glb, gltf, obj, ply, stl, off, occscn)",
            root.display()
        );
        return Err(Failure::input(message));
    }
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    let start = Instant::now();
    let size = |file: &PathBuf| std::fs::metadata(root.join(file)).map_or(0.0, |m| m.len() as f64);
    // What the least takes is not nothing.
    let costs: Vec<f64> = files.iter().map(|file| size(file) + 100_000.0).collect();
    let rows = Mutex::new(Vec::new());
    let one_at_a_time = Mutex::new(());
    let make = |item: u32| {
        // Each uses all threads.
        let _turn = one_at_a_time.lock();
        let file = files.get(item as usize)?;
        let row = row(args, root, file, fail_ifs);
        // What was interrupted is not kept.
        let row = row.filter(|_| !interrupted())?;
        if let Ok(mut rows) = rows.lock() {
            console.line(line(&row));
            rows.push(row.clone());
        }
        serde_json::to_vec(&row).ok()
    };
    let names = files.iter().map(|file| root.join(file).to_string_lossy().into_owned());
    let items = Items {
        units: &args.units,
        of: &args.out,
        options: options(args, &files),
        files: names.collect(),
        costs,
        make: &make,
    };
    let (end, made) = items.run(console)?;
    if end == ItemsEnd::Share {
        return Ok(Exit::Fine);
    }
    let mut rows: Vec<Row> = match made {
        Some(made) => items.read(&made)?,
        None => rows.into_inner().unwrap_or_default(),
    };
    rows.sort_by_cached_key(|row| {
        (row.error.is_some(), std::cmp::Reverse(row.waste()), row.file.clone())
    });
    let complete = end == ItemsEnd::Whole;
    write(args, root, &rows, complete)?;
    let page = args.out.join("index.html");
    let seconds = start.elapsed().as_secs_f64();
    let of = count(rows.len() as u64, "file", "files");
    console.line(format!("{}: {of}, written in {seconds:.1} s", page.display()));
    Ok(verdict(&rows, complete, console))
}

/// The report of a file; `None` where it was interrupted.
fn row(args: &ReportArgs, root: &Path, file: &Path, fail_ifs: &[FailIf]) -> Option<Row> {
    let name = words(file);
    let mut own = args.clone();
    own.input.scene.scene = root.join(file).to_string_lossy().into_owned();
    own.input.settle();
    own.out = args.out.join(file);
    own.json = None;
    match of_scene(&own, None, &Console::new(true, None)) {
        Ok(record) if record.complete => Some(Row::of(&name, &record, fail_ifs)),
        Ok(_) => None,
        Err(failure) => Some(Row::failed(&name, failure)),
    }
}

fn verdict(rows: &[Row], complete: bool, console: &Console) -> Exit {
    let unread = rows.iter().filter(|row| row.error.is_some()).count() as u64;
    if unread > 0 {
        console.note(format!("{} read", count(unread, "file cannot be", "files cannot be")));
    }
    if !complete {
        return Exit::Interrupted;
    }
    if rows.iter().any(|row| row.false_culls > 0) {
        return Exit::FalseCull;
    }
    let failed = rows.iter().flat_map(|row| row.failed.iter().map(move |line| (&row.file, line)));
    let mut any = false;
    for (file, line) in failed {
        console.line(format!("{file}: {line}"));
        any = true;
    }
    match (unread > 0, any) {
        (true, _) => Exit::Input,
        (false, true) => Exit::FailIf,
        (false, false) => Exit::Fine,
    }
}

/// Scenes in a folder and those below it, by name. Links are not followed.
fn files_in(root: &Path) -> Result<Vec<PathBuf>, Failure> {
    let fail = |path: &Path, e: std::io::Error| {
        Failure::input(format!("{}: cannot be listed: {e}", path.display()))
    };
    let (mut files, mut folders) = (Vec::new(), vec![PathBuf::new()]);
    while let Some(below) = folders.pop() {
        let folder = root.join(&below);
        for entry in std::fs::read_dir(&folder).map_err(|e| fail(&folder, e))? {
            let entry = entry.map_err(|e| fail(&folder, e))?;
            let path = below.join(entry.file_name());
            match entry.file_type() {
                Ok(kind) if kind.is_dir() => folders.push(path),
                Ok(kind) if kind.is_file() && has_scene_ending(&path) => files.push(path),
                _ => {}
            }
        }
    }
    files.sort();
    Ok(files)
}

/// A path with `/` between its parts.
fn words(path: &Path) -> String {
    let parts: Vec<_> = path.iter().map(|part| part.to_string_lossy()).collect();
    parts.join("/")
}

/// All that rows are a function of besides the files' contents, in words: which files, and the
/// options.
fn options(args: &ReportArgs, files: &[PathBuf]) -> String {
    let mut input = args.input.clone();
    input.view.threads = 0;
    input.scene.scene = String::new();
    let names: Vec<_> = files.iter().map(|file| words(file)).collect();
    format!("{:?}", (env!("CARGO_PKG_VERSION"), input, args.samples, &args.fail_if, names))
}

fn line(row: &Row) -> String {
    match &row.error {
        Some(error) => format!("  {}: {error}", row.file),
        None => {
            let t = row.triangles;
            let views = row.views.max(1) as u64;
            let false_culls = match row.false_culls {
                0 => String::new(),
                n => format!(", {}", count(n, "FALSE CULL", "FALSE CULLS")),
            };
            format!(
                "  {}: {} a view, {} left{false_culls}",
                row.file,
                count(t.all / views, "triangle", "triangles"),
                percent(t.potentially_visible, t.all),
            )
        }
    }
}

fn write(args: &ReportArgs, root: &Path, rows: &[Row], complete: bool) -> Result<(), Failure> {
    let index = Index { schema: SCHEMA, files: rows, complete };
    write_json(&args.out.join("index.json"), &index)?;
    if let Some(path) = &args.json {
        write_json(path, &index)?;
    }
    replace(
        &args.out.join("index.html"),
        page(&root.display().to_string(), rows, complete).as_bytes(),
    )
}

/// The page: a row a file, those that waste the most first, each with a link to its own.
fn page(name: &str, rows: &[Row], complete: bool) -> String {
    let name = escape(name);
    let read = rows.iter().filter(|row| row.error.is_none());
    let waste: u64 = read.clone().map(Row::waste).sum();
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <meta name=\"referrer\" content=\"no-referrer\">\
         <title>{name} · cullet report</title><style>\n{}</style></head><body><main>\n\
         <p class=\"kicker\">cullet report · <b>{name}</b></p>\n\
         <h1>{}, one view of each: {} drawn for nothing.</h1>\n",
        include_str!("style.css"),
        count(rows.len() as u64, "file", "files"),
        count(waste, "triangle is", "triangles are"),
    );
    if !complete {
        out.push_str("<span class=\"badge warn\">stopped early: the files done so far</span>\n");
    }
    out.push_str(
        "<h2>Files</h2><p class=\"sub\">Triangles a view; those that waste the most first.</p>\
         <div class=\"panel\"><table><thead><tr><th>file</th><th>instances</th><th>all</th><th>left</th>\
         <th>visible</th><th>tightness</th><th>proof</th><th>advice</th></tr></thead><tbody>\n",
    );
    for row in rows {
        let file = escape(&row.file);
        if let Some(error) = &row.error {
            let error = escape(error);
            let _ = writeln!(
                out,
                "<tr><td>{file}</td><td colspan=\"7\" class=\"bad\">{error}</td></tr>"
            );
            continue;
        }
        let link = link(row.page.as_deref().unwrap_or_default());
        let (t, views) = (row.triangles, row.views.max(1) as u64);
        let dash = || "–".to_owned();
        let proof = match (row.false_culls, row.verified_views) {
            (0, 0) => "not verified".to_owned(),
            (0, n) => count(n as u64, "view", "views"),
            (n, _) => format!("<b class=\"bad\">{n} lost</b>"),
        };
        let _ = writeln!(
            out,
            "<tr><td><a href=\"{link}\">{file}</a></td><td class=\"num\">{}</td><td class=\"num\">{}</td>\
             <td class=\"num\">{}</td><td class=\"num\">{}</td><td class=\"num\">{}</td><td>{proof}</td><td>{}</td></tr>",
            grouped(row.instances),
            grouped(t.all / views),
            grouped(t.potentially_visible / views),
            t.visible.map_or_else(dash, |n| grouped(n / views)),
            row.tightness.map_or_else(dash, |t| format!("{t:.2}")),
            row.advice.as_deref().map_or_else(String::new, escape),
        );
    }
    out.push_str("</tbody></table></div></main></body></html>\n");
    out
}
