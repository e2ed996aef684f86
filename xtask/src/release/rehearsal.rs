//! A rehearsal of a release: everything that would be uploaded is made, and the first example of its
//! README is run from that alone. Nothing is uploaded.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{current_version, published};
use crate::bindings::{python, web};
use crate::runner::{self, End, Ended, Step, all};
use crate::tools::{Done, cargo, cargo_program, command, output, root, run, target};

/// The artefacts, each made and used. The programs come first: they write the scene that others open.
const STEPS: &[Step] = &[
    Step { name: "programs", run: programs },
    Step { name: "crates", run: crates },
    Step { name: "c", run: c },
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
  7  the Godot addon, by its form; the book, from cargo xtask book, to where books are served
  8  README: the lines that say how to install, in place of \"Nothing is published yet\"";

/// Makes and uses the artefacts whose name contains `filter`, and lists their sizes and checksums.
pub(crate) fn rehearse(filter: &str) -> Done {
    let _ = fs::remove_dir_all(work());
    for folder in [artefacts(), work()] {
        fs::create_dir_all(&folder).map_err(|e| at(&folder, e))?;
    }
    let steps: Vec<Step> = STEPS.iter().filter(|s| s.name.contains(filter)).copied().collect();
    runner::run(&steps, "")?;
    checksums()?;
    println!("\n{}", BY_HAND.replace("{version}", &current_version()?));
    Ok(())
}

/// Folder of what would be uploaded.
fn artefacts() -> PathBuf {
    target().join("release-artefacts")
}

/// Folder of the empty projects that use it: outside of the checkout, whose settings cargo would find.
fn work() -> PathBuf {
    std::env::temp_dir().join("cullet-release-rehearsal")
}

fn at(path: &Path, error: std::io::Error) -> String {
    format!("{}: {error}", path.display())
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Makes an empty folder to use an artefact in.
fn empty(name: &str) -> Result<PathBuf, String> {
    let folder = work().join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|e| at(&folder, e))?;
    Ok(folder)
}

/// Runs a program in a folder, with nothing from this checkout in its environment.
fn run_in(folder: &Path, program: &Path, words: &[&str]) -> Done {
    let mut command = Command::new(program);
    command.args(words).current_dir(folder).env_remove("CARGO_TARGET_DIR");
    run(command)
}

/// Returns the first block of code of a README in a language.
fn first_example(readme: &str, language: &str) -> Result<String, String> {
    let path = root().join(readme);
    let text = fs::read_to_string(&path).map_err(|e| at(&path, e))?;
    let block = text.split(&format!("```{language}\n")).nth(1).and_then(|b| b.split("```").next());
    block.map(str::to_owned).ok_or_else(|| format!("{readme} has no example in {language}"))
}

/// Packs a folder of `parent` as a `.tar.gz` among the artefacts, and unpacks that into an empty folder;
/// returns the folder there.
fn pack(parent: &Path, name: &str) -> Result<PathBuf, String> {
    let archive = text(&artefacts().join(format!("{name}.tar.gz")));
    // Owned by nobody in particular, in a stable order.
    let words = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "-C"];
    let mut tar = command("tar", &words);
    tar.args([&text(parent), "-czf", &archive, name]);
    run(tar)?;
    let place = empty(&format!("unpacked-{name}"))?;
    run(command("tar", &["-xzf", &archive, "-C", &text(&place)]))?;
    Ok(place.join(name))
}

/// Returns the machine that this compiler builds for, as archives are named.
fn machine() -> Result<String, String> {
    let said = output("rustc", &["-vV"]).ok_or("rustc cannot be run")?;
    let host = said.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "rustc -vV names no host".into())
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

