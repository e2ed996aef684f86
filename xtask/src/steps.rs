//! The steps of `test`, in order: what fails fastest comes first.

use std::time::Instant;

use crate::graphics;
use crate::pictures;
use crate::tools::{Done, cargo, cargo_program, command, output, root, run};
use crate::web;

/// Packages whose tests run at every SIMD level.
const LEVELS: &[&str] = &["cullet"];

struct Step {
    name: &'static str,
    run: fn() -> Done,
}

const STEPS: &[Step] = &[
    Step { name: "format", run: || cargo(&["fmt", "--all", "--check"]) },
    Step {
        name: "lints",
        run: || {
            cargo(&[
                "clippy",
                "--workspace",
                "--all-targets",
                "--profile",
                "checked",
                "--",
                "-Dwarnings",
            ])
        },
    },
    Step { name: "docs", run: docs },
    Step { name: "graphics", run: graphics::prepare },
    Step { name: "tests", run: tests },
    Step { name: "levels", run: levels },
    Step { name: "features", run: features },
    Step { name: "examples", run: examples },
    Step { name: "neon", run: neon },
    Step { name: "licences", run: licences },
    Step { name: "book", run: book },
    Step { name: "web", run: web::test },
];

/// Runs the steps whose name contains `filter`.
pub(crate) fn test(filter: &str) -> Done {
    let mut done = 0;
    for step in STEPS.iter().filter(|s| s.name.contains(filter)) {
        println!("\n── {} ──", step.name);
        let start = Instant::now();
        (step.run)().map_err(|e| format!("step {}: {e}", step.name))?;
        println!("── {} done in {:.0} s", step.name, start.elapsed().as_secs_f64());
        done += 1;
    }
    if done == 0 {
        let names: Vec<_> = STEPS.iter().map(|s| s.name).collect();
        return Err(format!("no step is called {filter}; there are {}", names.join(", ")));
    }
    println!("\nall {done} steps done");
    Ok(())
}

fn docs() -> Done {
    let mut doc = command(&cargo_program(), &["doc", "--workspace", "--no-deps"]);
    doc.env("RUSTDOCFLAGS", "-Dwarnings");
    run(doc)
}

/// All tests. Where there is a graphics device, in software or not, those that need it must find it.
fn tests() -> Done {
    let mut test = command(&cargo_program(), &["test", "--workspace", "--profile", "checked"]);
    if graphics::is_there() && std::env::var_os("CI").is_some() {
        test.env("CULLET_REQUIRE_GPU", "1").env("WGPU_BACKEND", "vulkan");
    }
    run(test)
}

/// The tests once more with the scalar level beside those of the machine: the answers must not differ.
fn levels() -> Done {
    for package in LEVELS {
        let features = format!("{package}/force_support_fallback");
        cargo(&["test", "--package", package, "--profile", "checked", "--features", &features])?;
    }
    Ok(())
}

/// Each library alone, with no more features than it asks for: the workspace may lend it some.
fn features() -> Done {
    for package in ["cullet", "cullet-io", "cullet-draw"] {
        cargo(&["check", "--package", package, "--profile", "checked"])?;
    }
    Ok(())
}

/// Every example, of every package, must run to its end.
fn examples() -> Done {
    let metadata = output(&cargo_program(), &["metadata", "--no-deps", "--format-version", "1"])
        .ok_or("cargo metadata cannot be run")?;
    let metadata: serde_json::Value =
        serde_json::from_str(&metadata).map_err(|e| format!("cargo metadata: {e}"))?;
    for package in metadata["packages"].as_array().into_iter().flatten() {
        for target in package["targets"].as_array().into_iter().flatten() {
            let example =
                target["kind"].as_array().is_some_and(|k| k.iter().any(|k| k == "example"));
            let names = (package["name"].as_str(), target["name"].as_str());
            if let ((Some(package), Some(name)), true) = (names, example) {
                cargo(&[
                    "run",
                    "--quiet",
                    "--profile",
                    "checked",
                    "-p",
                    package,
                    "--example",
                    name,
                ])?;
            }
        }
    }
    Ok(())
}

/// The NEON code is compiled, never run: no machine of ours has it.
fn neon() -> Done {
    const TARGET: &str = "aarch64-unknown-linux-gnu";
    let installed = output("rustup", &["target", "list", "--installed"]).unwrap_or_default();
    if !installed.lines().any(|l| l == TARGET) {
        println!("skipped: NEON is not compiled here; rustup target add {TARGET}");
        return Ok(());
    }
    cargo(&["check", "--package", "cullet", "--target", TARGET])
}

fn licences() -> Done {
    if output(&cargo_program(), &["deny", "--version"]).is_none() {
        println!("skipped: licences are not checked here; cargo install --locked cargo-deny");
        return Ok(());
    }
    cargo(&["deny", "--offline", "check", "licenses", "bans", "sources"])
}

fn book() -> Done {
    pictures::all_there()?;
    if output("mdbook", &["--version"]).is_none() {
        println!("skipped: the book is not built here; cargo install --locked mdbook");
        return Ok(());
    }
    run(command("mdbook", &["build", "docs"]))
}

/// `cullet bench`, and the benches for developers.
pub(crate) fn bench() -> Done {
    cargo(&["run", "--release", "--", "bench"])?;
    cargo(&["bench", "--workspace", "--benches"])
}

/// The cuts of `cullet bench`, and of trimesh and VTK beside them.
pub(crate) fn peers_cut() -> Done {
    cargo(&["build", "--release"])?;
    let script = root().join("benches/peers/cut_python.py");
    let program = root().join("target/release/cullet");
    run(command("python3", &[&script.to_string_lossy(), &program.to_string_lossy()]))
}

/// The README's two commands where nobody has been before: a fresh clone, an empty target folder.
pub(crate) fn demo() -> Done {
    let folder = std::env::temp_dir().join(format!("cullet-demo-{}", std::process::id()));
    let clone = folder.join("cullet");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let result = in_clone(&clone.to_string_lossy());
    let _ = std::fs::remove_dir_all(&folder);
    result
}

fn in_clone(clone: &str) -> Done {
    let here = root();
    run(command("git", &["clone", "--quiet", "--no-hardlinks", &here.to_string_lossy(), clone]))?;
    let there = |args: &[&str]| {
        let mut c = command(&cargo_program(), args);
        // This program's own cargo would have the clone share our target folder.
        c.current_dir(clone).env_remove("CARGO_TARGET_DIR");
        c
    };
    let start = Instant::now();
    run(there(&["build", "--release"]))?;
    let built = start.elapsed();
    run(there(&["run", "--release", "--", "report"]))?;
    let ran = start.elapsed() - built;
    println!("built in {:.0} s, reported in {:.0} s", built.as_secs_f64(), ran.as_secs_f64());
    for file in ["index.html", "report.json", "views.csv"] {
        let path = std::path::Path::new(clone).join("report").join(file);
        let size = std::fs::metadata(&path).map_err(|e| format!("{}: {e}", path.display()))?.len();
        println!("report/{file}: {size} bytes");
    }
    // The second command is what runs this one in CI; its first step shows that it starts from here too.
    run(there(&["xtask", "test", "format"]))
}
