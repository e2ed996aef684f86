//! Runs steps one after the other, whatever becomes of them, and sums up: what passed, what failed,
//! and in one list what could not be tried here and which command gets it.

use std::time::{Duration, Instant};

use crate::tools::Done;

/// Something that is not tried on this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Skip {
    /// The check that is skipped.
    pub(crate) what: String,
    /// The command that gets what is missing, or a line that says where it would lie.
    pub(crate) cure: String,
}

impl Skip {
    pub(crate) fn new(what: impl Into<String>, cure: impl Into<String>) -> Self {
        Self { what: what.into(), cure: cure.into() }
    }
}

/// End of a step that does not fail.
pub(crate) enum End {
    Passed,
    /// It passed, but for what is named.
    Partly(Vec<Skip>),
    Skipped(Skip),
    /// It failed for this reason, and left out what is named.
    Failed(String, Vec<Skip>),
    /// It passed at this commit, and nothing that it depends on has changed since.
    Unchanged(String),
}

impl End {
    /// The end of tests that passed, but for those that were skipped.
    pub(crate) fn of(skipped: impl IntoIterator<Item = SkippedTest>) -> Self {
        Self::from(Ok(()), skipped)
    }

    /// The end of tests, some of which were skipped.
    pub(crate) fn from(done: Done, skipped: impl IntoIterator<Item = SkippedTest>) -> Self {
        let skips: Vec<Skip> = skipped.into_iter().map(Into::into).collect();
        match done {
            Err(why) => Self::Failed(why, skips),
            Ok(()) if skips.is_empty() => Self::Passed,
            Ok(()) => Self::Partly(skips),
        }
    }
}

/// How a step ends; the error says in a line why it failed.
pub(crate) type Ended = Result<End, String>;

/// The end of what leaves nothing out.
pub(crate) fn all(done: Done) -> Ended {
    done.map(|()| End::Passed)
}

/// A step: its name, and what it runs.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    pub(crate) name: &'static str,
    pub(crate) run: fn() -> Ended,
}

/// Result of a step.
struct Row {
    name: &'static str,
    end: Ended,
    took: Duration,
}

impl Row {
    /// Why it failed, if it did.
    fn failure(&self) -> Option<&str> {
        match &self.end {
            Err(why) | Ok(End::Failed(why, _)) => Some(why),
            Ok(_) => None,
        }
    }
}

/// Runs the step that is called `filter` or, if none is, those whose name contains it, all of them,
/// and prints the sums; an error names those that failed.
pub(crate) fn run(steps: &[Step], filter: &str) -> Done {
    run_by(steps, filter, |step| (step.run)())
}

/// The same, each run by `ended`, which may know how it ends.
pub(crate) fn run_by(steps: &[Step], filter: &str, ended: impl Fn(&Step) -> Ended) -> Done {
    let is_name = steps.iter().any(|s| s.name == filter);
    let fits = |s: &&Step| if is_name { s.name == filter } else { s.name.contains(filter) };
    let chosen: Vec<&Step> = steps.iter().filter(fits).collect();
    if chosen.is_empty() {
        let names: Vec<_> = steps.iter().map(|s| s.name).collect();
        return Err(format!("no step is called {filter}; there are {}", names.join(", ")));
    }
    let start = Instant::now();
    let mut rows = Vec::new();
    for (i, step) in chosen.iter().enumerate() {
        let so_far = time(start.elapsed());
        println!(
            "\n── step {} of {}: {} (time so far {so_far}) ──",
            i + 1,
            chosen.len(),
            step.name
        );
        let begun = Instant::now();
        let end = ended(step);
        match &end {
            Ok(End::Skipped(skip)) => println!("skipped: {}; {}", skip.what, skip.cure),
            // Again at the end, where it can be found.
            Err(e) | Ok(End::Failed(e, _)) => println!("failed: {e}"),
            Ok(End::Unchanged(commit)) => println!("nothing changed since it passed at {commit}"),
            Ok(_) => {}
        }
        rows.push(Row { name: step.name, end, took: begun.elapsed() });
    }
    println!("\n{}", table(&rows, start.elapsed()));
    println!("{}", missing(&rows));
    let kept = |row: &Row| matches!(row.end, Ok(End::Unchanged(_))).then_some(row.name);
    let kept: Vec<&str> = rows.iter().filter_map(kept).collect();
    if !kept.is_empty() {
        let kept = kept.join(", ");
        println!(
            "not run, for nothing that they depend on changed since they passed (CULLET_ALL=1 runs them): {kept}"
        );
    }
    let failed: Vec<String> = rows
        .iter()
        .filter_map(|row| row.failure().map(|e| format!("  {}: {e}", row.name)))
        .collect();
    if failed.is_empty() {
        return Ok(());
    }
    Err(format!("{} of {} steps failed:\n{}", failed.len(), rows.len(), failed.join("\n")))
}

