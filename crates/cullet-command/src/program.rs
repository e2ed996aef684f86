//! From what a program did to how it ends.

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::console;
use crate::exit::{Exit, Outcome};

/// Runs a program: watches for Ctrl-C, says why it failed, and turns a panic into a report of a
/// fault of ours.
pub fn run(name: &'static str, work: impl FnOnce() -> Outcome) -> Exit {
    std::panic::set_hook(Box::new(move |info| report_panic(name, info)));
    console::watch_interrupts();
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(exit)) => exit,
        Ok(Err(failure)) => {
            let _ = writeln!(std::io::stderr().lock(), "error: {}", failure.message);
            failure.exit
        }
        Err(_) => Exit::Internal,
    }
}

/// A fault of ours: says where, and what to send.
fn report_panic(name: &str, info: &std::panic::PanicHookInfo<'_>) {
    let payload = info.payload();
    let what = payload.downcast_ref::<&str>().copied();
    let what =
        what.or(payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
    let at = info.location().map_or_else(String::new, |l| {
        let file = Path::new(l.file()).components().rev().take(2).collect::<Vec<_>>();
        let file: Vec<_> = file.iter().rev().map(|c| c.as_os_str().to_string_lossy()).collect();
        format!(" ({}:{})", file.join("/"), l.line())
    });
    let _ = writeln!(
        std::io::stderr().lock(),
        "internal error: {what}{at}\nThis is a fault of {name} {}, not of your input. Please report it \
         with the command line{}.",
        env!("CARGO_PKG_VERSION"),
        std::env::args().nth(1).map_or_else(String::new, |c| format!(" ({name} {c} ...)"))
    );
}
