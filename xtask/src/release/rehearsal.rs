//! A rehearsal of a release: everything that would be uploaded is made, and the first example of its
//! README is run from that alone. Nothing is uploaded.

use std::fs;
use std::path::Path;

use super::folders::{artefacts, at, empty, first_example, machine, pack, run_in, text, work};
use super::{current_version, libraries, published};
use crate::bindings::{python, web};
use crate::cross;
use crate::runner::{self, End, Ended, Step, all};
use crate::tools::{Done, cargo, cargo_program, command, root, run, target};

/// The artefacts, each made and used. The programs come first: they write the scene that others open.
const STEPS: &[Step] = &[
    Step { name: "programs", run: programs },
    Step { name: "crates", run: crates },
    Step { name: "c", run: libraries::c },
    Step { name: "c-arm", run: || libraries::c_for(&cross::ARM) },
    Step { name: "c-windows", run: || libraries::c_for(&cross::WINDOWS) },
    Step { name: "godot", run: libraries::godot },
    Step { name: "wheel", run: wheel },
    Step { name: "npm", run: npm },
];

const BY_HAND: &str = "\
by hand, in this order:
  1  the date of the version in CHANGELOG.md and in those of bindings/; a commit, a tag v{version}
  2  cargo xtask ci, green on that commit; cargo xtask semver TAG, once there is a release to compare with
  3  accounts and rights on crates.io, npm, PyPI, GitHub and the Godot Asset Library
  4  cargo publish, with the packages that `crates` printed; it waits for each
  5  npm publish cullet-{version}.tgz; twine upload pycullet-{version}*
  6  a release on GitHub with the archives and SHA256SUMS: cargo binstall finds them there
  7  cullet-godot-{version}.zip to the Godot Asset Library, by its form; the book, from cargo xtask book, to where books are served
  8  README: the lines that say how to install, in place of \"Nothing is published yet\"";

/// Makes and uses the artefact that is called `filter` or else those whose name contains it, and lists their sizes and checksums.
pub(crate) fn rehearse(filter: &str) -> Done {
    let _ = fs::remove_dir_all(work());
    for folder in [artefacts(), work()] {
        fs::create_dir_all(&folder).map_err(|e| at(&folder, e))?;
    }
    runner::run(STEPS, filter)?;
    checksums()?;
    println!("\n{}", BY_HAND.replace("{version}", &current_version()?));
    Ok(())
}

/// Archive of the programs that need nothing but themselves, as `cargo binstall` expects it.
fn programs() -> Ended {
    let programs = ["cullet", "cullet-baker"];
    cargo(&[
        "build",
        "--release",
        "--quiet",
        "--package",
        "cullet-cli",
        "--package",
        "cullet-baker",
    ])?;
    let name = format!("cullet-{}-{}", current_version()?, machine()?);
    let stage = empty("stage")?.join(&name);
    fs::create_dir_all(&stage).map_err(|e| at(&stage, e))?;
    for program in programs {
        let (from, to) = (target().join("release").join(program), stage.join(program));
        run(command("strip", &["-o", &text(&to), &text(&from)]))?;
    }
    for file in ["README.md", "LICENSE-MIT", "LICENSE-APACHE"] {
        fs::copy(root().join(file), stage.join(file)).map_err(|e| at(&stage, e))?;
    }
    let unpacked = pack(stage.parent().unwrap_or(&stage), &name)?;
    let cullet = unpacked.join("cullet");
    run_in(&unpacked, &cullet, &["report", "--views", "2", "--quiet"])?;
    // The baker is found beside it.
    all(run_in(&unpacked, &cullet, &["bake", "solids", "-o", "scene.glb", "--quiet"]))
}

/// The crates as crates.io takes them, a project that has nothing but them, and their documentation.
fn crates() -> Ended {
    let published = published()?;
    let mut words = vec!["publish", "--dry-run", "--no-verify", "--allow-dirty"];
    words.extend(published.iter().map(String::as_str));
    cargo(&words)?;
    // A dry run leaves no packages behind.
    cargo(&[&["package", "--quiet"], &words[2..]].concat())?;
    let (version, user) = (current_version()?, empty("crate-user")?);
    let [source, examples] = ["src", "examples"].map(|name| user.join(name));
    for folder in [&source, &examples] {
        fs::create_dir_all(folder).map_err(|e| at(folder, e))?;
    }
    fs::write(source.join("lib.rs"), "").map_err(|e| at(&source, e))?;
    let names: Vec<&String> = published.iter().filter(|word| *word != "--package").collect();
    let (mut patches, mut members, mut needed) = (String::new(), String::new(), String::new());
    for name in &names {
        let folder = format!("{name}-{version}");
        let file = format!("{folder}.crate");
        let (from, to) = (target().join("package").join(&file), artefacts().join(&file));
        fs::copy(&from, &to).map_err(|e| at(&from, e))?;
        run(command("tar", &["-xzf", &text(&to), "-C", &text(&user)]))?;
        patches += &format!("{name} = {{ path = \"{folder}\" }}\n");
        members += &format!("\"{folder}\", ");
        // Programs have none in Rust.
        if let Ok(example) = first_example(&user.join(folder).join("README.md"), "rust") {
            needed += &format!("{name} = \"{version}\"\n");
            let whole = format!(
                "fn main() -> Result<(), Box<dyn std::error::Error>> {{\n{example}Ok(())\n}}\n"
            );
            let file = examples.join(format!("{name}.rs"));
            fs::write(&file, whole).map_err(|e| at(&file, e))?;
        }
    }
    let manifest = format!(
        "[package]\nname = \"user\"\nedition = \"2024\"\n[dependencies]\n{needed}\
         [workspace]\nmembers = [{members}]\n[patch.crates-io]\n{patches}"
    );
    fs::write(user.join("Cargo.toml"), manifest).map_err(|e| at(&user, e))?;
    let cargo = cargo_program();
    run_in(&user, Path::new(&cargo), &["run", "--quiet", "--example", "cullet"])?;
    // Others open files of a reader's own.
    run_in(&user, Path::new(&cargo), &["check", "--quiet", "--examples"])?;
    let takes_all = |name: &&String| {
        let manifest = user.join(format!("{name}-{version}/Cargo.toml"));
        fs::read_to_string(manifest).is_ok_and(|text| text.contains(DOCS_SETTING))
    };
    let (whole, plain): (Vec<&String>, Vec<&String>) = names.into_iter().partition(takes_all);
    documents(&user, &whole, &["--all-features"]).and_then(|()| all(documents(&user, &plain, &[])))
}