/// The steps with what became of them and how long they took.
fn table(rows: &[Row], took: Duration) -> String {
    let mut text = format!("{:<14} {:<8} {:>7}\n", "step", "", "seconds");
    for row in rows {
        let end = match row.end {
            Ok(End::Passed | End::Partly(_)) => "passed",
            Ok(End::Skipped(_)) => "skipped",
            Ok(End::Unchanged(_)) => "kept",
            Ok(End::Failed(..)) | Err(_) => "FAILED",
        };
        text += &format!("{:<14} {end:<8} {:>7.0}\n", row.name, row.took.as_secs_f64());
    }
    text + &format!("{:<14} {:<8} {:>7.0}\n", "in all", "", took.as_secs_f64())
}

/// The list of what was not tried, with what gets it, each cure once.
fn missing(rows: &[Row]) -> String {
    let skips = rows.iter().flat_map(|row| match &row.end {
        Ok(End::Skipped(skip)) => std::slice::from_ref(skip),
        Ok(End::Partly(skips) | End::Failed(_, skips)) => skips,
        _ => &[],
    });
    let mut by_cure: Vec<(&str, Vec<&str>)> = Vec::new();
    for skip in skips {
        match by_cure.iter_mut().find(|(cure, _)| *cure == skip.cure) {
            Some((_, whats)) => whats.push(&skip.what),
            None => by_cure.push((&skip.cure, vec![&skip.what])),
        }
    }
    if by_cure.is_empty() {
        return "nothing was skipped".to_owned();
    }
    let mut text = "not tried here, and what gets it:".to_owned();
    for (cure, whats) in by_cure {
        text += &format!("\n  {cure}");
        for what in whats {
            text += &format!("\n      {what}");
        }
    }
    text
}

/// A test that was skipped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SkippedTest {
    /// Its package, and its path there.
    test: String,
    lacks: Vec<String>,
    cure: String,
}

impl SkippedTest {
    /// Its name as the test harness knows it.
    pub(crate) fn path(&self) -> &str {
        self.test.split_once("::").map_or(&self.test, |(_, path)| path)
    }

    /// Whether it wants the test data, and is known by name.
    pub(crate) fn lacks_data(&self) -> bool {
        self.cure.contains("CULLET_DATA") && self.path() != "main"
    }
}

impl From<SkippedTest> for Skip {
    fn from(test: SkippedTest) -> Self {
        let more = match test.lacks.len() {
            1 => String::new(),
            n => format!(", and {} more", n - 1),
        };
        Self::new(format!("{} ({}{more})", test.test, test.lacks[0]), test.cure)
    }
}

/// Parses the lines that skipped tests write, as `cullet_testkit::skip` does: the test, what is
/// missing and what gets it; a test that lacks several things is one. Before them stands the number
/// of the run.
pub(crate) fn skipped_tests(text: &str) -> Vec<SkippedTest> {
    let mut lines: Vec<&str> = text.lines().collect();
    // In whichever order the tests ended.
    lines.sort_unstable();
    lines.dedup();
    let mut tests: Vec<SkippedTest> = Vec::new();
    for line in lines {
        let [test, lacks, cure] = line.splitn(3, '\t').collect::<Vec<_>>()[..] else { continue };
        match tests.last_mut() {
            Some(last) if last.test == test && last.cure == cure => last.lacks.push(lacks.into()),
            _ => tests.push(SkippedTest {
                test: test.into(),
                lacks: vec![lacks.into()],
                cure: cure.into(),
            }),
        }
    }
    tests
}

