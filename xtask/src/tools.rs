//! Running commands, and finding out what is installed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Why a step failed, in a line.
pub(crate) type Done = Result<(), String>;

/// The repository's root.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

/// A command in the repository's root, with what every step has in common.
pub(crate) fn command(program: &str, args: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(args).current_dir(root());
    if std::env::var_os("CULLET_DATA").is_none() {
        command.env("CULLET_DATA", root().join("../shared/data"));
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

/// What a command prints, if it can be run and succeeds.
pub(crate) fn output(program: &str, args: &[&str]) -> Option<String> {
    let out = command(program, args).stderr(Stdio::null()).output().ok()?;
    out.status.success().then(|| String::from_utf8_lossy(&out.stdout).into_owned())
}

/// Whether CI runs this: what is missing is installed there, or a failure.
pub(crate) fn is_ci() -> bool {
    std::env::var_os("CI").is_some_and(|v| v == "true")
}

/// What a user would type to install packages of Debian.
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
