//! The Python package: its wheel and sdist are built and checked, the wheel is installed into a
//! fresh environment, and used there as a user would.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::golden;
use crate::plain;
use crate::runner::{End, Ended, Skip, all};
use crate::tools::{
    Done, cache, command, data, install, install_words, is_ci, output, root, run, target,
};

/// Packages that build and check a wheel.
const BUILDING: &[&str] = &["maturin==1.16.*", "twine"];
/// Packages of its tests: those that it works with, clusters on one machine, and readers of types
/// and notebooks.
const TESTING: &[&str] = &[
    "distributed",
    "ipykernel",
    "mypy",
    "nbclient",
    "numpy",
    "pytest",
    "pyvista",
    "ray",
    "rtree",
    "trimesh",
];
/// System packages that VTK, which pyvista draws with, needs: the tests draw off-screen, without a GPU.
const SYSTEM: &[&str] = &["python3-venv", "libegl1", "libgl1", "libgl1-mesa-dri", "libxrender1"];
/// The oldest interpreter that the wheel is for.
const OLDEST: &str = "import sys; raise SystemExit(sys.version_info < (3, 10))";

/// The step of `test`.
pub(crate) fn test() -> Ended {
    match ready()? {
        Ok((python, tools)) => all(build_and_test(&python, &tools)),
        Err(skip) => Ok(End::Skipped(skip)),
    }
}

/// Returns the interpreter and the environment that builds and tests the package, which CI installs.
pub(crate) fn ready() -> Result<Result<(String, PathBuf), Skip>, String> {
    let what = "the Python package, in a fresh environment";
    let mut python = interpreter();
    if python.is_none() && is_ci() {
        install(SYSTEM)?;
        python = interpreter();
    }
    let Some(python) = python else {
        let cure = format!("{}, then set CI=true once", install_words(SYSTEM));
        return Ok(Err(Skip::new(what, cure)));
    };
    let tools = cache().join("python-tools");
    let has_tools =
        ["pytest", "maturin", "dask", "ray"].iter().all(|p| program(&tools, p).exists());
    if !has_tools && !is_ci() {
        let cure = "CI=true cargo xtask bindings python, which gets maturin, trimesh, pyvista and others from PyPI";
        return Ok(Err(Skip::new(what, cure)));
    }
    if !has_tools {
        environment(&python, &tools)?;
        pip(&tools, &[BUILDING, TESTING].concat())?;
    }
    Ok(Ok((python, tools)))
}

/// An interpreter that is new enough and can make environments.
pub(crate) fn interpreter() -> Option<String> {
    let fits = |name: &&&str| {
        output(name, &["-c", OLDEST]).is_some()
            && output(name, &["-c", "import venv, ensurepip"]).is_some()
    };
    ["python3", "python3.13", "python3.12", "python3.11", "python3.10"]
        .iter()
        .find(fits)
        .map(|n| (*n).to_owned())
}

/// A program of an environment.
pub(crate) fn program(environment: &Path, name: &str) -> PathBuf {
    environment.join("bin").join(name)
}

/// Makes an environment anew.
pub(crate) fn environment(python: &str, folder: &Path) -> Done {
    run(command(python, &["-m", "venv", "--clear", &folder.to_string_lossy()]))
}

/// Installs packages into an environment.
pub(crate) fn pip(environment: &Path, words: &[&str]) -> Done {
    let pip = program(environment, "pip");
    let all = [&["install", "--quiet", "--disable-pip-version-check"], words].concat();
    run(command(&pip.to_string_lossy(), &all))
}

/// Builds the wheel and the sdist into an emptied folder, as they are published, and checks both; returns
/// their paths in this order.
pub(crate) fn artefacts(python: &str, tools: &Path, out: &Path) -> Result<[String; 2], String> {
    let source = root().join("bindings/python");
    let fail = |e: std::io::Error| format!("{}: {e}", out.display());
    if out.exists() {
        fs::remove_dir_all(out).map_err(fail)?;
    }
    let maturin = |words: &[&str]| -> Command {
        let mut maturin = command(&program(tools, "maturin").to_string_lossy(), words);
        maturin.args(["--manifest-path", &source.join("Cargo.toml").to_string_lossy()]);
        maturin.args(["--out", &out.to_string_lossy()]);
        maturin
    };
    // Nearly all of it was built for the program.
    run(maturin(&["build", "--release", "--interpreter", python]))?;
    run(maturin(&["sdist"]))?;
    let files: Vec<PathBuf> =
        fs::read_dir(out).map_err(fail)?.flatten().map(|entry| entry.path()).collect();
    let named = |end: &str| {
        let names = files.iter().map(|f| f.to_string_lossy().into_owned());
        let mut names = names.filter(|name| name.ends_with(end));
        names.next().ok_or_else(|| format!("{}: there is no {end}", out.display()))
    };
    let made = [named(".whl")?, named(".tar.gz")?];
    let twine = program(tools, "twine");
    run(command(&twine.to_string_lossy(), &["check", "--strict", &made[0], &made[1]]))?;
    sdist_is_whole(&made[1])?;
    Ok(made)
}

fn build_and_test(python: &str, tools: &Path) -> Done {
    let source = root().join("bindings/python");
    let [wheel, _] = artefacts(python, tools, &target().join("wheels"))?;
    let wheel = wheel.as_str();

    // Nothing is there but the wheel and what it names itself.
    let fresh = target().join("python-fresh");
    environment(python, &fresh)?;
    pip(&fresh, &[wheel])?;
    let first = "import pycullet; scene = pycullet.Scene.builtin('solids'); \
                 camera = pycullet.Cameras.along(scene, 'orbit', 1)[0]; assert scene.verify(camera); print(scene)";
    run(command(&program(&fresh, "python").to_string_lossy(), &["-c", first]))?;

    pip(tools, &["--force-reinstall", "--no-deps", wheel])?;
    let python = program(tools, "python");
    if let Some(list) = output(&python.to_string_lossy(), &["-m", "pip", "list", "--format=freeze"])
    {
        println!(
            "installed in {}: {}",
            tools.display(),
            list.lines().collect::<Vec<_>>().join(" ")
        );
    }
    let mut tests = command(&python.to_string_lossy(), &["-m", "pytest", "-p", "no:cacheprovider"]);
    tests
        .current_dir(&source)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("MYPY_CACHE_DIR", target().join("mypy"));
    tests.env("CULLET_PROGRAM", plain::program("cullet")?);
    tests.envs(data().map(|folder| ("CULLET_DATA", folder)));
    if golden::folder().join("golden.json").exists() {
        tests.env("CULLET_GOLDEN", golden::folder());
    }
    run(tests)
}

/// The sdist has what builds the wheel: the crates of the engine lie in it too.
fn sdist_is_whole(sdist: &str) -> Done {
    let list =
        output("tar", &["-tzf", sdist]).ok_or_else(|| format!("{sdist}: cannot be listed"))?;
    for part in [
        "/bindings/python/src/lib.rs",
        "/crates/cullet/src/lib.rs",
        "/python/pycullet/py.typed",
        "/PKG-INFO",
    ] {
        if !list.lines().any(|line| line.ends_with(part)) {
            return Err(format!("{sdist}: it lacks {part}"));
        }
    }
    Ok(())
}
