//! How large the library is, stripped: shared, and within a program that it is linked into.

use std::fs;
use std::path::Path;

use super::{Host, STATIC, text};
use crate::tools::{Done, command, run};

/// What a file may have, in bytes: what was measured on x86-64, and a tenth more.
struct Limit {
    what: &'static str,
    most: u64,
}

/// The shared library, and a program of boxes alone that has the static one in it; of the whole library and
/// of the build with boxes alone.
const WHOLE: [Limit; 2] = [
    Limit { what: "shared library", most: 3_000_000 },
    Limit { what: "program with boxes", most: 600_000 },
];
const BOXES: [Limit; 2] = [
    Limit { what: "shared library with boxes alone", most: 600_000 },
    Limit { what: "program with boxes, from boxes alone", most: 600_000 },
];

/// Measures both builds, each in its tree; a program with a scene must not link where there is none.
pub(super) fn test(whole: &Host, boxes: &Host) -> Done {
    let mut wrong = Vec::new();
    for (host, [shared, program]) in [(whole, WHOLE), (boxes, BOXES)] {
        wrong.extend(measure(&shared, host, &host.prefix.join("lib/libcullet.so.0"))?);
        let linked = host.work.join("boxes_static");
        link(host, "examples/boxes.c", &linked)?;
        host.run(&linked, &[])?;
        wrong.extend(measure(&program, host, &linked)?);
    }
    if link(boxes, "examples/frames.c", &boxes.work.join("frames_static")).is_ok() {
        wrong.push("a program with a scene links with a library of boxes alone".into());
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("; ")) }
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
