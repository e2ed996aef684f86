//! How a test says that it was skipped, and how that is told once all have run.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Says that the running test, or a part of it, is skipped: what is missing, and what would get it.
///
/// The line goes to the test's output, which is hidden unless it fails or `--nocapture` is given; and to the list of this run:
/// the file that `CULLET_SKIPPED` names, else `target/skipped-tests.txt`. [`tell_skipped`] shows the list, and
/// `cargo xtask test` reads it. Where it cannot be written the line goes to the standard error at once, for a skip that nobody
/// hears of would pass for a success.
pub fn skip(missing: &str, cure: &str) {
    println!("skipped: {missing}, {cure}");
    let line = line(&test_name(), missing, cure);
    if append(&list(), parent(), &line).is_err() {
        // Past the test harness, which would hide it.
        let _ = std::io::stderr().write_all(format!("skipped: {line}").as_bytes());
    }
}

/// Shows what the run skipped that this process is a part of. The last test program of `cargo test` calls it, and after that the
/// last doc test: whichever of the two can be read where the run ends. Elsewhere it does nothing.
pub fn tell_skipped() {
    let Ok(text) = std::fs::read_to_string(list()) else { return };
    let Some((run, lines)) = text.split_once('\n') else { return };
    let Ok(run) = run.parse() else { return };
    let told = summary(lines);
    match (run == parent(), terminal(run)) {
        (true, None) => {
            let _ = std::io::stderr().write_all(told.as_bytes());
            if run == 0 {
                let _ = std::fs::remove_file(list());
            }
        }
        // What a doc test prints is hidden, so that it goes to where cargo prints.
        (false, Some(mut end)) if is_within(run) => {
            let _ = end.write_all(told.as_bytes());
        }
        _ => {}
    }
}

fn list() -> PathBuf {
    let named = std::env::var_os("CULLET_SKIPPED").filter(|v| !v.is_empty()).map(PathBuf::from);
    let ours = concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/skipped-tests.txt");
    named.unwrap_or_else(|| ours.into())
}

/// The process that runs this one: of all tests of a run the same, cargo's. Zero on systems that do not tell.
fn parent() -> u32 {
    #[cfg(unix)]
    return std::os::unix::process::parent_id();
    #[cfg(not(unix))]
    0
}

/// Where a process prints its errors, if this one can do so too. No plain file: what is appended to it would be written over, for
/// cargo goes on where it has been.
fn terminal(process: u32) -> Option<File> {
    let path = format!("/proc/{process}/fd/2");
    let is_file = std::fs::metadata(&path).ok()?.is_file();
    if is_file { None } else { OpenOptions::new().append(true).open(path).ok() }
}

/// Whether a process has started this one, or one that has.
fn is_within(process: u32) -> bool {
    let above = |child: &u32| {
        let status = std::fs::read_to_string(format!("/proc/{child}/status")).ok()?;
        status.lines().find_map(|l| l.strip_prefix("PPid:")?.trim().parse().ok())
    };
    std::iter::successors(Some(std::process::id()), above).any(|p| p == process)
}

/// The running test: its package, and its path there; the harness names its threads.
fn test_name() -> String {
    let package = std::env::var("CARGO_PKG_NAME").unwrap_or_default();
    let thread = std::thread::current();
    // In the main thread: with --test-threads=1, and where nextest runs each test by itself.
    let name = thread.name().filter(|name| *name != "main").map(str::to_owned);
    let name = name.or_else(|| std::env::var("NEXTEST_TEST_NAME").ok());
    format!("{package}::{}", name.as_deref().unwrap_or("main"))
}

/// A line of the file: its fields hold neither tabs nor line breaks.
fn line(test: &str, missing: &str, cure: &str) -> String {
    let field = |text: &str| text.replace(['\t', '\n', '\r'], " ");
    format!("{}\t{}\t{}\n", field(test), field(missing), field(cure))
}

