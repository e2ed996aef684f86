//! How a test says that it was skipped.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;

/// Says that the running test, or a part of it, is skipped: what is missing, and what would get it.
///
/// The line goes to the test's output, which is hidden unless it fails or `--nocapture` is given; and to the file
/// that `CULLET_SKIPPED` names, where `cargo xtask test` reads it. Fields there are separated by tabs: the test
/// program and test, what is missing, what gets it.
///
/// # Panics
///
/// When that file cannot be written: a skip that nobody hears of would pass for a success.
pub fn skip(missing: &str, cure: &str) {
    println!("skipped: {missing}, {cure}");
    let Some(file) = std::env::var_os("CULLET_SKIPPED") else { return };
    let file = Path::new(&file);
    if let Err(e) = append(file, &line(&test_name(), missing, cure)) {
        panic!("{}: {e}; it is what CULLET_SKIPPED says", file.display());
    }
}

/// The running test: its program without the hash that cargo adds, and its path in it.
fn test_name() -> String {
    let program = std::env::current_exe().ok();
    let program =
        program.as_deref().and_then(Path::file_stem).unwrap_or_default().to_string_lossy();
    let program = program.rsplit_once('-').map_or(&*program, |(name, _)| name);
    // The test harness names its threads; with --test-threads=1 it runs tests in the main one.
    let thread = std::thread::current();
    format!("{program}::{}", thread.name().unwrap_or("main"))
}

/// A line of the file: its fields hold neither tabs nor line breaks.
fn line(test: &str, missing: &str, cure: &str) -> String {
    let field = |text: &str| text.replace(['\t', '\n', '\r'], " ");
    format!("{}\t{}\t{}\n", field(test), field(missing), field(cure))
}

/// Written at once, so that lines of programs that run side by side do not mix.
fn append(file: &Path, line: &str) -> std::io::Result<()> {
    OpenOptions::new().create(true).append(true).open(file)?.write_all(line.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skips_are_appended_with_their_test() {
        let file = std::env::temp_dir().join(format!("cullet-skips-{}", std::process::id()));
        let _ = std::fs::remove_file(&file);
        append(&file, &line(&test_name(), "a\tmodel", "set\nit")).expect("written");
        append(&file, &line("program::test", "b", "c")).expect("written");
        let text = std::fs::read_to_string(&file).expect("read again");
        std::fs::remove_file(&file).expect("removed");
        let lines: Vec<Vec<&str>> = text.lines().map(|l| l.split('\t').collect()).collect();
        assert_eq!(lines.len(), 2, "{text}");
        assert!(lines[0][0].starts_with("cullet_testkit::"), "{text}");
        assert_eq!(lines[0][1..], ["a model", "set it"]);
        assert_eq!(lines[1], ["program::test", "b", "c"]);
    }

    #[test]
    fn a_file_that_cannot_be_written_is_an_error() {
        let folder = std::env::temp_dir().join("cullet-no-such-folder/skips");
        assert!(append(&folder, "x\n").is_err());
    }
}
