//! How large the library is, stripped: shared, and within a program that it is linked into.

use std::fs;
use std::path::Path;

use super::{Host, STATIC, text};
use crate::runner::Skip;
use crate::tools::{Done, command, is_ci, output, run, target};

/// Most bytes of a file, a little above what was measured on x86-64.
struct Limit {
    what: &'static str,
    most: u64,
}

/// The shared library, and a program of boxes alone that has the static one in it.
type Limits = [Limit; 2];

const WHOLE: Limits = [
    Limit { what: "shared library", most: 3_000_000 },
    Limit { what: "program with boxes", most: 800_000 },
];
/// A quarter of it prints backtraces of panics, which only a standard library without them leaves out.
const BOXES: Limits = [
    Limit { what: "shared library of boxes alone", most: 900_000 },
    Limit { what: "program with boxes of boxes alone", most: 810_000 },
];
const LEAST: Limits = [
    Limit { what: "shared library of boxes alone without backtraces", most: 600_000 },
    Limit { what: "program with boxes of boxes alone without backtraces", most: 600_000 },
];

/// Installs the last, in a folder of its own: by the compiler's options that are not stable, build
/// scripts that others share would be built anew at each turn.
pub(super) fn install_least(name: &str) -> Result<Host, String> {
    let folder = text(&target().join("host-c-least"));
    let of_boxes = [("CULLET_FEATURES", "boxes"), ("CULLET_NO_BACKTRACE", "1")];
    Host::install(name, &[&of_boxes[..], &[("CARGO_TARGET_DIR", &folder)]].concat())
}

/// Measures the builds, each in its tree; a program with a scene must not link where there is none.
pub(super) fn test(whole: &Host, boxes: &Host, skips: &mut Vec<Skip>) -> Done {
    let mut wrong = Vec::new();
    wrong.extend(both(whole, &WHOLE)?);
    wrong.extend(both(boxes, &BOXES)?);
    if link(boxes, "examples/frames.c", &boxes.work.join("frames_static")).is_ok() {
        wrong.push("a program with a scene links with a library of boxes alone".into());
    }
    if has_source() {
        wrong.extend(both(&install_least("least")?, &LEAST)?);
    } else {
        skips.push(Skip::new("the C library without backtraces", "rustup component add rust-src"));
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("; ")) }
}

/// Whether the source of the standard library is there, once CI has fetched it.
pub(super) fn has_source() -> bool {
    let is_there = || {
        let root = output("rustc", &["--print", "sysroot"]).unwrap_or_default();
        Path::new(root.trim()).join("lib/rustlib/src/rust/library").is_dir()
    };
    if !is_there() && is_ci() {
        output("rustup", &["component", "add", "rust-src"]);
    }
    is_there()
}

/// Measures a build, and runs the program; returns what is too large.
fn both(host: &Host, [shared, program]: &Limits) -> Result<Vec<String>, String> {
    let mut wrong = Vec::new();
    wrong.extend(measure(shared, host, &host.prefix.join("lib/libcullet.so.0"))?);
    let linked = host.work.join("boxes_static");
    link(host, "examples/boxes.c", &linked)?;
    host.run(&linked, &[])?;
    wrong.extend(measure(program, host, &linked)?);
    Ok(wrong)
}

/// Links an example with the static library; what nothing calls is left out.
fn link(host: &Host, source: &str, program: &Path) -> Done {
    let mut compile = command("gcc", &["-std=c11", "-O2", "-Wl,--gc-sections"]);
    compile.arg(format!("-I{}", text(&host.prefix.join("include"))));
    compile.arg(host.source.join(source)).arg("-o").arg(program);
    compile.arg(host.prefix.join("lib/libcullet.a")).args(STATIC);
    run(compile)
}

/// Returns what is wrong with the size of a file, once stripped.
fn measure(limit: &Limit, host: &Host, file: &Path) -> Result<Option<String>, String> {
    let Limit { what, most } = limit;
    let stripped = host.work.join("stripped");
    run(command("strip", &["-o", &text(&stripped), &text(file)]))?;
    let size = fs::metadata(&stripped).map_err(|e| format!("{}: {e}", stripped.display()))?.len();
    println!("{what}: {size} bytes, at most {most}");
    Ok((size > *most).then(|| format!("the {what} has {size} bytes: more than {most}")))
}