/// Adds a line to the list of a run, whose number stands first in the file; a list of another run is replaced. Programs that run
/// side by side wait for each other.
fn append(file: &Path, run: u32, line: &str) -> std::io::Result<()> {
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let mut list =
        OpenOptions::new().create(true).truncate(false).read(true).write(true).open(file)?;
    list.lock()?;
    let mut first = String::new();
    BufReader::new(&list).read_line(&mut first)?;
    if first.trim_end() != run.to_string() {
        list.set_len(0)?;
        list.rewind()?;
        writeln!(list, "{run}")?;
    }
    list.seek(SeekFrom::End(0))?;
    list.write_all(line.as_bytes())
}

/// Units that no run of `cargo test` has: the libraries' manifests say why.
const UNITS: &str = "  cargo test --release --lib\n      units of private parts of cullet, cullet-bake, -cut, -draw, -io, -lab, -maps, -scenes\n";

/// For each thing that is missing how many tests of which package want it, under what gets it.
fn summary(lines: &str) -> String {
    let mut cures: BTreeMap<&str, BTreeMap<&str, BTreeSet<&str>>> = BTreeMap::new();
    for line in lines.lines() {
        let mut fields = line.splitn(3, '\t');
        let [test, _, cure] = [(); 3].map(|()| fields.next().unwrap_or_default());
        let package = test.split("::").next().unwrap_or_default();
        cures.entry(cure).or_default().entry(package).or_default().insert(test);
    }
    let list = std::fs::canonicalize(list()).unwrap_or_else(|_| list());
    let mut text = format!("\nTests that were skipped, and what gets them ({}):\n", list.display());
    for (cure, packages) in cures {
        let count =
            |(package, tests): (&&str, &BTreeSet<&str>)| format!("{package} {}", tests.len());
        let counts: Vec<String> = packages.iter().map(count).collect();
        text += &format!("  {cure}\n      {}\n", counts.join(", "));
    }
    text + UNITS + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skips_are_listed_by_their_run_and_those_of_another_run_go() {
        let file = std::env::temp_dir().join(format!("cullet-skips-{}/list", std::process::id()));
        append(&file, 7, &line(&test_name(), "of old", "x")).expect("written");
        append(&file, 8, &line(&test_name(), "a\tmodel", "set\nit")).expect("written");
        append(&file, 8, &line("program::test", "b", "c")).expect("written");
        let text = std::fs::read_to_string(&file).expect("read again");
        std::fs::remove_dir_all(file.parent().expect("a folder")).expect("removed");
        let lines: Vec<Vec<&str>> = text.lines().map(|l| l.split('\t').collect()).collect();
        assert_eq!(lines.len(), 3, "{text}");
        assert_eq!(lines[0], ["8"]);
        let test = "skip::tests::skips_are_listed_by_their_run_and_those_of_another_run_go";
        assert_eq!(lines[1], [&format!("cullet-testkit::{test}"), "a model", "set it"]);
        assert_eq!(lines[2], ["program::test", "b", "c"]);
    }

    #[test]
    fn a_list_that_cannot_be_written_is_an_error() {
        // As in a checkout that is read-only: a folder cannot be made where there is a file.
        let file = std::env::current_exe().expect("this program").join("list");
        assert!(append(&file, 1, "x\n").is_err());
    }

    #[test]
    fn tests_are_counted_by_package_under_what_gets_them() {
        let lines =
            "b::t\tx.obj\tset it\na::t\ty.obj\tset it\nb::t\tz.obj\tset it\nb::u\tgl\tget gl\n";
        let told = summary(lines);
        let lines: Vec<&str> = told.trim().lines().map(str::trim).collect();
        assert_eq!(lines[1..5], ["get gl", "b 1", "set it", "a 1, b 1"]);
        assert!(told.contains("cargo test --release --lib"));
    }

    #[test]
    fn a_process_is_within_those_that_started_it() {
        // Elsewhere nothing tells who started whom.
        if cfg!(target_os = "linux") {
            assert!(is_within(std::process::id()) && is_within(parent()));
        }
        assert!(!is_within(u32::MAX));
    }
}