/// A time for people.
fn time(t: Duration) -> String {
    let seconds = t.as_secs();
    if seconds < 60 {
        return format!("{seconds} s");
    }
    format!("{} min {} s", seconds / 60, seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_follows_a_failed_step_runs_too_and_the_error_names_the_failure() {
        use std::sync::atomic::{AtomicU32, Ordering};
        static RAN: AtomicU32 = AtomicU32::new(0);
        let last = || {
            RAN.fetch_add(1, Ordering::Relaxed);
            Ok(End::Passed)
        };
        let steps = [
            Step { name: "bad", run: || Err("it broke".to_owned()) },
            Step { name: "worse", run: || Ok(End::Failed("it fell".to_owned(), Vec::new())) },
            Step { name: "absent", run: || Ok(End::Skipped(Skip::new("a", "b"))) },
            Step { name: "last", run: last },
            Step { name: "last-but", run: || Err("not asked for".to_owned()) },
        ];
        let error = run(&steps, "").expect_err("a step failed");
        assert!(error.contains("3 of 5") && error.contains("worse: it fell"), "{error}");
        assert_eq!(RAN.load(Ordering::Relaxed), 1);
        // Of that name; its letters are in another.
        assert_eq!(run(&steps, "last"), Ok(()));
        assert_eq!(RAN.load(Ordering::Relaxed), 2);
        let error = run(&steps, "none").expect_err("no such step");
        assert!(error.contains("bad, worse, absent, last, last-but"), "{error}");
    }

    #[test]
    fn every_skip_is_listed_under_what_gets_it() {
        let row = |name, end| Row { name, end, took: Duration::from_millis(1600) };
        let rows = [
            row("book", Ok(End::Skipped(Skip::new("the book", "get mdbook")))),
            row("tests", Ok(End::Partly(vec![Skip::new("t", "data"), Skip::new("u", "data")]))),
            row("more", Ok(End::Partly(vec![Skip::new("links of the book", "get mdbook")]))),
            row("bad", Err("broke".into())),
            row("worse", Ok(End::Failed("broke".into(), vec![Skip::new("v", "data")]))),
        ];
        let list = missing(&rows);
        let lines: Vec<&str> = list.lines().map(str::trim).collect();
        assert_eq!(
            lines[1..],
            ["get mdbook", "the book", "links of the book", "data", "t", "u", "v"]
        );
        let table = table(&rows, Duration::from_secs(9));
        for (name, end) in
            [("book", "skipped"), ("tests", "passed"), ("bad", "FAILED"), ("worse", "FAILED")]
        {
            let line = table.lines().find(|l| l.starts_with(name)).expect("a row");
            assert_eq!(line.split_whitespace().collect::<Vec<_>>()[1..], [end, "2"], "{table}");
        }
        assert_eq!(missing(&rows[3..4]), "nothing was skipped");
    }

    #[test]
    fn a_test_that_lacks_several_models_is_one() {
        let text = "77\nb::t\tx.obj\tset CULLET_DATA\na::m::t\ty.obj\tget it\nb::t\tz.obj\tset CULLET_DATA\n";
        let tests = skipped_tests(text);
        assert_eq!((tests[0].path(), tests[0].lacks_data()), ("m::t", false));
        assert_eq!((tests[1].path(), tests[1].lacks_data()), ("t", true));
        let skips: Vec<Skip> = tests.into_iter().map(Into::into).collect();
        assert_eq!(skips[0], Skip::new("a::m::t (y.obj)", "get it"));
        assert_eq!(skips[1..], [Skip::new("b::t (x.obj, and 1 more)", "set CULLET_DATA")]);
        assert!(skipped_tests("").is_empty());
    }

    #[test]
    fn times_are_told_in_minutes() {
        assert_eq!(time(Duration::from_secs(59)), "59 s");
        assert_eq!(time(Duration::from_secs(605)), "10 min 5 s");
    }
}