/// The crates as crates.io takes them, and a project that has nothing but them.
fn crates() -> Ended {
    let published = published()?;
    let mut words = vec!["publish", "--dry-run", "--no-verify", "--allow-dirty"];
    words.extend(published.iter().map(String::as_str));
    cargo(&words)?;
    // A dry run leaves no packages behind.
    cargo(&[&["package", "--quiet"], &words[2..]].concat())?;
    let (version, user) = (current_version()?, empty("crate-user")?);
    let mut patches = String::new();
    for name in published.iter().filter(|word| *word != "--package") {
        let file = format!("{name}-{version}.crate");
        let (from, to) = (target().join("package").join(&file), artefacts().join(&file));
        fs::copy(&from, &to).map_err(|e| at(&from, e))?;
        run(command("tar", &["-xzf", &text(&to), "-C", &text(&user)]))?;
        patches += &format!("{name} = {{ path = \"{name}-{version}\" }}\n");
    }
    let manifest = format!(
        "[package]\nname = \"user\"\nedition = \"2024\"\n[dependencies]\ncullet = \"{version}\"\n\
         [workspace]\n[patch.crates-io]\n{patches}"
    );
    let example = first_example("crates/cullet/README.md", "rust")?;
    let program =
        format!("fn main() -> Result<(), Box<dyn std::error::Error>> {{\n{example}Ok(())\n}}\n");
    let source = user.join("src");
    fs::create_dir_all(&source).map_err(|e| at(&source, e))?;
    fs::write(user.join("Cargo.toml"), manifest).map_err(|e| at(&user, e))?;
    fs::write(source.join("main.rs"), program).map_err(|e| at(&source, e))?;
    all(run_in(&user, Path::new(&cargo_program()), &["run", "--quiet"]))
}

/// Archive of the C library, and the first example compiled against it.
fn c() -> Ended {
    let name = format!("cullet-c-{}-{}", current_version()?, machine()?);
    let stage = empty("stage")?;
    let script = text(&root().join("bindings/c/install.sh"));
    let mut install = command("sh", &[&script, &text(&stage.join(&name))]);
    install.env("CARGO", cargo_program()).env("CARGO_TARGET_DIR", target());
    run(install)?;
    fs::copy(root().join("bindings/c/README.md"), stage.join(&name).join("README.md"))
        .map_err(|e| at(&stage, e))?;
    let prefix = pack(&stage, &name)?;
    let user = empty("c-user")?;
    let example = first_example("bindings/c/README.md", "c")?;
    fs::write(user.join("first.c"), example).map_err(|e| at(&user, e))?;
    // An example that opens a scene opens this one.
    let scene = work().join("scene.glb");
    let mut bake =
        command("cargo", &["run", "--release", "--quiet", "--package", "cullet-cli", "--"]);
    bake.args(["bake", "solids", "--quiet", "-o", &text(&scene)]);
    run(bake)?;
    fs::copy(&scene, user.join("scene.glb")).map_err(|e| at(&scene, e))?;
    let line = "gcc -std=c11 first.c -o first $(pkg-config --cflags --libs cullet) && ./first";
    let mut compile = Command::new("sh");
    compile.args(["-euc", line]).current_dir(&user);
    compile.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
    compile.env("LD_LIBRARY_PATH", prefix.join("lib"));
    all(run(compile))
}

/// The wheel and the sdist, each in an environment of its own.
fn wheel() -> Ended {
    let (interpreter, tools) = match python::ready()? {
        Ok(ready) => ready,
        Err(skip) => return Ok(End::Skipped(skip)),
    };
    let made = python::artefacts(&interpreter, &tools, &target().join("wheels"))?;
    let user = empty("python-user")?;
    let example = first_example("bindings/python/README.md", "python")?;
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
    let example = first_example("bindings/web/README.md", "js")?;
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

#[cfg(test)]
mod tests {
    use super::first_example;

    #[test]
    fn the_readme_of_each_artefact_has_a_first_example() {
        for (readme, language) in [
            ("crates/cullet/README.md", "rust"),
            ("bindings/c/README.md", "c"),
            ("bindings/python/README.md", "python"),
            ("bindings/web/README.md", "js"),
        ] {
            assert!(first_example(readme, language).unwrap().lines().count() > 4, "{readme}");
        }
        assert!(first_example("README.md", "cobol").unwrap_err().contains("no example"));
    }
}
