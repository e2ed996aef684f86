//! Everything that CI does, runnable by hand: `cargo xtask help` lists it.
#![forbid(unsafe_code)]

mod ahead;
mod benches;
mod bindings;
mod book;
mod changed;
mod checked;
mod ci;
mod compiler;
mod cross;
mod figures;
mod gpu_record;
mod graphics;
mod links;
mod pictures;
mod plain;
mod platforms;
mod readers;
mod release;
mod rooms;
mod runner;
mod steps;
mod tools;
mod web;

use std::process::ExitCode;

const HELP: &str = "\
cargo xtask test       everything that can be checked here: format, lints, docs, `cargo test --release`, tests at every
                       SIMD level and on devices, examples, hosts; ends with what was skipped, and what gets it
cargo xtask test NAME  only the step of that name, or those whose name contains NAME
cargo xtask machines [nothing | opengl | vulkan | both]
                       the tests that use a graphics device, as a machine with no more than that runs them; or as each of the four
cargo xtask slow       the tests of `cargo test --release` that take over 10 s without a reason in .config/nextest.toml
cargo xtask web        builds the viewer's page, then serves it on localhost
cargo xtask web SCENE  the same with a scene: a file, or a built-in one
cargo xtask web --no-serve
                       only builds it, into target/page
cargo xtask pictures   draws the pictures of README and docs again
cargo xtask figures [NAME] [--write]
                       runs the commands that figures of README and docs come from, and compares; with NAME those whose
                       file or command contains it; --write puts the new ones into the text
cargo xtask bindings [c | csharp | python | web | bevy | godot]
                       builds the bindings, or one of them, and tests each in its host, once the answers that all are held
                       against are made; says what is installed for it
cargo xtask book       builds the book with the viewer's page in it, into docs/book, to be published as it is
cargo xtask bench      cullet bench, then the criterion benches
cargo xtask bench-viewer [SCENE]
                       what each stage saves the viewer's renderer, against the hardware's back-face culling alone
cargo xtask bench-gpu  what culling on the graphics device takes and saves; of any device, software ones too
cargo xtask bench-gpu --record
                       the same within four minutes, once it is compiled, and written into docs/gpu.json and the table of
                       docs/src/gpu.md: a column for each device, and one for software
cargo xtask bench-gpu masks [FOLDER]
                       the table and graph of normal masks with the device's own back-face culling on, and what tests and
                       triangles cost there, as --costs takes it; into FOLDER, else target/bench-gpu
cargo xtask peers-cut  cullet's cuts beside those of trimesh and VTK, in a Python environment made for it
cargo xtask semver COMMIT
                       what changed in the public interface since a commit or tag, and whether the version says so
cargo xtask release --dry-run [NAME]
                       makes everything that a release uploads, or what NAME is part of, runs the first example of each from it
                       alone, and lists sizes, checksums and what is left to do by hand
cargo xtask bare       the README's two commands as a stranger meets them: in a fresh clone of what is committed,
                       with no data beside it and nothing used but Rust and compilers of C and C++
cargo xtask ci         what CI runs: bare, then in the same clone everything else that test has; what is missing is installed;
                       clone and builds are kept in CULLET_CACHE. Unless CULLET_ALL=1, steps do not run again whose files
                       have not changed since they passed, and renderers and systems like others are left out";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let done = match args[..] {
        ["test"] => steps::test(""),
        ["test", name] => steps::test(name),
        ["machines"] => steps::machines(""),
        ["machines", name] => steps::machines(name),
        ["slow"] => plain::slow(),
        ["web"] => web::serve(None),
        ["web", "--no-serve"] => web::build(),
        ["web", scene] if !scene.starts_with('-') => web::serve(Some(scene)),
        ["pictures"] => pictures::draw(),
        ["figures"] => figures::compare("", false),
        ["figures", "--write"] => figures::compare("", true),
        ["figures", name, "--write"] => figures::compare(name, true),
        ["figures", name] if !name.starts_with('-') => figures::compare(name, false),
        ["bindings"] => bindings::test(""),
        ["bindings", name] if !name.starts_with('-') => bindings::test(name),
        ["book"] => book::build(),
        ["bench"] => benches::all(),
        ["bench-viewer"] => benches::viewer(None),
        ["bench-viewer", scene] if !scene.starts_with('-') => benches::viewer(Some(scene)),
        ["bench-gpu"] => benches::gpu(),
        ["bench-gpu", "--record"] => gpu_record::record(),
        ["bench-gpu", "masks"] => benches::masks(None),
        ["bench-gpu", "masks", folder] => benches::masks(Some(folder)),
        ["peers-cut"] => benches::peers_cut(),
        ["semver", since] if !since.starts_with('-') => release::semver(since),
        ["release", "--dry-run"] => release::rehearse(""),
        ["release", "--dry-run", name] => release::rehearse(name),
        ["bare"] => ci::bare(),
        ["ci"] => ci::all(),
        // For `ci` alone.
        ["rest"] => ci::rest(),
        ["ahead"] => ahead::build(),
        [] | ["help" | "--help" | "-h"] => {
            println!("{HELP}");
            return ExitCode::SUCCESS;
        }
        _ => {
            eprintln!("xtask: unknown: {}\n{HELP}", args.join(" "));
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}