/// The settings that docs.rs finds in a package, as cargo writes them there; others have none.
const DOCS_SETTING: &str = "[package.metadata.docs.rs]\nall-features = true\n";

/// Builds the documentation of unpacked crates as docs.rs does.
fn documents(user: &Path, names: &[&String], features: &[&str]) -> Done {
    let mut doc = command(&cargo_program(), &["doc", "--quiet", "--no-deps"]);
    names.iter().for_each(|name| _ = doc.args(["--package", name.as_str()]));
    doc.args(features).current_dir(user).env_remove("CARGO_TARGET_DIR");
    doc.env("RUSTDOCFLAGS", "-Dwarnings --cfg docsrs");
    run(doc)
}

/// The wheel and the sdist, each in an environment of its own.
fn wheel() -> Ended {
    let (interpreter, tools) = match python::ready()? {
        Ok(ready) => ready,
        Err(skip) => return Ok(End::Skipped(skip)),
    };
    let made = python::artefacts(&interpreter, &tools, &target().join("wheels"))?;
    let user = empty("python-user")?;
    let example = first_example(&root().join("bindings/python/README.md"), "python")?;
    fs::write(user.join("first.py"), example).map_err(|e| at(&user, e))?;
    for (kind, file) in ["wheel", "sdist"].into_iter().zip(&made) {
        let environment = user.join(kind);
        python::environment(&interpreter, &environment)?;
        python::pip(&environment, &[file, "trimesh"])?;
        run_in(&user, &python::program(&environment, "python"), &["first.py"])?;
        let cullet = python::program(&environment, "cullet");
        run_in(&user, &cullet, &["report", "solids", "--views", "2", "--quiet"])?;
        let name = Path::new(file).file_name().unwrap_or_default();
        fs::copy(file, artefacts().join(name)).map_err(|e| at(Path::new(file), e))?;
    }
    Ok(End::Passed)
}

/// The npm package, installed from its tarball.
fn npm() -> Ended {
    let package = web::build()?;
    run(command(
        "npm",
        &["pack", "--silent", "--pack-destination", &text(&artefacts()), &text(&package)],
    ))?;
    let user = empty("npm-user")?;
    let tarball = artefacts().join(format!("cullet-{}.tgz", current_version()?));
    fs::write(user.join("package.json"), "{ \"type\": \"module\", \"private\": true }")
        .map_err(|e| at(&user, e))?;
    let example = first_example(&root().join("bindings/web/README.md"), "js")?;
    fs::write(user.join("first.js"), example).map_err(|e| at(&user, e))?;
    let words = ["install", "--no-audit", "--no-fund", "--omit=peer", &text(&tarball)];
    run_in(&user, Path::new("npm"), &words)?;
    run_in(&user, Path::new("node"), &["first.js"])?;
    fs::write(user.join("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        .map_err(|e| at(&user, e))?;
    all(run_in(&user, Path::new("npx"), &["--no-install", "cullet", "info", "one.obj"]))
}

/// Lists all artefacts with their sizes, and writes `SHA256SUMS` beside them.
fn checksums() -> Done {
    let folder = artefacts();
    let mut names: Vec<String> = fs::read_dir(&folder)
        .map_err(|e| at(&folder, e))?
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name != "SHA256SUMS")
        .collect();
    names.sort();
    let mut sum = command("sha256sum", &[]);
    sum.args(&names).current_dir(&folder);
    let sums = sum.output().map_err(|e| format!("sha256sum: {e}"))?;
    if !sums.status.success() {
        return Err(format!("sha256sum: {}", sums.status));
    }
    fs::write(folder.join("SHA256SUMS"), sums.stdout).map_err(|e| at(&folder, e))?;
    println!("\n{}:", folder.display());
    for name in &names {
        let size = fs::metadata(folder.join(name)).map_err(|e| at(&folder, e))?.len();
        println!("  {:>9} kB  {name}", size.div_ceil(1000));
    }
    Ok(())
}
