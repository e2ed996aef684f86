//! Opens baked files, culls them from a few views and writes what came of it, as data that every host can read:
//! `cullet-golden FOLDER [--write]`.
//!
//! `FOLDER/golden.json` holds the views and the answers in full. `answers.txt` beside this crate holds a line for each
//! view, so that a change of an answer is seen where it is made; `--write` takes the new ones over.
#![forbid(unsafe_code)]

mod answer;
mod view;

use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use answer::{Golden, Scene};

/// The answers that are kept.
const KEPT: &str = include_str!("../answers.txt");

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let done = match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [folder] => run(Path::new(folder), false),
        [folder, "--write"] => run(Path::new(folder), true),
        _ => {
            eprintln!(
                "cullet-golden FOLDER [--write]: culls each .glb of a folder, into golden.json there"
            );
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cullet-golden: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(folder: &Path, write: bool) -> Result<(), Box<dyn Error>> {
    let mut files: Vec<_> = std::fs::read_dir(folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|ending| ending == "glb"))
        .collect();
    files.sort();
    let scenes = files.iter().map(|file| Scene::of(file)).collect::<Result<Vec<_>, _>>()?;
    let golden = Golden { scenes };
    let path = folder.join("golden.json");
    std::fs::write(&path, serde_json::to_vec(&golden)?)?;
    let lines = lines(&golden);
    if write {
        std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/answers.txt"), &lines)?;
    } else if lines != KEPT {
        let other: Vec<&str> =
            lines.lines().filter(|line| !KEPT.lines().any(|kept| kept == *line)).collect();
        let of = other.first().unwrap_or(&"a view that is not there any more");
        return Err(format!("the answers are others than in answers.txt, the first: {of}; where they should be, --write").into());
    }
    println!("{}: {} scenes, {} views", path.display(), golden.scenes.len(), lines.lines().count());
    Ok(())
}

/// A line for each view: how much is visible, and a sum over which.
fn lines(golden: &Golden) -> String {
    let mut text = String::new();
    for scene in &golden.scenes {
        for (number, view) in scene.views.iter().enumerate() {
            // FNV-1a, over the indices and all counts.
            let counts = view.funnel.iter().flat_map(|row| [row.entered, row.left].concat());
            let numbers = view.visible.iter().map(|&index| u64::from(index)).chain(counts);
            let sum =
                numbers.flat_map(u64::to_le_bytes).fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| {
                    (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
                });
            let (name, of) = (&scene.name, scene.instances);
            let _ = writeln!(
                text,
                "{name} {number} {}: {} of {of}, {sum:016x}",
                view.preset,
                view.visible.len()
            );
        }
    }
    text
}
