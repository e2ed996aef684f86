//! Output for people: lines, progress bars, and Ctrl-C.

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::exit::Exit;

/// Where lines for people go, and whether they are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    /// Results and errors only.
    pub quiet: bool,
    /// The standard output carries JSON, so lines for people go to standard error.
    pub json_on_stdout: bool,
}

impl Console {
    /// A console; `json` is where JSON is written to.
    pub fn new(quiet: bool, json: Option<&Path>) -> Self {
        Self { quiet, json_on_stdout: json.is_some_and(|p| p == Path::new("-")) }
    }

    /// A line of the result.
    pub fn line(&self, text: impl AsRef<str>) {
        let text = text.as_ref();
        // A reader that has gone (`| head`) is no fault of ours.
        let _ = if self.json_on_stdout {
            if self.quiet { Ok(()) } else { writeln!(std::io::stderr().lock(), "{text}") }
        } else {
            writeln!(std::io::stdout().lock(), "{text}")
        };
    }

    /// A line that `--quiet` silences.
    pub fn note(&self, text: impl AsRef<str>) {
        if !self.quiet {
            let _ = writeln!(std::io::stderr().lock(), "{}", text.as_ref());
        }
    }

    /// A bar over `length` steps of `what`.
    pub fn progress(&self, what: &'static str, length: u64) -> Progress {
        let shown = !self.quiet && std::io::stderr().is_terminal();
        Progress { what, length, done: 0, start: Instant::now(), shown, bar: None }
    }

    /// A bar over a share of work.
    pub fn share_bar(&self) -> ShareBar {
        ShareBar(Mutex::new((self.progress("thousandths", THOUSANDTHS), 0)))
    }
}

/// A progress bar that appears only once the work is seen to take more than two seconds.
#[derive(Debug)]
pub struct Progress {
    what: &'static str,
    length: u64,
    done: u64,
    start: Instant,
    shown: bool,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Work shorter than this needs no bar.
    const PATIENCE: Duration = Duration::from_secs(2);

    /// One step is done.
    pub fn step(&mut self) {
        self.steps(1);
    }

    /// So many steps are done.
    pub fn steps(&mut self, count: u64) {
        self.done += count;
        if !self.shown {
            return;
        }
        let whole = self.start.elapsed().mul_f64(self.length as f64 / self.done.max(1) as f64);
        if self.bar.is_none() && whole > Self::PATIENCE {
            let bar = ProgressBar::new(self.length).with_elapsed(self.start.elapsed());
            let template = "{msg} {wide_bar} {pos}/{len}, {eta} left";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            bar.set_message(self.what);
            self.bar = Some(bar);
        }
        if let Some(bar) = &self.bar {
            bar.set_position(self.done);
        }
    }

    /// Removes the bar.
    pub fn finish(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// A bar over a share of work, 0 to 1, that any thread may move; it never goes back.
#[derive(Debug)]
pub struct ShareBar(Mutex<(Progress, u64)>);

/// Steps of such a bar.
const THOUSANDTHS: u64 = 1000;

impl ShareBar {
    /// Moves it.
    pub fn to(&self, share: f64) {
        if let Ok(mut bar) = self.0.lock() {
            let (progress, shown) = &mut *bar;
            let now = (share * THOUSANDTHS as f64) as u64;
            progress.steps(now.saturating_sub(*shown));
            *shown = now.max(*shown);
        }
    }

    /// Takes it away.
    pub fn finish(&self) {
        if let Ok(mut bar) = self.0.lock() {
            bar.0.finish();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on the first Ctrl-C requests a stop after the current view or step, and a second one
/// stops at once.
pub fn watch_interrupts() {
    // Where no handler can be set, Ctrl-C ends the program as it would have without one.
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(Exit::Interrupted as u8));
        }
        let _ = writeln!(
            std::io::stderr().lock(),
            "\nstopping after this step; Ctrl-C again stops at once"
        );
    });
}

/// Whether Ctrl-C was pressed.
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// A number with thin groups of thousands, for people: `1 234 567`.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            // A narrow no-break space: groups stay on one line and never read as two numbers.
            text.push('\u{202f}');
        }
        text.push(c);
    }
    text
}

/// A number with the words that agree with it: `1 view`, `2 views`, `1 mesh owns`, `1 234 meshes
/// own`.
pub fn count(n: u64, one: &str, many: &str) -> String {
    format!("{} {}", grouped(n), agree(n, one, many))
}

/// Returns the one of the two words that agrees with the number.
pub fn agree<'a>(n: u64, one: &'a str, many: &'a str) -> &'a str {
    if n == 1 { one } else { many }
}

/// `part` of `whole` in per cent, with one digit where that says more than none; 0 for 0 of 0.
pub fn percent(part: u64, whole: u64) -> String {
    if whole == 0 {
        return "0 %".into();
    }
    let p = part as f64 / whole as f64 * 100.0;
    // "100 %" and "0 %" are claims about every one, so near misses keep a digit.
    if part == whole || part == 0 || (10.0..99.0).contains(&p) {
        format!("{p:.0} %")
    } else if p < 0.1 {
        "under 0.1 %".into()
    } else if p > 99.9 {
        "over 99.9 %".into()
    } else {
        format!("{p:.1} %")
    }
}

/// A figure with as many digits as say something: two behind the first that is not zero below 10,
/// none from 100 up.
#[must_use]
pub fn digits(value: f64) -> String {
    if !value.is_finite() || value == 0.0 || value.abs() >= 100.0 {
        return format!("{value:.0}");
    }
    let places = (1 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.places$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_by_thousands() {
        let plain = |n| grouped(n).replace('\u{202f}', " ");
        assert_eq!(plain(0), "0");
        assert_eq!(plain(999), "999");
        assert_eq!(plain(1000), "1 000");
        assert_eq!(plain(1234567), "1 234 567");
    }

    #[test]
    fn words_agree_with_their_number() {
        assert_eq!(count(0, "view", "views"), "0 views");
        assert_eq!(count(1, "mesh owns", "meshes own"), "1 mesh owns");
        assert_eq!(count(1234, "view", "views").replace('\u{202f}', " "), "1 234 views");
    }

    #[test]
    fn per_cent_never_rounds_to_all_or_nothing() {
        assert_eq!(percent(1, 1), "100 %");
        assert_eq!(percent(0, 0), "0 %");
        assert_eq!(percent(999_999, 1_000_000), "over 99.9 %");
        assert_eq!(percent(1, 1_000_000), "under 0.1 %");
        assert_eq!(percent(1, 2), "50 %");
        assert_eq!(percent(995, 1000), "99.5 %");
    }

    #[test]
    fn figures_have_two_digits_or_are_whole() {
        for (value, text) in [
            (0.0, "0"),
            (0.00249, "0.0025"),
            (0.387, "0.39"),
            (3.24, "3.2"),
            (32.4, "32"),
            (324.15, "324"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(digits(value), text);
        }
    }
}
