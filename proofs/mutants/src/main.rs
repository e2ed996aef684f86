//! Puts mutants into a copy of the sources: `cullet-mutants COPY SEED COUNT FOLDER...`, and at the
//! end `--without FILE`.
//!
//! Every mutant stands in the same build behind a switch, as in
//! `if mutant::on(7) { a <= b } else { a < b }`, and the variable `CULLET_MUTANT` of the
//! environment turns one of them on. So a thousand mutants cost one build. `COUNT` of all that the
//! folders have are drawn with `SEED`; `--without` names a file with the numbers of mutants that do
//! not compile. `COPY/mutants.tsv` lists the mutants, one a line: number, file, first and last line
//! in the changed file, line in the original, change, text.

mod edit;
mod sites;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, process};

use sites::Site;

/// The switch. It is read once, at the first mutant that a run meets.
const SWITCH: &str = r#"
/// The mutant that is turned on.
#[doc(hidden)]
pub mod mutant {
    extern crate std;
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

    static ON: AtomicU32 = AtomicU32::new(u32::MAX);

    /// Whether the mutant of this number is turned on.
    #[inline(always)]
    pub fn on(number: u32) -> bool {
        let on = ON.load(Relaxed);
        (if on == u32::MAX { read() } else { on }) == number
    }

    #[cold]
    fn read() -> u32 {
        let on = std::env::var("CULLET_MUTANT").ok().and_then(|n| n.parse().ok()).unwrap_or(0);
        ON.store(on, Relaxed);
        on
    }
}
"#;

fn main() {
    if let Err(why) = run() {
        eprintln!("{why}");
        process::exit(2);
    }
}

fn run() -> Result<(), String> {
    let mut args: Vec<String> = std::env::args().skip(1).collect();
    let without = args.iter().position(|a| a == "--without").map(|at| {
        let file = args.get(at + 1).cloned().unwrap_or_default();
        args.truncate(at);
        file
    });
    let [copy, seed, count, folders @ ..] = &args[..] else {
        return Err("cullet-mutants COPY SEED COUNT FOLDER... [--without FILE]".into());
    };
    let number = |text: &String| text.parse::<u64>().map_err(|e| format!("{text}: {e}"));
    let (copy, seed, count) = (Path::new(copy), number(seed)?, number(count)? as usize);
    let mut files = Vec::new();
    for folder in folders {
        sources(&copy.join(folder), &mut files)?;
    }
    files.sort();
    let mut constants = Vec::new();
    for file in &files {
        constants.extend(sites::constants(&read(file)?)?);
    }
    let mut all: Vec<(PathBuf, Site)> = Vec::new();
    for file in &files {
        let found = sites::find(&read(file)?, &constants).map_err(|e| format!("{file:?}: {e}"))?;
        all.extend(found.into_iter().map(|site| (file.clone(), site)));
    }
    println!("{} mutants in {} files", all.len(), files.len());
    let mut drawn = draw(all.len(), count, seed);
    // The numbers are those of the draw, and stay when some are left out.
    let out = without.map_or(Ok(String::new()), |file| read(Path::new(&file)))?;
    let out: Vec<usize> = out.split_whitespace().filter_map(|n| n.parse().ok()).collect();
    let mut numbered: Vec<(usize, usize)> = drawn.drain(..).zip(1..).collect();
    numbered.retain(|(_, number)| !out.contains(number));
    let mut list = String::new();
    for file in &files {
        let here: Vec<(usize, &Site)> = numbered
            .iter()
            .filter(|(at, _)| all[*at].0 == *file)
            .map(|&(at, number)| (number, &all[at].1))
            .collect();
        if here.is_empty() {
            continue;
        }
        let name = file.strip_prefix(copy).unwrap_or(file).to_string_lossy().into_owned();
        let switch = if name.starts_with("crates/cullet/") { "crate" } else { "::cullet" };
        let text = read(file)?;
        let changed = edit::apply(&text, &here, switch);
        for (number, site) in here {
            let [first, last] = edit::lines(&changed, number);
            let what = text[site.whole.clone()].split_whitespace().collect::<Vec<_>>().join(" ");
            let what: String = what.chars().take(90).collect();
            let line = text[..site.whole.start].matches('\n').count() + 1;
            let _ = writeln!(
                list,
                "{number}\t{name}\t{first}\t{last}\t{line}\t{}\t{what}",
                site.change.name()
            );
        }
        fs::write(file, edit::clean(&changed)).map_err(|e| format!("{file:?}: {e}"))?;
    }
    let root = copy.join("crates/cullet/src/lib.rs");
    let text = read(&root)? + SWITCH;
    fs::write(&root, text).map_err(|e| format!("{root:?}: {e}"))?;
    fs::write(copy.join("mutants.tsv"), list).map_err(|e| e.to_string())
}

fn read(file: &Path) -> Result<String, String> {
    fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))
}

/// Adds the sources in a folder, or the one file; tests are none.
fn sources(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    if path.is_file() {
        if name.ends_with(".rs") && !name.starts_with("test") {
            files.push(path.to_owned());
        }
        return Ok(());
    }
    if name.starts_with("test") {
        return Ok(());
    }
    for entry in fs::read_dir(path).map_err(|e| format!("{}: {e}", path.display()))? {
        sources(&entry.map_err(|e| e.to_string())?.path(), files)?;
    }
    Ok(())
}

/// The first `count` of `all` numbers in an order that `seed` gives (Fisher and Yates; SplitMix64).
fn draw(all: usize, count: usize, seed: u64) -> Vec<usize> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let mut order: Vec<usize> = (0..all).collect();
    for i in 0..count.min(all) {
        let other = i + (next() % (all - i) as u64) as usize;
        order.swap(i, other);
    }
    order.truncate(count);
    order
}
