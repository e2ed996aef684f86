//! Running commands, and finding out what is installed.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Why a step failed, in a line.
pub(crate) type Done = Result<(), String>;

/// The repository's root: of the checkout that runs this, which a build kept from another one does
/// not know.
pub(crate) fn root() -> PathBuf {
    let here = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or(env!("CARGO_MANIFEST_DIR").into());
    let here = Path::new(&here);
    here.parent().unwrap_or(here).to_owned()
}

/// Where cargo builds.
pub(crate) fn target() -> PathBuf {
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// Folder that CI keeps from one run to the next, outside of any checkout: `CULLET_CACHE`, else a
/// folder of the user's.
pub(crate) fn cache() -> PathBuf {
    let set = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let home = || set("HOME").unwrap_or_else(std::env::temp_dir).join(".cache");
    let user = || set("XDG_CACHE_HOME").unwrap_or_else(home).join("cullet-ci");
    set("CULLET_CACHE").unwrap_or_else(user)
}

/// Where builds lie that share nothing with that of the tests: by other compilers, for other
/// machines. CI keeps them from one run to the next.
pub(crate) fn apart(name: &str) -> PathBuf {
    if is_ci() { cache().join("target").join(name) } else { target().join(name) }
}

/// A command in the repository's root, which finds the programs that CI installed too.
pub(crate) fn command(program: &str, args: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(args).current_dir(root());
    let path = std::env::var_os("PATH").unwrap_or_default();
    let ours = [cache().join("tools/bin")];
    if let Ok(path) = std::env::join_paths(std::env::split_paths(&path).chain(ours)) {
        command.env("PATH", path);
    }
    command
}

/// Runs a command and shows what it prints.
pub(crate) fn run(mut command: Command) -> Done {
    let words: Vec<_> = std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|w| w.to_string_lossy().into_owned())
        .collect();
    let words = words.join(" ");
    println!("$ {words}");
    // It stands in the sums at the end as well.
    let words = words.char_indices().nth(200).map_or(&*words, |(end, _)| &words[..end]);
    let status = command.status().map_err(|e| format!("{words}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{words}: {status}")) }
}

/// Runs cargo.
pub(crate) fn cargo(args: &[&str]) -> Done {
    run(command(&cargo_program(), args))
}

/// The cargo that runs this program.
pub(crate) fn cargo_program() -> String {
    std::env::var("CARGO").unwrap_or_else(|_| "cargo".into())
}

/// Output of a command, if it can be run and succeeds.
pub(crate) fn output(program: &str, args: &[&str]) -> Option<String> {
    let out = command(program, args).stderr(Stdio::null()).output().ok()?;
    out.status.success().then(|| String::from_utf8_lossy(&out.stdout).into_owned())
}

/// Whether CI runs this: what is missing is installed there, or a failure.
pub(crate) fn is_ci() -> bool {
    is_set("CI", "true")
}

/// Whether all is wanted that a step can do: by hand, and in CI with `CULLET_ALL=1`. Else CI leaves
/// out what is drawn or built once more for further renderers and systems, so that it ends in time.
pub(crate) fn is_whole() -> bool {
    !is_ci() || is_set("CULLET_ALL", "1")
}

/// Whether a variable of the environment has a value.
pub(crate) fn is_set(name: &str, value: &str) -> bool {
    std::env::var_os(name).is_some_and(|v| v == value)
}

/// Waits until no other process of this program has the name, and has it until it is dropped.
pub(crate) fn alone(name: &str) -> Result<File, String> {
    let folder = cache().join("alone");
    let path = folder.join(name);
    let fail = |e: std::io::Error| format!("{}: {e}", path.display());
    fs::create_dir_all(&folder).map_err(fail)?;
    let file = File::create(&path).map_err(fail)?;
    file.lock().map_err(fail)?;
    Ok(file)
}

/// The folder of test data, where there is one: `CULLET_DATA`, else beside the checkout.
pub(crate) fn data() -> Option<PathBuf> {
    let set = std::env::var_os("CULLET_DATA").filter(|v| !v.is_empty());
    let folder = root().join(set.unwrap_or_else(|| "../shared/data".into()));
    folder.is_dir().then_some(folder)
}

/// A C++ compiler that can be run, the one that `CXX` names first.
pub(crate) fn cpp_compiler() -> Result<String, String> {
    let set = std::env::var("CXX").ok().filter(|v| !v.is_empty());
    let mut compilers = set.into_iter().chain(["c++", "g++", "clang++"].map(str::to_owned));
    compilers.find(|c| output(c, &["--version"]).is_some()).ok_or_else(|| {
        format!("there is no C++ compiler, nor does CXX name one: {}", install_words(&["g++"]))
    })
}

/// The command that installs packages of Debian.
pub(crate) fn install_words(packages: &[&str]) -> String {
    format!("apt-get install --no-install-recommends {}", packages.join(" "))
}

/// Installs packages of Debian where we are root; else names them.
pub(crate) fn install(packages: &[&str]) -> Done {
    let is_root = output("id", &["-u"]).is_some_and(|id| id.trim() == "0");
    if !is_root || output("apt-get", &["--version"]).is_none() {
        return Err(format!("needed: {}", install_words(packages)));
    }
    run(command("apt-get", &["update", "-q"]))?;
    let mut args = vec!["install", "-q", "-y", "--no-install-recommends"];
    args.extend(packages);
    run(command("apt-get", &args))
}

/// The command that installs a program of a crate.
pub(crate) fn cargo_install_words(package: &str) -> String {
    format!("cargo install --locked {package}")
}

/// Whether a program is there, once CI has installed it where it was not: an error where that
/// fails.
pub(crate) fn has_program(program: &str, options: &[&str]) -> Result<bool, String> {
    let is_there = || output(program, &["--version"]).is_some();
    if !is_there() && is_ci() {
        cargo_install(program, options)?;
        if !is_there() {
            return Err(format!("{program} was installed, but cannot be run"));
        }
    }
    Ok(is_there())
}

/// Installs a program of a crate into the cache, where [`command`] finds it, with more options for
/// cargo; takes minutes.
fn cargo_install(package: &str, options: &[&str]) -> Done {
    let folder = cache().join("tools");
    let words = ["install", "--quiet", "--locked", package];
    let mut install = command(&cargo_program(), &[&words[..], options].concat());
    install.arg("--root").arg(&folder);
    // It runs for seconds, so that optimising it would take longer than it saves.
    install.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1").env_remove("CARGO_TARGET_DIR");
    run(install)
}
