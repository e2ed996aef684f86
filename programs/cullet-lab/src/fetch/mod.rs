//! `cullet fetch`: the models that everybody knows, by name, on their makers' terms.

mod models;
mod source;
mod unpack;

use std::fs::File;
use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use cullet_command::console::{Console, count, grouped};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_io::{LoadOptions, shell_word};

use models::{Known, MODELS};

/// End of `cullet fetch --help`.
pub(crate) const HELP: &str = "\
The models are their makers' and are not part of this program. What their terms say is shown before anything is fetched;
--accept accepts them. A summary of the terms is written beside the model, as NAME.terms.txt.

What arrives is read and its triangles are counted: a model that has another number of them is not kept.

Examples
  cullet fetch                              the models, and their terms
  cullet fetch bunny                        its terms
  cullet fetch bunny --accept               models/bunny.ply
  cullet report models/bunny.ply            what of it is drawn for nothing
  cullet fetch armadillo --accept --from Armadillo.ply.gz
                                            from a file that you have; an address serves as well";

/// `cullet fetch`
#[derive(Debug, Args)]
pub struct FetchArgs {
    /// The model; without one all are listed
    name: Option<String>,
    /// Accept its terms
    #[arg(long, requires = "name")]
    accept: bool,
    /// The folder to keep it in
    #[arg(long, value_name = "DIR", default_value = "models")]
    out: PathBuf,
    /// A file or an address to take it from instead: the archive, or the model out of it
    #[arg(long, value_name = "FILE_OR_URL", requires = "name")]
    from: Option<String>,
}

/// Runs the command.
pub(crate) fn run(args: &FetchArgs, console: &Console) -> Outcome {
    let Some(name) = &args.name else {
        list(console);
        return Ok(Exit::Fine);
    };
    let known = Known::find(name).ok_or_else(|| unknown(name))?;
    let from = args.from.as_deref().unwrap_or(known.address);
    let kept = args.out.join(known.file);
    if kept.exists() {
        check(&kept, known).map_err(|why| {
            Failure::input(format!("{}: {why}. Remove it to fetch it anew", kept.display()))
        })?;
        let triangles = grouped(known.triangles);
        console.line(format!("{} is there already: {triangles} triangles", kept.display()));
        return tell(&kept, console);
    }
    for line in terms(known) {
        console.line(line);
    }
    consent(args.accept, known)?;
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    let parts = Parts::new(&args.out, known);
    let archive = source::get(from, known, &parts.archive, console)?;
    let fail = |e| Failure::write(&parts.model, &e);
    let mut file = File::create(&parts.model).map_err(fail)?;
    unpack::unpack(&archive, known, &mut file)?;
    file.sync_all().map_err(fail)?;
    drop(file);
    check(&parts.model, known).map_err(|why| Failure::input(format!("{from}: {why}")))?;
    std::fs::rename(&parts.model, &kept).map_err(|e| Failure::write(&kept, &e))?;
    let beside = args.out.join(format!("{}.terms.txt", known.name));
    let text = terms(known).join("\n") + "\n";
    std::fs::write(&beside, text).map_err(|e| Failure::write(&beside, &e))?;
    let triangles = grouped(known.triangles);
    console.line(format!("{} written: {triangles} triangles", kept.display()));
    tell(&kept, console)
}

/// Prints what one may do with the file.
fn tell(kept: &Path, console: &Console) -> Outcome {
    console.line(format!("try: cullet report {}", shell_word(&kept.to_string_lossy())));
    Ok(Exit::Fine)
}

fn unknown(name: &str) -> Failure {
    let names: Vec<&str> = MODELS.iter().map(|known| known.name).collect();
    let near = names
        .iter()
        .copied()
        .max_by(|a, b| strsim::jaro_winkler(a, name).total_cmp(&strsim::jaro_winkler(b, name)));
    let near = near.filter(|near| strsim::jaro_winkler(near, name) > 0.7);
    let meant = near.map_or_else(String::new, |near| format!(" (did you mean '{near}'?)"));
    Failure::usage(format!("there is no model '{name}'{meant}; there are {}", names.join(", ")))
}

fn list(console: &Console) {
    for known in MODELS {
        let Known { name, title, triangles, address, terms, .. } = known;
        let triangles = count(*triangles, "triangle", "triangles");
        let most = known.most_bytes() / 1_000_000;
        console.line(format!("{name}\n  {title}"));
        console.line(format!("  {triangles}, a download of less than {most} MB"));
        console.line(format!("  terms: {}", terms.word));
        console.line(format!("  from {address}\n"));
    }
    console.line("cullet fetch NAME shows the terms of one, cullet fetch NAME --accept fetches it");
    console.line("What needs no fetching: cullet scenes lists the scenes that are built in");
}

/// The model and what its terms say.
fn terms(known: &Known) -> Vec<String> {
    let Known { name, title, address, terms, .. } = known;
    let mut lines = vec![format!("{name}: {title}"), format!("  from {address}")];
    lines.extend(terms.lines.iter().map(|line| format!("  {line}")));
    lines.push(format!("  In full: {}", terms.address));
    lines
}

/// Whether the terms are accepted; who sits at a terminal is asked.
fn consent(accepted: bool, known: &Known) -> Result<(), Failure> {
    let name = known.name;
    if accepted || !known.terms.bind {
        return Ok(());
    }
    let refused = || {
        Failure::usage(format!(
            "{name} is fetched on these terms alone: add --accept to accept them"
        ))
    };
    let (input, error) = (std::io::stdin(), std::io::stderr());
    if !input.is_terminal() || !error.is_terminal() {
        return Err(refused());
    }
    let mut answer = String::new();
    let _ = write!(error.lock(), "Do you accept these terms? yes or no: ");
    let _ = error.lock().flush();
    let read = input.lock().read_line(&mut answer);
    let is_yes = ["y", "yes"].contains(&answer.trim().to_ascii_lowercase().as_str());
    if read.is_ok() && is_yes { Ok(()) } else { Err(refused()) }
}

/// Whether a file is the model: what is wrong with it, where it is not.
fn check(path: &Path, known: &Known) -> Result<(), String> {
    let model = cullet_maps::load(path, &LoadOptions::default())
        .map_err(|error| format!("what is there cannot be read as {}: {error}", known.name))?;
    let (found, right) = (model.scene.triangle_count(), known.triangles);
    if found == right {
        return Ok(());
    }
    Err(format!(
        "what is there has {}, but {} has {}",
        count(found, "triangle", "triangles"),
        known.name,
        grouped(right)
    ))
}

/// Files on the way to a model, gone with the value. Their names are of this process, so that two
/// of them do not meet.
struct Parts {
    archive: PathBuf,
    model: PathBuf,
}

impl Parts {
    fn new(folder: &Path, known: &Known) -> Self {
        let name =
            |ending: &str| folder.join(format!(".{}-{}.{ending}", known.name, std::process::id()));
        // The ending says what some formats do not.
        Self { archive: name("part"), model: name(&format!("part-{}", known.file)) }
    }
}

impl Drop for Parts {
    fn drop(&mut self) {
        for path in [&self.archive, &self.model] {
            // Mostly they are not there: moved, or never made.
            let _ = std::fs::remove_file(path);
        }
    }
}
